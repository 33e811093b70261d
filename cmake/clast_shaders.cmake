# SPDX-License-Identifier: Apache-2.0
# Kernels: each shaders/FOLDER/NAME.comp (or .rgen and the like) becomes SPIR-V within the library, validated, under the number
# CLAST_SHADER_FOLDER_NAME. NAME.source.comp is compiled once for each kind of source, with SOURCE_KIND its number and an
# include file source_kind.glsl that is source/KIND.glsl, under CLAST_SHADER_FOLDER_NAME_KIND.
find_program(CLAST_GLSLANG glslangValidator REQUIRED)
find_program(CLAST_SPIRV_VAL spirv-val REQUIRED)

set(CLAST_SHADER_FOLDER ${CMAKE_BINARY_DIR}/shaders)
file(MAKE_DIRECTORY ${CLAST_SHADER_FOLDER})
file(GLOB_RECURSE shader_files CONFIGURE_DEPENDS RELATIVE ${CMAKE_SOURCE_DIR}/shaders
    ${CMAKE_SOURCE_DIR}/shaders/*.comp ${CMAKE_SOURCE_DIR}/shaders/*.rgen ${CMAKE_SOURCE_DIR}/shaders/*.rmiss
    ${CMAKE_SOURCE_DIR}/shaders/*.rchit ${CMAKE_SOURCE_DIR}/shaders/*.rahit)
if(NOT CLAST_BENCH)
    list(FILTER shader_files EXCLUDE REGEX "^bench/")
endif()
if(NOT CLAST_TESTS)
    list(FILTER shader_files EXCLUDE REGEX "^probe/")
endif()
file(READ ${CMAKE_SOURCE_DIR}/include/clast/lists.h lists)
string(REGEX MATCHALL "X\\(CLAST_SOURCE_[A-Z_]+, [0-9]+" source_lines "${lists}")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/include/clast/lists.h)

set(shader_symbols "")
set(shader_headers "")
set(shader_names "")

# Arithmetic is marked as not to be contracted once a shader is compiled: shader_embed.c says why not by `precise`.
add_executable(shader_embed src/vulkan/generate/shader_embed.c)
target_link_libraries(shader_embed PRIVATE clast_flags)

# A shader under its symbol. `defines` are for its compiler.
macro(clast_shader file symbol)
    set(spirv ${CLAST_SHADER_FOLDER}/${symbol}.spv)
    set(header ${CLAST_SHADER_FOLDER}/${symbol}.inc)
    add_custom_command(OUTPUT ${spirv}
        COMMAND ${CLAST_GLSLANG} -V --quiet --target-env vulkan1.3 -Dprecise= -I${CMAKE_SOURCE_DIR}/shaders
            -I${CMAKE_SOURCE_DIR}/src -I${CMAKE_SOURCE_DIR}/include ${ARGN} --depfile ${spirv}.d -o ${spirv}
            ${CMAKE_SOURCE_DIR}/shaders/${file}
        DEPENDS ${CMAKE_SOURCE_DIR}/shaders/${file} DEPFILE ${spirv}.d
        COMMENT "Compiling shader ${file}" VERBATIM)
    add_custom_command(OUTPUT ${header}
        COMMAND shader_embed ${spirv} ${spirv}.exact ${header}
        COMMAND ${CLAST_SPIRV_VAL} --target-env vulkan1.3 --scalar-block-layout ${spirv}.exact
        DEPENDS ${spirv} shader_embed
        COMMENT "Embedding ${symbol}" VERBATIM)
    list(APPEND shader_symbols ${symbol})
    list(APPEND shader_headers ${header})
    list(APPEND shader_names ${file})
endmacro()

foreach(file ${shader_files})
    string(REGEX REPLACE "\\.[a-z]+$" "" stem ${file})
    string(REGEX MATCH "\\.source$" per_source "${stem}")
    string(REGEX REPLACE "\\.source$" "" stem ${stem})
    string(REGEX REPLACE "[/.-]" "_" symbol ${stem})
    string(TOUPPER ${symbol} symbol)
    if(per_source)
        foreach(line ${source_lines})
            string(REGEX REPLACE "X\\(CLAST_SOURCE_([A-Z_]+), ([0-9]+)" "\\1;\\2" kind "${line}")
            list(GET kind 0 kind_name)
            list(GET kind 1 kind_number)
            string(TOLOWER ${kind_name} kind_file)
            if(NOT EXISTS ${CMAKE_SOURCE_DIR}/shaders/source/${kind_file}.glsl)
                continue() # a kind without a twin: the device refuses it
            endif()
            file(CONFIGURE OUTPUT ${CLAST_SHADER_FOLDER}/${kind_file}/source_kind.glsl
                CONTENT "#include \"source/${kind_file}.glsl\"\n")
            clast_shader(${file} ${symbol}_${kind_name} -DSOURCE_KIND=${kind_number} -I${CLAST_SHADER_FOLDER}/${kind_file})
        endforeach()
    elseif(file MATCHES "\\.comp$")
        clast_shader(${file} ${symbol})
    else()
        clast_shader(${file} ${symbol} -DGPU_RAY_STAGE)
    endif()
    # Kernels that trace rays of lists are launches of a ray tracing pipeline too (shaders/render/trace.glsl).
    file(STRINGS ${CMAKE_SOURCE_DIR}/shaders/${file} traces REGEX "^#include \"render/trace.glsl\"")
    if(traces)
        clast_shader(${file} ${symbol}_DRIVER -DGPU_RAY_STAGE -S rgen)
    endif()
endforeach()

# The list of them: an enum, and a table of where their words are.
set(enum_text "")
set(include_text "")
set(table_text "")
foreach(symbol header file IN ZIP_LISTS shader_symbols shader_headers shader_names)
    string(APPEND enum_text "    CLAST_SHADER_${symbol},\n")
    string(APPEND include_text "static const uint32_t words_of_${symbol}[] = {\n#include \"shaders/${symbol}.inc\"\n};\n")
    string(APPEND table_text
        "    [CLAST_SHADER_${symbol}] = {\"${file}\", \"${symbol}\", words_of_${symbol}, sizeof words_of_${symbol}},\n")
endforeach()
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/vulkan_shaders.h CONTENT
"// Made by the build: the shaders of the folder shaders/.
#ifndef CLAST_VULKAN_SHADERS_H
#define CLAST_VULKAN_SHADERS_H
#include <stddef.h>
#include <stdint.h>
typedef enum clast_shader {
@enum_text@    CLAST_SHADER_COUNT_,
} clast_shader;
typedef struct clast_shader_code {
    const char *file; // in shaders/
    const char *symbol; // of the enum, without CLAST_SHADER_: SYMBOL.spv.exact is what the build made of the file
    const uint32_t *words;
    size_t bytes;
} clast_shader_code;
extern const clast_shader_code clast_shader_codes[];
#endif
" @ONLY)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/vulkan_shaders.c CONTENT
"// Made by the build.
#include \"vulkan_shaders.h\"
@include_text@const clast_shader_code clast_shader_codes[] = {
@table_text@    [CLAST_SHADER_COUNT_] = {0},
};
" @ONLY)
set_source_files_properties(${CMAKE_BINARY_DIR}/vulkan_shaders.c PROPERTIES OBJECT_DEPENDS "${shader_headers}")
add_custom_target(clast_shaders DEPENDS ${shader_headers})
target_sources(clast_vulkan PRIVATE ${CMAKE_BINARY_DIR}/vulkan_shaders.c ${shader_headers})
target_include_directories(clast_vulkan PUBLIC ${CMAKE_BINARY_DIR})
