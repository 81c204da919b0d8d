// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery_contextual.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "app/appearance/appearance.hpp"
#include "app/engines.hpp"
#include "bench/gallery/gallery_appearances.hpp"
#include "bench/gallery/gallery_views.hpp"
#include "bench/scene_set.hpp"
#include "io/ct.hpp"
#include "render/engine.hpp"

namespace nav::bench {
namespace {

using app::SessionConfig;
using Vec = Eigen::Vector3d;

/// A recorded CT, the slice that stands in it, and from where it is seen.
struct RecordedCase {
  std::string name;
  std::filesystem::path file;  ///< Below SONDE_DATA_DIR.
  Vec centre;                  ///< Middle of the slice, as fractions of the volume's extent.
  double width_mm, height_mm;  ///< Size of the slice.
  render::HuWindow window;
  Vec from;  ///< Direction to the eye, LPS.
  double distance_mm;
};

std::vector<RecordedCase> recorded_cases() {
  return {{.name = "abdomen",
           .file = std::filesystem::path("ct-abdomen-totalseg") / "example_ct.nii.gz",
           .centre = {0.42, 0.42, 0.66},
           .width_mm = 150,
           .height_mm = 110,
           .window = {60, 350},
           .from = {-0.35, -1, 0.25},
           .distance_mm = 760},
          {.name = "cta",
           .file = std::filesystem::path("cta-aorta-totalseg") / "ct_cropped.nii.gz",
           .centre = {0.5, 0.5, 0.5},
           .width_mm = 110,
           .height_mm = 110,
           .window = {150, 600},
           .from = {0.35, -1, 0.2},
           .distance_mm = 560}};
}

class ContextualGallery {
 public:
  ContextualGallery(const GalleryOptions& options, app::OutputFolder& folder, app::Console& console)
      : options_(options), folder_(folder), console_(console) {}

  Result<void> cutaways(const RecordedCase& one);
  Result<void> fragments();
  Result<void> mr();

 private:
  [[nodiscard]] bool wanted(const std::string& name) const {
    return name.find(options_.only) != std::string::npos;
  }
  /// The recorded CT; absent, with a warning, if it is not there.
  Result<std::shared_ptr<const Volume>> recorded(const std::filesystem::path& file) const;
  Result<render::Scene> scene_of(const std::shared_ptr<const Volume>& volume,
                                 const SessionConfig::Appearance& appearance,
                                 const render::Camera& camera) const;
  Result<void> draw(const std::string& name, const render::Scene& scene);

