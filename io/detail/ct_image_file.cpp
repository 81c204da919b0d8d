// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "io/detail/ct_readers.hpp"
#include "io/detail/hu_builder.hpp"
#include "io/detail/image_file.hpp"
#include "io/detail/pixel_stream.hpp"
#include "io/detail/text.hpp"
#include "io/detail/within_memory.hpp"

namespace nav::io::detail {

namespace {

using Affine = Eigen::Matrix<double, 3, 4>;

/// Reads exactly \p count finite numbers of a field.
Result<std::vector<double>> numbers(const ImageFile& file, std::string_view key,
                                    std::size_t count) {
  auto values = parse_doubles(file.value(key));
  bool good = values && values->size() == count;
  for (std::size_t i = 0; good && i < count; ++i) good = std::isfinite((*values)[i]);
  if (good) return std::move(*values);
  return bad_field(file, key, std::to_string(count) + " finite numbers", file.value(key));
}

/// First of several spellings that the header contains; the first of the list when it contains
/// none.
std::string_view spelling(const ImageFile& file, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) {
    if (file.has(key)) return key;
  }
  return *keys.begin();
}

/// Directions from letters such as "RAI" in the sense of MetaIO: each letter says where the axis
/// starts, so RAI is LPS.
std::optional<Eigen::Matrix3d> directions_from_letters(std::string_view letters) {
  if (letters.size() != 3) return {};
  Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    constexpr std::string_view kFrom = "RAI";
    constexpr std::string_view kTo = "LPS";
    const char letter = letters[static_cast<std::size_t>(axis)];
    for (int patient = 0; patient < 3; ++patient) {
      const auto p = static_cast<std::size_t>(patient);
      if (letter == kFrom[p]) directions(patient, axis) = 1;
      if (letter == kTo[p]) directions(patient, axis) = -1;
    }
  }
  if (std::abs(std::abs(directions.determinant()) - 1) > 0.5) return {};
  return directions;
}

/// Letters of the axes in the sense of MetaIO, by the main direction of each.
std::string letters_of(const Eigen::Matrix3d& directions) {
  constexpr std::string_view kFrom = "RAI";
  constexpr std::string_view kTo = "LPS";
  std::string letters;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Index main = 0;
    directions.col(axis).cwiseAbs().maxCoeff(&main);
    const auto patient = static_cast<std::size_t>(main);
    letters += directions(main, axis) > 0 ? kFrom[patient] : kTo[patient];
  }
  return letters;
}

/// Warns when letters and matrix contradict each other; the matrix is used, as in ITK.
void compare_letters(const ImageFile& file, const Eigen::Matrix3d& directions,
                     Diagnostics& diagnostics) {
  const std::string_view letters = file.value("AnatomicalOrientation");
  const auto expected = directions_from_letters(letters);
  if (!expected) return;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Index main = 0;
    directions.col(axis).cwiseAbs().maxCoeff(&main);
    if ((*expected)(main, axis) * directions(main, axis) > 0) continue;
    diagnostics.report("io.ct", {.subject = file.path.string(),
                                 .key = "orientation",
                                 .values = {"AnatomicalOrientation " + std::string(letters),
                                            "TransformMatrix of " + letters_of(directions)},
                                 .used = "TransformMatrix"});
    return;
  }
}

