# One folder is one static library is one layer, a row of the table in docs/architecture.md. What a layer may
# link is written in its CMakeLists.txt; tests/architecture holds both includes and links to the table.
find_program(CCACHE ccache)
if(CCACHE)
  # What ccache has to be told of precompiled headers.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()

add_library(saccade_flags INTERFACE)
target_compile_features(saccade_flags INTERFACE cxx_std_20)
target_include_directories(saccade_flags INTERFACE ${saccade_SOURCE_DIR})
target_compile_options(saccade_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  # In test files that are compiled together a constant of one may have the name of a local variable of another. Clang warns of
  # such names in all files that are compiled together, and of a capture that has the name of its structured binding.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<NOT:$<BOOL:$<TARGET_PROPERTY:SACCADE_JOINED_TESTS>>>>:-Wshadow>
  # The same scenario and seed give the same bytes: no fused multiply-add that depends on the compiler.
  -ffp-contract=off
  # Nobody reads floating-point exceptions or errno after a function of cmath: the vectoriser need not keep them. Values
  # stay the same.
  -fno-trapping-math -fno-math-errno
  # The layers are linked into the Python module too, which is a shared library. Nobody replaces their functions.
  -fPIC -fno-semantic-interposition
  # GCC 12 warns of std::string's own operator+ (GCC bugs 105651 and 105329).
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-stringop-overflow;-Wno-array-bounds>"
  # What GCC has to write for ccache where a precompiled header is used.
  $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>
  # Clang's -Wconversion has the first, GCC's has not; its -Wpedantic has the second, for files that are embedded.
  "$<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion;-Wno-overlength-strings>")
