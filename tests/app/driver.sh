# SPDX-License-Identifier: Apache-2.0
# Pictures whose rays go through the driver's own acceleration structures, against those through clast's, on the device of
# vulkan.sh.
. "$DATA/check.sh"
rm -rf ./*

device="--device vulkan --device-name ${CLAST_VULKAN_TEST_DEVICE:-llvmpipe}"
usual='--quiet --width 128 --height 72 --spp 2'
works generate --quiet --detail 0.02 canyon canyon
if ! "$CLAST" render $usual $device --accel driver canyon/scene.json b.exr 2>err.txt; then
    grep -qi vulkan err.txt || { cat err.txt; exit 1; }
    echo "skipped: $(cat err.txt)"
    exit 77
fi

works render $usual $device --accel clast canyon/scene.json a.exr
works compare --max-flip 0.02 a.exr b.exr
cat out.txt
for layer in instance cluster triangle; do # no ray of this picture meets an edge
    works compare --layer $layer a.exr b.exr
done

# The processor has no driver.
fails 1 'accel driver' render $usual --device cpu --accel driver canyon/scene.json no.exr
absent no.exr
finish
