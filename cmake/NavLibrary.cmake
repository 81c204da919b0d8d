# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0

# Compiler flags for the project's own code only; linked PRIVATE.
add_library(nav_warnings INTERFACE)
add_library(nav::warnings ALIAS nav_warnings)
target_compile_options(nav_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                              # False warnings of GCC 12 about overlaps in std::string and
                                              # unset strings in std::variant (bugs 105651, 105562, 105329).
                                              -Wno-restrict -Wno-maybe-uninitialized
                                              -Wno-stringop-overflow
                                              # False overlaps in batches: a warning, not an error.
                                              "$<$<BOOL:${SONDE_WERROR}>:-Werror;-Wno-error=array-bounds>")

# Flags of every translation unit of the project: language, sanitizers, and code that can also be part of
# a shared library, at no cost when its symbols are hidden.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
add_library(nav_common INTERFACE)
add_library(nav::common ALIAS nav_common)
target_compile_features(nav_common INTERFACE cxx_std_20)
target_include_directories(nav_common INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                $<INSTALL_INTERFACE:include/sonde>)
option(SONDE_NAN_INIT "Fill fresh Eigen matrices with NaN" OFF)
if(SONDE_NAN_INIT)
  target_compile_definitions(nav_common INTERFACE EIGEN_INITIALIZE_MATRICES_BY_NAN)
endif()
set(SONDE_UNSANITIZED "" CACHE STRING "Folders that are compiled without the sanitizer: those that no test to be run is about")
if(SONDE_SANITIZER)
  target_compile_options(
    nav_common INTERFACE $<$<NOT:$<BOOL:$<TARGET_PROPERTY:NAV_UNSANITIZED>>>:-fsanitize=${SONDE_SANITIZER}>
                         -fno-omit-frame-pointer)
  target_link_options(nav_common INTERFACE -fsanitize=${SONDE_SANITIZER})
  if(SONDE_SANITIZER MATCHES "address")
    # Otherwise Eigen allocates in its own way, unlike the parts of Eigen that are instantiated in
    # Debian's Ceres.
    target_compile_definitions(nav_common INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
  if(SONDE_SANITIZER MATCHES "undefined")
    # These checks take more than half of the time to compile Eigen. The address sanitizer finds
    # null pointers and reads through an overflowed pointer. The processor reports misaligned
    # vectors. No pointer is cast to a derived class unchecked.
    target_compile_options(nav_common
                           INTERFACE -fno-sanitize=null,alignment,pointer-overflow,vptr)
  endif()
  if(SONDE_FUZZ) # A finding has to end the program.
    target_compile_options(nav_common INTERFACE -fno-sanitize-recover=all
                                                -Wno-unknown-warning-option)
  endif()
endif()

# Optimisation of the files with the hot loops. Kernels for several processors compile the same text
# several times, which is half of the compile time of render under a sanitizer.
set(nav_hot_loops -O3)
if(SONDE_SANITIZER)
  set(nav_hot_loops -O1)
endif()

# Precompiled headers hide a missing include, so they are only for builds that test. The daily
# builds have none, and find every missing include. There is one set for the libraries, one for the
# app, one for the window and one for the test programs. They hold the headers, ours as well, that
# at least half of these files include: to read them takes two thirds of the time of a file.
# With this option the files of a library, the app or a test program are also compiled sixteen at a
# time, in less than half the time. Therefore names local to a file are unique there, and differ
# from names that headers declare. GCC collects garbage only above a gigabyte, which saves a tenth
# of the time. The faster linker of the binutils is used if it is installed.
option(SONDE_PRECOMPILE "Precompile common headers and compile in batches" OFF)
if(SONDE_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(nav_common INTERFACE --param=ggc-min-heapsize=1000000)
  find_program(nav_gold ld.gold)
  if(nav_gold)
    target_link_options(nav_common INTERFACE -fuse-ld=gold)
  endif()
endif()
# nav_precompiled(<name> HEADERS <h>… USES targets…): a set of precompiled headers, as a target.
function(nav_precompiled name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "HEADERS;USES")
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE nav::common nav::warnings Threads::Threads ${arg_USES})
  target_precompile_headers(${name} PRIVATE <Eigen/Core> <Eigen/Geometry> <algorithm> <array>
                            <chrono> <cmath> <filesystem> <functional> <limits> <map> <memory>
                            <mutex> <optional> <set> <span> <sstream> <string> <variant> <vector>
                            ${arg_HEADERS})
endfunction()
# nav_optimise_as_test(<target>): a lower optimisation level, because the time-critical code is in the
# libraries. The set of precompiled headers of the tests must have the same flags as its users.
function(nav_optimise_as_test target)
  target_compile_options(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-O1>)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
endfunction()
# nav_precompile(<target> <set>): the target's files include that set of precompiled headers, which
# is created at its first use.
function(nav_precompile target from)
  if(NOT SONDE_PRECOMPILE)
    return()
  endif()
  if(NOT TARGET ${from})
    set(nav ${PROJECT_SOURCE_DIR})
    set(of_nav ${nav}/nav/diagnostics.hpp ${nav}/nav/image.hpp ${nav}/nav/volume.hpp)
    # CLI11 is left out: its classes would be compiled completely in every file that includes it.
    set(of_app <nlohmann/json.hpp> ${nav}/app/console.hpp ${nav}/render/engine.hpp
               ${nav}/session/navigator.hpp)
    if(from STREQUAL "nav_test_headers")
      nav_precompiled(${from} HEADERS <gmock/gmock.h> <gtest/gtest.h> ${of_nav} USES Eigen3::Eigen
                      GTest::gmock)
      nav_optimise_as_test(${from})
    elseif(from STREQUAL "nav_app_headers")
      nav_precompiled(${from} HEADERS ${of_app} USES Eigen3::Eigen nlohmann_json::nlohmann_json)
    elseif(from STREQUAL "nav_window_headers")
      nav_precompiled(${from} HEADERS ${of_app} <QLabel> <QPushButton> <QWidget>
                      ${nav}/app/views/panels.hpp USES Eigen3::Eigen nlohmann_json::nlohmann_json
                      Qt6::Widgets)
    else()
      nav_precompiled(${from} HEADERS ${of_nav} USES Eigen3::Eigen)
    endif()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${from})
