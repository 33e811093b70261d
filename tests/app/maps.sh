# SPDX-License-Identifier: Apache-2.0
# Displacement maps of odd sizes: a sheet is lifted by what they hold, whatever their size, or one error says what is wrong.
. "$DATA/check.sh"
rm -rf ./*

printf 'v %s\n' '0 0 0' '1 0 0' '1 1 0' '0 1 0' >sheet.obj
printf 'vt %s\n' '0 0' '1 0' '1 1' '0 1' >>sheet.obj
printf 'f %s\n' '1/1 2/2 3/3' '1/1 3/3 4/4' >>sheet.obj
scene() { # IMAGE MEMBERS
    printf '{"clast": 1, "models": [{"path": "sheet.obj", "displacement": {"image": "%s", "scale": 0.25%s}}]}' "$1" "${2:-}"
}

# map WIDTH HEIGHT COUNT: says that it has WIDTH x HEIGHT values, and has COUNT of 1.
map() {
    printf 'Pf\n%s %s\n-1\n' "$1" "$2"
    awk -v count="$3" 'BEGIN { for (i = 0; i < count; i++) print "1" }' | tr -d '\n' | sed 's/1/\x00\x00\x80\x3f/g'
}

# lifted MEMBERS: the whole of the sheet is a quarter up, without a hole in it.
lifted() {
    scene map.pfm "$1" >scene.json
    works export --quiet --metric fixed --segment 7 --weld --instance 0 scene.json sheet.ply
    works info sheet.ply
    grep -q '^bounds: 0 0 0.25 to 1 1 0.25$' out.txt || wrong "$size$1: $(grep '^bounds' out.txt)"
    works render --quiet --width 32 --height 18 --spp 1 scene.json sheet.png
    rm -f sheet.ply sheet.png
}

for size in '1 1' '2 1' '1 9' '3 5' '7 2' '37 100' '257 3' '1 1000'; do
    # shellcheck disable=SC2086 # two numbers
    map $size $((${size% *} * ${size#* })) >map.pfm
    for more in '' ', "wrap": "CLAMP_TO_EDGE"' ', "wrap": "MIRRORED_REPEAT", "repeat": [-3.7, 1e6]'; do
        lifted "$more"
    done
done

# refused TEXT: and nothing is written.
refused() {
    scene map.pfm >scene.json
    fails 1 "$1" render --quiet --width 32 --height 18 --spp 1 scene.json no.png
    grep -qF map.pfm err.txt || wrong "$1: does not name the map: $(cat err.txt)"
    absent no.png
}
rm map.pfm
refused 'map.pfm'
: >map.pfm
refused 'map.pfm'
map 0 0 0 >map.pfm
refused '0 x 0'
map 0 5 5 >map.pfm
refused '0 x 5'
map 100 100 99 >map.pfm
refused 'map.pfm'
for size in '2000000000 2000000000' '65536 65536' '1 99999999' '99999999999999999999 1' '-4 4'; do
    # shellcheck disable=SC2086 # two numbers
    map $size 4 >map.pfm
    refused 'map.pfm'
done
finish
