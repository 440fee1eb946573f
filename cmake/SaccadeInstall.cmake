# cmake --install BUILD --prefix PREFIX [--component NAME]. Components: program (with models and scenarios), library (the
# libraries saccade::core ... saccade::program with headers and a CMake package), python, manual (man pages, completion of
# shells), docs, examples; see docs/install.md. The tree may be moved.
# Headers lie below include/saccade, which is on the include path too, for they name each other from the project's root.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(SACCADE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/saccade)
set(SACCADE_DATA_DIR ${CMAKE_INSTALL_DATADIR}/saccade)

# The program; models and scenarios in share/saccade (sim/data_directory.h). Libraries in a prefix of their own are found as
# in the build; Debian's need no path.
if(TARGET saccade_yarp OR NOT mujoco_LIBRARY MATCHES "^/usr/lib/")
  set_target_properties(saccade PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
endif()
install(TARGETS saccade DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
# The helper program that reads HDF5, and the libraries that write it and read and write images (recording/helper_reader.h).
install(TARGETS saccade_hdf5_reader saccade_hdf5_writer saccade_image_codecs_library DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/saccade COMPONENT program)
install(DIRECTORY ${saccade_SOURCE_DIR}/models ${saccade_SOURCE_DIR}/scenarios DESTINATION ${SACCADE_DATA_DIR}
  COMPONENT program PATTERN invalid EXCLUDE PATTERN recurrent EXCLUDE)

# Man pages and the completion of shells, where Debian's packages have them; apps/CMakeLists.txt makes them with the program.
install(DIRECTORY ${saccade_BINARY_DIR}/pages/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT manual)
install(FILES ${saccade_SOURCE_DIR}/README.md ${saccade_SOURCE_DIR}/CHANGELOG.md ${saccade_SOURCE_DIR}/CITATION.cff
  ${saccade_SOURCE_DIR}/CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs)
install(DIRECTORY ${saccade_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT docs)
install(DIRECTORY ${saccade_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT examples USE_SOURCE_PERMISSIONS
  PATTERN __pycache__ EXCLUDE)

# Every layer is a library of the package: a static library needs those below it. `program` is the command line.
set(layers core flow hough tracker baselines detectors head threads control emulator recording robot loop sim scoring frame_camera
  calibration image_codecs report replay sensor_fit worlds config external images session live deploy serve sweep view cli)
if(TARGET saccade_yarp)
  list(APPEND layers yarp)
endif()
set(SACCADE_COMPONENTS "")
foreach(layer IN LISTS layers)
  set(name ${layer})
  if(layer STREQUAL cli)
    set(name program)
  endif()
  list(APPEND SACCADE_COMPONENTS ${name})
  set_target_properties(saccade_${layer} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(saccade_${layer} INTERFACE
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/saccade>)
  install(TARGETS saccade_${layer} EXPORT saccadeTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
endforeach()
install(EXPORT saccadeTargets NAMESPACE saccade:: DESTINATION ${SACCADE_PACKAGE_DIR} COMPONENT library)
install(CODE "set(SACCADE_SOURCE \"${saccade_SOURCE_DIR}\")
set(SACCADE_HEADERS \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/saccade\")" COMPONENT library)
install(SCRIPT ${saccade_SOURCE_DIR}/cmake/install_headers.cmake COMPONENT library)

configure_package_config_file(${saccade_SOURCE_DIR}/cmake/saccadeConfig.cmake.in
  ${CMAKE_BINARY_DIR}/saccadeConfig.cmake INSTALL_DESTINATION ${SACCADE_PACKAGE_DIR}
  PATH_VARS SACCADE_DATA_DIR NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/saccadeConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/saccadeConfig.cmake ${CMAKE_BINARY_DIR}/saccadeConfigVersion.cmake
  ${saccade_SOURCE_DIR}/cmake/Findmujoco.cmake DESTINATION ${SACCADE_PACKAGE_DIR} COMPONENT library)

set(CPACK_PACKAGE_CONTACT "The saccade authors <noreply@saccade.invalid>")
# cd build/release && cpack: packages/saccade_*.deb (the program, man pages, docs and examples), libsaccade-dev_*.deb and, where
# the Python module is built, python3-saccade_*.deb (docs/install.md). Each has a changelog and a copyright file, as Debian's
# policy asks for.
execute_process(COMMAND date -u -R -d ${SACCADE_DATE} OUTPUT_VARIABLE changelog_date OUTPUT_STRIP_TRAILING_WHITESPACE)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/packages/changelog @ONLY CONTENT "saccade (@PROJECT_VERSION@) unstable; urgency=low

  * The changes are in /usr/share/doc/saccade/CHANGELOG.md.

 -- @CPACK_PACKAGE_CONTACT@  @changelog_date@
")
# The licence with the paragraphs that Debian's format asks for: each line indented, an empty one a dot.
file(READ ${saccade_SOURCE_DIR}/LICENSE licence)
string(REGEX REPLACE "^[^\n]*\n\n[^\n]*\n\n" "" licence "${licence}")  # name and copyright
string(STRIP "${licence}" licence)
string(REPLACE "\n\n" "\n.\n" licence "${licence}")
string(REPLACE "\n" "\n " licence " ${licence}")
configure_file(${saccade_SOURCE_DIR}/cmake/copyright.in ${CMAKE_BINARY_DIR}/packages/copyright @ONLY)
set(packages saccade libsaccade-dev)
set(components program library)
if(TARGET saccade_module)
  list(APPEND packages python3-saccade)
  list(APPEND components python)
endif()
execute_process(COMMAND gzip -9 -n -k -f ${CMAKE_BINARY_DIR}/packages/changelog)
foreach(package component IN ZIP_LISTS packages components)
  install(FILES ${CMAKE_BINARY_DIR}/packages/changelog.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
    COMPONENT ${component})
  install(FILES ${CMAKE_BINARY_DIR}/packages/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME saccade)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
# A package is the component of its name; that of the program holds three more.
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENTS_ALL ${components} manual docs examples)
foreach(component IN LISTS components)
  string(TOUPPER ${component} group)
  set(CPACK_COMPONENT_${group}_GROUP ${component})
endforeach()
foreach(component MANUAL DOCS EXAMPLES)
  set(CPACK_COMPONENT_${component}_GROUP program)
endforeach()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME saccade)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# Programs and libraries that are started or loaded by name.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "gnuplot-nox, ffmpeg, python3, python3-numpy, fonts-dejavu-core, fonts-liberation, libegl1, libgl1-mesa-dri")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "hdf5-filter-plugin-blosc-serial")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "libosmesa6, slurm-client, xvfb")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "closed-loop testbench for event-driven vision on the iCub")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "A simulated iCub head watches a ball through a simulated event camera;
 a detector finds the ball and a gaze controller turns the head to it.
 Runs, scores and compares detectors on scenarios and recordings.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libsaccade-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS
  "saccade (= ${PROJECT_VERSION}), libeigen3-dev, libmujoco-dev, libceres-dev, libopencv-dev, libyaml-cpp-dev, nlohmann-json3-dev, libcli11-dev, libfmt-dev, pkg-config, liblz4-dev, libzstd-dev, libbz2-dev, zlib1g-dev, libglfw3-dev, libimgui-dev, libsqlite3-dev, libsqlitecpp-dev, libpugixml-dev")
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "Static libraries, headers and a CMake package: events, detectors,
 event camera emulator, event files, head kinematics, simulator,
 scoring, reports.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-saccade)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
# The module loads the models of the program's package.
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "saccade (= ${PROJECT_VERSION}), ${SACCADE_PYTHON_DEPENDS}, python3-numpy")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Python module of saccade: recordings as NumPy arrays, detectors,
 the event camera emulator, scoring, head kinematics, and the closed
 loop in lockstep.")
include(CPack)
