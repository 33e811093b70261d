# SPDX-License-Identifier: Apache-2.0
# Fails where a file of src/ includes a header of a folder that stands below its own in the order of the architecture.
order='base shared geometry accel scene generate load stream source cook frame render vulkan api app viewer'
cd "$1/src" || exit 1
result=0
checked=0
for folder in */; do
    folder=${folder%/}
    allowed=
    for name in $order; do
        allowed="$allowed $name"
        [ "$name" != "$folder" ] || break
    done
    case " $order " in
    *" $folder "*) ;;
    *) echo "src/$folder: not in the order of the architecture"; result=1; continue ;;
    esac
    for file in "$folder"/*.[ch]; do
        [ -e "$file" ] || continue
        checked=$((checked + 1))
        for included in $(sed -n 's/^#include "\([a-z]*\)\/.*/\1/p' "$file" | sort -u); do
            case "$included" in
            clast) continue ;;
            esac
            case " $allowed " in
            *" $included "*) ;;
            *) echo "src/$file: includes a header of $included, which stands below $folder"; result=1 ;;
            esac
        done
    done
done
echo "$checked files"
[ "$checked" -gt 0 ] || result=1
exit $result
