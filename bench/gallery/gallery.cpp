// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery.hpp"

#include <cmath>
#include <functional>

#include "app/engines.hpp"
#include "app/output_folder.hpp"
#include "bench/gallery/gallery_appearances.hpp"
#include "bench/gallery/gallery_contextual.hpp"
#include "bench/gallery/gallery_predicates.hpp"
#include "bench/gallery/gallery_registration.hpp"
#include "bench/gallery/gallery_simulator.hpp"
#include "bench/gallery/gallery_views.hpp"
#include "bench/scene_set.hpp"
#include "io/ct.hpp"
#include "render/engine.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/ultrasound.hpp"

namespace nav::bench {
namespace {

using render::Scene;
using Vec = Eigen::Vector3d;
using Pose = Transform<frames::Ct, frames::Image>;

constexpr double kDeg = M_PI / 180;

/// Pose of the probe of the simulated images: on the skin, looking at a point of the liver, its
/// face along a direction.
Pose probe_at(const sim::AbdomenPhantom& phantom, double angle_rad, double z_mm, const Vec& aim,
              const Vec& along) {
  const Vec face = phantom.skin_point(angle_rad, z_mm).mm;
  const Vec deep = (aim - face).normalized();
  const Vec across = (along - along.dot(deep) * deep).normalized();
  Eigen::Matrix3d axes;
  axes << across, deep, across.cross(deep);
  return {Eigen::Quaterniond(axes), face};
}

/// One patient, scanned and insonified.
class GalleryPatient {
 public:
  static Result<GalleryPatient> create(sim::Contrast contrast) {
    GalleryPatient patient(sim::AbdomenPhantom({1, contrast}));
    sim::CtOptions options;
    options.spacing_mm = {1.2, 1.2, 1.5};
    options.noise_hu = 6;
    auto ct = sim::scan_ct(patient.phantom_, options);
    if (!ct) return ct.error();
    patient.ct_ = std::make_shared<const Volume>(std::move(*ct));
    return patient;
  }
  [[nodiscard]] const sim::AbdomenPhantom& phantom() const { return phantom_; }
  [[nodiscard]] const std::shared_ptr<const Volume>& ct() const { return ct_; }
  /// Middle of the liver.
  [[nodiscard]] Vec liver() const {
    Vec sum = Vec::Zero();
    const auto targets = phantom_.targets();
    for (const auto& target : targets) sum += target.mm;
    return sum / static_cast<double>(targets.size());
  }
  [[nodiscard]] render::UltrasoundPlane ultrasound(const Pose& pose) const {
    const sim::UltrasoundSimulator simulator(phantom_, sim::convex_abdominal(), 1);
    return {simulator.simulate(pose, Timestamp(), 0), pose, 1.0, {SafetyState::kValid, ""}};
  }

 private:
  explicit GalleryPatient(sim::AbdomenPhantom phantom) : phantom_(std::move(phantom)) {}
  sim::AbdomenPhantom phantom_;
  std::shared_ptr<const Volume> ct_;
};

/// An image of the gallery.
struct GalleryImage {
  std::string name;
  Scene scene;
};

/// Draws what is asked for and keeps the volumes that several images share.
class Gallery {
 public:
  Gallery(const GalleryOptions& options, app::Console& console)
      : options_(options), console_(console) {}

  Result<void> add_angiography();
  Result<void> add_cutaways();
  Result<void> add_fusion();
  Result<void> add_plain_ct();
  Result<void> add_mr();
  [[nodiscard]] const std::vector<GalleryImage>& images() const { return images_; }

 private:
  [[nodiscard]] bool wanted(const std::string& name) const {
    return name.find(options_.only) != std::string::npos;
  }
  [[nodiscard]] bool any_wanted(const std::vector<std::string>& names) const {
    return std::any_of(names.begin(), names.end(), [&](const auto& n) { return wanted(n); });
  }
  void add(const std::string& name, const Scene& scene) {
    if (wanted(name)) images_.push_back({name, scene});
  }
  [[nodiscard]] Scene scene_of(std::shared_ptr<const Volume> ct,
                               render::TransferFunction appearance,
                               const render::Camera& camera) const;

