# SPDX-License-Identifier: Apache-2.0
# Animations: numbered pictures, each the same whichever frames were asked for.
. "$DATA/check.sh"
rm -rf ./*

cat >scene.json <<'JSON'
{"clast": 1, "models": [{"path": "move.gltf"}], "environment": {"colour": [1, 1, 1]},
 "waves": [{"size": 4, "tiles": 2, "amplitude": 0.3, "translation": [0, -1, 0]}],
 "cameras": [{"position": [0, 1, 6], "target": [0, 0, 0]}],
 "settings": {"width": 48, "height": 32, "spp": 1, "bounces": 2, "exposure": {"keys": [[0, 0], [1, -2]]}}}
JSON
# A triangle at node 0, which goes 4 to the right within two seconds, and back at once.
base64 -d >move.bin <<'BASE64'
AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAEAAAAAAAAAAAAAAAAAAAIBAAAAAAAAAAAA=
BASE64
cat >move.gltf <<'JSON'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "animations": [{"name": "slide", "samplers": [{"input": 1, "output": 2}],
  "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
  {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "SCALAR"},
  {"bufferView": 0, "byteOffset": 44, "componentType": 5126, "count": 2, "type": "VEC3"}],
 "bufferViews": [{"buffer": 0, "byteLength": 68}], "buffers": [{"uri": "move.bin", "byteLength": 68}]}
JSON

works render --quiet --frames 1:10 --fps 8 scene.json all.exr
works render --quiet --frames 10:10 --fps 8 scene.json one.exr
works render --quiet --frames 10 --fps 8 --threads 1 scene.json alone-%03d.exr
works render --quiet --time 1.25 scene.json still.exr
for frame in 01 02 03 04 05 06 07 08 09 10; do
    [ -s "all.00$frame.exr" ] || wrong "all.00$frame.exr is not there"
done
absent all.exr all.0000.exr all.0011.exr one.0009.exr one.exr
same all.0010.exr one.0010.exr
same all.0010.exr alone-010.exr
same all.0010.exr still.exr
cmp -s all.0009.exr all.0010.exr && wrong "nothing moves"

# Statistics of each frame.
works render --json=stats.json --quiet --frames 0:2 scene.json f.png
"$JSON_HAS" stats.json verb settings.width frames >values.txt || wrong "statistics: $(cat stats.json)"
grep -c '"image_hash"' stats.json | grep -qx 3 || wrong "not three frames: $(cat stats.json)"
grep -q '"frame": 2' stats.json || wrong "no frame 2: $(cat stats.json)"

# What moves can be chosen, or held.
works render --quiet --time 1 --animation none scene.json none.exr
works render --quiet --time 1 --animation slide scene.json named.exr
works render --quiet --time 1 scene.json default.exr
same named.exr default.exr
cmp -s none.exr default.exr && wrong "--animation none changes nothing"
fails 1 'animation "walk": expected the name or number of one of the scene'"'"'s 1 animations' render --animation walk scene.json a.png

works info --no-cook move.gltf
grep -q '^animations: 1' out.txt && grep -q '^  0 slide: 2 s, 1 channels' out.txt || wrong "info: $(cat out.txt)"

# A setting changes with time.
works render --quiet --time 0 --exposure 0 --animation none scene.json bright.png
works render --quiet --time 0 --animation none scene.json keyed.png
same bright.png keyed.png
works render --quiet --time 1 --animation none scene.json dark.png
works render --quiet --time 1 --exposure -2 --animation none scene.json darker.png
same dark.png darker.png
cmp -s bright.png dark.png && wrong "the keys of exposure change nothing"

fails 2 'expected two whole numbers' render --frames 3:1 scene.json a.png
fails 2 'expected two whole numbers' render --frames 1: scene.json a.png
fails 2 'expected two whole numbers' render --frames x scene.json a.png
fails 1 'shutter: samples are divided among its moments' render --shutter 1 --time-limit 1 scene.json a.png
fails 1 'shutter: samples are divided among its moments' render --shutter 1 --noise-target 0.1 scene.json a.png
fails 2 'expected one of them' render --frames 1:2 --time 3 scene.json a.png
fails 2 'needs --frames' render --fps 30 scene.json a.png
absent a.png a.0001.png
finish
