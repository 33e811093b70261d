# SPDX-License-Identifier: Apache-2.0
# The table of patterns is made by a program of the build. It is integers throughout, so that every machine makes the same.
add_executable(pattern_generate src/geometry/generate/pattern_generate.c src/geometry/generate/pattern_cut.c
    src/geometry/pattern_shape.c src/geometry/blocks.c)
target_include_directories(pattern_generate PRIVATE src include)
target_link_libraries(pattern_generate PRIVATE clast_flags m)
target_compile_options(pattern_generate PRIVATE -O2) # every build runs it

set(table ${CMAKE_BINARY_DIR}/pattern_table.c)
add_custom_command(OUTPUT ${table} COMMAND pattern_generate --table ${table} DEPENDS pattern_generate
    COMMENT "Cutting patterns" VERBATIM)
target_sources(clast_geometry PRIVATE ${table})
