# SPDX-License-Identifier: Apache-2.0
# Wrong command lines are refused with one line that says what was expected.
. "$DATA/check.sh"

fails 2 'a verb is missing'
fails 2 'there is no verb "rendr"; did you mean "render"?' rendr
fails 2 'there is no verb "qqqqqqqq"' qqqqqqqq
fails 2 'there is no verb "x"' help x
fails 2 'one too many' help render info
fails 2 'render needs INPUT' render
fails 2 '"c" is one too many' render a b c
fails 2 '--json=FILE' render --json stats.json a b
fails 2 'info takes INPUT: "b" is one too many' info a b
fails 2 'compare needs A B' compare a
fails 2 'generate needs SCENE OUTPUT' generate canyon
fails 2 'stands for no file' render ''
fails 2 'render has no option --spq; did you mean --spp?' render --spq 3 a
fails 2 'has no option --max-mse' render --max-mse 3 a
fails 2 'has no option -x' render -x a
fails 2 '--spp: expected N after it' render a --spp
fails 2 '--quiet takes no value' render --quiet=1 a
fails 2 '--json: expected FILE' render --json= a
for text in x '' 0 -1 1.5 1e3 ' 1' '1 ' 0x10 1048577 99999999999999999999999; do
    fails 2 "--spp: expected a whole number from 1 to 1048576, got \"$text\"" render --spp "$text" a
done
for text in x '' nan inf 0x1p3 1e999 65 ' 1'; do
    fails 2 "--exposure: expected a number from -64 to 64, got \"$text\"" render "--exposure=$text" a
done
for text in x '' -1 1.5G 4X 4GG 99999999T; do
    fails 2 "--memory: expected a number of bytes, as 4G or 512M, got \"$text\"" render --memory "$text" a
done
fails 2 '--tonemap: expected one of aces, none, agx, neutral, got "foo"' render --tonemap foo a
fails 2 '--isa: expected one of auto, plain' render --isa mmx a
fails 2 'ends in .png, .jpg, .exr, .pfm or .hdr' render "$DATA/box.obj" picture.bmp
fails 2 'ends in .png, .jpg, .exr, .pfm or .hdr' render "$DATA/box.obj" picture
fails 2 '--view instance: whole numbers' render --view instance "$DATA/box.obj" picture.pfm
fails 2 'there is no scene "moon"; expected one of' generate moon out
absent picture.bmp picture picture.pfm out
works generate --list
grep -q '^canyon ' out.txt || wrong "generate --list: no canyon"
finish
