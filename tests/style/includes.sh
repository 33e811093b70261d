# SPDX-License-Identifier: Apache-2.0
# Fails where a file of src/ includes a header of a folder that stands below its own in the order of the architecture. Headers that the
# build makes are in no folder.
cd "$1/src" || exit 1
awk '
BEGIN {
    count = split("base shared geometry accel scene generate load stream source cook frame render vulkan api app viewer", order)
    for (i = 1; i <= count; i++) {
        rank[order[i]] = i
    }
}
FNR == 1 {
    files++
    folder = substr(FILENAME, 1, index(FILENAME, "/") - 1)
    if (!(folder in rank)) {
        print "src/" folder ": not in the order of the architecture"
        failed = 1
    }
}
/^#include "[^"]*\// {
    split($2, part, /["\/]/)
    if (part[2] != "clast" && (!(part[2] in rank) || rank[part[2]] > rank[folder])) {
        print "src/" FILENAME ": includes a header of " part[2] ", which does not stand above " folder
        failed = 1
    }
}
END {
    print files " files"
    exit failed || files < 50
}' */*.[ch]
