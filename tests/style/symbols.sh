# SPDX-License-Identifier: Apache-2.0
# symbols.sh STATIC SHARED HEADERS: fails where a symbol that is not static lacks the prefix, where the shared library shows
# one that no public header declares, and where a function that a header declares is not there.
result=0
own=$(nm --defined-only --extern-only "$1" | awk 'NF == 3 { print $3 }' | grep -v -e '^clast_' -e '^CLAST_' -e '^_')
if [ -n "$own" ]; then
    echo "without the prefix: $own"
    result=1
fi
nm -D --defined-only "$2" | awk 'NF == 3 && $2 != "A" { sub(/@.*/, "", $3); print $3 }' | grep -v '^_' | sort -u >shown.txt
cat "$3"/*.h | tr '\n' ' ' | tr ';{' '\n' | sed -n 's/.*CLAST_API [^(]*[ *]\(clast_[a-z0-9_]*\)(.*/\1/p' | sort -u >declared.txt
for name in $(comm -23 shown.txt declared.txt); do
    echo "$name: shown, but in no public header"
    result=1
done
for name in $(comm -13 shown.txt declared.txt); do
    echo "$name: declared, but not in the library"
    result=1
done
[ -s declared.txt ] || result=1
exit $result
