// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/derive.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "app/output_folder.hpp"
#include "app/predicates/feature_maker.hpp"
#include "app/predicates/predicate_scan_lines.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "app/predicates/predicate_white.hpp"
#include "app/views/feature_slice.hpp"
#include "io/ct.hpp"
#include "io/image_output.hpp"
#include "nav/positions.hpp"
#include "nav/threads.hpp"
#include "render/features/service.hpp"

namespace nav::app {
namespace {

using namespace render::features;

struct Feature {
  std::string name;
  DerivedOptions options;
  std::string unit;
  double per_unit = 1;  ///< Factor from the computed value to the unit.
};

std::vector<Feature> features_of(const DeriveOptions& options) {
  VesselnessOptions vessels;
  vessels.smallest_radius_mm = options.smallest_radius_mm;
  vessels.largest_radius_mm = options.largest_radius_mm;
  vessels.polarity = options.bright_vessels ? Polarity::kBright : Polarity::kDark;
  const double white = options.white - options.black;
  const double per_white = 1 / white;
  const auto gradient = [&](GradientPart part) {
    GradientPartOptions out{part, {.smoothing_mm = options.smoothing_mm}};
    // The predicate gradient_angle has this limit too, in shares of white.
    out.gradient.least_per_mm *= white;
    return out;
  };
  SnrOptions snr = options.snr;
  snr.black = options.black;
  return {{"snr", snr, "1"},
          {"vesselness", vessels, "1"},
          {"confidence", options.confidence, "1"},
          {"gradient-magnitude", gradient(GradientPart::kMagnitude), "white/mm", per_white},
          {"gradient-angle", gradient(GradientPart::kAngle), "deg", 180 / M_PI},
          {"gradient-along", gradient(GradientPart::kAlong), "white/mm", per_white},
          {"gradient-across", gradient(GradientPart::kAcross), "white/mm", per_white},
          {"depth", ScanDepthOptions{}, "mm"}};
}

Result<std::vector<Feature>> chosen(const DeriveOptions& options) {
  const auto all = features_of(options);
  if (options.features.empty()) return all;
  std::vector<Feature> some;
  for (const std::string& name : options.features) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Feature& f) { return f.name == name; });
    if (found == all.end()) {
      return Error{ErrorCode::kUsage,
                   "--feature: expected snr, vesselness, confidence, gradient-magnitude, "
                   "gradient-angle, gradient-along, gradient-across or depth, found '" +
                       name + "'"};
    }
    some.push_back(*found);
  }
  return some;
}

Result<Point<frames::Ct>> given_place(const std::string& option, const Eigen::Vector3d& mm) {
  if (is_place(mm)) return Point<frames::Ct>{mm};
  std::ostringstream text;
  text << option << ": expected 3 numbers within 1e7 mm, found " << mm.transpose();
  return Error{ErrorCode::kUsage, text.str()};
}

/// Scan lines of the options or beside the volume; absent when there are none.
Result<std::optional<ScanLines>> lines_of(const DeriveOptions& options, const StoredVolume& volume,
                                          Console& console) {
  const VoxelGrid& grid = volume.grid();
  const auto vector = [](const std::vector<double>& v) {
    return Eigen::Vector3d(v[0], v[1], v[2]);
  };
  const auto known = [](Result<ScanLines> lines) -> Result<std::optional<ScanLines>> {
    if (!lines) return lines.error();
    return std::optional(*std::move(lines));
  };
  if (!options.scan_lines.empty()) {
    return known(
        read_scan_lines(options.scan_lines, grid, usable_threads(options.threads), console));
  }
  if (!options.apex_mm.empty()) {
    const auto apex = given_place("--apex", vector(options.apex_mm));
    if (!apex) return apex.error();
    return known(ScanLines::fan(*apex, options.face_radius_mm));
  }
  if (options.into.empty()) return scan_lines_beside(options.volume, volume, console);
  Eigen::Vector3d away = vector(options.into);
  if (!away.allFinite() || away.isZero(0)) {
    std::ostringstream text;
    text << "--into: expected 3 finite numbers, not all 0, found " << away.transpose();
    return Error{ErrorCode::kUsage, text.str()};
  }
  away = away.stableNormalized();  // The square of a very long vector may not be finite.
  if (options.face_mm.empty()) {
    const auto face = nearest_voxel(volume, away, stored_value(options.unknown));
    return known(ScanLines::parallel({away}, face));
  }
  const auto face = given_place("--face", vector(options.face_mm));
  if (!face) return face.error();
  return known(ScanLines::parallel({away}, *face));
}

/// Removes features that need scan lines and reports this; rejects them when the user gave their
/// names. Call it when there are no scan lines.
Result<void> leave_out_without_lines(const DeriveOptions& options, std::vector<Feature>& features,
                                     Diagnostics& diagnostics) {
  const std::string lines = "scan lines (--into, --apex or --scan-lines)";
  std::vector<std::string> lacking;
  for (const Feature& feature : features) {
    if (needs_scan_lines(feature.options)) lacking.push_back(feature.name);
  }
  if (lacking.empty()) return {};
  if (!options.features.empty()) {
    return Error{ErrorCode::kUsage, "--feature " + lacking.front() + " requires " + lines};
  }
  std::erase_if(features, [](const Feature& f) { return needs_scan_lines(f.options); });
  std::string names;
  for (const std::string& name : lacking) names += (names.empty() ? "" : ", ") + name;
  diagnostics.report(Severity::kWarning, "derive", "left out: " + names + "; they need " + lines);
  return {};
}

