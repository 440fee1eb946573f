# cmake --install BUILD --prefix PREFIX [--component program|library]: the program with its models and scenarios, and the
# libraries saccade::core ... saccade::program with headers and a CMake package (docs/install.md). The tree may be moved.
# Headers lie below include/saccade, which is on the include path too, for they name each other from the project's root.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(SACCADE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/saccade)
set(SACCADE_DATA_DIR ${CMAKE_INSTALL_DATADIR}/saccade)

# The program; models and scenarios in share/saccade (sim/data_directory.h). Libraries of Debian that lie in folders of
# their own are found as in the build.
set_target_properties(saccade saccade_hdf5_reader PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
install(TARGETS saccade DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
# The helper program that reads HDF5 (recording/helper_reader.h).
install(TARGETS saccade_hdf5_reader DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/saccade COMPONENT program)
install(DIRECTORY ${saccade_SOURCE_DIR}/models ${saccade_SOURCE_DIR}/scenarios DESTINATION ${SACCADE_DATA_DIR}
  COMPONENT program PATTERN invalid EXCLUDE)
install(FILES ${saccade_SOURCE_DIR}/LICENSE ${saccade_SOURCE_DIR}/README.md ${saccade_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

# Every layer is a library of the package: a static library needs those below it. `program` is the command line.
set(layers core head control emulator recording robot loop sim scoring frame_camera calibration report config images session
  deploy serve sweep view cli)
if(TARGET saccade_yarp)
  list(APPEND layers yarp)
endif()
foreach(layer IN LISTS layers)
  set(name ${layer})
  if(layer STREQUAL cli)
    set(name program)
  endif()
  set_target_properties(saccade_${layer} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(saccade_${layer} INTERFACE
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/saccade>)
  install(TARGETS saccade_${layer} EXPORT saccadeTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
endforeach()
install(EXPORT saccadeTargets NAMESPACE saccade:: DESTINATION ${SACCADE_PACKAGE_DIR} COMPONENT library)
foreach(folder core head control emulator recording robot loop sim evaluation apps)
  install(DIRECTORY ${saccade_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/saccade COMPONENT library
    FILES_MATCHING PATTERN "*.h")
endforeach()
install(FILES ${saccade_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)

configure_package_config_file(${saccade_SOURCE_DIR}/cmake/saccadeConfig.cmake.in
  ${CMAKE_BINARY_DIR}/saccadeConfig.cmake INSTALL_DESTINATION ${SACCADE_PACKAGE_DIR}
  PATH_VARS SACCADE_DATA_DIR NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/saccadeConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/saccadeConfig.cmake ${CMAKE_BINARY_DIR}/saccadeConfigVersion.cmake
  DESTINATION ${SACCADE_PACKAGE_DIR} COMPONENT library)