  const GalleryOptions& options_;
  app::OutputFolder& folder_;
  app::Console& console_;
};

Result<std::shared_ptr<const Volume>> ContextualGallery::recorded(
    const std::filesystem::path& file) const {
  const auto path = bench_data_dir() / file;
  if (!std::filesystem::exists(path)) {
    console_.report(Severity::kWarning, "gallery",
                    "skipped: expected " + path.string() + ", found nothing (set SONDE_DATA_DIR)");
    return std::shared_ptr<const Volume>();
  }
  auto ct = io::read_ct(path, console_);
  if (!ct) return ct.error();
  return std::make_shared<const Volume>(*std::move(ct));
}

Result<render::Scene> ContextualGallery::scene_of(const std::shared_ptr<const Volume>& volume,
                                                  const SessionConfig::Appearance& appearance,
                                                  const render::Camera& camera) const {
  auto resolved = app::resolve_appearance(appearance, *volume);
  if (!resolved) return resolved.error();
  render::Scene scene{.ct = volume, .transfer = resolved->transfer, .camera = camera};
  scene.shading = resolved->shading;
  scene.cutaway = resolved->cutaway;
  scene.background_rgb = {0.08, 0.09, 0.11};
  scene.width = options_.width;
  scene.height = options_.height;
  if (resolved->drawn) {
    scene.ct = resolved->drawn->ct;
    scene.transfer = resolved->drawn->transfer;
    scene.gradient_source = resolved->drawn->gradient_source;
    for (const auto& statement : resolved->drawn->statements) console_.say(statement);
  }
  return scene;
}

/// An engine of its own for each image: none can depend on the one before.
Result<void> ContextualGallery::draw(const std::string& name, const render::Scene& scene) {
  auto engine = app::make_engine(options_.engine, 0, console_);
  if (!engine) return engine.error();
  const auto drawn = (*engine)->render(scene);
  if (!drawn) return drawn.error();
  return folder_.write_image(name + ".png", render::to_8bit(drawn->pixels));
}

/// The simple cutaway beside the contextual one, about a slice of the CT itself.
Result<void> ContextualGallery::cutaways(const RecordedCase& one) {
  const std::string simple = "recorded-" + one.name + "-simple";
  const std::string contextual = "recorded-" + one.name + "-contextual";
  if (!wanted(simple) && !wanted(contextual)) return {};
  const auto volume = recorded(one.file);
  if (!volume) return volume.error();
  if (!*volume) return {};
  const VoxelGrid& grid = (*volume)->grid();
  // Fractions along LPS, whatever the order of the voxels.
  const Vec half = 0.5 * (grid.directions * grid.extent_mm()).cwiseAbs();
  const Vec centre = grid.centre().mm + (2 * one.centre - Vec::Ones()).cwiseProduct(half);
  auto scene = scene_of(*volume, {}, looking(centre, one.from, one.distance_mm));
  if (!scene) return scene.error();
  scene->plane = coronal_slice(**volume, centre, one.width_mm, one.height_mm, one.window);
  if (wanted(contextual)) {
    if (auto ok = draw(contextual, *scene); !ok) return ok;
  }
  if (!wanted(simple)) return {};
  scene->cutaway->theta2_rad = scene->cutaway->theta1_rad;
  scene->cutaway->overlay_mm = 0;
  return draw(simple, *scene);
}

/// Vessels by fixed windows, with the table and unsmoothed, and as they are drawn by default.
Result<void> ContextualGallery::fragments() {
  const std::string before = "fragments-before";
  const std::string after = "fragments-after";
  if (!wanted(before) && !wanted(after)) return {};
  const auto volume = recorded(recorded_cases().back().file);
  if (!volume) return volume.error();
  if (!*volume) return {};
  SessionConfig::Appearance appearance;
  appearance.preset = "cta-vessels";
  const auto camera = looking((*volume)->grid().centre().mm, {0.6, -1, 0.2}, 520);
  SessionConfig::Appearance fixed = appearance;
  fixed.fit_vessels = false;
  fixed.remove_table = false;
  fixed.smoothing_mm = 0;
  appearance.smoothing_mm = 1;
  for (const auto& [name, how] : {std::pair{before, fixed}, {after, appearance}}) {
    if (!wanted(name)) continue;
    auto scene = scene_of(*volume, how, camera);
    if (!scene) return scene.error();
    scene->cutaway.reset();
    if (auto ok = draw(name, *scene); !ok) return ok;
  }
  return {};
}

/// An MR with bright fat: fat of importance 0.99, and the default.
Result<void> ContextualGallery::mr() {
  const std::string before = "mr-before";
  const std::string after = "mr-after";
  if (!wanted(before) && !wanted(after)) return {};
  const sim::AbdomenPhantom phantom({1, sim::Contrast::kNative});
  const auto volume = simulated_mr(phantom, MrFat::kBright);
  if (!volume) return volume.error();
  Vec liver = Vec::Zero();
  const auto targets = phantom.targets();
  for (const auto& target : targets) liver += target.mm / static_cast<double>(targets.size());
  const auto camera = looking(liver, {-0.9, -0.9, 0.2}, 470);
  SessionConfig::Appearance important;
  important.preset = "mr-default";
  constexpr double kAll = std::numeric_limits<double>::infinity();
  important.importance = {{-kAll, kAll, 0.99, "bright"}};
  for (const auto& [name, how] :
       {std::pair{before, important}, {after, SessionConfig::Appearance{}}}) {
    if (!wanted(name)) continue;
    auto scene = scene_of(*volume, how, camera);
    if (!scene) return scene.error();
    if (!scene->cutaway) scene->cutaway.emplace();
    scene->plane = coronal_slice(**volume, liver, 120, 100, {400, 900});
    if (auto ok = draw(name, *scene); !ok) return ok;
  }
  return {};
}

}  // namespace

std::vector<std::string> contextual_gallery_names() {
  std::vector<std::string> names{"fragments-before", "fragments-after", "mr-before", "mr-after"};
  for (const RecordedCase& one : recorded_cases()) {
    names.push_back("recorded-" + one.name + "-simple");
    names.push_back("recorded-" + one.name + "-contextual");
  }
  return names;
}

Result<void> draw_contextual_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                     app::Console& console) {
  ContextualGallery gallery(options, folder, console);
  console.begin("the default appearance");
  for (const RecordedCase& one : recorded_cases()) {
    if (auto ok = gallery.cutaways(one); !ok) return ok;
  }
  if (auto ok = gallery.fragments(); !ok) return ok;
  if (auto ok = gallery.mr(); !ok) return ok;
  console.end();
  return {};
}

}  // namespace nav::bench
