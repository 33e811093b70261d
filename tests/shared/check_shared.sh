# SPDX-License-Identifier: Apache-2.0
# check_shared.sh [--faults] SOURCE COMPILER: reads each header of src/shared alone, as C and as GLSL; looks for arithmetic
# that a driver may fuse, and for operations that differ between machines outside functions named rough_*; compares the layouts
# of records.
# With --faults, headers with a fault each must all be refused.
faults=no
if [ "$1" = --faults ]; then
    faults=yes
    shift
fi
source=$1
compiler=$2
here=$source/tests/shared
for tool in glslangValidator spirv-dis; do
    command -v $tool > /dev/null || { echo "skipped: $tool is not installed"; exit 77; }
done
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/shared"

compile_c() { # FILE
    "$compiler" -std=gnu11 -Wall -Wextra -Werror -Wdouble-promotion -Wno-psabi -ffp-contract=off -fsyntax-only \
        -I"$folder" -I"$source/src" -I"$source/include" "$1" 2> "$folder/messages" || { head -20 "$folder/messages"; return 1; }
}

# A shader with the header, and a buffer of each of its records.
write_shader() { # HEADER FILE-OF-HEADER
    printf '#version 460\n#extension GL_GOOGLE_include_directive : require\n#extension GL_EXT_scalar_block_layout : require\n'
    printf '#include "shared/%s"\nlayout(local_size_x = 1) in;\n' "$1"
    binding=0
    for record in $records; do
        printf 'layout(scalar, binding = %d) buffer buffer_%s { %s values[2]; } of_%s;\n' $binding "$record" "$record" "$record"
        binding=$((binding + 1))
    done
    printf 'void main() {}\n'
}

check_header() { # HEADER FILE-OF-HEADER
    records=$(sed -n 's/^RECORD(\([a-z_0-9]*\)).*/\1/p' "$2" | sort -u | tr '\n' ' ')
    printf '#include "shared/%s"\nint nothing_else;\n' "$1" > "$folder/alone.c"
    compile_c "$folder/alone.c" || return 1
    write_shader "$1" > "$folder/alone.comp"
    glslangValidator -V --keep-uncalled --target-env vulkan1.3 -I"$folder" -I"$source/src" -I"$source/include" -o "$folder/alone.spv" \
        "$folder/alone.comp" > "$folder/messages" 2>&1 || { grep -v '^$' "$folder/messages" | head -20; return 1; }
    spirv-dis --no-color "$folder/alone.spv" -o "$folder/alone.txt" || return 1
    awk -f "$here/arithmetic.awk" "$folder/alone.txt" || return 1
    { printf '#include "shared/%s"\n' "$1"; awk -v records="$records" -f "$here/layout.awk" "$folder/alone.txt"; } > "$folder/layout.c"
    compile_c "$folder/layout.c"
}

refuse() { # WHAT IT SHOWS, then the header on standard input
    { printf '#include "shared/dialect.h"\n'; cat; } > "$folder/shared/fault.h"
    if check_header fault.h "$folder/shared/fault.h" > "$folder/report" 2>&1; then
        echo "not found: $1"
        result=1
    else
        echo "found: $1: $(head -1 "$folder/report")"
    fi
}

accept() { # the header on standard input
    { printf '#include "shared/dialect.h"\n'; cat; } > "$folder/shared/sound.h"
    check_header sound.h "$folder/shared/sound.h" || { echo "refused: a sound header"; result=1; }
}

result=0
if [ $faults = yes ]; then
    accept << 'END'
RECORD(sound_record)
{
    packed3 place;
    uint number;
    float weights[3];
};
RECORD_SIZE(sound_record, 28)
FN float sound(float a, float b) { precise bool less = a * b + 1.0f < a; if (less) { return a * b - b; } return rough_sqrt(a); }
END
    refuse 'a function without FN' << 'END'
#ifdef VULKAN
float fused(float a, float b, float c) { return a * b + c; }
#endif
END
    refuse 'a condition that is fused' << 'END'
FN float fused(float a, float b, float c) { float r = a; if (a * b + c < 1.0f) { r = b; } return r; }
END
    refuse 'a quotient' << 'END'
FN float quotient(float a, float b) { return a / b; }
END
    refuse 'a root' << 'END'
#ifdef VULKAN
FN float root(float a) { return sqrt(a); }
#endif
END
    refuse 'the minimum of the language' << 'END'
#ifdef VULKAN
FN float least(float a, float b) { return min(a, b); }
#endif
END
    refuse 'an explicit fused operation' << 'END'
#ifdef VULKAN
FN float fused(float a, float b) { return fma(a, b, a); }
#endif
END
    refuse 'a double' << 'END'
FN float twice(float a) { return a * 2.0; }
END
    refuse 'a vec3 in a record' << 'END'
RECORD(padded)
{
    vec3 place;
    float weight;
};
END
    refuse 'a size that is wrong' << 'END'
RECORD(small)
{
    packed3 place;
};
RECORD_SIZE(small, 16)
END
    refuse 'members in another order' << 'END'
#ifdef VULKAN
RECORD(swapped) { uint a; float b; };
#else
RECORD(swapped) { float b; uint a; };
#endif
RECORD(swapped_user)
{
    swapped one;
};
END
    refuse 'a name that GLSL reserves' << 'END'
FN float reserved(float sample) { return sample; }
END
    exit $result
fi
checked=0
for file in "$source"/src/shared/*.h; do
    header=$(basename "$file")
    check_header "$header" "$file" > "$folder/report" 2>&1 || { sed "s|^|src/shared/$header: |" "$folder/report"; result=1; }
    checked=$((checked + 1))
done
echo "$checked headers"
[ $checked -gt 0 ] || result=1
exit $result
