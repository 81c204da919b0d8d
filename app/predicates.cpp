// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates.hpp"

#include <cstdio>

#include "app/engines.hpp"
#include "app/predicate_file.hpp"
#include "app/predicate_labels.hpp"
#include "app/predicate_picture.hpp"
#include "app/predicate_scribbles.hpp"
#include "bench/predicate_patient.hpp"
#include "io/ct.hpp"
#include "io/picture.hpp"
#include "render/derived_features.hpp"
#include "render/engine.hpp"
#include "render/predicates/gradient_features.hpp"
#include "render/predicates/registry.hpp"

namespace nav::app {
namespace {

using render::derived::Stroke;

/// A preset by its name, otherwise a file; then the edits of the histogram.
Result<PredicateFile> set_up(const PredicateOptions& options) {
  Result<PredicateFile> file = [&]() -> Result<PredicateFile> {
    if (std::filesystem::exists(options.set_up)) return read_predicate_file(options.set_up);
    auto preset = preset_predicate_file(options.set_up);
    if (!preset) {
      return Error{ErrorCode::kUsage,
                   "--predicates: expected a file, or a " + preset.error().message};
    }
    return preset;
  }();
  if (!file) return file;
  if (const auto ok = apply_edits(options.histogram, file->model); !ok) return ok.error();
  file->vessels.smallest_radius_mm =
      options.smallest_radius_mm.value_or(file->vessels.smallest_radius_mm);
  file->vessels.largest_radius_mm =
      options.largest_radius_mm.value_or(file->vessels.largest_radius_mm);
  file->vessels.bright |= options.bright_vessels;
  return file;
}

/// Absent where nothing was said of them: no scan line is made up.
std::optional<render::ScanGeometry> scan_of(const PredicateOptions& options,
                                            const VoxelGrid& grid) {
  if (options.apex_ct) return render::FanScan{{*options.apex_ct}, options.face_radius_mm};
  if (!options.into_ct) return {};
  // Depth 0: the corner that lies furthest towards the probe.
  Point<frames::Ct> nearest = grid.at({0, 0, 0});
  for (int corner = 1; corner < 8; ++corner) {
    const Eigen::Vector3d index((corner & 1) * (grid.size[0] - 1),
                                (corner >> 1 & 1) * (grid.size[1] - 1),
                                (corner >> 2) * (grid.size[2] - 1));
    if ((grid.at(index).mm - nearest.mm).dot(*options.into_ct) < 0) nearest = grid.at(index);
  }
  return render::ParallelScan{nearest, {*options.into_ct}};
}

Result<bench::PredicateVolume> phantom_of(const PredicateOptions& options) {
  if (options.phantom != "neck") {
    auto volume = bench::simulated_ultrasound(options.phantom, options.phantom_side);
    if (!volume) return Error{volume.error().code, "--" + volume.error().message + ", or neck"};
    return volume;
  }
  auto phantom = bench::neck_phantom(options.phantom_side);
  // Vessels are to be found, as in any other volume, not taken from the phantom's truth.
  if (phantom) phantom->predicates.features.volumes.erase(render::feature::kVesselness);
  return phantom;
}

Result<bench::PredicateVolume> volume_of(const PredicateOptions& options, Console& console) {
  auto out = [&]() -> Result<bench::PredicateVolume> {
    if (options.volume.empty()) return phantom_of(options);
    auto read = io::read_ct(options.volume, console);
    if (!read) return read.error();
    return bench::PredicateVolume{
        options.volume.stem().string(), std::make_shared<const Volume>(*std::move(read)), {}, {}};
  }();
  if (!out) return out;
  const VoxelGrid& grid = out->ultrasound->grid();
  if (auto scan = scan_of(options, grid)) out->predicates.scan = *std::move(scan);
  out->predicates.intensity = {options.black, options.white};
  if (options.labels.empty()) return out;
  auto labels = read_labels(options.labels, grid, console);
  if (!labels) return labels.error();
  out->predicates.features.labels = *std::move(labels);
  return out;
}

/// Before anything is computed: what predicates ask for and only the user can give.
Result<void> check_needs(const PredicateOptions& options, const bench::PredicateVolume& volume,
                         const render::PredicateModel& model) {
  const render::PredicatePlace place{volume.ultrasound->grid(), volume.predicates.scan, {}, {}};
  for (const std::string& name : kinds_of(model)) {
    const auto kind = render::find_predicate_kind(name);
    if (!kind) return kind.error();
    const render::PredicateNeeds needs = (*kind)->needs(place);
    const auto refuse = [&](const std::string& expected) {
      return Error{ErrorCode::kUsage,
                   "predicate " + name + ": expected " + expected + ", found none"};
    };
    const bool scan = needs.scan || name == render::feature::kConfidence;
    if (scan && !volume.predicates.scan) {
      return refuse("scan-line directions of the volume (--into x y z or --apex x y z)");
    }
    if (needs.labels && !volume.predicates.features.labels) {
      return refuse("a label volume (--labels FILE)");
    }
    if (needs.needle && !options.needle) return refuse("a needle (--needle TIP HUB)");
    if (needs.target && !options.target) return refuse("a target (--target x y z RADIUS)");
  }
  return {};
}

Result<void> add_features(const PredicateOptions& options, const VesselScales& vessels, int threads,
                          bench::PredicateVolume& volume) {
  if (const auto ok = render::add_gradient_features(*volume.ultrasound, options.smoothing_mm,
                                                    volume.predicates, usable_threads(threads));
      !ok) {
    return ok;
  }
  render::DerivedFeatureOptions derive;
  derive.vesselness.smallest_radius_mm = vessels.smallest_radius_mm;
  derive.vesselness.largest_radius_mm = vessels.largest_radius_mm;
  if (vessels.bright) derive.vesselness.polarity = render::derived::Polarity::kBright;
  render::derived::DerivedLimits limits;
  limits.threads = usable_threads(threads);
  render::derived::DerivedVolumes service(limits);
  return render::add_derived_features(volume.ultrasound, derive, service, volume.predicates);
}

render::Scene scene_of(const SessionConfig& config, const PredicateFile& file,
                       const bench::PredicateVolume& volume) {
  const PredicateOptions& options = config.predicates;
  render::Scene scene = bench::predicate_scene(volume, {file.name, file.model}, config.output.width,
                                               config.output.height);
  const Eigen::Vector3d look_at = scene.camera.look_at_ct.mm;
  const double fitting = (scene.camera.eye_ct.mm - look_at).norm();
  const double distance = config.view.distance_mm > 0 ? config.view.distance_mm : fitting;
  const Eigen::Matrix3d& axes = volume.ultrasound->grid().directions;
  const Eigen::Vector3d from = (axes * options.from).normalized();
  scene.camera.eye_ct = {look_at + distance * from};
  constexpr double kNearlyAlong = 0.95;
  if (std::abs(scene.camera.up_ct.v.normalized().dot(from)) > kNearlyAlong) {
    scene.camera.up_ct = {axes.col(2)};
  }
  scene.quality.step_voxels = config.output.step_voxels;
  scene.predicates->opacity_length_mm = options.opacity_length_mm.value_or(file.opacity_length_mm);
  if (options.target) {
    scene.spheres = {{{options.target->head<3>()}, options.target->w()}};
    scene.spheres.front().opacity = 0.5;
  }
  if (options.needle) {
    render::NeedleShape needle{};
    needle.tip_ct = {options.needle->head<3>()};
    needle.hub_ct = {options.needle->tail<3>()};
    needle.safety = {SafetyState::kValid, ""};
    scene.needle = needle;
  }
  return scene;
}

Result<Image2d<Rgba8>> draw(render::Engine& engine, const render::Scene& scene, Console& console) {
  const auto image = engine.render(scene);
  if (!image) return image.error();
  const std::string& note = image->statistics.note;
  if (!note.empty()) console.report(Severity::kWarning, "picture", note);
  return render::to_8bit(image->pixels);
}

/// Standard rendering beside the one by predicates.
Result<std::vector<PredicatePanel>> compare(render::Engine& engine, const render::Scene& scene,
                                            Console& console) {
  auto right = draw(engine, scene, console);  // Says what is wrong with the options.
  if (!right) return right.error();
  auto left = draw(engine, bench::standard_scene(scene), console);
  if (!left) return left.error();
  return std::vector<PredicatePanel>{{"standard transfer function", *std::move(left)},
                                     {"predicates", *std::move(right), scene.predicates->model}};
}

void say_outcome(const ScribbleOutcome& outcome, const render::PredicateModel& model,
                 Console& console) {
  std::string text = std::to_string(outcome.shown) + " voxels to show, " +
                     std::to_string(outcome.hidden) + " to hide";
  if (!outcome.decisive) {
    console.report(Severity::kWarning, "scribbles",
                   text + ": every predicate is true for as many of both, so nothing changes");
    return;
  }
  for (std::size_t j = 0; j < model.entries.size(); ++j) {
    char importance[32];
    std::snprintf(importance, sizeof importance, " %.3f -> %.3f",
                  model.histogram.bars()[j].importance, outcome.histogram.bars()[j].importance);
    text += (j == 0 ? "; " : ", ") + model.entries[j].name + importance;
  }
  console.say(text);
}

/// Before and after; leaves the changed histogram in the scene.
Result<std::vector<PredicatePanel>> compare_scribbles(render::Engine& engine,
                                                      const std::vector<Stroke>& strokes,
                                                      double share, render::Scene& scene,
                                                      Console& console) {
  const auto outcome = scribble(scene, strokes, share);
  if (!outcome) return outcome.error();
  auto before = draw(engine, scene, console);
  if (!before) return before.error();
  const render::PredicateModel model = scene.predicates->model;
  say_outcome(*outcome, model, console);
  scene.predicates->model.histogram = outcome->histogram;
  auto after = draw(engine, scene, console);
  if (!after) return after.error();
  return std::vector<PredicatePanel>{
      {"strokes: show green, hide red",
       stroke_picture(*scene.ct, scene.predicates->intensity, strokes, scene.width, scene.height)},
      {"before", *std::move(before), model},
      {"after", *std::move(after), scene.predicates->model}};
}

Result<std::vector<Stroke>> strokes_of(const PredicateOptions& options) {
  std::vector<Stroke> strokes;
  if (!options.scribbles.empty()) {
    auto read = read_scribble_file(options.scribbles);
    if (!read) return read.error();
    strokes = *std::move(read);
  }
  strokes.insert(strokes.end(), options.strokes.begin(), options.strokes.end());
  return strokes;
}

}  // namespace

Result<void> run_predicates(const SessionConfig& config, Console& console) {
  const PredicateOptions& options = config.predicates;
  if (options.picture.empty()) {
    return Error{ErrorCode::kUsage, "--out: expected a PNG to write, found none"};
  }
  const auto strokes = strokes_of(options);
  if (!strokes) return strokes.error();
  auto file = set_up(options);
  if (!file) return file.error();
  auto engine = make_engine(config.output.engine, config.output.threads, console);
  if (!engine) return engine.error();
  auto volume = volume_of(options, console);
  if (!volume) return volume.error();
  if (const auto ok = check_needs(options, *volume, file->model); !ok) return ok;
  volume->predicates.model = file->model;
  volume->predicates.hue_mean = file->hue_mean;
  volume->predicates.cutaway_importance = file->cutaway_importance;
  if (const auto ok = add_features(options, file->vessels, config.output.threads, *volume); !ok)
    return ok;
  render::Scene scene = scene_of(config, *file, *volume);
  const auto panels = strokes->empty() ? compare(**engine, scene, console)
                                       : compare_scribbles(**engine, *strokes,
                                                           options.scribble_share, scene, console);
  if (!panels) return panels.error();
  if (const auto ok = io::write_png(predicate_picture(*panels), options.picture); !ok) return ok;
  console.say(volume->name + " by " + file->name + " in " + options.picture.string());
  if (options.save_set_up.empty()) return {};
  file->model = scene.predicates->model;
  file->opacity_length_mm = scene.predicates->opacity_length_mm;
  return write_predicate_file(options.save_set_up, *file);
}

}  // namespace nav::app
