// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "io/digest.hpp"
#include "nav/image.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Where a verb writes. Files appear under their names only when complete. Not thread-safe.
class OutputFolder {
 public:
  /// Creates the folder when it is missing and proves that it can be written to.
  static Result<OutputFolder> create(const std::filesystem::path& path);

  /// Writes and lists a picture; its pixels enter the image digest.
  Result<void> write_picture(const std::string& name, const Image2d<Rgba8>& picture);
  /// Removes the reports of an earlier run, so that they never lie beside the pictures of a run
  /// that stopped.
  void forget_reports() const;
  /// Removes what an earlier run wrote under the names of this one, before its first picture:
  /// reports, files and numbered pictures ("sweep_012.png" of "sweep"). Links stay.
  [[nodiscard]] Result<void> forget_earlier_run(const std::set<std::string>& files,
                                                const std::set<std::string>& series) const;
  /// The same of files and numbered pictures alone, in a folder whose reports may be of others.
  [[nodiscard]] Result<void> forget(const std::set<std::string>& files,
                                    const std::set<std::string>& series = {}) const;
  Result<void> write_text(const std::string& name, const std::string& text);
  /// Lists a file that something else wrote.
  void list(const std::string& name) { files_.push_back(name); }

  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] const std::vector<std::string>& files() const { return files_; }
  /// SHA-256 over the SHA-256 of every picture's 8-bit RGBA pixels, in the order written.
  [[nodiscard]] std::string image_digest() const;

 private:
  explicit OutputFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
  std::vector<std::string> files_;
  std::string picture_digests_;
};

/// Removes the reports of an earlier run, and files of these names, before anything can stop this
/// one. Where there is no folder yet, none is made: a run may be refused.
Result<void> forget_earlier_reports(const std::filesystem::path& folder,
                                    const std::set<std::string>& files = {});

}  // namespace nav::app
