# SPDX-License-Identifier: Apache-2.0
# What generate and export write has no error by clast's own validator.
. "$DATA/check.sh"
. "$DATA/written_files.sh"
for file in $files; do
    works validate "$file"
    grep -q '^error: 0, ' out.txt || wrong "$file: $(cat out.txt)"
done
finish
