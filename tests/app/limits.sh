# SPDX-License-Identifier: Apache-2.0
# Parts of pictures, and renders that a limit or an interrupt ends.
. "$DATA/check.sh"
rm -rf ./*

settings='--quiet --device cpu --width 90 --height 60'
box="$DATA/box.obj"

# A crop has the whole picture's pixels; an EXR file says where they lie.
works render $settings --spp 2 "$box" whole.exr
works render $settings --spp 2 --crop 0,0,90,60 "$box" all.exr
works compare --layer all whole.exr all.exr
works render $settings --spp 2 --crop 30,20,17,11 "$box" part.exr
works render $settings --spp 2 --crop 30,20,17,11 "$box" part.png
works info part.exr
grep -q '90 x 60' out.txt || wrong "a crop as .exr: $(cat out.txt)"
works info part.png
grep -q '17 x 11' out.txt || wrong "a crop as .png: $(cat out.txt)"
fails 1 'setting crop: expected X,Y,WIDTH,HEIGHT in pixels, within the picture of 90 x 60' \
    render $settings --crop 80,20,17,11 "$box" no.png
absent no.png

# Limits.
works render $settings --time-limit 0.000001 --json "$box" time.png
[ "$("$JSON_HAS" out.txt samples)" = 1 ] || wrong "--time-limit: $(cat out.txt)"
[ "$("$JSON_HAS" out.txt settings.spp)" = 65536 ] || wrong "--time-limit without --spp: $(cat out.txt)"
works render $settings --noise-target 0.05 --min-spp 16 --json "$box" noise.png
"$JSON_HAS" out.txt samples mean_samples pixels_above_target >values.txt || wrong "--noise-target: $(cat out.txt)"
[ "$(tail -1 values.txt)" = 0 ] || wrong "--noise-target: $(cat values.txt)"
works render $settings --noise-target 0.01 --spp 64 --view samples "$box" samples.png

# An interrupt leaves a checkpoint, from which the picture becomes what it would have been. Points are laid out for 4096 samples.
settings='--quiet --device cpu --width 32 --height 18'
"$CLAST" render $settings --spp 4096 --checkpoint kept --checkpoint-interval 0.1 "$box" some.pfm 2>err.txt &
process=$!
for wait in 1 2 3 4 5 6 7 8 9 10; do
    [ -e kept ] && break
    sleep 0.5
done
kill -INT $process
wait $process
code=$?
[ $code -eq 3 ] || [ $code -eq 0 ] || wrong "interrupted: $code, $(cat err.txt)" # 0: it was done before
works render $settings --spp 1 --resume kept --json "$box" some.pfm
samples=$("$JSON_HAS" out.txt samples)
[ "$samples" -ge 1 ] || wrong "resumed: $(cat out.txt)"
[ "$samples" -gt 2100 ] || samples=2100
works render $settings --spp "$samples" --resume kept "$box" more.pfm
works render $settings --spp "$samples" "$box" straight.pfm
same more.pfm straight.pfm

fails 1 'another value of the setting seed' render $settings --seed 4 --resume kept "$box" no.pfm
fails 1 'for another camera' render $settings --camera 0,3,1/0,0,0 --resume kept "$box" no.pfm
fails 1 'no checkpoint of clast' render $settings --resume "$box" "$box" no.pfm
fails 2 'a checkpoint is of one picture' render $settings --frames 1:2 --checkpoint kept "$box" no.pfm
fails 2 'needs --checkpoint' render $settings --checkpoint-interval 3 "$box" no.pfm
fails 1 'cannot be written there' render $settings --checkpoint no/such/folder/kept "$box" no.pfm
absent no.pfm
finish
