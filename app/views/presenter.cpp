// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/presenter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "app/views/orthographic.hpp"
#include "app/views/panels.hpp"
#include "nav/hounsfield.hpp"
#include "render/default_window.hpp"
#include "render/predicates/registry.hpp"
#include "render/projection_window.hpp"

namespace nav::app {

namespace {

bool shows_plane(const session::Epoch& epoch) {
  return epoch.ct_from_image && epoch.frame && epoch.plane.state != SafetyState::kLost;
}

bool same_plan(const NeedlePlan& a, const NeedlePlan& b) {
  return a.entry_ct.mm == b.entry_ct.mm && a.target_ct.mm == b.target_ct.mm &&
         a.target_radius_mm == b.target_radius_mm && a.margin_mm == b.margin_mm;
}

/// True where the 3D view without plane and needle is the same.
bool same_view(const SessionFacts& a, const SessionFacts& b) {
  const auto& one = a.typical_plane;
  const auto& two = b.typical_plane;
  const bool same_plane = one.has_value() == two.has_value() &&
                          (!one || (one->extent_mm == two->extent_mm &&
                                    one->ct_from_image.matrix() == two->ct_from_image.matrix()));
  const bool same_focus = a.focus_ct.has_value() == b.focus_ct.has_value() &&
                          (!a.focus_ct || a.focus_ct->mm == b.focus_ct->mm);
  const bool same_path =
      a.plan.has_value() == b.plan.has_value() && (!a.plan || same_plan(*a.plan, *b.plan));
  return same_plane && same_focus && same_path;
}

}  // namespace

Result<Presenter> Presenter::create(PresenterOptions options, std::shared_ptr<const Volume> ct,
                                    std::unique_ptr<render::Engine> engine) {
  auto appearance = resolve_appearance(options.appearance, *ct);
  if (!appearance) return appearance.error();
  return create(std::move(options), std::move(*appearance), std::move(ct), std::move(engine));
}

Result<Presenter> Presenter::create(PresenterOptions options, ResolvedAppearance appearance,
                                    std::shared_ptr<const Volume> ct,
                                    std::unique_ptr<render::Engine> engine) {
  const CutawayShapes& shapes = options.cut_free;
  const bool any = !shapes.polygons.empty() || !shapes.boxes.empty() || !shapes.meshes.empty();
  if (!appearance.cutaway && any && !options.appearance.cutaway.enabled) {
    return Error{ErrorCode::kUsage,
                 "cutaway_objects: requires look.cutaway.enabled = true, because the appearance "
                 "file does not cut"};
  }
  if (appearance.cutaway) {
    appearance.cutaway->polygons = shapes.polygons;
    appearance.cutaway->boxes = shapes.boxes;
    appearance.cutaway->meshes = shapes.meshes;
  }
  return Presenter(std::move(options), std::move(appearance), std::move(ct), std::move(engine));
}

Presenter::Presenter(PresenterOptions options, ResolvedAppearance appearance,
                     std::shared_ptr<const Volume> ct, std::unique_ptr<render::Engine> engine)
    : options_(std::move(options)),
      appearance_(std::move(appearance)),
      ct_(std::move(ct)),
      engine_(std::move(engine)) {
  if (!is_hounsfield(*ct_)) modality_ = "MR";
  if (appearance_.projection == render::Projection::kComposite) {
    ct_legend_ = legend_of(appearance_.transfer);
  }
  if (!options_.predicates) return;
  const render::UltrasoundVolume& ultrasound = options_.predicates->ultrasound;
  without_ct_ = options_.predicates->alone;
  legend_ = legend_of(ultrasound.predicates.model);
  for (const std::string& name : kinds_of(ultrasound.predicates.model)) {
    const auto kind = render::find_predicate_kind(name);
    const render::PredicatePosition place{ultrasound.volume->grid(), {}, {}, {}};
    asks_needle_ |= kind && (*kind)->needs(place).needle;
  }
}

void Presenter::set_facts(SessionFacts facts) {
  if (!same_view(facts_, facts)) empty_view_.reset();
  facts_ = std::move(facts);
}

std::string Presenter::appearance_words() const {
  if (without_ct_) return {};
  if (appearance_.projection != render::Projection::kComposite) {
    return options_.appearance.projection + " projection";
  }
  std::ostringstream text;
  text.precision(3);
  text << appearance_.transfer.name();
  if (appearance_.shading.enabled) {
    text << "  E " << appearance_.shading.emphasis;
  } else {
    text << "  no shading";
  }
  if (!appearance_.cutaway) {
    text << "  no cutaway";
    return text.str();
  }
  constexpr double kDegrees = 180 / M_PI;
  text << "  theta1 " << appearance_.cutaway->theta1_rad * kDegrees << " deg  theta2 "
       << appearance_.cutaway->theta2_rad * kDegrees << " deg  d ";
  if (std::isfinite(appearance_.cutaway->overlay_mm)) {
    text << appearance_.cutaway->overlay_mm << " mm";
  } else {
    text << "inf";
  }
  return text.str();
}

Eigen::Vector3d Presenter::direction_to_eye() const {
  // LPS: anterior is -y, the patient's left +x, superior +z.
  const auto& view = options_.view;
  if (facts_.typical_plane && !view.azimuth_deg && !view.elevation_deg) {
    constexpr double kOffNormalRad = 0.6;
    const auto& ct_from_image = facts_.typical_plane->ct_from_image;
    const Eigen::Vector3d front_and_feet(0, -0.8, -0.6);
    Eigen::Vector3d normal = (ct_from_image * Direction<frames::Image>{{0, 0, 1}}).v;
    if (normal.dot(front_and_feet) < 0) normal = -normal;
    const Eigen::Vector3d deep = (ct_from_image * Direction<frames::Image>{{0, 1, 0}}).v;
    return std::cos(kOffNormalRad) * normal - std::sin(kOffNormalRad) * deep;
  }
  const double azimuth = view.azimuth_deg.value_or(-35) * M_PI / 180;
  const double elevation = view.elevation_deg.value_or(20) * M_PI / 180;
  return {std::cos(elevation) * std::sin(azimuth), -std::cos(elevation) * std::cos(azimuth),
          std::sin(elevation)};
}

render::Camera Presenter::camera() const {
  const double fov = options_.view.fov_deg * M_PI / 180;
  double distance_mm = options_.view.distance_mm;
  if (distance_mm <= 0) {
    // The sphere around the CT fits the smaller side of the image.
    const double aspect = std::min(1.0, 1.0 * options_.width / options_.height);
    const double half = std::atan(std::tan(fov / 2) * aspect);
    distance_mm = 0.5 * ct_->grid().extent_mm().norm() / std::sin(half) * 0.8;
    // A small ultrasound image in a large CT would hardly be visible: go nearer, but keep its
    // surroundings.
    constexpr double kSurroundings = 3.2;
    if (facts_.typical_plane) {
      constexpr double kLeastMm = 20;
      const double extent_mm = std::max(facts_.typical_plane->extent_mm, kLeastMm);
      distance_mm = std::min(distance_mm, kSurroundings * extent_mm / (2 * std::tan(half)));
    }
  }
  const Eigen::Vector3d towards_eye = direction_to_eye();
  render::Camera camera;
  camera.look_at_ct = facts_.focus_ct.value_or(ct_->grid().centre());
  camera.eye_ct = {camera.look_at_ct.mm + distance_mm * towards_eye};
  // Superior is up; anterior is up when the camera looks along the body.
  constexpr double kAlongBody = 0.8;
  const bool along_body = std::abs(towards_eye.z()) > kAlongBody;
  camera.up_ct = {along_body ? Eigen::Vector3d(-Eigen::Vector3d::UnitY())
                             : Eigen::Vector3d(Eigen::Vector3d::UnitZ())};
  camera.vertical_fov_rad = fov;
  return options_.view.orthographic ? orthographic_of(camera, ct_->grid()) : camera;
}

std::string Presenter::note_of(const session::Epoch& epoch) const {
  if (!asks_needle_ || (epoch.ct_from_needle && epoch.needle.state <= SafetyState::kDegraded)) {
    return note_;
  }
  const std::string cause = epoch.needle.cause.empty() ? epoch.placement.cause : epoch.needle.cause;
  return "distance from the needle withdrawn: " + cause + (note_.empty() ? "" : "; " + note_);
}

Image2d<std::uint8_t> Presenter::ct_on(const render::UltrasoundPlane& plane) const {
  const auto& pixels = plane.frame.pixels;
  const auto& grid = plane.frame.grid;
  std::vector<std::uint8_t> grey;
  grey.reserve(pixels.pixels().size());
  const double width = facts_.window.width;
  const double black = facts_.window.level - 0.5 * width;
  for (int row = 0; row < pixels.height(); ++row) {
    for (int column = 0; column < pixels.width(); ++column) {
      const auto hu = ct_->sample(plane.ct_from_image * grid.at(column, row));
      const double share = hu ? std::clamp((*hu - black) / width, 0.0, 1.0) : 0.0;
      grey.push_back(static_cast<std::uint8_t>(std::lround(255 * share)));
    }
  }
  return {pixels.width(), pixels.height(), std::move(grey)};
}

render::Scene Presenter::scene(const session::Epoch& epoch) const {
  render::Scene scene{.ct = ct_,
                      .transfer = appearance_.transfer,
                      .shading = appearance_.shading,
                      .plane = {},
                      .needle = {},
                      .spheres = {},
                      .camera = camera(),
                      .quality = {},
                      .width = options_.width,
                      .height = options_.height};
  if (appearance_.drawn) {
    scene.ct = appearance_.drawn->ct;
    scene.transfer = appearance_.drawn->transfer;
    scene.gradient_source = appearance_.drawn->gradient_source;
  }
  scene.cutaway = appearance_.cutaway;
  scene.projection = appearance_.projection;
  scene.grey = grey_.value_or(render::GreyWindow{});
  if (options_.step_voxels) scene.quality.step_voxels = *options_.step_voxels;
  if (step_) scene.quality.step_voxels = step_->step_voxels;
  scene.quality.pixel_error = std::max(options_.pixel_error, step_ ? step_->pixel_error : 0);
  scene.quality.classification = options_.quality.classification == "post-classified"
                                     ? render::Classification::kPostClassified
                                     : render::Classification::kPreIntegrated;
  scene.quality.jitter = options_.quality.jitter;
  const auto& predicates = options_.predicates;
  if (predicates && predicates->alone) {
    scene.ct = predicates->ultrasound.volume;
    scene.gradient_source.reset();
    scene.predicates = predicates->ultrasound.predicates;
  } else if (predicates) {
    scene.ultrasound = predicates->ultrasound;
  }
  if (shows_plane(epoch)) {
    scene.plane = render::UltrasoundPlane{epoch.frame->frame, *epoch.ct_from_image,
                                          options_.appearance.plane_opacity, epoch.plane};
    scene.plane->frame.colours = {};  // The plane is grey.
    if (options_.appearance.plane_texture == "ct") scene.plane->frame.pixels = ct_on(*scene.plane);
  }
  if (epoch.ct_from_needle && epoch.needle.state != SafetyState::kLost) {
    const auto& needle = *epoch.ct_from_needle;
    scene.needle = render::NeedleShape{
        .tip_ct = needle * Point<frames::Needle>{{0, 0, 0}},
        .hub_ct = needle * Point<frames::Needle>{{0, 0, -options_.needle.length_mm}},
        .radius_mm = options_.needle.diameter_mm / 2,
        .rgb = {0.95, 0.95, 1.0},
        .safety = epoch.needle};
  }
  if (asks_needle_ && !scene.needle) {
    (without_ct_ ? *scene.predicates : scene.ultrasound->predicates).needle_lost = true;
  }
  // Predicates take the first sphere as the target.
  if (predicates && predicates->target) scene.spheres.push_back(*predicates->target);
  // The plan lies in the CT, so it does not depend on the tracker.
  if (const auto& plan = facts_.plan) {
    scene.spheres.push_back({plan->target_ct, plan->target_radius_mm, {1.0, 0.85, 0.1}, 0.45});
    scene.spheres.push_back({plan->entry_ct, 2.5, {0.2, 0.7, 1.0}, 1.0});
    scene.lines.push_back({.from_ct = plan->entry_ct,
                           .to_ct = plan->target_ct,
                           .radius_mm = 0.5,
                           .rgb = {0.2, 0.7, 1.0},
                           .opacity = 1.0});
    if (plan->margin_mm > 0) {
      // Faint, so that its contents and the plane behind it stay visible.
      constexpr double kMarginOpacity = 0.25;
      scene.spheres.push_back({plan->target_ct,
                               plan->target_radius_mm + plan->margin_mm,
                               {1.0, 0.45, 0.2},
                               kMarginOpacity});
    }
  }
  return scene;
}

std::string most_telling(const std::vector<std::string>& warnings) {
  for (const char* first : {"predicted error", "needle"}) {
    const auto found = std::find_if(warnings.begin(), warnings.end(), [&](const auto& warning) {
      return warning.starts_with(first);
    });
    if (found != warnings.end()) return *found;
  }
  return warnings.empty() ? "" : warnings.front();
}

void say_sampling(const std::optional<render::StepChoice>& step, double wanted_rms,
                  Diagnostics& diagnostics) {
  if (!step || step->reached || std::isnan(step->rms)) return;
  std::ostringstream text;
  text << "--rms-error (output.rms_error): expected an error of " << wanted_rms << ", found about "
       << step->rms << ": no step down to 1/16 voxel surely reaches it; --step allows finer steps";
  diagnostics.report(Severity::kWarning, "sampling", text.str());
}

std::string registration_warning(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return {};
  const std::string head = warnings.size() > 1 ? "warning 1 of " + std::to_string(warnings.size())
                                               : std::string("registration warning");
  return head + ": " + most_telling(warnings);
}

Result<void> Presenter::choose_grey(const render::Scene& first) {
  const auto& said = options_.appearance;
  if (said.grey_level_hu && said.grey_width_hu) {
    grey_ = render::GreyWindow{*said.grey_level_hu, *said.grey_width_hu};
    return {};
  }
  const auto found = render::window_of_projection(first);
  if (!found) return found.error();
  grey_ = render::GreyWindow{said.grey_level_hu.value_or(found->window.level_hu),
                             said.grey_width_hu.value_or(found->window.width_hu)};
  const std::string projection = "projection " + said.projection + ": ";
  if (found->only_air) {
    grey_note_ = projection + "every ray finds only air; crop the CT to the body";
  } else if (found->one_value) {
    grey_note_ = projection + "every ray finds one value: there is nothing to see";
  }
  note_ = grey_note_;
  return {};
}

Result<void> Presenter::choose_step(const session::Epoch& epoch) {
  if (appearance_.projection != render::Projection::kComposite && !grey_) {
    if (auto ok = choose_grey(scene(epoch)); !ok) return ok;
  }
  if (options_.step_voxels) return {};
  const SearchedFor now{shows_plane(epoch), epoch.placement.state == SafetyState::kValid};
  if (step_ && now.plane <= searched_for_.plane && now.registered <= searched_for_.registered) {
    return {};
  }
  const render::Scene first = scene(epoch);
  if (first.predicates) return {};  // The search draws a CT, not predicates.
  if (!step_of_ct_) {
    const auto found =
        render::step_for_error(*engine_, render::ct_alone(first), options_.rms_error);
    if (!found) return found.error();
    step_of_ct_ = *found;
  }
  const auto choice = render::step_for_error(*engine_, first, options_.rms_error, *step_of_ct_);
  if (!choice) return choice.error();
  step_ = *choice;
  empty_view_.reset();
  searched_for_ = now;
  // The step suits the CT; the additional error from the ultrasound volume was not measured.
  if (first.ultrasound) step_->pixel_error = 0;
  if (first.ultrasound || options_.pixel_error > step_->pixel_error) {
    step_->rms = std::numeric_limits<double>::quiet_NaN();
  }
  step_->pixel_error = std::max(step_->pixel_error, first.ultrasound ? 0 : options_.pixel_error);
  return {};
}

Result<Image2d<Rgba8>> Presenter::present(const session::Epoch& epoch) {
  if (auto ok = choose_step(epoch); !ok) return ok.error();
  const render::Scene wanted = scene(epoch);
  const bool empty = !wanted.plane && !wanted.needle;
  if (empty && empty_view_) {
    view_ = *empty_view_;
    ++views_reused_;
  } else {
    const auto rendered = engine_->render(wanted);
    if (!rendered) return rendered.error();
    view_ = render::to_8bit(rendered->pixels);
    count(rendered->statistics);
    if (empty) empty_view_ = view_;
  }
  return compose_panels(view_, context(epoch, wanted.camera));
}

void Presenter::count(const render::RenderStatistics& statistics) {
  ++views_cast_;
  cast_seconds_ += statistics.cast_s;
  const std::string& note = statistics.note;
  note_ = grey_note_ + (grey_note_.empty() || note.empty() ? "" : "; ") + note;
}

PanelContext Presenter::context(const session::Epoch& epoch, const render::Camera& camera) const {
  std::vector<LegendEntry> legend = legend_;
  if (!without_ct_) legend.insert(legend.end(), ct_legend_.begin(), ct_legend_.end());
  session::GuidanceError error;
  if (epoch.guidance && epoch.ct_from_needle && facts_.plan) {
    error = session::guidance_error(
        *facts_.plan, *epoch.ct_from_needle,
        {.registration = facts_.uncertainty, .tracker_rms_mm = epoch.tracker_error_mm});
  }
  return {.epoch = epoch,
          .ct = *ct_,
          .plan = facts_.plan,
          .window = facts_.window,
          .banner = facts_.banner,
          .camera = camera,
          .note = note_of(epoch),
          .warning = facts_.warning,
          .needle_expected = facts_.needle_expected,
          .needle_length_mm = options_.needle.length_mm,
          .legend = std::move(legend),
          .modality = modality_,
          .appearance = appearance_words(),
          .simulated = facts_.simulated,
          .guidance_error = std::move(error),
          .grey = grey_};
}

}  // namespace nav::app
