# SPDX-License-Identifier: Apache-2.0
# Geometry that adapts: its settings, budgets and views, and its export.
. "$DATA/check.sh"
rm -rf ./*

works generate --quiet --detail 0.02 cloister yard
works generate --quiet --detail 0.02 --threads 1 cloister again
for file in yard/*; do
    same "$file" "again/${file#yard/}"
done

# triangles ARGUMENT...: how many there are in the frame.
triangles() {
    works render --quiet --width 80 --height 45 --spp 1 --bounces 1 --json=frame.json "$@" yard/scene.json frame.png
    "$JSON_HAS" frame.json triangles >value.txt || wrong "$*: no statistics"
    cat value.txt
}

least=$(triangles --rate 0)
usual=$(triangles)
finer=$(triangles --segment 1)
[ "$usual" -gt "$least" ] || wrong "--rate 0: $least triangles, without it $usual"
[ "$finer" -gt "$usual" ] || wrong "--segment 1: $finer triangles, without it $usual"
[ "$(triangles --rate 2)" -gt "$usual" ] || wrong "--rate 2 is not finer"
[ "$(triangles --hidden-fraction 0)" -lt "$usual" ] || wrong "--hidden-fraction 0 is not coarser"
[ "$(triangles --metric fixed --segment 1)" -eq "$least" ] || wrong "--metric fixed --segment 1 is not the least"
[ "$(triangles --metric length --segment 0.5)" -ne "$usual" ] || wrong "--metric length changes nothing"
[ "$(triangles --metric sphere)" -ne "$usual" ] || wrong "--metric sphere changes nothing"

# A frozen camera keeps the triangles.
near=$(triangles --camera globe)
[ "$(triangles --camera yard --tess-camera globe)" -eq "$near" ] || wrong "--tess-camera does not keep the triangles"

# A table of patterns of one's own.
awk -f "$DATA/patterns.awk" >fans.txt
fans=$(triangles --patterns fans.txt)
[ "$fans" -gt "$least" ] && [ "$fans" -ne "$usual" ] || wrong "--patterns: $fans triangles, as without"
[ "$(triangles --patterns fans.txt --rate 0)" -eq "$least" ] || wrong "--patterns: the least is another"
works render --quiet --width 80 --height 45 --spp 1 --view triangle yard/scene.json own.png
works render --quiet --width 80 --height 45 --spp 1 --view triangle --patterns fans.txt yard/scene.json fans.png
cmp -s own.png fans.png && wrong "--patterns changes no triangle"
works export --quiet --patterns fans.txt --metric fixed --segment 5 --instance 0 --weld yard/scene.json fans.ply
sed '/^pattern 11 11 11/,$d' fans.txt >short.txt
fails 1 'short.txt' render --patterns short.txt yard/scene.json no.png
sed 's/^triangle 11 0 3$/triangle 11 3 0/' fans.txt >turned.txt
fails 1 'turned.txt' render --patterns turned.txt yard/scene.json no.png
absent no.png

# Budgets are kept, and the least is told.
half=$(((usual + least) / 2))
[ "$(triangles --max-triangles $half)" -le $half ] || wrong "--max-triangles $half is not kept"
fails 1 'a budget of 10 triangles is below' render --max-triangles 10 yard/scene.json no.png
fails 1 'a budget of 2 clusters is below' render --max-clusters 2 yard/scene.json no.png
[ "$(triangles --segment 0.25 --max-memory 1)" -lt "$(triangles --segment 0.25)" ] || wrong "--max-memory 1 is not kept"
absent no.png

# Pictures: the same for any number of threads; settings take effect.
settings='--quiet --width 80 --height 45 --spp 2'
works render $settings --threads 1 yard/scene.json one.exr
works render $settings --threads 3 yard/scene.json three.exr
same one.exr three.exr
works render $settings yard/scene.json usual.png
for change in '--displacement-scale 0' '--displacement-scale -1' '--curved'; do
    works render $settings $change yard/scene.json changed.png
    cmp -s usual.png changed.png && wrong "$change changes nothing"
done
for view in primitive segments rate area; do
    works render $settings --view $view yard/scene.json $view.png
    [ -s $view.png ] || wrong "--view $view: no picture"
done

# Export.
works export --quiet --metric fixed --segment 2 yard/scene.json yard.glb
works export --quiet --metric fixed --segment 2 --instance 0 --weld yard/scene.json yard.ply
works export --json --metric fixed --segment 2 yard/scene.json yard.gltf
"$JSON_HAS" out.txt written.meshes written.instances written.triangles written.vertices rate >values.txt ||
    wrong "export: no statistics: $(cat out.txt)"
works info --json yard.glb
"$JSON_HAS" out.txt mesh_triangles >value.txt || wrong "info: no statistics"
[ "$(cat value.txt)" = "$(sed -n 3p values.txt)" ] || wrong "yard.glb has $(cat value.txt) triangles, not $(sed -n 3p values.txt)"
works validate yard.glb
works validate yard.gltf
fails 2 'ends in .gltf, .glb or .ply' export yard/scene.json yard.obj
fails 2 'export needs INPUT OUTPUT' export yard/scene.json
fails 2 'export has no option --spp' export --spp 3 yard/scene.json yard.ply
fails 1 'no visible instance 1000000' export --instance 1000000 yard/scene.json no.ply
fails 2 'did you mean --max-triangles?' render --max-triangle 3 a
fails 2 '--tess-camera: expected CAMERA after it' render a --tess-camera
fails 1 'nowhere.txt' render --patterns nowhere.txt yard/scene.json no.png
absent no.ply no.png yard.obj
finish
