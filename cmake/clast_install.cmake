# SPDX-License-Identifier: Apache-2.0
# What is installed: the command with its manual page and completion, the library with a CMake package and a pkg-config file.
include(CMakePackageConfigHelpers)

install(TARGETS clast_library_static clast_library_shared EXPORT clast
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/clast DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/clast)
install(EXPORT clast NAMESPACE clast:: FILE clast-targets.cmake DESTINATION ${package})
configure_package_config_file(cmake/clast-config.cmake.in ${CMAKE_BINARY_DIR}/clast-config.cmake INSTALL_DESTINATION ${package})
# Before 1.0 every minor version may change the interface.
write_basic_package_version_file(${CMAKE_BINARY_DIR}/clast-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/clast-config.cmake ${CMAKE_BINARY_DIR}/clast-config-version.cmake DESTINATION ${package})

file(RELATIVE_PATH CLAST_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /) # so that an installed tree may be moved
configure_file(cmake/clast.pc.in ${CMAKE_BINARY_DIR}/clast.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/clast.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(TARGETS clast RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# The command prints its own manual page and completion, from the table that its parser uses.
if(NOT CMAKE_CROSSCOMPILING)
    add_custom_command(OUTPUT clast.1 clast.bash
        COMMAND clast help --man > clast.1
        COMMAND clast help --completion > clast.bash
        DEPENDS clast VERBATIM)
    add_custom_target(clast_manual ALL DEPENDS clast.1 clast.bash)
    install(FILES ${CMAKE_BINARY_DIR}/clast.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
    install(FILES ${CMAKE_BINARY_DIR}/clast.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME clast)
endif()
