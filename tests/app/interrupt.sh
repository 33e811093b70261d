# SPDX-License-Identifier: Apache-2.0
# An interrupt ends a render that would take hours, and the picture is whole. How far it has come by then is left open: where
# the interrupt came before the first sample, it is sent later.
. "$DATA/check.sh"

for signal in INT TERM; do
    for seconds in 1 3 9; do
        rm -f picture.png
        "$CLAST" render --quiet --spp 1048576 --width 64 --height 36 --json=stats.json "$DATA/box.obj" picture.png 2>err.txt &
        process=$!
        sleep $seconds
        kill -$signal $process
        wait $process
        code=$?
        [ "$code" -eq 3 ] || wrong "$signal: ended with $code"
        [ ! -e picture.png ] || break
    done
    grep -q '^clast: stopped by an interrupt: picture.png has [1-9][0-9]* of 1048576 samples a pixel' err.txt ||
        wrong "$signal: $(cat err.txt)"
    works compare picture.png picture.png
    "$JSON_HAS" stats.json cancelled samples >values.txt || wrong "no statistics"
    [ "$(head -1 values.txt)" = true ] || wrong "not said to be cancelled"
done
finish
