// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/feature_cache.hpp"

#include <bit>
#include <cstring>
#include <sstream>
#include <system_error>
#include <vector>

#include "io/atomic_file.hpp"
#include "io/digest.hpp"

namespace nav::app {
namespace {

using render::features::DerivedRequest;
using render::features::DerivedVolume;
using render::features::FeatureVolume;

static_assert(std::endian::native == std::endian::little, "files hold little-endian floats");
constexpr std::size_t kDigestSize = 64;
constexpr std::size_t kMostNoteBytes = 4096;

std::string head_of(const std::string& key, std::size_t voxels, std::size_t note_bytes) {
  return "sonde_feature 1 " + key + " " + std::to_string(voxels) + " " +
         std::to_string(note_bytes) + "\n";
}

std::string digest_of(std::string_view text) {
  return io::sha256_hex(std::as_bytes(std::span(text.data(), text.size())));
}

/// Reads the contents of a file; the error says what is wrong with them.
Result<DerivedVolume> parse(const std::string& file, const std::string& key,
                            const VoxelGrid& grid) {
  const auto reject = [](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData, "expected " + expected + ", found " + found};
  };
  const std::size_t line = file.find('\n');
  std::istringstream head(file.substr(0, std::min(line, std::size_t{256})));
  std::string magic, version, found_key;
  std::size_t voxels = 0;
  std::size_t note_bytes = 0;
  head >> magic >> version >> found_key >> voxels >> note_bytes;
  if (!head || magic != "sonde_feature") {
    return reject("a derived volume of this program", "something else");
  }
  if (version != "1") return reject("version 1", version);
  if (found_key != key) return reject("the key " + key, found_key);
  if (voxels != grid.voxel_count() || note_bytes > kMostNoteBytes) {
    return reject(std::to_string(grid.voxel_count()) + " voxels", std::to_string(voxels));
  }
  const std::size_t wanted = line + 1 + note_bytes + voxels * sizeof(float) + kDigestSize;
  if (file.size() != wanted) {
    return reject(std::to_string(wanted) + " bytes", std::to_string(file.size()));
  }
  const std::string_view content(file.data(), file.size() - kDigestSize);
  if (digest_of(content) != file.substr(content.size())) {
    return reject("bytes that match the digest at its end", "other bytes");
  }
  std::vector<float> values(voxels);
  std::memcpy(values.data(), file.data() + line + 1 + note_bytes, voxels * sizeof(float));
  return DerivedVolume{
      FeatureVolume{grid, std::make_shared<const std::vector<float>>(std::move(values))},
      file.substr(line + 1, note_bytes)};
}

}  // namespace

std::filesystem::path FeatureCache::path_of(const DerivedRequest& request) const {
  return folder_ / (key_of(request) + ".feature");
}

std::optional<DerivedVolume> FeatureCache::find(const DerivedRequest& request,
                                                Diagnostics& diagnostics) const {
  const auto path = path_of(request);
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return {};
  const VoxelGrid& grid = request.volume.grid();
  constexpr std::uint64_t kMostBeside = 8192;  // Bytes of head, note and digest.
  const auto file = io::read_file(path, grid.voxel_count() * sizeof(float) + kMostBeside);
  auto volume = file ? parse(*file, key_of(request), grid) : Result<DerivedVolume>(file.error());
  if (volume) return *std::move(volume);
  const std::string& why = volume.error().message;
  const std::string name = path.string();
  diagnostics.report(Severity::kWarning, "cache",
                     (why.starts_with(name) ? why : name + ": " + why) + "; computed again");
  return {};
}

void FeatureCache::keep(const DerivedRequest& request, const DerivedVolume& volume,
                        Diagnostics& diagnostics) const {
  const std::vector<float>& values = *volume.volume.values;
  const std::string note = volume.note.substr(0, kMostNoteBytes);
  std::string content = head_of(key_of(request), values.size(), note.size()) + note;
  const std::size_t before = content.size();
  content.resize(before + values.size() * sizeof(float));
  std::memcpy(content.data() + before, values.data(), values.size() * sizeof(float));
  content += digest_of(content);
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  const auto path = path_of(request);
  const auto written = [&]() -> Result<void> {
    if (failed) {
      return Error{ErrorCode::kIo,
                   folder_.string() + ": cannot create the folder: " + failed.message()};
    }
    // Writing to a pipe would wait for a reader.
    const auto there = std::filesystem::status(path, failed);
    if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) {
      return Error{ErrorCode::kIo,
                   path.string() + ": expected a regular file, found a special file"};
    }
    return io::write_file(path, content);
  }();
  if (!written) {
    diagnostics.report(Severity::kWarning, "cache",
                       written.error().message + "; the feature is not cached");
  }
}

}  // namespace nav::app
