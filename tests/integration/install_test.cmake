# Installs everything, moves it elsewhere, runs the program there, builds the examples against the libraries as a user
# would, and compares what the event camera prints with the same program linked to the libraries of this build.
#   cmake -D BUILD=... -D SOURCE=... -D COMPILER=... -D TYPE=... -D FLAGS=... -D IN_TREE=... -P ...
cmake_minimum_required(VERSION 3.25)
function(must)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}\nended with ${status}:\n${text}")
  endif()
  set(text "${text}" PARENT_SCOPE)
endfunction()

# Outside the build, whose own share/saccade lies above every folder in it.
if(DEFINED ENV{TMPDIR})
  set(temporary $ENV{TMPDIR})
else()
  set(temporary /tmp)
endif()
string(RANDOM LENGTH 12 name)
set(WORK ${temporary}/saccade_install_${name})
must(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/staged)
file(RENAME ${WORK}/staged ${WORK}/prefix)

file(GLOB_RECURSE package ${WORK}/prefix/*.cmake)
list(LENGTH package count)
if(count LESS 3)
  message(FATAL_ERROR "no CMake package was installed: ${package}")
endif()
foreach(file IN LISTS package)
  file(READ ${file} text)
  foreach(private ${SOURCE} ${BUILD} saccade_flags x86-64-v2 ffp-contract -Wall)
    string(FIND "${text}" ${private} at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} speaks of ${private}")
    endif()
  endforeach()
endforeach()

# What each component holds, and that a component is not left out of the list.
set(held_program bin/saccade share/saccade/scenarios/look_at_ball.yaml share/doc/saccade/copyright)
set(held_library include/saccade/core/event.h ${LIBDIR}/libsaccade_core.a ${LIBDIR}/cmake/saccade/saccadeConfig.cmake)
set(held_manual share/man/man1/saccade.1.gz share/man/man1/saccade-run.1.gz share/bash-completion/completions/saccade
  share/zsh/vendor-completions/_saccade)
set(held_docs share/doc/saccade/README.md share/doc/saccade/docs/install.md share/doc/saccade/docs/data_flow.svg)
set(held_examples share/doc/saccade/examples/CMakeLists.txt share/doc/saccade/examples/external/proportional.py)
file(GLOB_RECURSE everything RELATIVE ${WORK}/prefix ${WORK}/prefix/*)
foreach(component program library manual docs examples python)
  must(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/${component} --component ${component})
  file(GLOB_RECURSE found RELATIVE ${WORK}/${component} ${WORK}/${component}/*)
  foreach(file IN LISTS held_${component})
    if(NOT file IN_LIST found)
      message(FATAL_ERROR "the component ${component} has no ${file}; it has ${found}")
    endif()
  endforeach()
  if(found)  # the Python module is not part of every build
    list(REMOVE_ITEM everything ${found})
  endif()
endforeach()
if(everything)
  message(FATAL_ERROR "no component of docs/install.md has ${everything}")
endif()

# The program finds its models and scenarios where they were moved, and nowhere else.
file(MAKE_DIRECTORY ${WORK}/elsewhere)
set(run ${WORK}/prefix/bin/saccade run look_at_ball --set run.duration_s=0.03 --set output.pictures=0 --set expect={})
execute_process(COMMAND ${run} --out ${WORK}/elsewhere/run WORKING_DIRECTORY ${WORK}/elsewhere RESULT_VARIABLE status
  OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(NOT status EQUAL 0 OR NOT EXISTS ${WORK}/elsewhere/run/metrics.json)
  message(FATAL_ERROR "the installed program ended with ${status}:\n${text}")
endif()
# Files that scenarios name are relative to them.
execute_process(COMMAND ${WORK}/prefix/bin/saccade run gaze_football --set run.duration_s=0.03 --set output.pictures=0 --set expect={}
  --out ${WORK}/elsewhere/football WORKING_DIRECTORY ${WORK}/elsewhere RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "a scenario with files of its own ended with ${status}:\n${text}")
endif()
file(RENAME ${WORK}/prefix/share/saccade ${WORK}/prefix/share/hidden)
execute_process(COMMAND ${run} --out ${WORK}/elsewhere/none WORKING_DIRECTORY ${WORK}/elsewhere RESULT_VARIABLE status
  OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(NOT status EQUAL 1 OR NOT text MATCHES "no folder share/saccade")
  message(FATAL_ERROR "without share/saccade the program ended with ${status}:\n${text}")
endif()
file(RENAME ${WORK}/prefix/share/hidden ${WORK}/prefix/share/saccade)

must(${CMAKE_COMMAND} -S ${WORK}/prefix/share/doc/saccade/examples/emulator -B ${WORK}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${WORK}/prefix -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_BUILD_TYPE=${TYPE}
  -D CMAKE_CXX_FLAGS=${FLAGS})
must(${CMAKE_COMMAND} --build ${WORK}/build)
must(${WORK}/build/moving_bar)
set(installed "${text}")
must(${IN_TREE})
if(NOT installed STREQUAL text)
  message(FATAL_ERROR "the installed library says\n${installed}\nthat of this build\n${text}")
endif()
message(STATUS "${installed}")

# Each library in a program of its own, built against the moved tree.
must(${CMAKE_COMMAND} -S ${WORK}/prefix/share/doc/saccade/examples/libraries -B ${WORK}/libraries -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${WORK}/prefix -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_BUILD_TYPE=${TYPE}
  -D CMAKE_CXX_FLAGS=${FLAGS})
must(${CMAKE_COMMAND} --build ${WORK}/libraries)
# A program with a detector of one's own, likewise.
must(${CMAKE_COMMAND} -S ${WORK}/prefix/share/doc/saccade/examples -B ${WORK}/own -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${WORK}/prefix -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_BUILD_TYPE=${TYPE}
  -D CMAKE_CXX_FLAGS=${FLAGS})
must(${CMAKE_COMMAND} --build ${WORK}/own --target detector_example)
# Every library that is installed is a component of the package, by itself.
file(READ ${WORK}/prefix/${LIBDIR}/cmake/saccade/saccadeTargets.cmake text)
string(REGEX MATCHALL "add_library\\(saccade::[a-z_]+" found "${text}")
list(TRANSFORM found REPLACE "add_library\\(saccade::" "")
if(NOT "core" IN_LIST found OR NOT "threads" IN_LIST found)
  message(FATAL_ERROR "installed libraries: ${found}")
endif()
foreach(component IN LISTS found)
  file(WRITE ${WORK}/component/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(component C CXX)
find_package(saccade REQUIRED COMPONENTS ${component})
add_library(uses INTERFACE)
target_link_libraries(uses INTERFACE saccade::${component})
")
  must(${CMAKE_COMMAND} -S ${WORK}/component -B ${WORK}/component/build -G ${GENERATOR} -D CMAKE_PREFIX_PATH=${WORK}/prefix)
endforeach()

set(ENV{SACCADE_DATA} ${WORK}/prefix/share/saccade)  # the examples lie outside the tree
foreach(library core detectors control emulator recording robot loop sim scoring config session report)
  must(${WORK}/libraries/${library}_example)
  if(NOT text MATCHES "^${library}: ")
    message(FATAL_ERROR "${library}_example printed ${text}")
  endif()
endforeach()
must(${WORK}/libraries/program_example keys ball)
if(NOT text MATCHES "diameter of the ball")
  message(FATAL_ERROR "program_example printed ${text}")
endif()
must(${WORK}/own/detector_example keys detectors.centroid)
file(REMOVE_RECURSE ${WORK})