if(SACCADE_WERROR)
  target_compile_options(saccade_flags INTERFACE -Werror)
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(saccade_flags INTERFACE -march=x86-64-v2)
endif()
if(SACCADE_SANITIZE)
  target_compile_options(saccade_flags INTERFACE -fsanitize=${SACCADE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(saccade_flags INTERFACE -fsanitize=${SACCADE_SANITIZE})
  # Ceres is built without sanitizers. With AddressSanitizer Eigen would allocate in another way here than there, and each
  # frees what the other allocated.
  if(SACCADE_SANITIZE MATCHES "address")
    target_compile_definitions(saccade_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
  # These three checks stand at every access to a member and double GCC's compile time with Eigen. AddressSanitizer finds null
  # pointers too, and the fuzzers (preset fuzz) have all three.
  if(SACCADE_SANITIZE MATCHES "undefined" AND NOT SACCADE_FUZZ)
    target_compile_options(saccade_flags INTERFACE -fno-sanitize=null,alignment,vptr)
  endif()
endif()
if(SACCADE_FUZZ)
  # A layer with the property SACCADE_PLAIN takes no part in what the fuzzers test.
  target_compile_options(saccade_flags INTERFACE "$<$<BOOL:$<TARGET_PROPERTY:SACCADE_PLAIN>>:-O0;-fno-sanitize=all>"
    $<$<NOT:$<BOOL:$<TARGET_PROPERTY:SACCADE_PLAIN>>>:-fsanitize=fuzzer-no-link>)
  target_link_options(saccade_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Headers that nearly every file reads, compiled once. They serve the compiler alone: a file still includes what it uses.
# `layers` for layers with loops over events, pixels or joints, `cold` for the others: -O1 halves their compile time.
foreach(kind layers cold)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/pch/${kind}.cpp CONTENT "")  # unlike file(WRITE) it leaves an old file alone
  add_library(saccade_${kind}_pch OBJECT ${CMAKE_BINARY_DIR}/pch/${kind}.cpp)
  target_link_libraries(saccade_${kind}_pch PRIVATE saccade_flags Eigen3::Eigen)
  target_precompile_headers(saccade_${kind}_pch PRIVATE
    <algorithm> <cstdint> <filesystem> <functional> <map> <memory> <optional> <span> <string> <string_view> <variant>
    <vector> <Eigen/Geometry>)
endforeach()
if(NOT SACCADE_CORE_ONLY)
  target_link_libraries(saccade_cold_pch PRIVATE fmt::fmt)
  target_precompile_headers(saccade_cold_pch PRIVATE <fmt/format.h>)
endif()
set(saccade_cold_options $<$<CONFIG:Release>:-O1>)
target_compile_options(saccade_cold_pch PRIVATE ${saccade_cold_options})

# saccade_layer(NAME SOURCES a.cpp ... LAYERS core ... LIBRARIES Eigen3::Eigen ... PRIVATE_LIBRARIES ... [COLD]
# [ALONE a.cpp ...]). COLD: no loops over events, pixels or joints. ALONE: sources that a unity build does not join with
# others, because names in their anonymous namespaces are the same.
function(saccade_layer name)
  cmake_parse_arguments(LAYER "COLD" "" "SOURCES;LAYERS;LIBRARIES;PRIVATE_LIBRARIES;ALONE" ${ARGN})
  list(TRANSFORM LAYER_LAYERS PREPEND saccade_)
  if(NOT LAYER_SOURCES)  # headers alone
    add_library(saccade_${name} INTERFACE)
    target_link_libraries(saccade_${name} INTERFACE ${LAYER_LAYERS} ${LAYER_LIBRARIES})
    target_compile_features(saccade_${name} INTERFACE cxx_std_20)
    target_include_directories(saccade_${name} INTERFACE $<BUILD_INTERFACE:${saccade_SOURCE_DIR}>)
    return()
  endif()
  add_library(saccade_${name} STATIC ${LAYER_SOURCES})
  target_link_libraries(saccade_${name} PUBLIC ${LAYER_LAYERS} ${LAYER_LIBRARIES}
    PRIVATE $<BUILD_INTERFACE:saccade_flags> ${LAYER_PRIVATE_LIBRARIES})
  target_compile_features(saccade_${name} PUBLIC cxx_std_20)
  target_include_directories(saccade_${name} PUBLIC $<BUILD_INTERFACE:${saccade_SOURCE_DIR}>)
  # The fuzzers read recordings, messages and scenarios. What they do not read compiles in a quarter of the time without
  # optimisation and sanitizers.
  if(SACCADE_FUZZ AND NOT name MATCHES "^(core|head|recording|robot|external|sim|worlds|config)$")
    set_target_properties(saccade_${name} PROPERTIES SACCADE_PLAIN ON DISABLE_PRECOMPILE_HEADERS ON)
  endif()
  if(LAYER_COLD)
    target_link_libraries(saccade_${name} PRIVATE fmt::fmt)
    target_compile_options(saccade_${name} PRIVATE ${saccade_cold_options})
    target_precompile_headers(saccade_${name} REUSE_FROM saccade_cold_pch)
  else()
    target_precompile_headers(saccade_${name} REUSE_FROM saccade_layers_pch)
  endif()
  set_source_files_properties(${LAYER_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# saccade_test(NAME SOURCES a_test.cpp ... LAYERS core ... LIBRARIES ... [SERIAL] [LOCKED] [NO_LEAK_CHECK] [ALONE a_test.cpp ...]): one
# GoogleTest program per layer, each of its tests a CTest test. SERIAL: no other test runs beside them. LOCKED: they run one
# at a time, beside those of other programs. NO_LEAK_CHECK: foreign libraries that they load and unload leak, and a sanitizer
# can no longer name them. ALONE: as in saccade_layer.
function(saccade_test name)
  cmake_parse_arguments(TEST "SERIAL;LOCKED;NO_LEAK_CHECK" "" "SOURCES;LAYERS;LIBRARIES;ALONE" ${ARGN})
  if(TEST_SERIAL)
    set(serial RUN_SERIAL TRUE)
  elseif(TEST_LOCKED)
    set(serial RESOURCE_LOCK saccade_${name})
  endif()
  if(TEST_NO_LEAK_CHECK)
    set(environment ENVIRONMENT ASAN_OPTIONS=detect_leaks=0)
  endif()
  add_executable(saccade_${name}_tests ${TEST_SOURCES})
  set_source_files_properties(${TEST_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  list(TRANSFORM TEST_LAYERS PREPEND saccade_)
  target_link_libraries(saccade_${name}_tests PRIVATE saccade_flags ${TEST_LAYERS} ${TEST_LIBRARIES}
    GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_definitions(saccade_${name}_tests PRIVATE
    SACCADE_SOURCE_DIR="${saccade_SOURCE_DIR}" SACCADE_SHARED_DATA="${saccade_SOURCE_DIR}/../shared/data")
  target_precompile_headers(saccade_${name}_tests REUSE_FROM saccade_tests_pch)
  # Tests check results, not speed: they compile in a third of the time without the optimiser's later passes.
  target_compile_options(saccade_${name}_tests PRIVATE $<$<CONFIG:Release>:-O1>)
  set_target_properties(saccade_${name}_tests PROPERTIES SACCADE_JOINED_TESTS "${CMAKE_UNITY_BUILD}")
  gtest_discover_tests(saccade_${name}_tests TEST_PREFIX "${name}." DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120
    NO_PRETTY_VALUES PROPERTIES TIMEOUT 600 ${serial} ${environment})
endfunction()
