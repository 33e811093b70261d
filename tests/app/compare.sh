# SPDX-License-Identifier: Apache-2.0
# compare: exit codes by bounds, figures that can be checked by hand, and JSON.
. "$DATA/check.sh"

# PFM, 2 x 1, one channel: values as little-endian floats.
pfm() { printf 'Pf\n2 1\n-1.0\n%b%b' "$2" "$3" >"$1"; }
zero='\000\000\000\000'
half='\000\000\000\077'
nan='\000\000\300\177'
pfm a.pfm "$zero" "$half"
pfm b.pfm "$zero" "$zero"
pfm n.pfm "$zero" "$nan"
printf 'Pf\n1 1\n-1.0\n%b' "$zero" >small.pfm

works compare a.pfm a.pfm
grep -q 'MSE 0, PSNR inf dB, FLIP 0.000000, maximum 0: the images agree' out.txt || wrong "equal images: $(cat out.txt)"
differs() {
    "$CLAST" compare "$@" >out.txt 2>err.txt
    [ $? -eq 1 ] || wrong "compare $*: did not end with 1"
    [ ! -s err.txt ] || wrong "compare $*: $(cat err.txt)"
}
differs a.pfm b.pfm
grep -q 'MSE 0.125, PSNR 9.03 dB, FLIP [01][.0-9]*, maximum 0.5 at 1,0, 1 pixels differ: the images differ' out.txt || wrong "figures: $(cat out.txt)"
works compare --max-difference 0.5 a.pfm b.pfm
differs --max-difference 0.49 a.pfm b.pfm
works compare --max-mse 0.125 a.pfm b.pfm
differs --max-mse 0.124 a.pfm b.pfm
differs --max-mse 0.2 --max-difference 0.1 a.pfm b.pfm
differs --max-mse 1e30 --max-difference 1e30 a.pfm n.pfm

"$CLAST" compare --json a.pfm b.pfm >out.txt
[ $? -eq 1 ] || wrong "compare --json: did not end with 1"
"$JSON_HAS" out.txt mse maximum differing_pixels agree >values.txt || wrong "JSON: $(cat out.txt)"
[ "$(tr '\n' ' ' <values.txt)" = '0.125 0.5 1 false ' ] || wrong "JSON: $(cat values.txt)"

works compare --max-flip 1 a.pfm b.pfm
differs --max-flip 0.01 a.pfm b.pfm
works compare a.pfm a.pfm same.png
works compare same.png same.png
differs a.pfm b.pfm errors.pfm
[ "$(head -c 2 errors.pfm)" = Pf ] || wrong 'errors.pfm is not a PFM file of one channel'
# layers of EXR files, as a render writes them
works generate canyon scene --detail 0.02 --quiet
works render scene/scene.json a.exr --width 32 --height 18 --spp 1 --quiet
works render scene/scene.json half.exr --width 32 --height 18 --spp 1 --quiet --bits 16
works render scene/scene.json normal.exr --width 32 --height 18 --spp 1 --quiet --view normal
works compare a.exr a.exr --layer all
[ "$(grep -c ': the layers agree' out.txt)" -ge 10 ] || wrong "layers: $(cat out.txt)"
differs a.exr half.exr --layer all
works compare a.exr half.exr --layer all --max-difference 0.05
works compare a.exr normal.exr --layer N
differs a.exr normal.exr --layer all --max-difference 1e30
grep -q 'only one of the files has this layer' out.txt || wrong "missing layers: $(cat out.txt)"
fails 2 'no such layer' compare a.exr a.exr --layer nothing
fails 2 'only EXR files have layers' compare a.pfm a.pfm --layer N

fails 2 'errors.txt' compare a.pfm a.pfm errors.txt
fails 2 'one too many' compare a.pfm a.pfm errors.pfm more
fails 2 'missing.png' compare a.pfm missing.png
fails 2 'expected equal sizes' compare a.pfm small.pfm
fails 2 'compare.sh' compare a.pfm "$DATA/compare.sh"
finish
