# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT: a C++ file with the texts of the files NAMES ("a|b") in FOLDER.
string(REPLACE "\"" "" NAMES "${NAMES}")
string(REPLACE "|" ";" names "${NAMES}")
set(entries "")
foreach(name IN LISTS names)
  file(READ "${FOLDER}/${name}" text)
  string(APPEND entries "    {\"${name}\", R\"GLSL(${text})GLSL\"},\n")
endforeach()
file(
  WRITE "${OUTPUT}"
  "#include \"shaders/shaders.hpp\"\n\n#include <array>\n#include <utility>\n\nnamespace nav::shaders {\nnamespace {\nconstexpr std::pair<std::string_view, std::string_view> kSources[] = {\n${entries}};\n}  // namespace\n\nstd::string_view source(std::string_view name) {\n  for (const auto& [key, text] : kSources) {\n    if (key == name) return text;\n  }\n  return {};\n}\n}  // namespace nav::shaders\n"
)
