# SPDX-License-Identifier: Apache-2.0
# From the text of a SPIR-V module with a buffer of each record (named by -v records="a b c"), writes C that asserts the
# same offsets and sizes.
BEGIN { count = split(records, list, " "); for (i = 1; i <= count; i++) wanted[list[i]] = 1 }
/OpName / { gsub(/"/, "", $3); name[$2] = $3; next }
/OpMemberName / { gsub(/"/, "", $4); member[$2, $3] = $4; next }
/OpMemberDecorate .* Offset / { offset[$2, $3] = $5; laid_out[$2] = 1; if ($3 + 1 > members[$2]) members[$2] = $3 + 1; next }
/OpDecorate .* ArrayStride / { stride[$2] = $4; next }
/= OpTypeArray / { if ($1 in stride) size[$4] = stride[$1]; next }
END {
    for (id in laid_out) {
        record = name[id]
        if (!(record in wanted)) continue
        found[record] = 1
        for (i = 0; i < members[id]; i++)
            printf "_Static_assert(offsetof(%s, %s) == %d, \"%s.%s\");\n", record, member[id, i], offset[id, i], record, member[id, i]
        if (id in size) {
            sized[record] = 1
            printf "_Static_assert(sizeof(%s) == %d, \"size of %s\");\n", record, size[id], record
        }
    }
    for (record in wanted) if (!(record in found) || !(record in sized)) printf "#error no layout was found for %s\n", record
}
