// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/overwriting.hpp"

#include <algorithm>
#include <string>
#include <system_error>

#include "io/atomic_file.hpp"
#include "io/ct.hpp"
#include "io/own_mark.hpp"
#include "io/sequence.hpp"

namespace nav::app {
namespace {

bool may_be_replaced(const std::filesystem::path& path) {
  std::error_code failed;
  return path.empty() || path == "-" ||
         std::filesystem::is_other(std::filesystem::status(path, failed));
}

/// Absolute path without links, . and ..; the file need not exist.
std::filesystem::path whole_name(const std::filesystem::path& path) {
  std::error_code failed;
  return std::filesystem::weakly_canonical(std::filesystem::absolute(path, failed), failed);
}

bool same(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code failed;
  if (std::filesystem::equivalent(a, b, failed)) return true;  // Links and other names too.
  return whole_name(a) == whole_name(b);
}

/// True if a file is one of the DICOM images in a folder, under any name or link.
bool is_image_of(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code failed;
  if (!std::filesystem::is_directory(folder, failed) || !io::is_dicom(file)) return false;
  std::filesystem::recursive_directory_iterator it(folder, failed);
  for (; !failed && it != std::filesystem::recursive_directory_iterator(); it.increment(failed)) {
    std::error_code ignored;
    if (std::filesystem::equivalent(it->path(), file, ignored)) return true;
  }
  return false;
}

/// Files that belong to the inputs, but that no option names: pixels beside a header.
std::vector<NamedFile> pixels_of(const std::vector<NamedFile>& inputs) {
  std::vector<NamedFile> pixels;
  for (const NamedFile& input : inputs) {
    for (const auto& file : io::sample_files(input.path)) {
      pixels.push_back(
          {"holds the pixels of " + input.path.string() + ", that of " + input.name, file});
    }
  }
  return pixels;
}

/// True if a path is in a folder, by its name: neither has to exist.
bool lies_below(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const auto inside = whole_name(path).lexically_relative(whole_name(folder));
  return !inside.empty() && *inside.begin() != "..";
}

bool is_there(const NamedFile& output) {
  std::error_code failed;
  return std::filesystem::is_regular_file(output.path, failed);
}

}  // namespace

Result<void> reject_overwriting(const std::vector<NamedFile>& outputs,
                                const std::vector<NamedFile>& inputs) {
  const bool replaces = std::ranges::any_of(outputs, is_there);
  const std::vector<NamedFile> pixels = replaces ? pixels_of(inputs) : std::vector<NamedFile>{};
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedFile& out = outputs[i];
    if (may_be_replaced(out.path)) continue;
    const auto reject = [&](const std::string& found) {
      return Error{ErrorCode::kUsage, out.name + ": expected a file of its own, found " +
                                          out.path.string() + ", which " + found};
    };
    std::vector<NamedFile> others = inputs;
    others.insert(others.end(), outputs.begin(), outputs.begin() + static_cast<std::ptrdiff_t>(i));
    for (const NamedFile& other : others) {
      if (other.path.empty()) continue;
      if (is_image_of(out.path, other.path)) {
        return reject("is an image of that of " + other.name);
      }
      if (same(out.path, other.path)) return reject("is that of " + other.name);
    }
    for (const NamedFile& file : pixels) {
      if (same(out.path, file.path)) return reject(file.name);
    }
  }
  return {};
}

Result<void> reject_foreign(const std::vector<NamedFile>& outputs) {
  for (const NamedFile& out : outputs) {
    if (out.path.empty() || !is_there(out)) continue;
    const auto own = io::is_own_file(out.path);
    if (!own) return Error{own.error().code, out.name + ": " + own.error().message};
    if (*own) continue;
    return Error{ErrorCode::kIo, out.name + ": expected no file or one of an earlier run, found " +
                                     out.path.string() +
                                     ", which Sonde did not write or which was changed; move it "
                                     "away or choose another name"};
  }
  return {};
}

Result<void> reject_unwritable(const std::vector<NamedFile>& outputs,
                               const std::vector<std::filesystem::path>& made) {
  for (const NamedFile& out : outputs) {
    if (may_be_replaced(out.path)) continue;
    const bool own_folder = std::ranges::any_of(
        made, [&](const auto& folder) { return !folder.empty() && lies_below(out.path, folder); });
    if (own_folder) continue;
    const auto file = io::AtomicFile::create(out.path);
    if (!file) return Error{file.error().code, out.name + ": " + file.error().message};
    const std::filesystem::path folder = out.path.parent_path();
    io::remove_leftovers(folder.empty() ? "." : folder);
  }
  return {};
}

}  // namespace nav::app