/// Name of the image of a slice across an axis of the volume, 0 to 2.
std::string image_name(const Feature& feature, int axis) {
  return feature.name + "-across-" + "ijk"[axis] + ".png";
}

Result<void> write_slices(const FeatureVolume& volume, const Feature& feature,
                          const DeriveOptions& options) {
  std::vector<float> finite(*volume.values);
  for (float& v : finite) v = std::isinf(v) ? kUnknown : v;
  const auto scalar = ScalarVolume::create(volume.grid, std::move(finite), feature.name);
  if (!scalar) return scalar.error();
  const ValueRange range = value_range(*scalar, 0.01, 0.99, 0);
  const double unit = feature.per_unit;
  std::printf("%-20s %-9s %10.4g %10.4g %10.4g %10.4g", feature.name.c_str(), feature.unit.c_str(),
              unit * range.least, unit * range.low, unit * range.high, unit * range.greatest);
  std::ostringstream words;
  words.precision(3);
  words << unit * range.low << " to " << unit * range.high;
  if (feature.unit != "1") words << ' ' << feature.unit;
  for (int axis = 0; axis < 3; ++axis) {
    const auto path = options.out / image_name(feature, axis);
    const auto image = feature_slice(volume, axis,
                                     {.range = range,
                                      .title = feature.name + " across " + "ijk"[axis],
                                      .range_words = words.str(),
                                      .size_px = options.size_px});
    if (auto ok = io::write_png(image, path); !ok) return ok;
  }
  return {};
}

}  // namespace

Result<void> run_derive(const DeriveOptions& given, Console& console) {
  DeriveOptions options = given;
  auto features = chosen(options);
  if (!features) return features.error();
  if (options.out.empty()) {
    return Error{ErrorCode::kUsage, "--out: expected a folder, found nothing"};
  }
  const bool shares_of_white = std::ranges::any_of(*features, [](const Feature& f) {
    return std::holds_alternative<GradientPartOptions>(f.options);
  });
  if (shares_of_white && !(options.black < options.white)) {
    std::ostringstream text;
    text << "--white: expected more than --black, " << options.black << ", found " << options.white;
    return Error{ErrorCode::kUsage, text.str()};
  }
  if (options.smallest_radius_mm > options.largest_radius_mm) {
    std::ostringstream text;
    text << "--smallest-radius: expected at most --largest-radius, " << options.largest_radius_mm
         << " mm, found " << options.smallest_radius_mm;
    return Error{ErrorCode::kUsage, text.str()};
  }
  auto read = io::read_stored_volume(options.volume, console);
  if (!read) return read.error();
  const auto stored = std::make_shared<const StoredVolume>(std::move(*read));
  const auto lines = lines_of(options, *stored, console);
  if (!lines) return lines.error();
  const bool none_given =
      options.scan_lines.empty() && options.apex_mm.empty() && options.into.empty();
  if (*lines && none_given) options.unknown = unknown_of_reconstruction(*stored, options.unknown);
  const auto volume = ScalarVolume::of(stored, stored_value(options.unknown));
  if (!*lines) {
    const auto ok = leave_out_without_lines(options, *features, console);
    if (!ok) return ok;
  }
  // All features are checked before the first is computed.
  for (const Feature& feature : *features) {
    if (const auto ok = validate(DerivedRequest{volume, feature.options, *lines}); !ok) return ok;
  }
  RunFiles images;
  for (const Feature& feature : *features) {
    for (int axis = 0; axis < 3; ++axis) images.files.insert(image_name(feature, axis));
  }
  const auto folder = OutputFolder::open(options.out, images);
  if (!folder) return folder.error();
  std::error_code failed;
  std::filesystem::create_directories(options.out, failed);
  if (failed) {
    return Error{ErrorCode::kIo, options.out.string() + ": expected a folder to write to, found " +
                                     failed.message()};
  }
  std::printf("%-20s %-9s %10s %10s %10s %10s %10s\n", "feature", "unit", "least", "1 %", "99 %",
              "greatest", "seconds");
  if (std::ranges::any_of(*features, [](const Feature& f) { return f.unit == "white/mm"; })) {
    warn_of_white(options.volume.string(), stored->values(), options.white, options.unknown,
                  console);
  }
  FeatureMaker maker(options.threads, options.cache, console);
  for (const Feature& feature : *features) {
    const auto begun = std::chrono::steady_clock::now();
    const auto found = maker.make(feature.name, {volume, feature.options, *lines});
    if (!found) return found.error();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun;
    if (auto ok = write_slices(found->volume, feature, options); !ok) return ok;
    std::printf(" %10.2f  %s\n", taken.count(), found->note.c_str());
  }
  return {};
}

}  // namespace nav::app
