# SPDX-License-Identifier: Apache-2.0
# files.sh SOURCE: each file that a person writes names its licence in its first lines, and none is very large.
cd "$1" || exit 1
result=0
checked=0
for file in $(git ls-files -co --exclude-standard 2>/dev/null || find . -type f ! -path './.git/*' | sed 's|^\./||'); do
    [ -f "$file" ] || continue
    size=$(wc -c < "$file")
    if [ "$size" -gt 307200 ]; then
        echo "$file: $size bytes, expected at most 307200"
        result=1
    fi
    case "$file" in
    *.[ch] | *.cpp | *.glsl | *.comp | *.sh | *.awk | *.py | *CMakeLists.txt | *.cmake | scripts/* | .ci/*) ;;
    *) continue ;;
    esac
    checked=$((checked + 1))
    head -3 "$file" | grep -q 'SPDX-License-Identifier: Apache-2.0' || { echo "$file: no licence in its first lines"; result=1; }
done
echo "$checked files"
[ "$checked" -gt 100 ] || result=1
exit $result
