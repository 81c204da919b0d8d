// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/look/look.hpp"
#include "app/options/session_config.hpp"
#include "app/views/panels.hpp"
#include "render/canvas.hpp"
#include "render/engine.hpp"
#include "render/quality/step_search.hpp"
#include "render/slices/slice.hpp"
#include "render/window/window.hpp"
#include "session/navigator.hpp"
#include "session/needle_size.hpp"

namespace nav::app {

/// How the refreshes of a session look.
struct PresenterOptions {
  SessionConfig::Look look;
  SessionConfig::View view;
  int width = 800;                                   ///< Of the 3D view, pixels.
  int height = 600;                                  ///< Of the 3D view, pixels.
  std::optional<double> step_voxels = std::nullopt;  ///< Absent: what rms_error needs.
  double rms_error = render::kDefaultRms;            ///< Of the picture of the CT, estimated.
  double pixel_error = 0;                            ///< Of render::Quality, at least.
  render::HuWindow window;                           ///< Of the CT slice.
  SessionConfig::Quality quality{};
  session::NeedleSize needle{};
};

/// Of warnings that a registration was accepted with the one that there is room for: how far off
/// the target may be, then the needle, then the first; empty without any.
std::string most_telling(const std::vector<std::string>& warnings);

/// Warns where the error that was asked for was not reached.
void say_sampling(const std::optional<render::StepChoice>& step, double wanted_rms,
                  Diagnostics& diagnostics);

/// Turns epochs into pictures: the 3D view at the left, the live ultrasound and the CT along the
/// same plane at the right, state and numbers below. Draws nothing anew that has not changed.
/// Not thread-safe.
class Presenter {
 public:
  /// Refuses an unknown preset, a bad look file or transfer function, and angles that contradict.
  static Result<Presenter> create(const PresenterOptions& options, std::shared_ptr<const Volume> ct,
                                  std::unique_ptr<render::Engine> engine);

  void set_plan(const NeedlePlan& plan) { plan_ = plan; }
  /// What the 3D view looks at; the centre of the CT unless told.
  void set_focus(const Point<frames::Ct>& focus_ct) { focus_ct_ = focus_ct; }
  /// The plane that the view is chosen for, where the user chose none: seen from the side that is
  /// nearer to the patient's front and feet, off its normal, and near enough to show its picture.
  /// extent_mm: diagonal of the picture.
  void set_typical_plane(const Transform<frames::Ct, frames::Image>& ct_from_image,
                         double extent_mm) {
    typical_plane_ = ct_from_image;
    typical_extent_mm_ = extent_mm;
  }
  /// The 3D view shows an ultrasound volume that lies in the CT's frame, by predicates: inside the
  /// CT, or alone instead of it; the slice stays the CT's. Distances are from the live needle and
  /// from the target, if any, which is drawn. While the needle is stale or lost, no voxel is at a
  /// distance from it, and every picture says so.
  void draw_by_predicates(render::UltrasoundVolume ultrasound, bool alone,
                          const std::optional<render::SphereShape>& target = {});
  /// A needle is tracked, or ought to be: its state is shown also while it is lost.
  void expect_needle() { needle_expected_ = true; }
  /// What the cutaway cuts free beside the plane, the needle and the targets. Refuses objects where
  /// the look file alone says that nothing is cut.
  Result<void> cut_free(const CutawayShapes& shapes);
  /// What the colours of predicates mean; empty without them.
  [[nodiscard]] const std::vector<LegendEntry>& legend() const { return legend_; }
  /// How the 3D view looks.
  [[nodiscard]] const ResolvedLook& look() const { return look_; }
  /// A word that stands on every picture ("SIMULATED PATIENT").
  void set_banner(std::string banner) { banner_ = std::move(banner); }

  /// What a registration was accepted with, for the user to see on every picture; may be empty.
  void set_registration_warnings(const std::vector<std::string>& warnings);
  /// What the user is to see instead: one sentence about where the CT lies.
  void set_warning(std::string warning) { warning_ = std::move(warning); }