Result<Affine> meta_affine(const ImageFile& file, Diagnostics& diagnostics,
                           const CtOptions& options) {
  const std::size_t n = file.sizes.size();
  // MetaIO writes "?" for an unknown unit.
  if (const auto unit = file.value("DistanceUnits"); !unit.empty() && unit != "mm" && unit != "?") {
    return bad_field(file, "DistanceUnits", "mm", unit);
  }
  const auto spacing = numbers(file, spelling(file, {"ElementSpacing", "ElementSize"}), n);
  if (!spacing) return spacing.error();
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();
  const auto matrix_key = spelling(file, {"TransformMatrix", "Rotation", "Orientation"});
  if (file.has(matrix_key)) {
    const auto matrix = numbers(file, matrix_key, n * n);
    if (!matrix) return matrix.error();
    // Each group of numbers is the direction of one axis.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t patient = 0; patient < 3; ++patient) {
        directions(static_cast<Eigen::Index>(patient), static_cast<Eigen::Index>(axis)) =
            (*matrix)[axis * n + patient];
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kUnitTolerance = 1e-3;
      if (std::abs(directions.col(axis).norm() - 1) > kUnitTolerance) {
        return bad_field(file, matrix_key, "unit vectors", file.value(matrix_key));
      }
    }
    compare_letters(file, directions, diagnostics);
  } else if (const auto letters = file.value("AnatomicalOrientation"); letters != "RAI") {
    // Programs read RAI as LPS and disagree about all other letters.
    const std::string what = letters.empty() || letters == "???"
                                 ? "no TransformMatrix"
                                 : "AnatomicalOrientation " + excerpt(letters) +
                                       " without TransformMatrix, which programs read in "
                                       "different ways";
    const auto ok = unknown_orientation(file.path, what, diagnostics, options);
    if (!ok) return ok.error();
  }
  Affine affine = Affine::Zero();
  const auto offset_key = spelling(file, {"Offset", "Position", "Origin"});
  if (file.has(offset_key)) {
    const auto offset = numbers(file, offset_key, n);
    if (!offset) return offset.error();
    affine.col(3) << (*offset)[0], (*offset)[1], (*offset)[2];
  } else {
    diagnostics.report("io.ct", {.subject = file.path.string(),
                                 .key = "Offset",
                                 .values = {"none"},
                                 .used = "0 0 0 mm for the first voxel"});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!((*spacing)[axis] > 0)) {
      return bad_field(file, "ElementSpacing", "positive spacing in mm",
                       file.value(spelling(file, {"ElementSpacing", "ElementSize"})));
    }
    affine.col(static_cast<Eigen::Index>(axis)) =
        directions.col(static_cast<Eigen::Index>(axis)) * (*spacing)[axis];
  }
  return affine;
}

/// Parses "(1,0,0)" as three finite numbers.
std::optional<Eigen::Vector3d> nrrd_vector(std::string_view text) {
  text = trim(text);
  if (text.size() < 2 || text.front() != '(' || text.back() != ')') return {};
  std::string inner(text.substr(1, text.size() - 2));
  for (char& c : inner) {
    if (c == ',') c = ' ';
  }
  const auto values = parse_doubles(inner);
  if (!values || values->size() != 3) return {};
  const Eigen::Vector3d out((*values)[0], (*values)[1], (*values)[2]);
  return out.allFinite() ? std::optional(out) : std::nullopt;
}

/// Parses "space directions": one vector for each axis of the file, absent for "none"; nothing when
/// one cannot be read.
std::optional<std::vector<std::optional<Eigen::Vector3d>>> nrrd_vectors(std::string_view text) {
  std::vector<std::optional<Eigen::Vector3d>> out;
  for (text = trim(text); !text.empty(); text = trim(text)) {
    if (text.starts_with("none")) {
      out.emplace_back();
      text.remove_prefix(4);
      continue;
    }
    const auto end = text.find(')');
    if (end == std::string_view::npos) return {};
    const auto vector = nrrd_vector(text.substr(0, end + 1));
    if (!vector) return {};
    out.push_back(*vector);
    text.remove_prefix(end + 1);
  }
  return out;
}

/// Signs that convert coordinates of the file's space to LPS; nothing for spaces that are not
/// anatomical.
std::optional<Eigen::Vector3d> lps_signs(std::string_view space) {
  if (equals_ignoring_case(space, "left-posterior-superior") || space == "LPS") {
    return Eigen::Vector3d(1, 1, 1);
  }
  if (equals_ignoring_case(space, "right-anterior-superior") || space == "RAS") {
    return Eigen::Vector3d(-1, -1, 1);
  }
  if (equals_ignoring_case(space, "left-anterior-superior") || space == "LAS") {
    return Eigen::Vector3d(1, -1, 1);
  }
  return {};
}

