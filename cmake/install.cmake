# Installation: libraries, headers, CMake package, pkg-config files, models, licence.
set(config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/graspctx")
set(pkgconfig_dir "${CMAKE_INSTALL_LIBDIR}/pkgconfig")

install(TARGETS graspctx graspctx_io
        EXPORT graspctxTargets
        RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}"
        LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
        ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
        FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(EXPORT graspctxTargets NAMESPACE graspctx:: DESTINATION "${config_dir}")

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/graspctxConfig.cmake.in"
                              "${PROJECT_BINARY_DIR}/cmake/graspctxConfig.cmake"
                              INSTALL_DESTINATION "${config_dir}" NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may break what uses it.
write_basic_package_version_file("${PROJECT_BINARY_DIR}/cmake/graspctxConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/cmake/graspctxConfig.cmake"
              "${PROJECT_BINARY_DIR}/cmake/graspctxConfigVersion.cmake"
              "${PROJECT_SOURCE_DIR}/cmake/FindLIBSVM.cmake"
        DESTINATION "${config_dir}")

# The .pc files find their prefix relative to themselves, so the installed tree can be moved.
foreach(directory INCLUDEDIR LIBDIR)
  file(RELATIVE_PATH relative "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_FULL_${directory}}")
  string(REGEX REPLACE "/$" "" relative "${relative}")
  set(PC_${directory} "\${pcfiledir}/${relative}")
endforeach()
foreach(library graspctx graspctx_io)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${library}.pc.in" "${PROJECT_BINARY_DIR}/cmake/${library}.pc" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/cmake/${library}.pc" DESTINATION "${pkgconfig_dir}")
endforeach()

# The libraries and the program find each other, and the models, wherever the tree is moved to.
file(RELATIVE_PATH libraries_from_programs "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_LIBDIR}")
set_target_properties(graspctx_io PROPERTIES INSTALL_RPATH "$ORIGIN")
if(GRASPCTX_BUILD_CLI)
  set_target_properties(graspctx_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries_from_programs}")
  install(TARGETS graspctx_cli RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endif()

install(DIRECTORY "${PROJECT_SOURCE_DIR}/models" DESTINATION "${CMAKE_INSTALL_DATADIR}/graspctx"
        FILES_MATCHING PATTERN "*.safetensors")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
