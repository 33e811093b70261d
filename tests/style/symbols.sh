# SPDX-License-Identifier: Apache-2.0
# symbols.sh STATIC SHARED HEADERS: fails where a symbol that is not static lacks the prefix, where the shared library shows
# one that no public header declares, and where a function that a header declares is not there.
result=0
own=$(nm --defined-only --extern-only "$1" | awk 'NF == 3 { print $3 }' | grep -v -e '^clast_' -e '^CLAST_' -e '^__' -e '^_')
if [ -n "$own" ]; then
    echo "without the prefix: $own"
    result=1
fi
shown=$(nm -D --defined-only "$2" | awk 'NF == 3 && $2 != "A" { print $3 }' | sed 's/@.*//' | sort -u)
declared=$(cat "$3"/*.h | tr '\n' ' ' | tr ';{' '\n\n' | sed -n 's/.*CLAST_API [^(]*[ *]\(clast_[a-z0-9_]*\)(.*/\1/p' | sort -u)
for name in $shown; do
    echo "$declared" | grep -qx "$name" || { echo "$name: shown, but in no public header"; result=1; }
done
for name in $declared; do
    echo "$shown" | grep -qx "$name" || { echo "$name: declared, but not in the library"; result=1; }
done
[ -n "$declared" ] || result=1
exit $result