endfunction()

# ccache, where it is installed. Precompiled headers need its leave to ignore their time stamps.
option(SONDE_CCACHE "Compile through ccache if it is installed" ON)
find_program(nav_ccache ccache)
if(SONDE_CCACHE AND nav_ccache AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
                                  CCACHE_SLOPPINESS=pch_defines,time_macros ${nav_ccache})
endif()

set(SONDE_BATCHES ${SONDE_PRECOMPILE} CACHE STRING "Compile several files at a time: ON, OFF, or TESTS for tests and benchmarks only")
set_property(CACHE SONDE_BATCHES PROPERTY STRINGS ON OFF TESTS)
# nav_in_batches(<target>): the target's files are compiled several at a time.
function(nav_in_batches target)
  if(NOT SONDE_BATCHES)
    return()
  endif()
  if(SONDE_BATCHES STREQUAL "TESTS" AND NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/(tests|bench)")
    return()
  endif()
  # Avoids a warning: in a batch, the types local to a file seem to belong to a header.
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
  target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
endfunction()

set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()

# nav_add_library(<folder> SOURCES a.cpp… [USES targets…] [PRIVATE_USES targets…]):
# one static library per folder, called nav::<folder>. USES appear in public headers, PRIVATE_USES
# only in .cpp files.
function(nav_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;USES;PRIVATE_USES")
  add_library(nav_${name} STATIC ${arg_SOURCES})
  add_library(nav::${name} ALIAS nav_${name})
  target_link_libraries(
    nav_${name}
    PUBLIC nav::common ${arg_USES}
    PRIVATE nav::warnings ${arg_PRIVATE_USES})
  if(SONDE_SANITIZER AND name IN_LIST SONDE_UNSANITIZED)
    set_target_properties(nav_${name} PROPERTIES NAV_UNSANITIZED ON)
  elseif(name STREQUAL "window")
    nav_precompile(nav_${name} nav_window_headers)
  elseif(name MATCHES "^(app|bench_program)$")
    nav_precompile(nav_${name} nav_app_headers)
  else()
    nav_precompile(nav_${name} nav_library_headers)
  endif()
  nav_in_batches(nav_${name})
endfunction()

# nav_with_vtk_part(<folder> ON_DEMAND a.cpp): whoever links nav::<folder> also links nav_<folder>_vtk, the
# part of it that uses VTK. A target with the property NAV_VTK_ON_DEMAND, the program sonde, links
# instead a.cpp, which loads that part when a command needs it: to load VTK takes longer than all the
# rest of a short command.
file(RELATIVE_PATH nav_vtk_folder ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR}/sonde)
function(nav_with_vtk_part name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "ON_DEMAND" "")
  nav_add_library(${name}_on_demand SOURCES ${arg_ON_DEMAND} USES nav::nav)
  target_compile_definitions(nav_${name}_on_demand PRIVATE SONDE_VTK_FOLDER="${nav_vtk_folder}")
  set(on_demand $<BOOL:$<TARGET_PROPERTY:NAV_VTK_ON_DEMAND>>)
  target_link_libraries(
    nav_${name} INTERFACE $<$<NOT:${on_demand}>:$<TARGET_NAME:nav_${name}_vtk>>
                          $<BUILD_INTERFACE:$<${on_demand}:nav_${name}_on_demand>>)
  target_link_libraries(nav_${name}_vtk PRIVATE nav_${name})
  target_link_libraries(nav_${name}_on_demand PRIVATE nav_${name})
endfunction()

# nav_presets_beside_programs(): programs of the current folder find the presets of appearances as
# installed programs do, in a folder beside them.
function(nav_presets_beside_programs)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/app/appearance/presets
       ${CMAKE_CURRENT_BINARY_DIR}/appearances SYMBOLIC)
