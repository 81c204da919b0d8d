// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_volume.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "app/predicates/feature_maker.hpp"
#include "app/predicates/phantom_volume.hpp"
#include "app/predicates/predicate_labels.hpp"
#include "app/predicates/predicate_layers.hpp"
#include "app/predicates/predicate_scan_lines.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "app/predicates/predicate_white.hpp"
#include "io/ct.hpp"
#include "nav/threads.hpp"
#include "render/features/derived_features.hpp"
#include "render/predicates/connected.hpp"
#include "render/predicates/registry.hpp"
#include "render/predicates/shaped_intensity.hpp"

namespace nav::app {
namespace {

/// Error for contradicting radii: one comes from the options, the other from the options or the
/// predicate set.
Error reject_radii(const PredicateOptions& options, const VesselScales& vessels) {
  std::ostringstream text;
  if (options.smallest_radius_mm) {
    text << "predicates.smallest_radius_mm: expected at most the largest radius, "
         << vessels.largest_radius_mm << " mm, found " << vessels.smallest_radius_mm;
  } else {
    text << "predicates.largest_radius_mm: expected at least the smallest radius, "
         << vessels.smallest_radius_mm << " mm, found " << vessels.largest_radius_mm;
  }
  return {ErrorCode::kUsage, text.str()};
}

/// Scan lines of the options; absent when the options give none, because scan lines are never
/// guessed.
std::optional<render::ScanGeometry> scan_of(const PredicateOptions& options,
                                            const StoredVolume& volume) {
  if (options.apex_ct) return render::FanScan{{*options.apex_ct}, options.face_radius_mm};
  if (!options.into_ct) return {};
  // Scaled, because products of very long directions may not be finite.
  const Eigen::Vector3d into = *options.into_ct / options.into_ct->cwiseAbs().maxCoeff();
  if (options.face_ct) return render::ParallelScan{{*options.face_ct}, {into}};
  return render::ParallelScan{nearest_voxel(volume, into, stored_value(options.unknown)), {into}};
}

Result<render::PredicateVolume> phantom_of(const PredicateOptions& options) {
  auto volume = phantom_volume(options.phantom, options.phantom_side);
  if (volume || options.phantom == "neck") return volume;
  return Error{volume.error().code, "predicates." + volume.error().message};
}

/// Sets the stored values of no and of full intensity. Phantoms have 0 and 255.
void set_window(const PredicateOptions& options, const std::optional<int>& unknown,
                render::PredicateVolume& volume, Console& console) {
  IntensityWindow window;
  const bool given = options.black || options.white;
  if (!given && !options.volume.empty()) {
    window = intensity_window(volume.ultrasound->values(), unknown);
  }
  const double black = options.black.value_or(window.black);
  const double white = options.white.value_or(window.white);
  volume.predicates.intensity = {black, white};
  if (window.by_percentiles) {
    std::ostringstream text;
    text << volume.name << ": black " << black << " and white " << white
         << ", from the percentiles 1 and 99.5 of its values (--black and --white give others)";
    console.say(text.str());
  }
}

/// Volume and scan lines. Where the scan lines lie beside the volume, 'sonde reconstruct' has
/// written both, and \p unknown becomes its mark of voxels without echoes unless it is given.
Result<render::PredicateVolume> volume_of(const PredicateOptions& options, int threads,
                                          std::optional<int>& unknown, Console& console) {
  auto out = [&]() -> Result<render::PredicateVolume> {
    if (options.volume.empty()) return phantom_of(options);
    auto read = io::read_stored_volume(options.volume, console);
    if (!read) return read.error();
    return render::PredicateVolume{
        options.volume.stem().string(), std::make_shared<const StoredVolume>(*std::move(read)), {}};
  }();
  if (!out) return out;
  const VoxelGrid& grid = out->ultrasound->grid();
  if (auto scan = scan_of(options, *out->ultrasound)) out->predicates.scan = *std::move(scan);
  if (!options.scan_lines.empty()) {
    if (auto ok = add_scan_lines(options.scan_lines, grid, usable_threads(threads), out->predicates,
                                 console);
        !ok) {
      return ok.error();
    }
  }
  if (!options.volume.empty() && !out->predicates.scan) {
    const auto beside = scan_lines_beside(options.volume, *out->ultrasound, console);
    if (!beside) return beside.error();
    if (*beside) {
      if (auto ok = add_lines(**beside, grid, usable_threads(threads), out->predicates); !ok) {
        return ok.error();
      }
      unknown = unknown_of_reconstruction(*out->ultrasound, unknown);
    }
  }
  set_window(options, unknown, *out, console);
  if (options.labels.empty() && options.layers.empty()) return out;
  auto labels = options.layers.empty() ? read_labels(options.labels, grid, console)
                                       : read_layers(options.layers, grid);
  if (!labels && options.volume.empty() && !options.labels.empty()) {
    // An option with many values takes a volume that follows it as one more value.
    return Error{labels.error().code,
                 labels.error().message + "; no volume is given, so the phantom " +
                     options.phantom + " is used: put the volume before --labels"};
  }
  if (!labels) return labels.error();
  out->predicates.features.labels = *std::move(labels);
  return out;
}

/// Before anything is computed: what predicates ask for and only the user can give.
Result<void> check_needs(const PredicateOptions& options, const render::PredicateVolume& volume,
                         const render::PredicateModel& model, DistancesFrom from) {
  const render::PredicatePosition place{volume.ultrasound->grid(), volume.predicates.scan, {}, {}};
  for (const std::string& name : kinds_of(model)) {
    const auto kind = render::find_predicate_kind(name);
    if (!kind) return kind.error();
    const render::PredicateNeeds needs = (*kind)->needs(place);
    const auto reject = [&](const std::string& required) {
      return Error{ErrorCode::kUsage, "predicate " + name + " requires " + required};
    };
    if (render::reads_scan_lines(needs) && !volume.predicates.scan) {
      return reject(
          "scan-line directions of the volume (--into x y z, --apex x y z or --scan-lines FILE)");
    }
    if (needs.labels && !volume.predicates.features.labels) {
      return reject("a label volume (--labels FILE or --layers FILE)");
    }
    const bool live = from != DistancesFrom::kOptions;
    if (needs.needle && !(live ? from == DistancesFrom::kLiveNeedle : options.needle.has_value())) {
      return reject(live ? "a needle in the recording (--needle-frame NAME)"
                         : "a needle (--needle TIP HUB)");
    }
    if (needs.target && !options.target) {
      return reject(live ? "a target (predicates.target_mm or [plan] of the session file)"
                         : "a target (--target x y z RADIUS)");
    }
  }
  return {};
}

render::DerivedFeatureOptions derive_options(const PredicateOptions& options,
                                             const PredicateFile& file) {
  render::DerivedFeatureOptions derive;
  derive.gradient.smoothing_mm = file.smoothing_mm;
  derive.snr = file.snr;
  derive.confidence = file.confidence;
  derive.vesselness.smallest_radius_mm = file.vessels.smallest_radius_mm;
  derive.vesselness.largest_radius_mm = file.vessels.largest_radius_mm;
  derive.unknown = stored_value(options.unknown);
  if (file.vessels.bright) derive.vesselness.polarity = render::features::Polarity::kBright;
  return derive;
}

/// A predicate that is true nowhere: a set without predicates shows nothing.
render::PredicateModel nothing_to_show() {
  using E = render::PredicateExpression;
  const E any = E::kind("intensity");
  render::PredicateModel model;
  model.entries.push_back({"nothing", E::all({any, E::negation(any)})});
  model.histogram.add(0, 0);
  return model;
}

/// The volume as the set draws it: connected parts, floors and soft thresholds applied.
Result<render::PredicateVolume> resolved(const render::PredicateVolume& source, double soft_share) {
  render::PredicateVolume volume = source;
  if (const auto ok = render::resolve_connected(volume); !ok) return ok.error();
  if (const auto ok = render::shape_intensity(volume, soft_share); !ok) return ok.error();
  return volume;
}

}  // namespace

std::optional<std::int16_t> stored_value(const std::optional<int>& option) {
  if (!option) return {};
  return static_cast<std::int16_t>(*option);
}

Result<PredicateFile> set_up_of(const PredicateOptions& options) {
  Result<PredicateFile> file = [&]() -> Result<PredicateFile> {
    // The name of a preset always means the preset; ./NAME means a file of that name.
    auto preset = preset_predicate_file(options.set_up);
    if (preset) return preset;
    std::error_code ignored;
    if (std::filesystem::exists(options.set_up, ignored))
      return read_predicate_file(options.set_up);
    return Error{ErrorCode::kUsage,
                 "predicates.set_up: expected a file, or a " + preset.error().message};
  }();
  if (!file) return file;
  if (const auto ok = apply_edits(options.histogram, file->model); !ok) return ok.error();
  file->vessels.smallest_radius_mm =
      options.smallest_radius_mm.value_or(file->vessels.smallest_radius_mm);
  file->vessels.largest_radius_mm =
      options.largest_radius_mm.value_or(file->vessels.largest_radius_mm);
  file->shading_mm = options.shading_mm.value_or(file->shading_mm);
  file->soft_share = options.soft_share.value_or(file->soft_share);
  file->smoothing_mm = options.smoothing_mm.value_or(file->smoothing_mm);
  file->vessels.bright = options.bright_vessels.value_or(file->vessels.bright);
  if (file->vessels.smallest_radius_mm > file->vessels.largest_radius_mm) {
    return reject_radii(options, file->vessels);
  }
  if (options.hue_mean) {
    file->hue_mean = *options.hue_mean == "linear" ? render::spec::HueMean::kLinear
                                                   : render::spec::HueMean::kCircular;
  }
  return file;
}

namespace {

/// Volume with unknown voxels set to black, because nothing is known about tissue there.
Result<std::shared_ptr<const StoredVolume>> without_unknown(
    const std::shared_ptr<const StoredVolume>& volume, const PredicateOptions& options,
    double black, Console& console) {
  if (!options.unknown) return volume;
  const std::int16_t unknown = *stored_value(options.unknown);
  if (std::ranges::find(volume->values(), unknown) == volume->values().end()) {
    console.report(
        Severity::kWarning, volume->name(),
        "predicates.unknown (--unknown): no voxel has the value " + std::to_string(unknown));
    return volume;
  }
  if (unknown <= black) return volume;
  using Stored = std::numeric_limits<std::int16_t>;
  const auto dark = static_cast<std::int16_t>(
      std::clamp<double>(std::floor(black), Stored::min(), Stored::max()));
  std::vector<std::int16_t> voxels(volume->values().begin(), volume->values().end());
  std::ranges::replace(voxels, unknown, dark);
  auto shown = StoredVolume::create(volume->grid(), std::move(voxels), volume->name());
  if (!shown) return shown.error();
  return std::make_shared<const StoredVolume>(*std::move(shown));
}

}  // namespace

render::SphereShape target_sphere(const Eigen::Vector4d& target) {
  render::SphereShape sphere{{target.head<3>()}, target.w()};
  sphere.opacity = 0.5;
  return sphere;
}

Result<PreparedPredicates> prepare_predicates(
    const PredicateOptions& given, int threads, Console& console, DistancesFrom from,
    const std::vector<render::features::Stroke>& strokes) {
  PredicateOptions options = given;
  auto file = set_up_of(options);
  if (!file) return file.error();
  auto volume = volume_of(given, threads, options.unknown, console);
  if (!volume) return volume.error();
  if (const auto ok = check_needs(options, *volume, file->model, from); !ok) return ok.error();
  if (const auto ok = check_strokes(strokes, volume->ultrasound->grid()); !ok) return ok.error();
  if (!options.volume.empty()) {
    warn_of_white(options.volume.string(), volume->ultrasound->values(),
                  volume->predicates.intensity.white, options.unknown, console);
  }
  render::PredicateScene& predicates = volume->predicates;
  predicates.model = file->model;
  predicates.hue_mean = file->hue_mean;
  predicates.cutaway_importance = file->cutaway_importance;
  predicates.opacity_length_mm = options.opacity_length_mm.value_or(file->opacity_length_mm);
  FeatureMaker maker(threads, options.cache, console);
  const auto added = render::add_derived_features(
      volume->ultrasound, derive_options(options, *file),
      [&maker](const std::string& name, const render::features::DerivedRequest& request) {
        return maker.make(name, request);
      },
      volume->predicates);
  if (!added) return added.error();
  // Features read voxels that nobody knows as unknown; rays read them as black.
  const auto as_read = volume->ultrasound;
  auto shown = without_unknown(volume->ultrasound, options, predicates.intensity.black, console);
  if (!shown) return shown.error();
  volume->ultrasound = *std::move(shown);
  const auto as_recorded = volume->ultrasound;
  if (file->shading_mm > 0) {
    auto shading =
        render::shading_of_predicates(*as_recorded, predicates.intensity, file->shading_mm,
                                      file->full_gradient_per_mm, usable_threads(threads));
    if (!shading) return shading.error();
    predicates.shading = *std::move(shading);
  }
  auto ready = resolved(*volume, file->soft_share);
  if (!ready) return ready.error();
  auto source =
      std::make_shared<const PredicateSource>(PredicateSource{.file = *file,
                                                              .options = options,
                                                              .distances = from,
                                                              .as_read = as_read,
                                                              .volume = *std::move(volume)});
  return PreparedPredicates{*std::move(file), *std::move(ready), as_recorded, std::move(source)};
}

Result<render::PredicateVolume> prepare_model(PredicateSource& source,
                                              const render::PredicateModel& model,
                                              const render::MakeFeature& make) {
  render::PredicateVolume& volume = source.volume;
  const bool empty = model.entries.empty();
  volume.predicates.model = empty ? nothing_to_show() : model;
  const auto& set = volume.predicates.model;
  if (auto ok = render::validate(set); !ok) return ok.error();
  if (auto ok = check_needs(source.options, volume, set, source.distances); !ok) return ok.error();
  const auto added = render::add_derived_features(
      source.as_read, derive_options(source.options, source.file), make, volume.predicates);
  if (!added) return added.error();
  return resolved(volume, empty ? 0 : source.file.soft_share);
}

}  // namespace nav::app