/// Affine map from spacings without directions, only if the caller accepts an unknown orientation.
Result<Affine> nrrd_spacings(const ImageFile& file) {
  Affine affine = Affine::Zero();
  const auto spacing = numbers(file, "spacings", file.sizes.size());
  if (!spacing) return spacing.error();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double s = (*spacing)[static_cast<std::size_t>(axis)];
    if (!(s > 0)) return bad_field(file, "spacings", "positive spacing", file.value("spacings"));
    affine(axis, axis) = s;
  }
  return affine;
}

/// Reports spacings that differ from the lengths of the directions, which the format has instead.
void compare_nrrd_spacings(const ImageFile& file, const Affine& affine, Diagnostics& diagnostics) {
  constexpr double kShare = 0.01;
  const auto words = split_words(file.value("spacings"));
  if (words.size() != file.component_axes + 3) return;
  bool same = true;
  std::string by_directions;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double mm = affine.col(axis).norm();
    const auto stated = parse_double(words[file.component_axes + static_cast<std::size_t>(axis)]);
    by_directions += ' ' + to_text(mm);
    if (!stated || std::isnan(*stated)) continue;
    same = same && std::abs(*stated - mm) <= kShare * mm;
  }
  if (same) return;
  diagnostics.report("io.ct", {.subject = file.path.string(),
                               .key = "spacing",
                               .values = {"space directions" + by_directions + " mm",
                                          "spacings " + excerpt(file.value("spacings"))},
                               .used = "space directions"});
}

Result<Affine> nrrd_affine(const ImageFile& file, Diagnostics& diagnostics,
                           const CtOptions& options) {
  const auto signs = lps_signs(file.value("space"));
  if (!signs) {
    const auto ok = unknown_orientation(
        file.path, file.has("space") ? "space '" + excerpt(file.value("space")) + "'" : "no space",
        diagnostics, options);
    if (!ok) return ok.error();
  }
  if (file.has("space units")) {
    std::string units(file.value("space units"));
    for (char& c : units) {
      if (c == '"') c = ' ';
    }
    for (const std::string_view unit : split_words(units)) {
      if (unit != "mm") return bad_field(file, "space units", "mm", file.value("space units"));
    }
  }
  if (!file.has("space directions") && !signs) return nrrd_spacings(file);
  // The samples follow the order of the axes, so it matters which axes have no direction.
  const auto axes = nrrd_vectors(file.value("space directions"));
  const std::size_t first = file.component_axes;
  bool good = axes && axes->size() >= first + 3;
  for (std::size_t axis = 0; good && axis < axes->size(); ++axis) {
    good = (*axes)[axis].has_value() == (axis >= first && axis < first + 3);
  }
  if (!good) {
    return bad_field(file, "space directions",
                     "three vectors of three finite numbers, one for each axis in space",
                     file.value("space directions"));
  }
  Affine affine = Affine::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    affine.col(static_cast<Eigen::Index>(axis)) = *(*axes)[first + axis];
  }
  if (file.has("space origin")) {
    const auto origin = nrrd_vector(file.value("space origin"));
    if (!origin) {
      return bad_field(file, "space origin", "a vector of three finite numbers",
                       file.value("space origin"));
    }
    affine.col(3) = *origin;
  } else {
    diagnostics.report("io.ct", {.subject = file.path.string(),
                                 .key = "space origin",
                                 .values = {"none"},
                                 .used = "0 0 0 mm for the first voxel"});
  }
  compare_nrrd_spacings(file, affine, diagnostics);
  if (signs) affine = signs->asDiagonal() * affine;
  return affine;
}

