// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery_predicates.hpp"

#include <algorithm>
#include <functional>
#include <tuple>

#include "app/engines.hpp"
#include "app/predicates/phantom_volume.hpp"
#include "app/predicates/predicate_image.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "bench/predicate_cases.hpp"
#include "bench/scene_set.hpp"
#include "bench/two_volumes.hpp"
#include "io/ct.hpp"
#include "io/image_output.hpp"
#include "render/engine.hpp"
#include "render/predicates/shading_source.hpp"

namespace nav::bench {
namespace {

using E = render::PredicateExpression;
using Bar = render::PredicateHistogram::Bar;
using render::features::Stroke;
using Vec = Eigen::Vector3d;

constexpr int kSide = 192;  // Voxels of a simulated volume.

render::PredicateModel model_of(std::vector<render::PredicateEntry> entries,
                                std::vector<Bar> bars) {
  return {std::move(entries), *render::PredicateHistogram::create(std::move(bars))};
}

/// One part of an image: a volume by a model, or by the standard transfer function.
struct Part {
  std::string title;
  std::optional<render::PredicateModel> model{};
};

/// A preset and what it shows.
struct Step {
  std::string title, preset;
};

/// From where a volume is seen, along its axes, and how near.
struct View {
  Vec from{-0.5, -1, 0.45};
  double nearer = 1;
  double opacity_length_mm = 2;
};

class PredicateGallery {
 public:
  PredicateGallery(const GalleryOptions& options, app::OutputFolder& folder, app::Console& console)
      : options_(options), folder_(folder), console_(console) {}

  Result<void> patient(const std::string& name, const Step& b, const Step& c);
  Result<void> carried();
  Result<void> scribbles();
  Result<void> prostate();
  Result<void> spine();
  Result<void> inside();
  Result<void> shaded();
  [[nodiscard]] bool wanted(const std::string& name) const {
    return ("predicates-" + name).find(options_.only) != std::string::npos;
  }

 private:
  Result<render::Scene> scene_of(const render::PredicateModel& model, const View& view,
                                 render::PredicateVolume& volume) const;
  Result<app::PredicatePanel> panel(const Part& part, const View& view,
                                    render::PredicateVolume& volume);
  Result<void> write(const std::string& name,
                     const std::vector<app::PredicatePanel>& panels) const {
    return folder_.write_image("predicates-" + name + ".png", app::predicate_image(panels));
  }
  Result<void> draw(const std::string& name, const std::vector<Part>& parts, const View& view,
                    render::PredicateVolume& volume);
  Result<Image2d<Rgba8>> rendered(const render::Scene& scene);
  /// Nothing, and a warning, where the data folder lacks a file.
  Result<std::optional<render::PredicateVolume>> recorded(const std::filesystem::path& file) const;

