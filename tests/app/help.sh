# SPDX-License-Identifier: Apache-2.0
# Every option that the help of a verb names is one that the verb takes, in the manual page and in the completion too.
. "$DATA/check.sh"

works help
grep -q '^exit codes:' out.txt || wrong "help: no exit codes"
works --help
works --version
grep -qx 'clast [0-9]*\.[0-9]*\.[0-9]*' out.txt || wrong "--version: $(cat out.txt)"
works help --man
cp out.txt manual.txt
works help --completion
cp out.txt completion.txt
sh -n completion.txt 2>/dev/null || bash -n completion.txt || wrong "the completion is no shell code"

for verb in render generate info compare; do
    works help $verb
    cp out.txt help.txt
    works $verb --help
    same help.txt out.txt
    grep -q '^exit codes:' help.txt || wrong "$verb: no exit codes"
    options=$(sed -n 's/^  --\([a-z-]*\).*/\1/p' help.txt)
    [ "$(echo "$options" | wc -l)" -ge 4 ] || wrong "$verb: few options"
    for option in $options; do
        "$CLAST" $verb "--$option" >/dev/null 2>err.txt
        ! grep -q 'has no option' err.txt || wrong "$verb: --$option is in the help only"
        grep -q "^\.B .*$(echo "$option" | sed 's/-/\\\\-/g')" manual.txt || wrong "$verb: --$option is not in the manual page"
        grep -q -e "--$option" completion.txt || wrong "$verb: --$option is not in the completion"
    done
done
works help render
for view in colour albedo normal depth uv instance cluster triangle steps; do
    grep -q "^  $view " out.txt || wrong "render: the help does not tell of view $view"
done
finish
