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

/// Output folder of a verb. Files appear under their names only when complete. Not thread-safe.
class OutputFolder {
 public:
  /// Creates the folder when it is missing and writes a test file to check that it is writable.
  static Result<OutputFolder> create(const std::filesystem::path& path);

  /// Writes an image and adds it to files(); its pixels enter the image digest.
  Result<void> write_image(const std::string& name, const Image2d<Rgba8>& image);
  /// Removes the reports of an earlier run, so that they never stand beside the images of a later
  /// run that stopped.
  void forget_reports() const;
  /// Removes files of an earlier run that have the names of this run. Call it before the first
  /// image. It removes reports, \p files and numbered images of \p series ("sweep_012.png" for
  /// "sweep"). Links stay.
  [[nodiscard]] Result<void> forget_earlier_run(const std::set<std::string>& files,
                                                const std::set<std::string>& series) const;
  /// Does what forget_earlier_run() does, but keeps the reports: those in a shared folder may be of
  /// another program.
  [[nodiscard]] Result<void> forget(const std::set<std::string>& files,
                                    const std::set<std::string>& series = {}) const;
  Result<void> write_text(const std::string& name, const std::string& text);
  /// Adds a file that other code wrote to files().
  void list(const std::string& name) { files_.push_back(name); }

  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] const std::vector<std::string>& files() const { return files_; }
  /// SHA-256 over the SHA-256 of every image's 8-bit RGBA pixels, in the order written.
  [[nodiscard]] std::string image_digest() const;

 private:
  explicit OutputFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
  std::vector<std::string> files_;
  std::string image_digests_;
};

/// Removes the reports of an earlier run and the named files. Call it before anything can stop the
/// new run. Does not create a missing folder, because the run may still be rejected.
Result<void> forget_earlier_reports(const std::filesystem::path& folder,
                                    const std::set<std::string>& files = {});

}  // namespace nav::app