/// Rejects axes that are not those of a volume in space, by their kinds.
Result<void> check_kinds(const ImageFile& file) {
  for (std::size_t axis = 0; axis < std::min<std::size_t>(file.kinds.size(), 3); ++axis) {
    const std::string_view kind = file.kinds[axis];
    const bool spatial = kind == "domain" || kind == "space" || kind == "none" || kind == "???";
    if (!spatial) {
      return bad_field(file, file.format == "NRRD" ? "kinds" : "Kinds", "three axes in space",
                       file.value(file.format == "NRRD" ? "kinds" : "Kinds"));
    }
  }
  return {};
}

/// Reports statements of an NRRD that are not used, although they say what values and lengths mean.
void report_unused_nrrd(const ImageFile& file, const Eigen::Vector3d& spacing_mm,
                        Diagnostics& diagnostics) {
  const auto report = [&](std::string_view key, std::vector<std::string> values,
                          const std::string& used, Severity severity = Severity::kWarning) {
    diagnostics.report("io.ct", {.subject = file.path.string(),
                                 .key = std::string(key),
                                 .values = std::move(values),
                                 .used = used,
                                 .severity = severity});
  };
  const auto units = spelling(file, {"sample units", "sampleunits"});
  const std::string_view unit = trim(file.value(units));
  if (file.has(units) && !unit.empty() && !equals_ignoring_case(unit, "HU") && unit != "\"HU\"") {
    report(units, {excerpt(unit)}, "the values as stored");
  }
  for (const auto key : {"axis mins", "axismins", "axis maxs", "axismaxs"}) {
    if (file.has(key)) {
      report(key, {excerpt(file.value(key)), "space directions and space origin"},
             "space directions and space origin");
    }
  }
  if (const auto dimension = file.value("space dimension");
      !dimension.empty() && dimension != "3") {
    report("space dimension", {excerpt(dimension), "3 by space"}, "3");
  }
  if (file.has("measurement frame")) {
    report("measurement frame", {excerpt(file.value("measurement frame"))},
           "nothing of it: the values have no direction", Severity::kInfo);
  }
  // Slices that are thicker than their distance overlap, and thinner ones leave gaps.
  constexpr double kShare = 0.01;
  const auto words = split_words(file.value("thicknesses"));
  for (std::size_t axis = 0; axis < 3 && words.size() == file.component_axes + 3; ++axis) {
    const auto mm = parse_double(words[file.component_axes + axis]);
    const double spacing = spacing_mm[static_cast<Eigen::Index>(axis)];
    if (!mm || !std::isfinite(*mm) || std::abs(*mm - spacing) <= kShare * spacing) continue;
    report("thicknesses", {"slices " + to_text(*mm) + " mm thick", to_text(spacing) + " mm apart"},
           "their distance");
  }
}

/// NRRD keeps the range from which values were quantised; they are not restored.
void warn_of_quantisation(const ImageFile& file, Diagnostics& diagnostics) {
  const auto low = spelling(file, {"old min", "oldmin"});
  const auto high = spelling(file, {"old max", "oldmax"});
  if (!file.has(low) && !file.has(high)) return;
  diagnostics.report("io.ct",
                     {.subject = file.path.string(),
                      .key = "old min, old max",
                      .values = {excerpt(file.value(low)) + " to " + excerpt(file.value(high)) +
                                 ", from which the values were quantised"},
                      .used = "the values as stored"});
}

/// True for a file with fields of a second frame: its slices are images with their own poses. A
/// volume may be written as a sequence of one frame.
bool is_of_images(const ImageFile& file) {
  return std::ranges::any_of(file.fields, [](const Field& field) {
    return is_frame_key(field.first) && !field.first.starts_with("Seq_Frame0000");
  });
}

