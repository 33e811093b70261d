# SPDX-License-Identifier: Apache-2.0
# 64-bit Arm: Debian's cross compiler, libraries from a folder that scripts/arm64 fills, programs run by qemu-user.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

get_filename_component(clast_source ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
set(CLAST_ARM64_ROOT ${clast_source}/build/arm64-root CACHE PATH "unpacked arm64 packages")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES CLAST_ARM64_ROOT)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L ${CLAST_ARM64_ROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${CLAST_ARM64_ROOT}/usr/lib/aarch64-linux-gnu/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${CLAST_ARM64_ROOT})
# Libraries that libraries need.
set(clast_libraries ${CLAST_ARM64_ROOT}/usr/lib/aarch64-linux-gnu:${CLAST_ARM64_ROOT}/lib/aarch64-linux-gnu)
set(CMAKE_EXE_LINKER_FLAGS_INIT -Wl,-rpath-link,${clast_libraries})
set(CMAKE_SHARED_LINKER_FLAGS_INIT -Wl,-rpath-link,${clast_libraries})
set(CMAKE_FIND_ROOT_PATH ${CLAST_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
