# SPDX-License-Identifier: Apache-2.0
# Sourced by the tests of the command. CLAST and JSON_HAS are the programs, DATA is this folder.
set -u
failures=0

wrong() {
    echo "wrong: $*"
    failures=$((failures + 1))
}

# fails CODE TEXT ARGUMENT...: the command ends with CODE, prints nothing on standard output, and one line on standard error,
# which begins with "clast: " and holds TEXT.
fails() {
    code=$1
    text=$2
    shift 2
    "$CLAST" "$@" >out.txt 2>err.txt
    got=$?
    [ "$got" -eq "$code" ] || wrong "$*: ended with $got, not $code: $(cat err.txt)"
    [ ! -s out.txt ] || wrong "$*: printed on standard output"
    [ "$(wc -l <err.txt)" -eq 1 ] || wrong "$*: printed $(wc -l <err.txt) lines: $(cat err.txt)"
    grep -q '^clast: ' err.txt || wrong "$*: does not begin with clast: $(cat err.txt)"
    grep -qF -e "$text" err.txt || wrong "$*: does not say \"$text\": $(cat err.txt)"
}

# works ARGUMENT...: the command succeeds and prints no error. Its output is in out.txt.
works() {
    "$CLAST" "$@" >out.txt 2>err.txt
    got=$?
    [ "$got" -eq 0 ] || wrong "$*: ended with $got: $(cat err.txt)"
    [ ! -s err.txt ] || wrong "$*: printed an error: $(cat err.txt)"
}

same() {
    cmp -s "$1" "$2" || wrong "$1 and $2 differ"
}

absent() {
    for name in "$@"; do
        [ ! -e "$name" ] || wrong "$name was written"
    done
}

finish() {
    [ "$failures" -eq 0 ] || exit 1
    exit 0
}
