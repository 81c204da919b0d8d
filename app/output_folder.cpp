// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/output_folder.hpp"

#include "io/atomic_file.hpp"
#include "io/image_output.hpp"

namespace nav::app {

Result<OutputFolder> OutputFolder::create(const std::filesystem::path& path) {
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
  const std::filesystem::path probe = path / ".sonde-write-test";
  if (const auto written = io::write_file(probe, std::string_view("x")); !written) {
    return reject(written.error().message);
  }
  std::filesystem::remove(probe, status);
  return OutputFolder(path);
}

Result<void> OutputFolder::write_image(const std::string& name, const Image2d<Rgba8>& image) {
  if (const auto written = io::write_png(image, path_ / name); !written) return written;
  files_.push_back(name);
  image_digests_ += io::sha256_hex(std::as_bytes(image.pixels()));
  return {};
}

void OutputFolder::forget_reports() const {
  std::error_code status;
  for (const char* name : {"report.json", "report.html"}) {
    std::filesystem::remove(path_ / name, status);
  }
}

Result<void> OutputFolder::forget_earlier_run(const std::set<std::string>& files,
                                              const std::set<std::string>& series) const {
  forget_reports();
  return forget(files, series);
}

Result<void> OutputFolder::forget(const std::set<std::string>& files,
                                  const std::set<std::string>& series) const {
  const auto is_earlier = [&](const std::string& name) {
    if (files.contains(name)) return true;
    const std::size_t end = name.rfind('_');
    if (end == name.npos || !series.contains(name.substr(0, end))) return false;
    const std::string number = name.substr(end + 1);
    constexpr std::size_t kLeastDigits = 3;
    return number.ends_with(".png") &&
           number.find_first_not_of("0123456789") == number.size() - 4 &&
           number.size() - 4 >= kLeastDigits;
  };
  std::error_code status;
  std::vector<std::filesystem::path> earlier;
  std::filesystem::directory_iterator it(path_, status);
  for (; !status && it != std::filesystem::directory_iterator(); it.increment(status)) {
    std::error_code ignored;
    const bool file = std::filesystem::is_regular_file(it->symlink_status(ignored));
    if (file && is_earlier(it->path().filename().string())) earlier.push_back(it->path());
  }
  if (status) return Error{ErrorCode::kIo, path_.string() + ": cannot list: " + status.message()};
  for (const std::filesystem::path& file : earlier) {
    if (std::filesystem::remove(file, status) || !status) continue;
    return Error{ErrorCode::kIo, file.string() + ": cannot remove: " + status.message()};
  }
  return {};
}

Result<void> forget_earlier_reports(const std::filesystem::path& folder,
                                    const std::set<std::string>& files) {
  std::error_code status;
  if (folder.empty() || !std::filesystem::exists(folder, status)) return {};
  const auto out = OutputFolder::create(folder);
  if (!out) return out.error();
  return out->forget_earlier_run(files, {});
}

Result<void> OutputFolder::write_text(const std::string& name, const std::string& text) {
  return io::write_file(path_ / name, std::string_view(text));
}

std::string OutputFolder::image_digest() const { return io::sha256_hex(image_digests_); }

}  // namespace nav::app
