# SPDX-License-Identifier: Apache-2.0
# Files that are missing, empty, cut off, of another kind, or folders; outputs that cannot be written: one line, and nothing
# half written.
. "$DATA/check.sh"
rm -rf ./*
mkdir folder

: >empty.obj
printf 'glTF\002\000\000\000' >short.glb
printf '{"asset": {"version": "2.0"}, "meshes": [' >cut.gltf
printf 'ply\nformat ascii 1.0\nelement vertex 3\n' >cut.ply
head -c 300 "$CLAST" >program.gltf
printf '\211PNG\r\n\032\n\000\000\000\015IHDR' >cut.png
printf 'v 0 0 0\nf 1 2 3\n' >range.obj

for verb in render info; do
    fails 1 'missing.gltf' $verb missing.gltf
    fails 1 'folder' $verb folder
    for file in empty.obj short.glb cut.gltf cut.ply program.gltf range.obj; do
        fails 1 "$file" $verb $file
    done
done
fails 1 'cut.png' info cut.png
absent missing.png folder.png empty.png short.png program.png range.png

fails 1 'nowhere/picture.png' render "$DATA/box.obj" nowhere/picture.png
fails 1 'folder' render "$DATA/box.obj" folder/x.png/y.png
mkdir folder.png
fails 1 'folder.png' render "$DATA/box.obj" folder.png
fails 1 'nowhere' render --width 8 --height 8 --spp 1 --quiet --json=nowhere/x.json "$DATA/box.obj" picture.png
fails 1 'camera' render --camera nobody "$DATA/box.obj" other.png
fails 1 'missing.hdr' render --env missing.hdr --width 8 --height 8 "$DATA/box.obj" other.png
fails 1 'memory' render --memory 100K "$DATA/box.obj" other.png
absent other.png nowhere
: >file
fails 1 'file' generate --detail 0.02 canyon file/below
ls -A | grep -q '\.png\.' && wrong "a temporary file is left: $(ls -A)"
finish
