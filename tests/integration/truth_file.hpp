// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <fstream>

#include "io/json.hpp"

namespace nav::app {

/// Reads a truth file or a report.
inline io::Json read_json(const std::filesystem::path& path) {
  std::ifstream in(path);
  return io::Json::parse(in);
}

/// Returns a matrix from 16 numbers, row-major.
inline Eigen::Matrix4d matrix_of(const io::Json& numbers) {
  Eigen::Matrix4d m;
  for (int i = 0; i < 16; ++i) m(i / 4, i % 4) = numbers.at(static_cast<std::size_t>(i));
  return m;
}

}  // namespace nav::app
