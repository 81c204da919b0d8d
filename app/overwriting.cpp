// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/overwriting.hpp"

#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

namespace nav::app {
namespace {

bool may_be_replaced(const std::filesystem::path& path) {
  std::error_code failed;
  return path.empty() || path == "-" ||
         std::filesystem::is_other(std::filesystem::status(path, failed));
}

bool same(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code failed;
  if (std::filesystem::equivalent(a, b, failed)) return true;  // Links and other names too.
  const auto whole = [&](const std::filesystem::path& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path, failed), failed);
  };
  return whole(a) == whole(b);
}

bool is_dicom(const std::filesystem::path& path) {
  std::array<char, 132> head{};
  std::ifstream file(path, std::ios::binary);
  return file.read(head.data(), head.size()) && std::string_view(head.data() + 128, 4) == "DICM";
}

/// Whether a file is one of the pictures of a folder.
bool is_picture_of(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code failed;
  if (!std::filesystem::is_directory(folder, failed) || !is_dicom(file)) return false;
  std::filesystem::path above = std::filesystem::canonical(file, failed);
  while (above.has_relative_path()) {
    above = above.parent_path();
    if (std::filesystem::equivalent(above, folder, failed)) return true;
  }
  return false;
}

}  // namespace

Result<void> refuse_overwriting(const std::vector<NamedFile>& outputs,
                                const std::vector<NamedFile>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedFile& out = outputs[i];
    if (may_be_replaced(out.path)) continue;
    std::vector<NamedFile> others = inputs;
    others.insert(others.end(), outputs.begin(), outputs.begin() + static_cast<std::ptrdiff_t>(i));
    for (const NamedFile& other : others) {
      if (other.path.empty()) continue;
      if (is_picture_of(out.path, other.path)) {
        return Error{ErrorCode::kUsage, out.name + ": expected a file of its own, found " +
                                            out.path.string() + ", which is a picture of that of " +
                                            other.name};
      }
      if (!same(out.path, other.path)) continue;
      return Error{ErrorCode::kUsage, out.name + ": expected a file of its own, found " +
                                          out.path.string() + ", which is that of " + other.name};
    }
  }
  return {};
}

}  // namespace nav::app
