// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/ct.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>

#include "io/detail/ct_readers.hpp"
#include "io/detail/dicom_structure.hpp"
#include "io/detail/hu_builder.hpp"
#include "io/detail/input_file.hpp"
#include "io/detail/meta_writer.hpp"
#include "io/detail/text.hpp"
#include "io/own_mark.hpp"
#include "nav/hounsfield.hpp"
#include "nav/positions.hpp"

namespace nav::io {

namespace detail {

Result<void> unknown_orientation(const std::filesystem::path& path, const std::string& found,
                                 Diagnostics& diagnostics, const CtOptions& options) {
  const std::string message =
      path.string() + ": expected the orientation of the axes in the patient, found " + found;
  if (!options.accept_unknown_orientation) return Error{ErrorCode::kUnsupportedData, message};
  diagnostics.report("io.ct", {.subject = path.string(),
                               .key = "orientation",
                               .values = {found},
                               .used = "left, posterior, superior, as requested"});
  return {};
}

}  // namespace detail

namespace {

Result<std::vector<std::filesystem::path>> files_below(const std::filesystem::path& folder,
                                                       Diagnostics& diagnostics) {
  constexpr std::size_t kMaxFiles = 200000;
  std::vector<std::filesystem::path> files;
  std::error_code code;
  std::filesystem::recursive_directory_iterator it(folder, code);
  for (; !code && it != std::filesystem::recursive_directory_iterator(); it.increment(code)) {
    std::error_code ignored;
    if (it->is_regular_file(ignored)) files.push_back(it->path());
    if (it->is_symlink(ignored) && !it->exists(ignored)) {
      diagnostics.report(
          Severity::kWarning, "io.ct",
          it->path().string() + ": the link points to no file; if that was a slice, it is missing");
    }
    if (files.size() > kMaxFiles) {
      return Error{ErrorCode::kUnsupportedData,
                   folder.string() + ": expected at most 200000 files, found more"};
    }
  }
  if (code) {
    return Error{ErrorCode::kIo, folder.string() + ": cannot list: " + code.message()};
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string lower_name(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return name;
}

}  // namespace

namespace detail {

std::optional<Result<VoxelGrid>> read_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                             Diagnostics& diagnostics,
                                             const VolumeReading& options) {
  const std::string name = lower_name(path);
  const auto ends = [&](std::initializer_list<const char*> endings) {
    return std::any_of(endings.begin(), endings.end(),
                       [&](const char* ending) { return name.ends_with(ending); });
  };
  if (ends({".nii", ".nii.gz"})) return read_nifti_voxels(path, sink, diagnostics, options);
  if (ends({".mha", ".mhd", ".nrrd", ".nhdr"})) {
    return read_image_file_voxels(path, sink, diagnostics, options);
  }
  return {};
}

}  // namespace detail

namespace {

Result<StoredVolume> read_files(const std::filesystem::path& path, Diagnostics& diagnostics,
                                const detail::VolumeReading& options) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    const auto files = files_below(path, diagnostics);
    if (!files) return files.error();
    return detail::read_ct_dicom(*files, path.string(), diagnostics, options);
  }
  const auto file = detail::InputFile::open(path);
  if (!file) return file.error();
  detail::HuBuilder builder(0, options.least);
  if (const auto grid = detail::read_voxels(path, builder, diagnostics, options)) {
    if (!*grid) return grid->error();
    return std::move(builder).finish(**grid, path.string(), options.unit, diagnostics);
  }
  if (detail::is_dicom(*file)) {
    return detail::read_ct_dicom({path}, path.string(), diagnostics, options);
  }
  return Error{ErrorCode::kUnsupportedData,
               path.string() +
                   ": expected DICOM, .nii, .nii.gz, .mha, .mhd, .nrrd or .nhdr, found another "
                   "kind of file"};
}

/// Reports voxels of a size that no scanner for patients makes: their unit is another one.
void warn_of_size(const VoxelGrid& grid, const std::filesystem::path& path,
                  Diagnostics& diagnostics) {
  constexpr double kLeastSpacingMm = 0.01;
  constexpr double kMostSpacingMm = 60;
  const Eigen::Vector3d& mm = grid.spacing_mm;
  const bool small = mm.minCoeff() < kLeastSpacingMm;
  if (!small && mm.maxCoeff() <= kMostSpacingMm) return;
  std::ostringstream text;
  text << mm.x() << " x " << mm.y() << " x " << mm.z() << " mm, a volume of "
       << grid.extent_mm().maxCoeff() << " mm (expected voxels of " << kLeastSpacingMm << " to "
       << kMostSpacingMm << " mm; is it in " << (small ? "metres" : "micrometres") << "?)";
  diagnostics.report("io.ct", {.subject = path.string(),
                               .key = "size of the voxels",
                               .values = {text.str()},
                               .used = "millimetres"});
}

Result<StoredVolume> read_anywhere(const std::filesystem::path& path, Diagnostics& diagnostics,
                                   const detail::VolumeReading& options) {
  auto volume = read_files(path, diagnostics, options);
  if (!volume) return volume;
  const VoxelGrid& grid = volume->grid();
  const Eigen::Vector3d last(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  for (const Eigen::Vector3d& corner : {grid.at({0, 0, 0}).mm, grid.at(last).mm}) {
    if (is_place(corner)) continue;
    std::ostringstream text;
    text << path.string() << ": expected voxels within 1e7 mm of the origin, found one at "
         << corner.transpose();
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  warn_of_size(grid, path, diagnostics);
  return volume;
}

/// Pixels of a CT are square, and its slices are farther apart than its pixels, or nearly so.
void warn_of_flat_voxels(const Eigen::Vector3d& spacing_mm, const std::filesystem::path& path,
                         Diagnostics& diagnostics) {
  constexpr double kMostBetweenPixels = 4;
  constexpr double kMostBetweenSlices = 25;
  std::array<double, 3> sorted{spacing_mm.x(), spacing_mm.y(), spacing_mm.z()};
  std::ranges::sort(sorted);
  if (sorted[1] <= kMostBetweenPixels * sorted[0] && sorted[2] <= kMostBetweenSlices * sorted[1]) {
    return;
  }
  std::ostringstream text;
  text << spacing_mm.x() << " x " << spacing_mm.y() << " x " << spacing_mm.z() << " mm";
  diagnostics.report("io.ct", {.subject = path.string(),
                               .key = "spacing",
                               .values = {text.str() + " (expected pixels that are about square)"},
                               .used = text.str()});
}

/// Reports values that do not seem to be Hounsfield units, because none is that of air, and what
/// they may be instead.
void warn_of_unit(const StoredVolume& volume, const std::filesystem::path& path,
                  Diagnostics& diagnostics) {
  constexpr int kMostOfBytes = 255;
  constexpr int kMostOfSoftTissue = 1000;
  if (is_hounsfield(volume)) return;
  const auto [least, most] = std::ranges::minmax(volume.values());
  if (least < kLeastTissueHu) return;  // A part of a CT with little air.
  const char* guess = "is it an MR, or a part of a CT without air?";
  if (least >= 0 && most > kMostOfSoftTissue) guess = "is it an MR, or a CT in HU + 1024?";
  if (least >= 0 && most <= kMostOfBytes) guess = "is it a window of a CT, in 8 bits?";
  diagnostics.report("io.ct", {.subject = path.string(),
                               .key = "unit of the values",
                               .values = {std::to_string(least) + " to " + std::to_string(most) +
                                          ", none below -200 HU, air (" + guess + ")"},
                               .used = "the values as HU"});
}

}  // namespace

Result<Volume> read_ct(const std::filesystem::path& path, Diagnostics& diagnostics,
                       const CtOptions& options) {
  auto volume = read_anywhere(path, diagnostics, detail::VolumeReading{options});
  if (!volume) return volume.error();
  warn_of_flat_voxels(volume->grid().spacing_mm, path, diagnostics);
  if (options.expect_hounsfield_units) warn_of_unit(*volume, path, diagnostics);
  return Volume(*std::move(volume));
}

Result<StoredVolume> read_stored_volume(const std::filesystem::path& path,
                                        Diagnostics& diagnostics) {
  detail::VolumeReading reading;
  reading.least_slices = 1;
  reading.unit = "";
  reading.least = std::numeric_limits<std::int16_t>::min();
  return read_anywhere(path, diagnostics, reading);
}

bool is_dicom(const std::filesystem::path& path) {
  const auto file = detail::InputFile::open(path);
  return file && detail::is_dicom(*file);
}

Result<void> write_ct_mha(const StoredVolume& volume, const std::filesystem::path& path,
                          bool compress, bool mark) {
  const std::string software = "Software = " + std::string(kSoftwareMark) + "\n";
  return detail::write_meta_image(volume.grid(), 1, mark ? software : "",
                                  std::as_bytes(volume.values()), compress, path);
}

}  // namespace nav::io
