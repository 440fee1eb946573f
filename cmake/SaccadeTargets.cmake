# One folder is one static library is one room of the table in docs/architecture.md. What a room may
# link is written in its CMakeLists.txt; tests/architecture holds both includes and links to the table.
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(saccade_flags INTERFACE)
target_compile_features(saccade_flags INTERFACE cxx_std_20)
target_include_directories(saccade_flags INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(saccade_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  # The same scenario and seed give the same bytes: no fused multiply-add that depends on the compiler.
  -ffp-contract=off
  # Nobody reads floating-point exceptions: the vectoriser need not keep them. Values stay the same.
  -fno-trapping-math
  # GCC 12 warns of std::string's own operator+ (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # Clang's -Wconversion has it, GCC's has not.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>)
if(SACCADE_WERROR)
  target_compile_options(saccade_flags INTERFACE -Werror)
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(saccade_flags INTERFACE -march=x86-64-v2)
endif()
if(SACCADE_SANITIZE)
  target_compile_options(saccade_flags INTERFACE -fsanitize=${SACCADE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(saccade_flags INTERFACE -fsanitize=${SACCADE_SANITIZE})
endif()
if(SACCADE_FUZZ)
  target_compile_options(saccade_flags INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(saccade_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# saccade_room(NAME SOURCES a.cpp ... ROOMS core ... LIBRARIES Eigen3::Eigen ...)
function(saccade_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;ROOMS;LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  add_library(saccade_${name} STATIC ${ROOM_SOURCES})
  list(TRANSFORM ROOM_ROOMS PREPEND saccade_)
  target_link_libraries(saccade_${name} PUBLIC ${ROOM_ROOMS} ${ROOM_LIBRARIES}
    PRIVATE $<BUILD_INTERFACE:saccade_flags> ${ROOM_PRIVATE_LIBRARIES})
  target_compile_features(saccade_${name} PUBLIC cxx_std_20)
  target_include_directories(saccade_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
endfunction()

# saccade_test(NAME SOURCES a_test.cpp ... ROOMS core ... LIBRARIES ... [SERIAL]): one GoogleTest program per room,
# each of its tests a CTest test. SERIAL: nothing else is tested beside them, since they need the machine's time.
function(saccade_test name)
  cmake_parse_arguments(TEST "SERIAL" "" "SOURCES;ROOMS;LIBRARIES" ${ARGN})
  if(TEST_SERIAL)
    set(serial PROPERTIES RUN_SERIAL TRUE)
  endif()
  add_executable(saccade_${name}_tests ${TEST_SOURCES})
  list(TRANSFORM TEST_ROOMS PREPEND saccade_)
  target_link_libraries(saccade_${name}_tests PRIVATE saccade_flags ${TEST_ROOMS} ${TEST_LIBRARIES}
    GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_definitions(saccade_${name}_tests PRIVATE
    SACCADE_SOURCE_DIR="${CMAKE_SOURCE_DIR}" SACCADE_SHARED_DATA="${CMAKE_SOURCE_DIR}/../shared/data")
  gtest_discover_tests(saccade_${name}_tests TEST_PREFIX "${name}." DISCOVERY_MODE PRE_TEST
    NO_PRETTY_VALUES ${serial})
endfunction()
