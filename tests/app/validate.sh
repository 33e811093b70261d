# SPDX-License-Identifier: Apache-2.0
# validate: exit codes, lines, and JSON.
. "$DATA/check.sh"

printf '{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"name":"n","children":[1]},{"camera":7}]}' >wrong.gltf
printf '{"asset":{"version":"2.0"}}' >right.gltf

works validate right.gltf
[ "$(cat out.txt)" = 'error: 0, warning: 0, information: 0, hint: 0' ] || wrong "a sound file: $(cat out.txt)"
works validate "$DATA/box.obj"
works validate --quiet right.gltf
[ ! -s out.txt ] || wrong "--quiet printed: $(cat out.txt)"

has_errors() {
    "$CLAST" validate "$@" >out.txt 2>err.txt
    [ $? -eq 1 ] || wrong "validate $*: did not end with 1"
    [ ! -s err.txt ] || wrong "validate $*: $(cat err.txt)"
}
has_errors wrong.gltf
grep -q '^error UNRESOLVED_REFERENCE at /nodes/1/camera: ' out.txt || wrong "lines: $(cat out.txt)"
grep -q '^error: 1, ' out.txt || wrong "the sum: $(cat out.txt)"
has_errors --json wrong.gltf
"$JSON_HAS" out.txt valid input >values.txt || wrong "JSON: $(cat out.txt)"
[ "$(tr '\n' ' ' <values.txt)" = 'false wrong.gltf ' ] || wrong "JSON: $(cat values.txt)"
grep -q '"pointer": *"/nodes/1/camera"' out.txt || wrong "JSON: $(cat out.txt)"
has_errors --json=result.json wrong.gltf
"$JSON_HAS" result.json valid counts faults >values.txt || wrong "JSON file: $(cat result.json)"
has_errors "$DATA/validate.sh"
grep -q '^error FILE_UNSUPPORTED at byte 0: ' out.txt || wrong "another file: $(cat out.txt)"

fails 2 'missing.gltf' validate missing.gltf
fails 2 'needs INPUT' validate
finish
