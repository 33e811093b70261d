# SPDX-License-Identifier: Apache-2.0
# install.sh BUILD SOURCE SCRATCH COMPILER
set -eu
build=$1
source=$2
scratch=$3
compiler=$4
prefix=$scratch/prefix
rm -rf "$prefix" "$scratch/minimal" "$scratch/picture.png"
cmake --install "$build" --prefix "$prefix" >/dev/null

# Nothing of the source tree may be needed: the example is copied.
mkdir -p "$scratch/minimal"
cp "$source/examples/minimal.c" "$source/examples/dynamic_cloth.c" "$scratch/minimal/"
cat >"$scratch/minimal/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.22)
project(minimal LANGUAGES C)
find_package(clast REQUIRED)
foreach(kind clast static shared)
    add_executable(minimal_${kind} minimal.c)
    target_link_libraries(minimal_${kind} PRIVATE clast::${kind})
endforeach()
add_executable(dynamic_cloth dynamic_cloth.c)
target_link_libraries(dynamic_cloth PRIVATE clast::clast m)
END
cmake -S "$scratch/minimal" -B "$scratch/minimal/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_C_COMPILER="$compiler" >/dev/null
cmake --build "$scratch/minimal/build" >/dev/null

pc=$(dirname "$(find "$prefix" -name clast.pc)")
export PKG_CONFIG_PATH="$pc"
# shellcheck disable=SC2046 # lists of words
"$compiler" "$scratch/minimal/minimal.c" -o "$scratch/minimal/build/minimal_pkg" $(pkg-config --cflags --libs clast) \
    -Wl,-rpath,"$(pkg-config --variable=libdir clast)"
[ "$(pkg-config --modversion clast)" = "$("$prefix/bin/clast" --version | cut -d' ' -f2)" ]

for kind in clast static shared pkg; do
    rm -f "$scratch/picture.png"
    "$scratch/minimal/build/minimal_$kind" "$source/tests/app/box.obj" "$scratch/picture.png"
    [ -s "$scratch/picture.png" ]
done
"$scratch/minimal/build/dynamic_cloth" 2 "$scratch/picture.png" | grep -q 'bytes a triangle'
[ -s "$(find "$prefix" -name clast.1)" ]
[ -s "$(find "$prefix" -path '*completions/clast')" ]