endfunction()

# nav_add_test(<name> SOURCES a_test.cpp… [USES targets…] [LABELS unit;…] [TIMEOUT s] [PREFIX text]
# [OPTIONS flags…]):
# one GoogleTest program. Each TEST becomes one CTest test, whose name follows the prefix. Under a
# sanitizer each program becomes four CTest tests. Default label: unit. Programs labelled gpu,
# hardware or slow are neither run nor built under a sanitizer. Options are used for compiling and
# linking.
function(nav_add_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "TIMEOUT;PREFIX" "SOURCES;USES;LABELS;OPTIONS")
  if(NOT arg_LABELS)
    set(arg_LABELS unit)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  add_executable(${name} ${arg_SOURCES})
  nav_presets_beside_programs()
  nav_optimise_as_test(${name})
  if(SONDE_SANITIZER AND arg_LABELS MATCHES "gpu|hardware|slow")
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    set(not_run ON)
  endif()
  target_link_libraries(${name} PRIVATE nav::common nav::warnings ${arg_USES} GTest::gmock
                                        GTest::gtest_main)
  if(arg_OPTIONS)
    target_compile_options(${name} PRIVATE ${arg_OPTIONS})
    target_link_options(${name} PRIVATE ${arg_OPTIONS})
  else()
    nav_precompile(${name} nav_test_headers)
  endif()
  nav_in_batches(${name})
  if(not_run)
    return()
  endif()
  if(SONDE_SANITIZER)
    # The part that every change runs: folders that read what comes from outside, and threads.
    cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME folder)
    if(folder MATCHES "^(nav|io|tracking|devices|sim|session|threads)$")
      list(APPEND arg_LABELS change)
      if(NOT TARGET change_tests)
        add_custom_target(change_tests)
      endif()
      add_dependencies(change_tests ${name})
    endif()
    # Under a sanitizer, the start of a program takes longer than most tests.
    set(parts 4)
    math(EXPR last "${parts} - 1")
    foreach(part RANGE ${last})
      add_test(NAME ${name}_${part} COMMAND ${name} --gtest_brief=1)
      set_tests_properties(
        ${name}_${part}
        PROPERTIES LABELS "${arg_LABELS}"
                   TIMEOUT 1800
                   ENVIRONMENT "GTEST_TOTAL_SHARDS=${parts};GTEST_SHARD_INDEX=${part}")
    endforeach()
    return()
  endif()
  include(GoogleTest)
  gtest_discover_tests(
    ${name}
    TEST_PREFIX "${arg_PREFIX}"
    DISCOVERY_TIMEOUT 120
    PROPERTIES LABELS "${arg_LABELS}" TIMEOUT ${arg_TIMEOUT})
endfunction()

# nav_add_benchmark(<name> SOURCES a_bench.cpp… [USES targets…] [SMOKE regex]): a Google Benchmark
# program. `ctest -L bench` runs it once as a smoke test: all benchmarks, or those that match the
# regex.
function(nav_add_benchmark name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "SMOKE" "SOURCES;USES")
  if(NOT arg_SMOKE)
    set(arg_SMOKE ".")
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE nav::common nav::warnings ${arg_USES}
                                        benchmark::benchmark_main)
  add_test(NAME ${name}_smoke COMMAND ${name} --benchmark_min_time=0.001
                                               "--benchmark_filter=${arg_SMOKE}")
  set_tests_properties(${name}_smoke PROPERTIES LABELS bench TIMEOUT 600)
endfunction()
