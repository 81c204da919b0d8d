// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/output_folder.hpp"

#include <utility>

#include "io/atomic_file.hpp"
#include "io/image_output.hpp"
#include "io/own_mark.hpp"

namespace nav::app {
namespace {

bool is_name_of(const RunFiles& run, const std::string& name) {
  if (run.files.contains(name)) return true;
  const std::size_t end = name.rfind('_');
  if (end == name.npos || !run.series.contains(name.substr(0, end))) return false;
  const std::string number = name.substr(end + 1);
  constexpr std::size_t kLeastDigits = 3;
  return number.ends_with(".png") && number.find_first_not_of("0123456789") == number.size() - 4 &&
         number.size() - 4 >= kLeastDigits;
}

}  // namespace

Result<OutputFolder> OutputFolder::create(const std::filesystem::path& path, Replaces replaces) {
  const auto reject = [&](const std::string& found) {
    return Error{ErrorCode::kIo,
                 path.string() + ": expected a folder that can be written to, found " + found};
  };
  if (path.empty()) return Error{ErrorCode::kUsage, "--out: expected a folder, found nothing"};
  std::error_code status;
  if (std::filesystem::exists(path, status) && !std::filesystem::is_directory(path, status)) {
    return reject("a file");
  }
  std::filesystem::create_directories(path, status);
  if (status) return reject(status.message());
  auto lock = FolderLock::take(path);
  if (!lock) return lock.error();
  io::remove_leftovers(path);
  return OutputFolder(path, *std::move(lock), replaces);
}

Result<std::optional<OutputFolder>> OutputFolder::open(const std::filesystem::path& path,
                                                       const RunFiles& run) {
  std::error_code status;
  if (path.empty() || !std::filesystem::exists(path, status)) return std::optional<OutputFolder>();
  auto out = create(path);
  if (!out) return out.error();
  if (const auto earlier = out->earlier_files(run); !earlier) return earlier.error();
  return std::optional(*std::move(out));
}

Result<void> OutputFolder::check_replaced(const std::filesystem::path& file) const {
  if (replaces_ == Replaces::kAnyFile) return {};
  std::error_code status;
  if (!std::filesystem::is_regular_file(file, status)) return {};
  const auto own = io::is_own_file(file);
  if (!own) return own.error();
  if (*own) return {};
  return Error{ErrorCode::kIo, file.string() +
                                   ": expected a file of an earlier run, which this run may "
                                   "replace, found one that Sonde did not write or that was "
                                   "changed; move it away or choose another folder"};
}

Result<std::vector<std::filesystem::path>> OutputFolder::earlier_files(const RunFiles& run) const {
  std::error_code status;
  std::vector<std::filesystem::path> earlier;
  std::filesystem::directory_iterator it(path_, status);
  for (; !status && it != std::filesystem::directory_iterator(); it.increment(status)) {
    std::error_code ignored;
    const bool file = std::filesystem::is_regular_file(it->symlink_status(ignored));
    if (!file || !is_name_of(run, it->path().filename().string())) continue;
    if (const auto ok = check_replaced(it->path()); !ok) return ok.error();
    earlier.push_back(it->path());
  }
  if (status) return Error{ErrorCode::kIo, path_.string() + ": cannot list: " + status.message()};
  return earlier;
}

Result<void> OutputFolder::forget_earlier_run(const RunFiles& run) const {
  const auto earlier = earlier_files(run);
  if (!earlier) return earlier.error();
  std::error_code status;
  for (const std::filesystem::path& file : *earlier) {
    if (std::filesystem::remove(file, status) || !status) continue;
    return Error{ErrorCode::kIo, file.string() + ": cannot remove: " + status.message()};
  }
  return {};
}

Result<void> OutputFolder::write_image(const std::string& name, const Image2d<Rgba8>& image) {
  if (const auto ok = check_replaced(path_ / name); !ok) return ok;
  if (const auto written = io::write_png(image, path_ / name); !written) return written;
  files_.push_back(name);
  image_digests_ += io::sha256_hex(std::as_bytes(image.pixels()));
  return {};
}

Result<void> OutputFolder::write_text(const std::string& name, const std::string& text) {
  if (const auto ok = check_replaced(path_ / name); !ok) return ok;
  return io::write_file(path_ / name, std::string_view(text));
}

Result<void> OutputFolder::write_session(const std::string& name, const std::string& toml,
                                         Diagnostics& diagnostics) {
  if (check_replaced(path_ / name)) return write_text(name, io::with_mark(toml));
  const std::string beside = std::filesystem::path(name).stem().string() + ".written.toml";
  if (auto written = write_text(beside, io::with_mark(toml)); !written) return written;
  diagnostics.report(Severity::kWarning, "session",
                     (path_ / name).string() +
                         ": Sonde did not write it, or it was changed: it stays, and the session "
                         "of this run is in " +
                         beside);
  return {};
}

std::string OutputFolder::image_digest() const { return io::sha256_hex(image_digests_); }

}  // namespace nav::app
