# SPDX-License-Identifier: Apache-2.0
# Pictures that a Vulkan device makes against those of the processor: what is hit is the same, and an eye sees no difference.
# The device is the software driver's, or what CLAST_VULKAN_TEST_DEVICE names. Models come from CLAST_ASSETS, where it is set.
. "$DATA/check.sh"
rm -rf ./*

device="--device vulkan --device-name ${CLAST_VULKAN_TEST_DEVICE:-llvmpipe}"
usual='--quiet --width 160 --height 90 --spp 2'
works generate --quiet --detail 0.02 canyon canyon
works generate --quiet --detail 0.02 cloister cloister
if ! "$CLAST" render $usual --width 8 --height 8 $device canyon/scene.json first.exr 2>err.txt; then
    grep -qi vulkan err.txt || { cat err.txt; exit 1; }
    echo "skipped: $(cat err.txt)"
    exit 77
fi

# agrees ARGUMENT... : the pictures of both. Radiance may differ by FLIP 0.005 in the mean; numbers and depths are equal.
agrees() {
    works render $usual --device cpu "$@" a.exr
    works render $usual $device "$@" b.exr
    works compare --max-flip 0.005 a.exr b.exr
    cp out.txt picture.txt
    for layer in instance cluster triangle primitive segments; do
        works compare --layer $layer a.exr b.exr
    done
    echo "$*: $(cat picture.txt)"
}

agrees canyon/scene.json
agrees --camera globe --segment 4 cloister/scene.json
agrees --integrator ao --aperture 0.2 canyon/scene.json
agrees --fireflies soften --max-triangles 20000 cloister/scene.json

# A frame's statistics are the processor's.
counts() { "$JSON_HAS" "$1" triangles clusters vertices rate samples primary_rays; }
works render $usual --device cpu --json=a.json cloister/scene.json a.png
works render $usual $device --json=b.json cloister/scene.json b.png
[ "$(counts a.json)" = "$(counts b.json)" ] || wrong "statistics: $(counts b.json), not $(counts a.json)"

fails 1 'no such device' render $usual --device vulkan --device-name 'no such device' canyon/scene.json no.png
absent no.png

models='gltf-edge/CornellBox.glb gltf-edge/BoxTextured/BoxTextured.gltf gltf-edge/VertexColorTest/VertexColorTest.gltf
gltf-edge/KhronosSampleModels/TextureSettingsTest.gltf gltf-edge/MultiUVTest/MultiUVTest.gltf gltf-edge/02_suzanne/02_suzanne.gltf
gltf-edge/24_gpu_instancing/24_gpu_instancing.gltf gltf-compressed/pirate.glb gltf-models/Duck/Duck.gltf gltf-models/Avocado.glb
gltf-models/CesiumMilkTruck/CesiumMilkTruck.gltf gltf-animated/CesiumMan.glb gltf-animated/AnimatedMorphCube/AnimatedMorphCube.gltf
displaced-gltf/spot_rock/spot_rock.gltf'
if [ -n "${CLAST_ASSETS:-}" ]; then
    for model in $models; do
        [ ! -f "$CLAST_ASSETS/$model" ] || agrees --time 0.4 "$CLAST_ASSETS/$model"
    done
    fox=$CLAST_ASSETS/gltf-animated/Fox/Fox.gltf
    [ ! -f "$fox" ] || agrees --time 0.4 --shutter 0.3 --shutter-steps 2 "$fox"
fi
finish
