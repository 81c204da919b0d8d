// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/folder_lock.hpp"
#include "io/digest.hpp"
#include "nav/diagnostics.hpp"
#include "nav/image.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Names of the files that a verb may write into its folder.
struct RunFiles {
  std::set<std::string> files;   ///< Whole names.
  std::set<std::string> series;  ///< Numbered images: "sweep" for "sweep_012.png".
};

/// Output folder of a verb. One run at a time holds it. Files appear under their names only when
/// complete. A file that Sonde did not write (io::is_own_file) is neither removed nor replaced.
/// Not thread-safe.
class OutputFolder {
 public:
  /// Who may have written the files that are replaced.
  enum class Replaces { kOwnFiles, kAnyFile };

  /// Creates the folder when it is missing, takes its lock and removes unfinished files of
  /// processes that were killed. Errors: kIo when it cannot be written to or another run holds it.
  static Result<OutputFolder> create(const std::filesystem::path& path,
                                     Replaces replaces = Replaces::kOwnFiles);
  /// Takes a folder that exists, as create() does, and checks that all files in it with the names
  /// of \p run are of Sonde; none if there is no such folder: the run may still be rejected. Call
  /// it before the inputs are read. It removes no result.
  static Result<std::optional<OutputFolder>> open(const std::filesystem::path& path,
                                                  const RunFiles& run);

  /// Removes files of an earlier run that have the names of this run, so that its results never
  /// stand beside those of this run. Call it when the inputs have been read, before the first
  /// image. Links stay. Errors: kIo, before anything is removed, when one of them is not of Sonde.
  [[nodiscard]] Result<void> forget_earlier_run(const RunFiles& run) const;

  /// Writes an image and adds it to files(); its pixels enter the image digest.
  Result<void> write_image(const std::string& name, const Image2d<Rgba8>& image);
  Result<void> write_text(const std::string& name, const std::string& text);
  /// Writes the session of the run as \p name ("session.toml"). If there is a file of that name
  /// that is not of Sonde or was changed, it stays: the session is written beside it
  /// ("session.written.toml"), which is reported.
  Result<void> write_session(const std::string& name, const std::string& toml,
                             Diagnostics& diagnostics);
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
  OutputFolder(std::filesystem::path path, FolderLock lock, Replaces replaces)
      : path_(std::move(path)), lock_(std::move(lock)), replaces_(replaces) {}
  /// Files of the folder with names of the run. Errors: kIo when one of them is not of Sonde.
  [[nodiscard]] Result<std::vector<std::filesystem::path>> earlier_files(const RunFiles& run) const;
  [[nodiscard]] Result<void> check_replaced(const std::filesystem::path& file) const;

  std::filesystem::path path_;
  FolderLock lock_;
  Replaces replaces_;
  std::vector<std::string> files_;
  std::string image_digests_;
};

}  // namespace nav::app