  const GalleryOptions& options_;
  app::OutputFolder& folder_;
  app::Console& console_;
};

Result<render::Scene> PredicateGallery::scene_of(const render::PredicateModel& model,
                                                 const View& view,
                                                 render::PredicateVolume& volume) const {
  if (auto ok = add_features(model, volume); !ok) return ok.error();
  render::Scene scene = render::predicate_scene(volume, model, options_.width, options_.height);
  const Vec middle = scene.camera.look_at_ct.mm;
  const double distance = (scene.camera.eye_ct.mm - middle).norm() / view.nearer;
  const Vec from = (volume.ultrasound->grid().directions * view.from).normalized();
  scene.camera.eye_ct = {middle + distance * from};
  scene.predicates->opacity_length_mm = view.opacity_length_mm;
  return scene;
}

/// An engine of its own for each: no image can depend on the one before.
Result<Image2d<Rgba8>> PredicateGallery::rendered(const render::Scene& scene) {
  auto engine = app::make_engine(options_.engine, 0, console_);
  if (!engine) return engine.error();
  const auto image = (*engine)->render(scene);
  if (!image) return image.error();
  return render::to_8bit(image->pixels);
}

Result<app::PredicatePanel> PredicateGallery::panel(const Part& part, const View& view,
                                                    render::PredicateVolume& volume) {
  const render::PredicateModel any =
      model_of({{"all", E::kind("intensity", {0, 1e6})}}, {{1, 0, 0}});
  auto scene = scene_of(part.model.value_or(any), view, volume);
  if (!scene) return scene.error();
  auto image = rendered(part.model ? *scene : render::standard_scene(*scene));
  if (!image) return image.error();
  return app::PredicatePanel{part.title, *std::move(image), part.model};
}

Result<void> PredicateGallery::draw(const std::string& name, const std::vector<Part>& parts,
                                    const View& view, render::PredicateVolume& volume) {
  std::vector<app::PredicatePanel> panels;
  for (const Part& part : parts) {
    auto one = panel(part, view, volume);
    if (!one) return one.error();
    panels.push_back(*std::move(one));
  }
  return write(name, panels);
}

/// Figures 1 and 6 to 8: standard, surroundings, target with context.
Result<void> PredicateGallery::patient(const std::string& name, const Step& b, const Step& c) {
  if (!wanted(name)) return {};
  auto volume = app::phantom_volume(name, kSide);
  if (!volume) return volume.error();
  return draw(name,
              {{"(a) standard transfer function"},
               {"(b) " + b.title, *render::preset_predicates(b.preset)},
               {"(c) " + c.title, *render::preset_predicates(c.preset)}},
              {}, *volume);
}

/// Figure 9: one predicate set, two patients.
Result<void> PredicateGallery::carried() {
  if (!wanted("carried")) return {};
  const auto model = *render::preset_predicates("carotid-vessel");
  auto first = app::phantom_volume("carotid", kSide);
  auto second = app::phantom_volume("carotid-2", kSide);
  if (!first || !second) return first ? second.error() : first.error();
  std::vector<app::PredicatePanel> panels;
  for (const auto& [part, volume] : {std::pair(Part{"(a) patient 1: made here", model}, &*first),
                                     {Part{"(b) patient 2: standard"}, &*second},
                                     {Part{"(c) patient 2: carried over", model}, &*second}}) {
    auto one = panel(part, {}, *volume);
    if (!one) return one.error();
    panels.push_back(*std::move(one));
  }
  return write("carried", panels);
}

/// Along the bone of the middle slice, and in skin and muscle above it, as a hand would draw.
std::vector<Stroke> shoulder_strokes(const render::PredicateVolume& volume) {
  const VoxelGrid& grid = volume.ultrasound->grid();
  const auto labels = volume.predicates.features.labels->bits();
  constexpr std::uint32_t kBone = 4;
  const int k = grid.size[2] / 2;
  Stroke show;
  show.plane_normal = {grid.directions.col(2)};
  show.radius_mm = 0.6;
  Stroke skin = show;
  skin.paint = render::features::Paint::kHide;
  Stroke muscle = skin;
  constexpr int kStep = 6;
  for (int i = grid.size[0] / 5; i < grid.size[0] * 4 / 5; i += kStep) {
    int j = 0;
    while (j < grid.size[1] && (labels[render::features::offset_of(grid, i, j, k)] & kBone) == 0)
      ++j;
    if (j < grid.size[1]) show.points.push_back(grid.at(Vec(i, j, k)));
    skin.points.push_back(grid.at(Vec(i, grid.size[1] * 0.06, k)));
    muscle.points.push_back(grid.at(Vec(i, grid.size[1] * 0.27, k)));
  }
  return {show, skin, muscle};
}

/// Figure 5: strokes that show bone and hide skin and muscle, before and after.
Result<void> PredicateGallery::scribbles() {
  if (!wanted("scribbles")) return {};
  auto volume = app::phantom_volume("shoulder", kSide);
  if (!volume) return volume.error();
  auto model = *render::preset_predicates("shoulder-bone");
  auto bars = model.histogram.bars();
  for (Bar& bar : bars) bar.importance = 1;
  model.histogram = *render::PredicateHistogram::create(std::move(bars));
  auto scene = scene_of(model, {}, *volume);
  if (!scene) return scene.error();
  const auto strokes = shoulder_strokes(*volume);
  constexpr double kShare = 0.25;  // The paper's.
  const auto outcome = app::scribble(*scene, strokes, kShare);
  if (!outcome) return outcome.error();
  auto before = rendered(*scene);
  if (!before) return before.error();
  scene->predicates->model.histogram = outcome->histogram;
  auto after = rendered(*scene);
  if (!after) return after.error();
  return write("scribbles", {{"(a) before: all alike", *std::move(before), model},
                             {"(b) strokes: show green, hide red",
                              app::stroke_image(*scene->ct, scene->predicates->intensity, strokes,
                                                options_.width, options_.height)},
                             {"(c) after", *std::move(after), scene->predicates->model}});
}

Result<std::optional<render::PredicateVolume>> PredicateGallery::recorded(
    const std::filesystem::path& file) const {
  const auto path = bench_data_dir() / file;
  if (!std::filesystem::exists(path)) {
    console_.report(Severity::kWarning, "gallery",
                    "skipped: expected " + path.string() + ", found nothing (set SONDE_DATA_DIR)");
    return std::optional<render::PredicateVolume>();
  }
  auto read = io::read_stored_volume(path, console_);
  if (!read) return read.error();
  return std::optional(render::PredicateVolume{
      path.stem().string(), std::make_shared<const StoredVolume>(*std::move(read)), {}});
}

Result<void> PredicateGallery::prostate() {
  if (!wanted("prostate")) return {};
  auto volume = recorded(std::filesystem::path("us-predicate") / "prostatePhantom.mha");
  if (!volume) return volume.error();
  if (!*volume) return {};
  const E tissue = E::kind("intensity", {0.15, 1e6});
  const E interfaces =
      E::all({E::kind("intensity", {0.3, 1e6}), E::kind("gradient_magnitude", {0.08, 1e6})});
  return draw("prostate",
              {{"(a) standard transfer function"},
               {"(b) interfaces", model_of({{"interfaces", interfaces}, {"gland", tissue}},
                                           {{0.8, 45, 0.6}, {0.2, 35, 0.25}})},
               {"(c) tubes within the gland",
                model_of({{"tubes", E::kind("vesselness", {0.2, 1})}, {"gland", tissue}},
                         {{0.7, 0, 0.8}, {0.3, 35, 0.25}})}},
              {{-0.5, -1, 0.45}, 1.3}, **volume);
}

Result<void> PredicateGallery::spine() {
  if (!wanted("spine")) return {};
  auto volume = recorded(std::filesystem::path("plus-sequences") / "baselines" /
                         "SpinePhantomFreehandReconstructed.mha");
  if (!volume) return volume.error();
  if (!*volume) return {};
  // The probe lay on the first plane.
  const VoxelGrid& grid = (*volume)->ultrasound->grid();
  (*volume)->predicates.scan = render::ParallelScan{grid.at({0, 0, 0}), {grid.directions.col(2)}};
  const E deep = E::kind("depth", {14, 1e4});
  const E tissue = E::kind("intensity", {0.15, 1e6});
  const E facing = E::kind("gradient_angle", {0, 1.3, 0.02});
  const E bone = E::all({E::kind("intensity", {0.45, 1e6}), facing, deep});
  return draw("spine",
              {{"(a) standard transfer function"},
               {"(b) bone through tissue", model_of({{"bone surface", bone}, {"tissue", tissue}},
                                                    {{0.85, 50, 0.6}, {0.15, 5, 0.3}})},
               {"(c) tissue above 14 mm left out",
                model_of({{"bone surface", E::all({E::kind("intensity", {0.4, 1e6}), deep})},
                          {"tissue", E::all({tissue, deep})}},
                         {{0.85, 50, 0.6}, {0.15, 5, 0.3}})}},
              {{-0.5, -0.6, -1}, 1.3}, **volume);
}

/// A CT with a 3D ultrasound volume in it.
Result<void> PredicateGallery::inside() {
  if (!wanted("inside")) return {};
  auto scene = two_volumes_scene(kSide, options_.width, options_.height);
  if (!scene) return scene.error();
  const auto model = scene->ultrasound->predicates.model;
  render::Scene alone = *scene;
  alone.ultrasound.reset();
  render::Scene equal = *scene;
  equal.ultrasound->ct_importance = 1024;  // Held at the greatest of the predicates.
  std::vector<app::PredicatePanel> panels;
  for (const auto& [title, drawn, legend] :
       {std::tuple{"(a) CT", &alone, false}, std::tuple{"(b) CT and ultrasound", &*scene, true},
        std::tuple{"(c) CT as important as the vessel", &equal, true}}) {
    auto image = rendered(*drawn);
    if (!image) return image.error();
    panels.push_back({title, *std::move(image), legend ? std::optional(model) : std::nullopt});
  }
  return write("inside", panels);
}

/// The shoulder's bone without shading, as in the paper, and with it.
Result<void> PredicateGallery::shaded() {
  if (!wanted("shaded")) return {};
  auto volume = app::phantom_volume("shoulder", kSide);
  if (!volume) return volume.error();
  const auto model = *render::preset_predicates("shoulder-bone");
  std::vector<app::PredicatePanel> panels;
  for (const double smoothing_mm : {0.0, 1.0, 2.0}) {
    auto scene = scene_of(model, {}, *volume);
    if (!scene) return scene.error();
    if (smoothing_mm > 0) {
      auto shading =
          render::shading_of_predicates(*scene->ct, scene->predicates->intensity, smoothing_mm,
                                        render::kUsualFullGradientPerMm, 0);
      if (!shading) return shading.error();
      scene->predicates->shading = *std::move(shading);
    }
    auto image = rendered(*scene);
    if (!image) return image.error();
    const std::string title = smoothing_mm == 0   ? "(a) not shaded"
                              : smoothing_mm == 1 ? "(b) shaded, 1 mm"
                                                  : "(c) shaded, 2 mm";
    panels.push_back({title, *std::move(image), model});
  }
  return write("shaded", panels);
}

}  // namespace

std::vector<std::string> predicate_gallery_names() {
  return {"predicates-carotid", "predicates-shoulder",  "predicates-tendon",
          "predicates-carried", "predicates-scribbles", "predicates-prostate",
          "predicates-spine",   "predicates-inside",    "predicates-shaded"};
}

Result<void> draw_predicate_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                    app::Console& console) {
  GalleryOptions part = options;  // Three stand side by side.
  part.width = std::max(options.width * 7 / 10, 16);
  part.height = std::max(options.height * 8 / 10, 16);
  PredicateGallery gallery(part, folder, console);
  console.begin("3D ultrasound");
  const std::vector<std::function<Result<void>()>> images{
      [&] {
        return gallery.patient("carotid", {"surroundings", "carotid-context"},
                               {"vessel with context", "carotid-vessel"});
      },
      [&] {
        return gallery.patient("shoulder", {"fibrous muscle", "shoulder-muscle"},
                               {"bone with context", "shoulder-bone"});
      },
      [&] {
        return gallery.patient("tendon", {"tendon by angle and label", "tendon-fibres"},
                               {"tendon among fibrous muscle", "tendon-context"});
      },
      [&] { return gallery.carried(); },
      [&] { return gallery.scribbles(); },
      [&] { return gallery.prostate(); },
      [&] { return gallery.spine(); },
      [&] { return gallery.inside(); },
      [&] { return gallery.shaded(); }};
  double done = 0;
  for (const auto& image : images) {
    if (auto ok = image(); !ok) return ok;
    console.progress(++done / static_cast<double>(images.size()));
  }
  console.end();
  return {};
}

}  // namespace nav::bench
