# SPDX-License-Identifier: Apache-2.0
# How the project's folders, kernels and programs are compiled.

# Contraction off: the shared formulas promise the same bits everywhere. No trap and no errno: nothing here looks at them.
add_library(clast_flags INTERFACE)
target_compile_options(clast_flags INTERFACE -ffp-contract=off -fno-math-errno -fno-trapping-math
    -Wall -Wextra -Wno-psabi $<$<COMPILE_LANGUAGE:C>:-Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes -Wvla>)
target_compile_definitions(clast_flags INTERFACE _GNU_SOURCE)
if(CLAST_WARNINGS_AS_ERRORS)
    target_compile_options(clast_flags INTERFACE -Werror)
endif()
if(CLAST_SANITIZE)
    target_compile_options(clast_flags INTERFACE -fsanitize=${CLAST_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(clast_flags INTERFACE -fsanitize=${CLAST_SANITIZE})
endif()
if(CLAST_FUZZ)
    # What is left out here costs comparisons at each access, all of which are traced; the tests' build has it.
    target_compile_options(clast_flags INTERFACE -fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer
        -fno-sanitize-recover=all -fno-sanitize=null,alignment,pointer-overflow,object-size)
    target_link_options(clast_flags INTERFACE -fsanitize=address,undefined)
endif()
if(CLAST_COVERAGE)
    target_compile_options(clast_flags INTERFACE --coverage)
    target_link_options(clast_flags INTERFACE --coverage)
endif()
set(CMAKE_C_FLAGS_RELEASE "-O3 -DNDEBUG")

set(CLAST_FOLDERS "" CACHE INTERNAL "")
set(CLAST_KERNELS "" CACHE INTERNAL "") # their kernels: the objects of a static library leave out those of others within

# The instruction sets of kernel files: name and compiler options. Others than x86 have the plain one only.
set(CLAST_KERNEL_SETS plain)
set(CLAST_KERNEL_OPTIONS_plain "")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND CLAST_KERNEL_SETS sse42 avx2 avx512)
    set(CLAST_KERNEL_OPTIONS_sse42 -msse4.2)
    set(CLAST_KERNEL_OPTIONS_avx2 -mavx2 -mbmi -mlzcnt -mpopcnt)
    set(CLAST_KERNEL_OPTIONS_avx512 -mavx512f -mavx512vl -mavx512bw -mavx512dq -mavx512vbmi
        -mavx2 -mbmi -mbmi2 -mlzcnt -mpopcnt)
endif()

# Comparisons are traced for fuzzing where they are with what a file should contain, not where they decide geometry: there each of
# them takes longer than the arithmetic.
set(CLAST_UNTRACED base shared geometry accel source cook frame render vulkan)
set(CLAST_UNTRACED_FILES block block_bptc meshopt meshopt_filter number polygon texel)

# A folder of src/ as a static library clast_NAME. NAME.kernel.c files are compiled once for each instruction set.
function(clast_folder name)
    cmake_parse_arguments(folder "" "" "USES;LINK" ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/${name}/*.c)
    set(kernels ${sources})
    list(FILTER sources EXCLUDE REGEX "\\.kernel\\.c$")
    list(FILTER kernels INCLUDE REGEX "\\.kernel\\.c$")
    if(NOT sources)
        add_library(clast_${name} INTERFACE)
        target_link_libraries(clast_${name} INTERFACE clast_flags)
        target_include_directories(clast_${name} INTERFACE ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/include)
        foreach(used ${folder_USES})
            target_link_libraries(clast_${name} INTERFACE clast_${used})
        endforeach()
        return()
    endif()
    add_library(clast_${name} STATIC ${sources})
    if(CLAST_FUZZ)
        if(name IN_LIST CLAST_UNTRACED)
            set_source_files_properties(${sources} ${kernels} PROPERTIES COMPILE_OPTIONS -fno-sanitize-coverage=trace-cmp)
        elseif(name STREQUAL load)
            list(TRANSFORM CLAST_UNTRACED_FILES REPLACE "(.+)" "${CMAKE_SOURCE_DIR}/src/load/\\1.c")
            set_source_files_properties(${CLAST_UNTRACED_FILES} PROPERTIES COMPILE_OPTIONS -fno-sanitize-coverage=trace-cmp)
        endif()
    endif()
    target_include_directories(clast_${name} PUBLIC ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/include)
    target_link_libraries(clast_${name} PUBLIC clast_flags ${folder_LINK})
    foreach(used ${folder_USES})
        target_link_libraries(clast_${name} PUBLIC clast_${used})
    endforeach()
    if(kernels)
        foreach(set ${CLAST_KERNEL_SETS})
            add_library(clast_${name}_${set} OBJECT ${kernels})
            target_include_directories(clast_${name}_${set} PRIVATE ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/include)
            target_compile_options(clast_${name}_${set} PRIVATE ${CLAST_KERNEL_OPTIONS_${set}})
            target_compile_definitions(clast_${name}_${set} PRIVATE CLAST_KERNEL_SUFFIX=${set})
            target_link_libraries(clast_${name}_${set} PRIVATE clast_flags)
            target_sources(clast_${name} PRIVATE $<TARGET_OBJECTS:clast_${name}_${set}>)
            set(CLAST_KERNELS ${CLAST_KERNELS} clast_${name}_${set} CACHE INTERNAL "")
        endforeach()
    endif()
    set(CLAST_FOLDERS ${CLAST_FOLDERS} clast_${name} CACHE INTERNAL "")
endfunction()

# Before 1.0 every minor version may break the binary interface; from then on only a major one may.
set(CLAST_SOVERSION ${PROJECT_VERSION_MAJOR})
if(PROJECT_VERSION_MAJOR EQUAL 0)
    set(CLAST_SOVERSION 0.${PROJECT_VERSION_MINOR})
endif()

# The library, static and shared, from all folders.
function(clast_libraries)
    set(objects "")
    foreach(folder ${CLAST_FOLDERS} ${CLAST_KERNELS})
        list(APPEND objects $<TARGET_OBJECTS:${folder}>)
    endforeach()
    foreach(kind STATIC SHARED)
        string(TOLOWER ${kind} suffix)
        add_library(clast_library_${suffix} ${kind} ${objects})
        add_library(clast::${suffix} ALIAS clast_library_${suffix})
        target_include_directories(clast_library_${suffix} PUBLIC
            $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
        target_link_libraries(clast_library_${suffix} PRIVATE $<BUILD_INTERFACE:clast_flags> Threads::Threads m
            PkgConfig::jansson PkgConfig::png PkgConfig::turbojpeg PkgConfig::openexr PkgConfig::webp PkgConfig::zstd)
        set_target_properties(clast_library_${suffix} PROPERTIES OUTPUT_NAME clast EXPORT_NAME ${suffix} LINKER_LANGUAGE C
            VERSION ${PROJECT_VERSION} SOVERSION ${CLAST_SOVERSION})
        target_link_options(clast_library_${suffix} PRIVATE -Wl,--as-needed)
    endforeach()
endfunction()

# A program of all C files of a folder over the static library.
function(clast_program name folder)
    cmake_parse_arguments(program "" "" "LINK" ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/*.c)
    if(NOT sources)
        return()
    endif()
    add_executable(${name} ${sources})
    target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/src)
    target_link_libraries(${name} PRIVATE clast_flags clast_library_static Threads::Threads m
        PkgConfig::jansson PkgConfig::png PkgConfig::turbojpeg PkgConfig::openexr PkgConfig::webp PkgConfig::zstd
        ${program_LINK})
endfunction()
