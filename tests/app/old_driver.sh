# SPDX-License-Identifier: Apache-2.0
# A device that lacks what clast needs: asked for, it is refused with the reason; left to the command, the processor serves, and
# the log says why. The device is that of a software driver that is too old, as Debian 12 has it (scripts/mesa --old).
. "$DATA/check.sh"
rm -rf ./*

[ -f "${OLD_DRIVER:-}" ] || { echo "skipped: no driver that is too old (scripts/mesa --old)"; exit 77; }
LD_LIBRARY_PATH=$(sed -n 's/^LD_LIBRARY_PATH=//p' "$(dirname "$OLD_DRIVER")/environment")
VK_DRIVER_FILES=$OLD_DRIVER
VK_ICD_FILENAMES=$OLD_DRIVER
# What such a driver keeps when it is closed is no leak of clast's.
ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}detect_leaks=0
export LD_LIBRARY_PATH VK_DRIVER_FILES VK_ICD_FILENAMES ASAN_OPTIONS
usual="--width 8 --height 8 --spp 1 $DATA/box.obj"

fails 1 "runtime descriptor arrays" render --quiet --device vulkan --device-name llvmpipe $usual no.png
works render --quiet --device cpu $usual cpu.png
works render --quiet --device auto $usual auto.png
cmp cpu.png auto.png || wrong 'auto: not the picture of the processor'
finish