Result<std::array<int, 3>> volume_size(ImageFile& file, int least_slices) {
  if (is_of_images(file)) {
    return Error{
        ErrorCode::kUnsupportedData,
        file.path.string() + ": expected a volume, found a sequence of images (Seq_Frame fields)"};
  }
  if (file.sizes.size() == 4 && file.sizes[3] == 1 && file.format == "NRRD") file.sizes.pop_back();
  if (file.sizes.size() != 3 || file.components != 1) {
    return Error{ErrorCode::kUnsupportedData, file.path.string() +
                                                  ": expected 3 axes of one component, found " +
                                                  std::to_string(file.sizes.size()) + " axes of " +
                                                  std::to_string(file.components)};
  }
  std::array<int, 3> size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (file.sizes[axis] < 1 || file.sizes[axis] > std::numeric_limits<int>::max()) {
      return Error{ErrorCode::kMalformedData,
                   file.path.string() + (file.format == "NRRD" ? ": sizes" : ": DimSize") +
                       ": expected sizes from 1 to 2^31, found " +
                       std::to_string(file.sizes[axis])};
    }
    size[axis] = static_cast<int>(file.sizes[axis]);
  }
  if (size[2] < least_slices) {
    return Error{ErrorCode::kMalformedData,
                 file.path.string() + ": expected at least 2 slices, found 1"};
  }
  if (file.encoding == Encoding::kRaw && file.available_bytes < file.sample_bytes) {
    return Error{ErrorCode::kMalformedData,
                 file.path.string() + ": pixel data cut short: expected " +
                     std::to_string(file.sample_bytes) + " bytes, found " +
                     std::to_string(file.available_bytes)};
  }
  for (const auto& [key, unit] : {std::pair("ElementToIntensityFunctionSlope", 1.0),
                                  std::pair("ElementToIntensityFunctionOffset", 0.0)}) {
    if (file.has(key) && parse_double(file.value(key)) != unit) {
      return Error{ErrorCode::kUnsupportedData, file.path.string() + ": " + key + ": expected " +
                                                    to_text(unit) + ", found '" +
                                                    excerpt(file.value(key)) + "'"};
    }
  }
  return size;
}

}  // namespace

Result<VoxelGrid> read_image_file_voxels(const std::filesystem::path& path, VoxelSink& sink,
                                         Diagnostics& diagnostics, const VolumeReading& options) {
  auto file = read_image_file(path);
  if (!file) return file.error();
  const auto size = volume_size(*file, options.least_slices);
  if (!size) return size.error();
  for (const Finding& finding : file->findings) diagnostics.report("io.ct", finding);
  if (const auto ok = check_kinds(*file); !ok) return ok.error();
  warn_of_quantisation(*file, diagnostics);
  const auto affine = file->format == "NRRD" ? nrrd_affine(*file, diagnostics, options)
                                             : meta_affine(*file, diagnostics, options);
  if (!affine) return affine.error();
  const auto grid = grid_from_affine(*size, *affine, path.string());
  if (!grid) return grid.error();
  if (file->format == "NRRD") report_unused_nrrd(*file, grid->spacing_mm, diagnostics);
  auto stream = PixelStream::open(file->data, file->encoding);
  if (!stream) return stream.error();
  const auto fail = [&](const Error& error) {
    return Error{error.code, path.string() + ": " + error.message};
  };
  const StoredVoxels voxels{
      .count = grid->voxel_count(),
      .type = file->type,
      .swapped = file->big_endian != (std::endian::native == std::endian::big)};
  const auto copied =
      within_memory(path, static_cast<double>(voxels.count) * sizeof(std::int16_t),
                    [&] { return copy_voxels(*stream, voxels, file->available_bytes, sink); });
  if (!copied && copied.error().code == ErrorCode::kUnavailable) return copied.error();
  if (!copied) return fail(copied.error());
  if (const auto end = stream->expect_end(); !end) return fail(end.error());
  return *grid;
}

}  // namespace nav::io::detail