  const GalleryOptions& options_;
  app::Console& console_;
  std::vector<GalleryImage> images_;
};

Scene Gallery::scene_of(std::shared_ptr<const Volume> ct, render::TransferFunction appearance,
                        const render::Camera& camera) const {
  Scene scene{.ct = std::move(ct),
              .transfer = std::move(appearance),
              .shading = {},
              .plane = {},
              .needle = {},
              .spheres = {},
              .camera = camera,
              .quality = {},
              .background_rgb = {0.08, 0.09, 0.11},
              .width = options_.width,
              .height = options_.height,
              .lines = {},
              .cutaway = {}};
  scene.shading.full_gradient_per_mm = 25;
  return scene;
}

/// Figures 2 and 3: importance decides what is shaded.
Result<void> Gallery::add_angiography() {
  const std::vector<std::string> names{"fig2a", "fig2b", "fig2c", "fig3a", "fig3b"};
  if (!any_wanted(names)) return {};
  const auto file = bench_data_dir() / "cta-aorta-totalseg" / "ct_cropped.nii.gz";
  if (!std::filesystem::exists(file)) {
    console_.report(Severity::kWarning, "gallery",
                    "figures 2 and 3 skipped: expected " + file.string() +
                        ", found nothing (set SONDE_DATA_DIR)");
    return {};
  }
  auto ct = io::read_ct(file, console_);
  if (!ct) return ct.error();
  const auto volume = std::make_shared<const Volume>(std::move(*ct));
  const auto appearance = angiography_appearance(*volume);
  if (!appearance) return appearance.error();
  Scene scene =
      scene_of(volume, *appearance, looking(volume->grid().centre().mm, {1, -0.55, 0.2}, 460));
  scene.shading.enabled = false;
  add("fig2a", scene);
  scene.shading.enabled = true;
  add("fig2b", scene);
  scene.shading.emphasis = 1;
  add("fig2c", scene);
  add("fig3a", scene);
  scene.shading.style = render::ShadingStyle::kGooch;
  add("fig3b", scene);
  return {};
}

/// Figure 5: the four settings of the cutaway about a plane textured with the CT.
Result<void> Gallery::add_cutaways() {
  if (!any_wanted({"fig5a", "fig5b", "fig5c", "fig5d"})) return {};
  const auto patient = GalleryPatient::create(sim::Contrast::kPortal);
  if (!patient) return patient.error();
  const Vec centre = patient->liver() + Vec(15, 0, 0);
  AbdomenImportance importance;
  importance.vessels = importance.bone = 0.99;
  const auto appearance = abdomen_appearance(*patient->ct(), importance);
  if (!appearance) return appearance.error();
  Scene scene = scene_of(patient->ct(), *appearance, looking(centre, {0.25, -1, 0.25}, 480));
  scene.plane = coronal_slice(*patient->ct(), centre, 135, 108, {100, 250});
  const double inf = std::numeric_limits<double>::infinity();
  const auto cut = [&](const std::string& name, double inner_deg, double outer_deg,
                       double overlay_mm) {
    scene.cutaway = render::Cutaway{};
    scene.cutaway->theta1_rad = inner_deg * kDeg;
    scene.cutaway->theta2_rad = outer_deg * kDeg;
    scene.cutaway->overlay_mm = overlay_mm;
    add(name, scene);
  };
  cut("fig5a", 25, 25, 0);
  cut("fig5b", 25, 25, inf);
  cut("fig5c", 25, 55, inf);
  cut("fig5d", 25, 55, 30);
  return {};
}

/// Figure 6: live ultrasound in the liver, vessels of importance 1 before it.
Result<void> Gallery::add_fusion() {
  if (!any_wanted({"fig6a", "fig6b"})) return {};
  const auto patient = GalleryPatient::create(sim::Contrast::kPortal);
  if (!patient) return patient.error();
  const Vec liver = patient->liver();
  const auto appearance = abdomen_appearance(*patient->ct(), {});
  if (!appearance) return appearance.error();
  Scene scene = scene_of(patient->ct(), *appearance, looking(liver, {-0.9, -0.9, 0.2}, 470));
  scene.cutaway = render::Cutaway{};
  scene.cutaway->theta1_rad = 20 * kDeg;
  scene.cutaway->theta2_rad = 50 * kDeg;
  scene.plane = patient->ultrasound(
      probe_at(patient->phantom(), 1.40 * M_PI, -45, liver + Vec(10, 0, 10), Vec::UnitZ()));
  scene.shading.emphasis = 0.4;
  add("fig6a", scene);
  scene.plane = patient->ultrasound(
      probe_at(patient->phantom(), 1.42 * M_PI, -30, liver + Vec(5, 0, 0), Vec::UnitX()));
  scene.camera = looking(liver, {-0.3, -0.35, -1}, 470);
  scene.cutaway->theta2_rad = 25 * kDeg;
  scene.shading.emphasis = 0;
  add("fig6b", scene);
  return {};
}

/// Figure 7: without contrast agent, bone may stand before the plane.
Result<void> Gallery::add_plain_ct() {
  if (!wanted("fig7")) return {};
  const auto patient = GalleryPatient::create(sim::Contrast::kNative);
  if (!patient) return patient.error();
  const Vec liver = patient->liver();
  const auto appearance = plain_ct_appearance(*patient->ct());
  if (!appearance) return appearance.error();
  Scene scene = scene_of(patient->ct(), *appearance, looking(liver, {-0.6, -0.6, 0.75}, 470));
  scene.plane = patient->ultrasound(
      probe_at(patient->phantom(), 1.42 * M_PI, -30, liver + Vec(5, 0, 0), Vec::UnitX()));
  scene.cutaway = render::Cutaway{};
  scene.cutaway->theta1_rad = 20 * kDeg;
  scene.cutaway->theta2_rad = 40 * kDeg;
  add("fig7", scene);
  return {};
}

/// Figure 8: MR, simple cutaway against transition and overlay.
Result<void> Gallery::add_mr() {
  if (!any_wanted({"fig8a", "fig8b"})) return {};
  const auto patient = GalleryPatient::create(sim::Contrast::kPortal);
  if (!patient) return patient.error();
  auto mr = simulated_mr(patient->phantom(), MrFat::kSuppressed);
  if (!mr) return mr.error();
  const Vec liver = patient->liver();
  const auto simple = mr_appearance(**mr, 0.8);
  if (!simple) return simple.error();
  const auto contextual = mr_appearance(**mr, 1);
  if (!contextual) return contextual.error();
  Scene scene = scene_of(*mr, *simple, looking(liver, {-0.9, -0.9, 0.2}, 470));
  scene.shading.full_gradient_per_mm = 60;
  scene.plane = patient->ultrasound(
      probe_at(patient->phantom(), 1.40 * M_PI, -45, liver + Vec(10, 0, 10), Vec::UnitZ()));
  scene.cutaway = render::Cutaway{};
  scene.cutaway->theta1_rad = scene.cutaway->theta2_rad = 25 * kDeg;
  scene.cutaway->overlay_mm = 0;
  scene.shading.emphasis = 0.1;
  add("fig8a", scene);
  scene.transfer = *contextual;
  scene.cutaway->theta2_rad = 50 * kDeg;
  scene.cutaway->overlay_mm = 15;
  scene.shading.emphasis = 1;
  add("fig8b", scene);
  return {};
}

/// Rejects a text that no image's name contains.
Result<void> check_only(const std::string& only) {
  std::vector<std::string> names{"fig2a", "fig2b", "fig2c", "fig3a", "fig3b", "fig5a", "fig5b",
                                 "fig5c", "fig5d", "fig6a", "fig6b", "fig7",  "fig8a", "fig8b"};
  for (const auto& part : {contextual_gallery_names(), registration_gallery_names(),
                           simulator_gallery_names(), predicate_gallery_names()}) {
    names.insert(names.end(), part.begin(), part.end());
  }
  std::string all;
  for (const std::string& name : names) {
    if (name.find(only) != std::string::npos) return {};
    all += (all.empty() ? "" : ", ") + name;
  }
  return Error{ErrorCode::kUsage,
               "--only: expected a part of one of the names " + all + ", found " + only};
}

}  // namespace

Result<void> run_gallery(const GalleryOptions& options, app::Console& console) {
  if (auto ok = check_only(options.only); !ok) return ok;
  // Reports a wrong name also if no chosen image needs the engine.
  if (auto engine = app::make_engine(options.engine, 0, console); !engine) return engine.error();
  auto folder = app::OutputFolder::create(options.out, app::OutputFolder::Replaces::kAnyFile);
  if (!folder) return folder.error();
  Gallery gallery(options, console);
  console.begin("volumes");
  for (const auto add : {&Gallery::add_angiography, &Gallery::add_cutaways, &Gallery::add_fusion,
                         &Gallery::add_plain_ct, &Gallery::add_mr}) {
    if (auto ok = (gallery.*add)(); !ok) return ok;
  }
  console.end();
  console.begin("images");
  double done = 0;
  for (const GalleryImage& image : gallery.images()) {
    // An engine of its own for each: no image can depend on the one before.
    auto engine = app::make_engine(options.engine, 0, console);
    if (!engine) return engine.error();
    const auto drawn = (*engine)->render(image.scene);
    if (!drawn) return drawn.error();
    if (auto ok = folder->write_image(image.name + ".png", render::to_8bit(drawn->pixels)); !ok) {
      return ok;
    }
    console.progress(++done / static_cast<double>(gallery.images().size()));
  }
  console.end();
  if (auto ok = draw_contextual_gallery(options, *folder, console); !ok) return ok;
  if (auto ok = draw_registration_gallery(options, *folder, console); !ok) return ok;
  if (auto ok = draw_simulator_gallery(options, *folder, console); !ok) return ok;
  if (auto ok = draw_predicate_gallery(options, *folder, console); !ok) return ok;
  if (folder->files().empty()) {
    return Error{ErrorCode::kNotFound, bench_data_dir().string() + ": expected the data of " +
                                           (options.only.empty() ? "the gallery" : options.only) +
                                           " (set SONDE_DATA_DIR), found none; nothing was drawn"};
  }
  return {};
}

}  // namespace nav::bench
