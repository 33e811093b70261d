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
small='--quiet --width 8 --height 8 --spp 1'
# shellcheck disable=SC2086 # lists of words
works render $small --json=/dev/null "$DATA/box.obj" picture.png
[ -c /dev/null ] || wrong "/dev/null was replaced"
# What cannot be written in the end leaves the file before as it was.
cp picture.png before.png
if [ -c /dev/full ]; then
    # shellcheck disable=SC2086 # lists of words
    fails 1 '/dev/full' render $small --json=/dev/full "$DATA/box.obj" picture.png
    "$CLAST" help >/dev/full 2>err.txt
    [ $? -eq 1 ] || wrong "help on a full disk did not fail"
fi
same picture.png before.png
# So does a limit on the size of files.
(
    ulimit -f 1
    "$CLAST" render --quiet --width 64 --height 64 --spp 1 "$DATA/box.obj" limited.png 2>err.txt
)
[ $? -eq 1 ] || wrong "a file beyond the limit did not fail"
grep -q '^clast: limited.png: ' err.txt || wrong "a file beyond the limit: $(cat err.txt)"
absent limited.png
# Links stay links.
ln -s picture.png link.png
# shellcheck disable=SC2086 # lists of words
works render $small --seed 3 "$DATA/box.obj" link.png
[ -L link.png ] || wrong "the link was replaced"
cmp -s picture.png before.png && wrong "what the link names was not written"
: >file
fails 1 'file' generate --detail 0.02 canyon file/below
ls -A | grep -q '\.png\.' && wrong "a temporary file is left: $(ls -A)"
finish
