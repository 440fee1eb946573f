# Only robot/yarp needs YARP, and is not built without. In no Debian package; CMAKE_PREFIX_PATH tells where it is. A YARP that
# is there and does not fit ends the configuration: without a message, the backend `yarp` would be missing from the build.
set(SACCADE_YARP_MINIMUM 3.9)  # of docs/robot.md, too
set(SACCADE_YARP_COMPONENTS os dev)
find_package(YARP ${SACCADE_YARP_MINIMUM} QUIET COMPONENTS ${SACCADE_YARP_COMPONENTS})
if(NOT YARP_FOUND AND YARP_CONSIDERED_CONFIGS)
  set(found "")
  foreach(config version IN ZIP_LISTS YARP_CONSIDERED_CONFIGS YARP_CONSIDERED_VERSIONS)
    string(APPEND found "\n  version ${version} in ${config}")
  endforeach()
  if(YARP_NOT_FOUND_MESSAGE)
    string(APPEND found "\n  ${YARP_NOT_FOUND_MESSAGE}")
  endif()
  list(JOIN SACCADE_YARP_COMPONENTS ", " components)
  message(FATAL_ERROR "YARP: found${found}\nexpected a version 3 from ${SACCADE_YARP_MINIMUM} on, with ${components}. Pass its "
    "prefix first in -DCMAKE_PREFIX_PATH, or build without YARP: -DCMAKE_DISABLE_FIND_PACKAGE_YARP=ON")
endif()
