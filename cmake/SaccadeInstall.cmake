# cmake --install BUILD --prefix PREFIX: the event camera as a library (docs/emulator.md). Headers lie below
# include/saccade, which is on the include path too, for they name each other from the project's root.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(SACCADE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/saccade)

foreach(layer core emulator)
  set_target_properties(saccade_${layer} PROPERTIES EXPORT_NAME ${layer})
  target_include_directories(saccade_${layer} INTERFACE
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/saccade>)
endforeach()
install(TARGETS saccade_core saccade_emulator EXPORT saccadeTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(EXPORT saccadeTargets NAMESPACE saccade:: DESTINATION ${SACCADE_PACKAGE_DIR} COMPONENT library)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/core DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/saccade COMPONENT library
  FILES_MATCHING PATTERN "*.h")
install(FILES ${CMAKE_SOURCE_DIR}/emulator/emulator_config.h ${CMAKE_SOURCE_DIR}/emulator/event_emulator.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/saccade/emulator COMPONENT library)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/saccadeConfig.cmake.in
  ${CMAKE_BINARY_DIR}/saccadeConfig.cmake INSTALL_DESTINATION ${SACCADE_PACKAGE_DIR}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/saccadeConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/saccadeConfig.cmake ${CMAKE_BINARY_DIR}/saccadeConfigVersion.cmake
  DESTINATION ${SACCADE_PACKAGE_DIR} COMPONENT library)

# The helper program that reads HDF5 (recording/helper_reader.h), where it was built.
install(TARGETS saccade_hdf5_reader DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/saccade COMPONENT program OPTIONAL)
