# SPDX-License-Identifier: Apache-2.0
# validate_codes.sh SOURCE: docs/validate.md lists every code of src/load/validate_codes.h with its severity and meaning, and no
# other.
cd "$1" || exit 1
awk '{ while (sub(/\\$/, "")) { getline more; $0 = $0 more } print }' src/load/validate_codes.h |
    grep -o 'X([A-Z_0-9]*, [A-Z]*, *"[^"]*")' |
    sed 's/X(\([A-Z_0-9]*\), \([A-Z]*\), *"\(.*\)")/\1 \2 \3/' | sort | {
    documented=$(grep '^| [A-Z_0-9]* | [a-z]* | ' docs/validate.md | sed 's/^| \(.*\) |$/\1/; s/ | / /g' |
        awk '{ $2 = toupper($2); print }' | sort)
    codes=$(cat)
    [ "$codes" = "$documented" ] && [ "$(echo "$codes" | wc -l)" -gt 100 ] && exit 0
    echo "docs/validate.md does not list the codes as they are:"
    list=$(mktemp) && echo "$codes" >"$list" && echo "$documented" | diff "$list" -
    rm -f "$list"
    exit 1
}
