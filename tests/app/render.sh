# SPDX-License-Identifier: Apache-2.0
# Pictures: the same bytes for any number of threads and any instruction set, every format, statistics.
. "$DATA/check.sh"
rm -rf ./*

works generate --quiet --detail 0.02 --seed 7 canyon scene
works generate --quiet --detail 0.02 --seed 7 --threads 1 canyon again
for file in scene/*; do
    same "$file" "again/${file#scene/}"
done
settings='--quiet --width 80 --height 45 --spp 2'
works render $settings --threads 1 scene/scene.json one.exr
for threads in 2 5; do
    works render $settings --threads $threads scene/scene.json other.exr
    same one.exr other.exr
done
for isa in plain sse4.2 avx2 avx512; do
    # A machine without the instruction set says so.
    if "$CLAST" info --no-cook --quiet --isa $isa "$DATA/box.obj" 2>err.txt || ! grep -q 'lacks the instruction set' err.txt; then
        works render $settings --isa $isa scene/scene.json other.exr
        same one.exr other.exr
    fi
done

# A scene under an obj file, with the default name, camera and light.
works render --quiet --width 64 --height 36 --spp 4 "$DATA/box.obj"
[ -s box.png ] || wrong "box.png is not there"
works compare box.png box.png
for view in colour albedo normal depth uv instance cluster triangle steps; do
    works render $settings --view $view "$DATA/box.obj" $view.png
    works render $settings --view $view "$DATA/box.obj" $view.exr
done
for view in colour albedo normal depth uv; do
    works render $settings --view $view "$DATA/box.obj" $view.pfm
    works render $settings --view $view "$DATA/box.obj" $view.hdr
done
works compare colour.pfm colour.exr
works render $settings "$DATA/box.obj" colour.jpg
works compare --max-difference 0.15 colour.jpg colour.png
works render $settings --bits 16 "$DATA/box.obj" deep.png
works compare --max-difference 0.0021 deep.png colour.png
cmp -s deep.png colour.png && wrong "--bits 16 changes nothing"
fails 2 '--bits' render $settings --bits 32 "$DATA/box.obj" deep.png
fails 2 '--bits' render $settings --bits 8 "$DATA/box.obj" deep.exr
fails 2 '--bits' render $settings --bits 16 "$DATA/box.obj" deep.jpg
works compare --max-difference 0.05 colour.hdr colour.pfm
cmp -s colour.png albedo.png && wrong "colour and albedo are equal"

# Settings take effect.
works render $settings --exposure 2 "$DATA/box.obj" bright.png
cmp -s bright.png colour.png && wrong "--exposure changes nothing"
works render $settings --seed 9 "$DATA/box.obj" seed.png
cmp -s seed.png colour.png && wrong "--seed changes nothing"
works render $settings --env 0,0,0 "$DATA/box.obj" dark.pfm
works render $settings --env 1,1,1 "$DATA/box.obj" white.pfm
cmp -s dark.pfm white.pfm && wrong "--env changes nothing"
works render $settings --env white.pfm "$DATA/box.obj" image.pfm
cmp -s image.pfm colour.pfm && wrong "--env with an image changes nothing"
works render $settings --camera 0,3,0.1/0,0,0 "$DATA/box.obj" above.png
cmp -s above.png colour.png && wrong "--camera changes nothing"

# Statistics.
works render $settings --json --copies 4 --memory 1G "$DATA/box.obj" copies.png
"$JSON_HAS" out.txt instances samples cancelled settings.width settings.tonemap milliseconds.load milliseconds.cook \
    milliseconds.passes.trace milliseconds.passes.tlas milliseconds.first_picture milliseconds.total triangles clusters \
    bytes.clas bytes_per_triangle.blas rays mrays_per_second memory_peak process_memory_peak image_hash >values.txt ||
    wrong "statistics: $(cat out.txt)"
head -3 values.txt | tr '\n' ' ' | grep -qx '8 2 false ' || wrong "statistics: $(head -3 values.txt)"
works render $settings --json=stats.json "$DATA/box.obj" stats.png
"$JSON_HAS" stats.json image_hash >hash.txt || wrong "no hash"
works render $settings --threads 1 --json=stats.json "$DATA/box.obj" stats.png
"$JSON_HAS" stats.json image_hash | cmp -s - hash.txt || wrong "the hash depends on the threads"

# Information.
works info "$DATA/box.obj"
grep -q '^geometries: 2, 14 triangles' out.txt || wrong "info: $(cat out.txt)"
grep -q '^clusters: 2' out.txt || wrong "info: no clusters: $(cat out.txt)"
works info --no-cook --json "$DATA/box.obj"
"$JSON_HAS" out.txt mesh_triangles instances images cameras lower upper >values.txt || wrong "info --json: $(cat out.txt)"
"$JSON_HAS" out.txt cooked >/dev/null 2>&1 && wrong "info --no-cook cooked"
works info --json "$DATA/box.obj"
"$JSON_HAS" out.txt cooked.clusters cooked.bytes.clas cooked.cluster_fill >values.txt || wrong "info --json: $(cat out.txt)"
works info box.png
grep -q '^image: 64 x 36, 3 channels, 8 bit' out.txt || wrong "info of an image: $(cat out.txt)"
finish
