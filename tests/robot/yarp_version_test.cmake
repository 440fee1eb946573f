# What cmake says of a YARP in the prefix, by stubs of its package: cmake -D SOURCE=... -P ...
if(DEFINED ENV{TMPDIR})
  set(temporary $ENV{TMPDIR})
else()
  set(temporary /tmp)
endif()
string(RANDOM LENGTH 12 name)
set(WORK ${temporary}/saccade_yarp_${name})

# A package of that version; `found`: whether it has the components.
function(stub version found)
  set(folder ${WORK}/${version}/lib/cmake/YARP)
  file(WRITE ${folder}/YARPConfig.cmake "set(YARP_FOUND ${found})\nset(YARP_NOT_FOUND_MESSAGE \"the component dev is missing\")\n")
  # As CMake's SameMajorVersion, which YARP has.
  file(WRITE ${folder}/YARPConfigVersion.cmake "set(PACKAGE_VERSION ${version})
string(REGEX MATCH \"^[0-9]+\" major \"\${PACKAGE_VERSION}\")
set(PACKAGE_VERSION_COMPATIBLE FALSE)
if(major EQUAL PACKAGE_FIND_VERSION_MAJOR AND PACKAGE_VERSION VERSION_GREATER_EQUAL PACKAGE_FIND_VERSION)
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
")
endfunction()

# Configures a project with that prefix and compares the exit status and the text.
function(expect version status pattern)
  file(WRITE ${WORK}/project/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(stub NONE)
include(${SOURCE}/cmake/SaccadeYarp.cmake)
message(STATUS \"YARP_FOUND=\${YARP_FOUND}\")
")
  file(REMOVE_RECURSE ${WORK}/build)
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK}/project -B ${WORK}/build -D CMAKE_PREFIX_PATH=${WORK}/${version}
    -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF -D CMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF
    -D CMAKE_FIND_USE_SYSTEM_ENVIRONMENT_PATH=OFF -D CMAKE_FIND_USE_CMAKE_ENVIRONMENT_PATH=OFF -D CMAKE_MAKE_PROGRAM=${CMAKE_COMMAND}
    ${ARGN}
    RESULT_VARIABLE found OUTPUT_VARIABLE text ERROR_VARIABLE text)
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  if(NOT found EQUAL status OR NOT text MATCHES "${pattern}")
    message(FATAL_ERROR "YARP ${version}: status ${found}, expected ${status} and ${pattern} in\n${text}")
  endif()
endfunction()

stub(4.0.0 TRUE)
stub(3.8.1 TRUE)
stub(3.12.3 TRUE)
stub(3.10.0 FALSE)
expect(4.0.0 1 "found version 4.0.0 in .*YARPConfig.cmake expected a version 3 from 3.9 on")
expect(4.0.0 0 "YARP_FOUND=0? " -D CMAKE_DISABLE_FIND_PACKAGE_YARP=ON)
expect(3.8.1 1 "found version 3.8.1 in .*YARPConfig.cmake expected a version 3 from 3.9 on")
expect(3.10.0 1 "found version 3.10.0 in .* the component dev is missing")
expect(3.12.3 0 "YARP_FOUND=1")
expect(none 0 "YARP_FOUND=0? ")

# The documentation names the same minimum.
file(READ ${SOURCE}/cmake/SaccadeYarp.cmake text)
string(REGEX MATCH "SACCADE_YARP_MINIMUM ([0-9.]+)" minimum "${text}")
set(minimum ${CMAKE_MATCH_1})
foreach(page README.md docs/robot.md)
  file(READ ${SOURCE}/${page} text)
  string(REGEX MATCHALL "YARP (>= )?[34]\\.[0-9]+( or newer)?" versions "${text}")
  foreach(version IN LISTS versions)
    if(version MATCHES ">=|newer" AND NOT version MATCHES "[^0-9]${minimum}($| )")
      message(FATAL_ERROR "${page} names ${version}, CMake ${minimum}")
    endif()
  endforeach()
endforeach()
file(REMOVE_RECURSE ${WORK})