  /// The whole picture of an epoch.
  Result<Image2d<Rgba8>> present(const session::Epoch& epoch);
  /// What a window says over the 3D scene of an epoch: window_words().
  [[nodiscard]] std::vector<render::WindowWords> words(const session::Epoch& epoch,
                                                       const render::Camera& camera,
                                                       bool ended) const;
  /// Finds the step for the error that was asked for: once, and anew when the ultrasound picture is
  /// first there to be cut free, and when the CT is first registered. Finds the grey window of a
  /// projection, once. present() does so by itself.
  Result<void> choose_step(const session::Epoch& epoch);
  /// Grey window of the CT slice; set before the first image.
  void set_window(const render::HuWindow& window) { options_.window = window; }
  [[nodiscard]] const render::HuWindow& window() const { return options_.window; }
  /// Of a projection, once a 3D view was cast; absent in colours.
  [[nodiscard]] const std::optional<render::GreyWindow>& grey() const { return grey_; }
  /// The 3D scene of an epoch, as every engine draws it.
  [[nodiscard]] render::Scene scene(const session::Epoch& epoch) const;
  [[nodiscard]] render::Engine& engine() { return *engine_; }
  /// Times that a 3D view was cast, and times that the last one was still right.
  [[nodiscard]] int views_cast() const { return views_cast_; }
  [[nodiscard]] int views_reused() const { return views_reused_; }
  /// The step and pixel error that were chosen for rms_error, once a 3D view was cast; absent where
  /// it was given, and in views by predicates alone. Of a CT with ultrasound in it the
  /// step is what the CT alone needs, and rms is NaN.
  [[nodiscard]] const std::optional<render::StepChoice>& step() const { return step_; }
  /// What the engine said of its last picture ("down-sampled …"), and a projection that shows
  /// nothing; may be empty.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// Seconds of the casting, all views.
  [[nodiscard]] double cast_seconds() const { return cast_seconds_; }

 private:
  Presenter(const PresenterOptions& options, ResolvedLook look, std::shared_ptr<const Volume> ct,
            std::unique_ptr<render::Engine> engine);
  [[nodiscard]] render::Camera camera() const;
  [[nodiscard]] PanelContext context(const session::Epoch& epoch,
                                     const render::Camera& camera) const;
  [[nodiscard]] Eigen::Vector3d direction_to_eye() const;
  Result<void> choose_grey(const render::Scene& first);
  /// What is said in the 3D view of an epoch; empty: nothing.
  [[nodiscard]] std::string note_of(const session::Epoch& epoch) const;

  PresenterOptions options_;
  ResolvedLook look_;
  std::shared_ptr<const Volume> ct_;
  std::optional<render::UltrasoundVolume> ultrasound_;
  bool without_ct_ = false;                    ///< The 3D view shows the ultrasound volume alone.
  std::vector<LegendEntry> legend_;            ///< Of its predicates.
  bool asks_needle_ = false;                   ///< Some predicate is a distance from the needle.
  std::optional<render::SphereShape> target_;  ///< Of predicates.
  std::unique_ptr<render::Engine> engine_;
  std::optional<NeedlePlan> plan_;
  bool needle_expected_ = false;
  Point<frames::Ct> focus_ct_;
  std::optional<Transform<frames::Ct, frames::Image>> typical_plane_;
  double typical_extent_mm_ = 0;
  std::string banner_;
  std::string warning_;                       ///< Of the registration or placement.
  std::optional<Image2d<Rgba8>> empty_view_;  ///< The 3D view without plane and needle.
  std::string note_;       ///< Of the engine about its last picture, after grey_note_.
  std::string grey_note_;  ///< Of a projection that shows nothing.
  std::optional<render::GreyWindow> grey_;
  std::optional<render::StepChoice> step_;
  std::optional<render::StepChoice> step_of_ct_;  ///< Of the CT alone, which does not change.
  struct SearchedFor {
    bool plane;
    bool registered;
  };
  SearchedFor searched_for_{};  ///< What step_ is for.
  int views_cast_ = 0;
  int views_reused_ = 0;
  double cast_seconds_ = 0;
};

}  // namespace nav::app
