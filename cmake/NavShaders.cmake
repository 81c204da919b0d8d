# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0

# nav_embed_shaders(<target> FILES a.glsl…): a static library. Its function
# nav::shaders::source(name) returns the text of each file, embedded at build time.
function(nav_embed_shaders target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FILES")
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded_shaders.cpp)
  list(TRANSFORM arg_FILES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE paths)
  string(REPLACE ";" "|" names "${arg_FILES}")
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DFOLDER=${CMAKE_CURRENT_SOURCE_DIR}
            -DNAMES="${names}" -P ${PROJECT_SOURCE_DIR}/cmake/embed_shaders.cmake
    DEPENDS ${paths} ${PROJECT_SOURCE_DIR}/cmake/embed_shaders.cmake
    VERBATIM)
  add_library(nav_${target} STATIC ${output})
  add_library(nav::${target} ALIAS nav_${target})
  target_link_libraries(nav_${target} PUBLIC nav::common)
endfunction()
