// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "io/detail/ct_readers.hpp"
#include "io/detail/hu_builder.hpp"
#include "io/detail/input_file.hpp"
#include "io/detail/pixel_stream.hpp"
#include "io/detail/text.hpp"
#include "io/detail/within_memory.hpp"

namespace nav::io::detail {

namespace {

using Affine = Eigen::Matrix<double, 3, 4>;

// NIfTI-1: 348 bytes; NIfTI-2: 540 (nifti1.h, nifti2.h of the NIfTI Data Format Working Group).
constexpr std::size_t kHeader1 = 348;
constexpr std::size_t kHeader2 = 540;

/// Bytes of a header, with typed access at offsets in the file's byte order.
class Bytes {
 public:
  Bytes(std::span<const std::byte> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}
  template <class T>
  [[nodiscard]] T at(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> raw{};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

 private:
  std::span<const std::byte> bytes_;
  bool swapped_;
};

struct Nifti {
  bool swapped = false;
  std::array<std::int64_t, 8> dim{};
  int datatype = 0;
  int bitpix = 0;  ///< Bits of a voxel, which the datatype says, too.
  std::array<double, 8> pixdim{};
  double data_offset = 0;
  double slope = 0, intercept = 0;
  int units = 0;
  int intent = 0;  ///< Meaning of the values: 0 none, 2 to 24 statistics, above 1000 others.
  int qform = 0, sform = 0;
  std::array<double, 6> quaternion{};  ///< Values b, c, d and the offset x, y, z.
  Affine srow = Affine::Zero();
  bool two_files = false;
};

template <class Real, class Int>
void fill(const Bytes& b, Nifti& n, std::size_t dim, std::size_t pixdim, std::size_t quaternion,
          std::size_t srow) {
  for (std::size_t i = 0; i < 8; ++i) {
    n.dim[i] = b.at<Int>(dim + i * sizeof(Int));
    n.pixdim[i] = b.at<Real>(pixdim + i * sizeof(Real));
  }
  for (std::size_t i = 0; i < 6; ++i) n.quaternion[i] = b.at<Real>(quaternion + i * sizeof(Real));
  for (std::size_t i = 0; i < 12; ++i) {
    n.srow(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) =
        b.at<Real>(srow + i * sizeof(Real));
  }
}

std::optional<Nifti> parse(std::span<const std::byte> bytes) {
  Nifti n;
  const auto size = Bytes(bytes, false).at<std::int32_t>(0);
  const auto swapped_size = Bytes(bytes, true).at<std::int32_t>(0);
  n.swapped = swapped_size == kHeader1 || swapped_size == kHeader2;
  const std::int32_t header = n.swapped ? swapped_size : size;
  const Bytes b(bytes, n.swapped);
  const auto magic = [&](std::size_t offset, const char* text) {
    return std::memcmp(bytes.data() + offset, text, 4) == 0;
  };
  if (header == kHeader1 && (magic(344, "n+1\0") || magic(344, "ni1\0"))) {
    n.two_files = magic(344, "ni1\0");
    fill<float, std::int16_t>(b, n, 40, 76, 256, 280);
    n.datatype = b.at<std::int16_t>(70);
    n.bitpix = b.at<std::int16_t>(72);
    n.data_offset = b.at<float>(108);
    n.slope = b.at<float>(112);
    n.intercept = b.at<float>(116);
    n.units = b.at<std::uint8_t>(123);
    n.intent = b.at<std::int16_t>(68);
    n.qform = b.at<std::int16_t>(252);
    n.sform = b.at<std::int16_t>(254);
    return n;
  }
  if (header == kHeader2 && bytes.size() >= kHeader2 && (magic(4, "n+2\0") || magic(4, "ni2\0"))) {
    n.two_files = magic(4, "ni2\0");
    fill<double, std::int64_t>(b, n, 16, 104, 352, 400);
    n.datatype = b.at<std::int16_t>(12);
    n.bitpix = b.at<std::int16_t>(14);
    n.data_offset = static_cast<double>(b.at<std::int64_t>(168));
    n.slope = b.at<double>(176);
    n.intercept = b.at<double>(184);
    n.qform = b.at<std::int32_t>(344);
    n.sform = b.at<std::int32_t>(348);
    n.units = b.at<std::int32_t>(500);
    n.intent = b.at<std::int32_t>(504);
    return n;
  }
  return {};
}

std::optional<PixelType> nifti_type(int code) {
  switch (code) {
    case 2:
      return PixelType::kUint8;
    case 4:
      return PixelType::kInt16;
    case 8:
      return PixelType::kInt32;
    case 16:
      return PixelType::kFloat32;
    case 64:
      return PixelType::kFloat64;
    case 256:
      return PixelType::kInt8;
    case 512:
      return PixelType::kUint16;
    case 768:
      return PixelType::kUint32;
    default:
      return {};
  }
}

/// RAS affine of the q-form (nifti1.h, method 2).
Affine qform_affine(const Nifti& n) {
  const auto& q = n.quaternion;
  const double rest = 1 - (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  Eigen::Quaterniond rotation(std::sqrt(std::max(rest, 0.0)), q[0], q[1], q[2]);
  rotation.normalize();
  const double handedness = n.pixdim[0] < 0 ? -1 : 1;
  Affine affine;
  affine.leftCols<3>() =
      rotation.toRotationMatrix() *
      Eigen::Vector3d(n.pixdim[1], n.pixdim[2], n.pixdim[3] * handedness).asDiagonal();
  affine.col(3) << q[3], q[4], q[5];
  return affine;
}

/// A number in a message; those of NIfTI-1 have seven digits.
std::string short_text(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

/// Compares the spacing of the s-form with pixdim, which is also that of the q-form. With a q-form,
/// two of three statements contradict the one that would be used; but what is no spacing states
/// none.
Result<void> compare_spacings(const Nifti& n, const std::filesystem::path& path,
                              Diagnostics& diagnostics) {
  constexpr double kShare = 0.01;
  bool same = true;
  bool states_spacing = true;
  std::string by_sform;
  std::string by_pixdim;
  for (int axis = 0; axis < 3; ++axis) {
    const double mm = n.srow.col(axis).norm();
    const double stated = n.pixdim[static_cast<std::size_t>(axis) + 1];
    states_spacing = states_spacing && std::isfinite(stated) && stated > 0;
    same = same && std::abs(mm - stated) <= kShare * stated;
    by_sform += ' ' + short_text(mm);
    by_pixdim += ' ' + short_text(stated);
  }
  if (same && states_spacing) return {};
  if (n.qform > 0 && states_spacing) {
    return Error{ErrorCode::kMalformedData, path.string() + ": spacing" + by_sform +
                                                " by the s-form," + by_pixdim +
                                                " by pixdim and the q-form"};
  }
  diagnostics.report("io.ct",
                     {.subject = path.string(),
                      .key = "spacing",
                      .values = {"s-form" + by_sform + " mm", "pixdim" + by_pixdim + " mm"},
                      .used = "s-form"});
  return {};
}

/// The three rows of a map, in RAS as in the file.
std::string numbers_of(const Affine& affine) {
  std::string text;
  for (Eigen::Index row = 0; row < 3; ++row) {
    text += row > 0 ? ", " : "[";
    for (Eigen::Index column = 0; column < 4; ++column) {
      text += (column > 0 ? " " : "") + short_text(affine(row, column));
    }
  }
  return text + "]";
}

Result<Affine> ras_affine(const Nifti& n, const std::filesystem::path& path,
                          Diagnostics& diagnostics, const CtOptions& options) {
  const auto check_spacing = [&]() -> Result<void> {
    for (std::size_t axis = 1; axis <= 3; ++axis) {
      if (!(std::isfinite(n.pixdim[axis]) && n.pixdim[axis] > 0)) {
        return Error{ErrorCode::kMalformedData,
                     path.string() + ": pixdim: expected a positive spacing, found " +
                         to_text(n.pixdim[axis])};
      }
    }
    return {};
  };
  if (n.sform > 0) {
    if (!n.srow.allFinite()) {
      return Error{ErrorCode::kMalformedData,
                   path.string() + ": s-form: expected finite numbers, found NaN or Inf"};
    }
    if (auto ok = compare_spacings(n, path, diagnostics); !ok) return ok.error();
    constexpr double kAgreement = 0.01;  // Limit in mm, and in mm per voxel.
    if (n.qform > 0 && check_spacing()) {
      const double difference = (qform_affine(n) - n.srow).cwiseAbs().maxCoeff();
      if (!(difference <= kAgreement)) {
        diagnostics.report("io.ct", {.subject = path.string(),
                                     .key = "axes and origin",
                                     .values = {"s-form " + numbers_of(n.srow),
                                                "q-form " + numbers_of(qform_affine(n))},
                                     .used = "s-form"});
      }
    }
    return n.srow;
  }
  if (const auto ok = check_spacing(); !ok) return ok.error();
  if (n.qform > 0) {
    constexpr double kRounding = 1e-3;
    const auto& q = n.quaternion;
    const double squares = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
    if (squares > 1 + kRounding) {
      return Error{ErrorCode::kMalformedData,
                   path.string() +
                       ": q-form: expected a rotation, b² + c² + d² of at most 1, found " +
                       short_text(squares)};
    }
    const Affine affine = qform_affine(n);
    if (!affine.allFinite()) {
      return Error{ErrorCode::kMalformedData,
                   path.string() + ": q-form: expected finite numbers, found NaN or Inf"};
    }
    return affine;
  }
  const auto ok = unknown_orientation(path, "neither s-form nor q-form", diagnostics, options);
  if (!ok) return ok.error();
  Affine affine = Affine::Zero();
  // The map is written in RAS here, so that the conversion below gives LPS axes.
  affine.leftCols<3>() = Eigen::Vector3d(-n.pixdim[1], -n.pixdim[2], n.pixdim[3]).asDiagonal();
  return affine;
}

Result<std::array<int, 3>> nifti_size(const Nifti& n, const std::filesystem::path& path,
                                      int least_slices) {
  bool good = n.dim[0] >= 3 && n.dim[0] <= 7;
  for (std::size_t axis = 1; good && axis <= static_cast<std::size_t>(n.dim[0]); ++axis) {
    good = axis <= 3 ? n.dim[axis] >= 1 && n.dim[axis] <= std::numeric_limits<int>::max()
                     : n.dim[axis] == 1;
  }
  if (!good) {
    std::string found;
    for (const std::int64_t d : n.dim) found += (found.empty() ? "" : " ") + std::to_string(d);
    return Error{ErrorCode::kUnsupportedData,
                 path.string() + ": dim: expected one volume of 3 axes, found " + found};
  }
  if (n.dim[3] < least_slices) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected at least 2 slices, found 1"};
  }
  return std::array<int, 3>{static_cast<int>(n.dim[1]), static_cast<int>(n.dim[2]),
                            static_cast<int>(n.dim[3])};
}

Result<VoxelGrid> nifti_grid(const Nifti& n, const std::filesystem::path& path,
                             Diagnostics& diagnostics, const VolumeReading& options) {
  const auto size = nifti_size(n, path, options.least_slices);
  if (!size) return size.error();
  auto affine = ras_affine(n, path, diagnostics, options);
  if (!affine) return affine.error();
  const int unit = n.units & 7;
  if (unit > 3) {
    return Error{
        ErrorCode::kMalformedData,
        path.string() + ": xyzt_units: expected a length, found code " + std::to_string(unit)};
  }
  constexpr std::array kMmPerUnit = {1.0, 1000.0, 1.0, 0.001};  // Unknown, m, mm, micron.
  *affine *= kMmPerUnit[static_cast<std::size_t>(unit)];
  *affine = Eigen::Vector3d(-1, -1, 1).asDiagonal() * *affine;  // Converts RAS to LPS.
  return grid_from_affine(*size, *affine, path.string());
}

/// Name of an intent code of nifti1.h, for messages.
std::string intent_name(int code) {
  constexpr int kEstimate = 1001;
  constexpr int kLabel = 1002;
  constexpr int kFirstOther = 1000;
  if (code == kEstimate) return "an estimate";
  if (code == kLabel) return "labels";
  return code < kFirstOther ? "a statistic" : "another quantity";
}

/// Reports statements that are not used, although they say what the values and lengths mean.
void report_unused(const Nifti& n, const std::filesystem::path& path, Diagnostics& diagnostics) {
  const auto report = [&](const char* key, std::vector<std::string> values, std::string used,
                          Severity severity = Severity::kWarning) {
    diagnostics.report("io.ct", {.subject = path.string(),
                                 .key = key,
                                 .values = std::move(values),
                                 .used = std::move(used),
                                 .severity = severity});
  };
  if (n.intent != 0) {
    report("intent_code",
           {std::to_string(n.intent) + ", " + intent_name(n.intent) + " (expected 0, none)"},
           "the values as stored");
  }
  if (n.slope == 0 && n.intercept != 0) {
    report("scl_slope, scl_inter",
           {"a slope of 0, no scaling", "scl_inter " + to_text(n.intercept)}, "no scaling");
  }
  // Many programs write no unit and mean millimetres.
  if ((n.units & 7) == 0) {
    report("xyzt_units", {"no unit of length"}, "millimetres", Severity::kInfo);
  }
}

Result<void> check_length(const Nifti& n, const VoxelGrid& grid, std::size_t sample,
                          std::int64_t file_size, bool compressed,
                          const std::filesystem::path& path) {
  if (!(n.data_offset >= static_cast<double>(kHeader1) && n.data_offset < 1e9)) {
    return Error{ErrorCode::kMalformedData, path.string() +
                                                ": vox_offset: expected at least 348, "
                                                "found " +
                                                to_text(n.data_offset)};
  }
  const double expected =
      n.data_offset + static_cast<double>(grid.voxel_count()) * static_cast<double>(sample);
  const double possible =
      static_cast<double>(file_size) * static_cast<double>(compressed ? kMostExpansion : 1);
  if (expected <= possible) return {};
  return Error{ErrorCode::kMalformedData, path.string() + ": pixel data cut short: expected " +
                                              to_text(expected) + " bytes, found a file of " +
                                              std::to_string(file_size)};
}

}  // namespace

Result<VoxelGrid> read_nifti_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                    Diagnostics& diagnostics, const VolumeReading& options) {
  const auto file = InputFile::open(path);
  if (!file) return file.error();
  const auto fail = [&](ErrorCode code, const std::string& message) {
    return Error{code, path.string() + ": " + message};
  };
  std::array<std::byte, 2> first{};
  if (const auto got = file->read_at(0, first); !got) return got.error();
  const bool compressed = first[0] == std::byte{0x1f} && first[1] == std::byte{0x8b};
  auto stream = PixelStream::open({{path, 0, file->size()}},
                                  compressed ? Encoding::kDeflate : Encoding::kRaw);
  if (!stream) return stream.error();
  std::array<std::byte, kHeader2> header{};
  // NIfTI-1 headers are shorter than the buffer. A file that ends between the two sizes has no
  // voxels anyway.
  if (!stream->read(0, std::span(header).first(kHeader1))) {
    return fail(ErrorCode::kMalformedData, "header cut short: expected 348 bytes, found fewer");
  }
  if (!stream->read(kHeader1, std::span(header).subspan(kHeader1))) {
    std::fill(header.begin() + kHeader1, header.end(), std::byte{0});
  }
  const auto nifti = parse(header);
  if (!nifti) return fail(ErrorCode::kUnsupportedData, "expected a NIfTI header, found another");
  if (nifti->two_files) {
    return fail(ErrorCode::kUnsupportedData, "expected a single .nii file, found a .hdr/.img pair");
  }
  const auto type = nifti_type(nifti->datatype);
  if (!type) {
    return fail(ErrorCode::kUnsupportedData,
                "datatype: expected integers up to 32 bits or reals, "
                "found code " +
                    std::to_string(nifti->datatype));
  }
  const auto bits = static_cast<int>(8 * size_of(*type));
  if (nifti->bitpix != 0 && nifti->bitpix != bits) {
    diagnostics.report("io.ct", {.subject = path.string(),
                                 .key = "bits of a voxel",
                                 .values = {"datatype " + std::to_string(bits),
                                            "bitpix " + std::to_string(nifti->bitpix)},
                                 .used = "datatype"});
  }
  const auto grid = nifti_grid(*nifti, path, diagnostics, options);
  if (!grid) return grid.error();
  report_unused(*nifti, path, diagnostics);
  const std::size_t sample = size_of(*type);
  const auto length = check_length(*nifti, *grid, sample, file->size(), compressed, path);
  if (!length) return length.error();
  Rescale rescale;
  if (nifti->slope != 0) rescale = {nifti->slope, nifti->intercept, {}};
  if (!std::isfinite(rescale.slope) || !std::isfinite(rescale.intercept)) {
    return fail(ErrorCode::kMalformedData, "scl_slope: expected finite scaling, found NaN or Inf");
  }
  const StoredVoxels voxels{.offset = static_cast<std::int64_t>(nifti->data_offset),
                            .count = grid->voxel_count(),
                            .type = *type,
                            .swapped = nifti->swapped,
                            .rescale = rescale};
  const auto copied =
      within_memory(path, static_cast<double>(voxels.count) * sizeof(std::int16_t),
                    [&] { return copy_voxels(*stream, voxels, file->size(), sink); });
  if (!copied && copied.error().code == ErrorCode::kUnavailable) return copied.error();
  if (!copied) return fail(copied.error().code, copied.error().message);
  // Only the checksum reveals a changed bit in the voxels.
  const auto stated = static_cast<std::int64_t>(voxels.count * sample);
  const auto left = stream->skip_to_end(voxels.offset + stated);
  if (!left) return fail(left.error().code, left.error().message);
  if (*left > 0) {
    diagnostics.report("io.ct", longer_than_stated(path, stated, stated + *left));
  }
  return *grid;
}

}  // namespace nav::io::detail
