# SPDX-License-Identifier: Apache-2.0
# Sourced by the other scripts: finds out which Debian packages are missing, and installs them where that is allowed.
# The names are those of Debian 12, Debian 13 and Ubuntu 24.04.

# What each package is needed for is seen by trying it, so that a tool or library from elsewhere does as well.
package_is_there() {
    case $1 in
    cmake) command -v cmake ;;
    ninja-build) command -v ninja ;;
    gcc) command -v cc ;;
    g++) command -v c++ ;;
    pkg-config) command -v pkg-config ;;
    libjansson-dev) pkg-config --exists jansson ;;
    libpng-dev) pkg-config --exists libpng ;;
    libturbojpeg0-dev) pkg-config --exists libturbojpeg ;;
    libopenexr-dev) pkg-config --exists OpenEXR ;;
    libwebp-dev) pkg-config --exists libwebp ;;
    libvulkan-dev) pkg-config --exists vulkan ;;
    libzstd-dev) pkg-config --exists libzstd ;;
    libxxhash-dev) pkg-config --exists libxxhash ;;
    libcmocka-dev) pkg-config --exists cmocka ;;
    libembree-dev) ls /usr/include/embree*/rtcore.h || ls /usr/local/include/embree*/rtcore.h ;;
    glslang-tools) command -v glslangValidator ;;
    spirv-tools) command -v spirv-dis ;;
    clang) command -v clang ;;
    gcc-aarch64-linux-gnu) command -v aarch64-linux-gnu-gcc ;;
    g++-aarch64-linux-gnu) command -v aarch64-linux-gnu-g++ ;;
    qemu-user) command -v qemu-aarch64 ;;
    *) dpkg-query -W -f '${Status}' "$1" | grep 'install ok installed' ;;
    esac >/dev/null 2>&1
}

missing_packages() {
    for package in "$@"; do
        package_is_there "$package" || printf ' %s' "$package"
    done
}

# Only installs packages: never adds sources of packages, never removes anything.
install_packages() {
    command -v apt-get >/dev/null 2>&1 || return 1
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        sudo -n true >/dev/null 2>&1 || return 1
        as_root='sudo -n'
    fi
    echo "installing: $*"
    # Lists of packages may be old or absent; they are fetched only now that something is missing. Old ones may still do.
    $as_root apt-get update -qq || true
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" </dev/null
}

# prepare PACKAGE...: returns when all are there; else names what is missing and ends the script.
prepare() {
    missing=$(missing_packages "$@")
    [ -n "$missing" ] || return 0
    # shellcheck disable=SC2086 # a list of words
    install_packages $missing >&2 || true
    missing=$(missing_packages "$@")
    if [ -n "$missing" ]; then
        echo "these packages are missing and could not be installed:$missing" >&2
        echo "as root: apt-get install$missing" >&2
        exit 1
    fi
}

build_packages='cmake ninja-build gcc g++ pkg-config libjansson-dev libpng-dev libturbojpeg0-dev libopenexr-dev libwebp-dev
    libzstd-dev libxxhash-dev libvulkan-dev glslang-tools spirv-tools'
test_packages='libcmocka-dev libembree-dev vulkan-validationlayers libvulkan1'
fuzz_packages='clang libclang-rt-dev'
