// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/appearance/appearance.hpp"
#include "app/options/cutaway_objects.hpp"
#include "app/options/session_config.hpp"
#include "app/views/panels.hpp"
#include "render/canvas.hpp"
#include "render/engine.hpp"
#include "render/quality/step_search.hpp"
#include "render/slices/slice.hpp"
#include "session/navigator.hpp"
#include "session/needle_size.hpp"

namespace nav::app {

/// Ultrasound volume that the 3D view shows by predicates. It lies in the CT's frame.
struct PredicateView {
  render::UltrasoundVolume ultrasound;
  bool alone = false;  ///< Instead of the CT, and not inside it. The slice still shows the CT.
  /// Target from which predicates measure distances; it is drawn.
  std::optional<render::SphereShape> target = std::nullopt;
};

/// Options for the display of a session.
struct PresenterOptions {
  SessionConfig::Appearance appearance{};
  SessionConfig::View view{};
  int width = 800;                                   ///< Width of the 3D view, pixels.
  int height = 600;                                  ///< Height of the 3D view, pixels.
  std::optional<double> step_voxels = std::nullopt;  ///< Absent: chosen for rms_error.
  double rms_error = render::kDefaultRms;            ///< Estimated error of the CT's image.
  double pixel_error = 0;                            ///< Least value for render::Quality.
  SessionConfig::Quality quality{};
  session::NeedleSize needle{};
  /// Objects that the cutaway exposes, in addition to the plane, the needle and the targets.
  CutawayShapes cut_free{};
  /// Predicates measure distances from the live needle and from the target, if there is one. While
  /// the needle is stale or lost, no voxel has a distance from it, and every image says so.
  std::optional<PredicateView> predicates = std::nullopt;
};

/// Facts about a session that are known by now. Its first image completes most of them; plan,
/// warning and uncertainty may change later.
struct SessionFacts {
  std::optional<NeedlePlan> plan = {};
  /// A needle is tracked; its state is then shown even while it is lost.
  bool needle_expected = false;
  /// Point that the 3D view looks at; absent: the centre of the CT.
  std::optional<Point<frames::Ct>> focus_ct = {};
  /// Typical ultrasound plane. If the user chose no view, the camera looks at this plane from the
  /// side that is nearer to the patient's front and feet, at an angle to its normal, and from near
  /// enough to show the image well.
  struct TypicalPlane {
    Transform<frames::Ct, frames::Image> ct_from_image;
    double extent_mm;  ///< Diagonal of the image.
  };
  std::optional<TypicalPlane> typical_plane = {};
  render::HuWindow window = {};  ///< Grey window of the CT slice.
  std::string banner = {};       ///< Text that every image shows ("simulated patient 1").
  bool simulated = false;        ///< Every image says SIMULATED.
  /// Warning that every image shows: one sentence about the registration or the position of the CT.
  std::string warning = {};
  /// Uncertainty of the registration, from which the intervals of the needle's numbers follow;
  /// absent: not known.
  std::optional<registration::PoseUncertainty> uncertainty = {};
};

/// Most important of the warnings with which a registration was accepted, because the display has
/// space for one: the predicted error, else the needle, else the first. Empty without warnings.
std::string most_telling(const std::vector<std::string>& warnings);

/// Text of most_telling() for the 3D view, with the number of warnings. Empty without warnings.
std::string registration_warning(const std::vector<std::string>& warnings);

/// Warns when no step reaches the wanted error.
void say_sampling(const std::optional<render::StepChoice>& step, double wanted_rms,
                  Diagnostics& diagnostics);

/// Turns epochs into images: the 3D view at the left, the live ultrasound and the CT along the same
/// plane at the right, states and numbers below. Keeps the 3D view without plane and needle, so
/// that it is cast only once. Not thread-safe.
class Presenter {
 public:
  /// Rejects an unknown preset, a bad appearance file or transfer function, angles that contradict,
  /// and objects to cut free when the appearance has no cutaway because its file turns it off.
  static Result<Presenter> create(PresenterOptions options, std::shared_ptr<const Volume> ct,
                                  std::unique_ptr<render::Engine> engine);
  /// Does the same with the options' appearance as resolve_appearance() made it for this CT.
  static Result<Presenter> create(PresenterOptions options, ResolvedAppearance appearance,
                                  std::shared_ptr<const Volume> ct,
                                  std::unique_ptr<render::Engine> engine);

  /// Replaces the facts, at the beginning and whenever one of them has changed. Facts are one
  /// value: those that stay are part of it.
  void set_facts(SessionFacts facts);
  [[nodiscard]] const SessionFacts& facts() const { return facts_; }
  /// Legend for the colours of predicates; empty without predicates.
  [[nodiscard]] const std::vector<LegendEntry>& legend() const { return legend_; }
  /// Appearance of the 3D view.
  [[nodiscard]] const ResolvedAppearance& appearance() const { return appearance_; }

  /// Draws the whole image of an epoch: 3D view, panels and status bar.
  Result<Image2d<Rgba8>> present(const session::Epoch& epoch);
  /// 3D view of the last present().
  [[nodiscard]] const Image2d<Rgba8>& view() const { return view_; }
  /// Counts a 3D view that engine() has cast elsewhere, and keeps the engine's note about it.
  void count(const render::RenderStatistics& statistics);
  /// Size of the 3D view of present(), pixels.
  [[nodiscard]] PixelSize view_size() const { return {options_.width, options_.height}; }
  /// Finds the step for the wanted error: once, again when the first ultrasound image can be cut
  /// free, and again when the CT is first registered. Also finds the grey window of a projection,
  /// once. present() calls it.
  Result<void> choose_step(const session::Epoch& epoch);
  /// Grey window of the CT slice.
  [[nodiscard]] const render::HuWindow& window() const { return facts_.window; }
  /// Grey window of a projection, after the first 3D view was cast; absent for views in colours.
  [[nodiscard]] const std::optional<render::GreyWindow>& grey() const { return grey_; }
  /// Camera of scene(); it depends on the options and the facts only.
  [[nodiscard]] render::Camera camera() const;
  /// 3D scene of an epoch; the same for every engine.
  [[nodiscard]] render::Scene scene(const session::Epoch& epoch) const;
  [[nodiscard]] render::Engine& engine() { return *engine_; }
  /// Number of 3D views that were cast, and number of times a kept view was used again.
  [[nodiscard]] int views_cast() const { return views_cast_; }
  [[nodiscard]] int views_reused() const { return views_reused_; }
  /// Step and pixel error that were chosen for rms_error, after the first 3D view was cast. Absent
  /// when the options give a step, and for views by predicates alone. For a CT with ultrasound in
  /// it the step is the one that the CT alone needs, and rms is NaN.
  [[nodiscard]] const std::optional<render::StepChoice>& step() const { return step_; }
  /// Engine's note about its last image ("down-sampled …"), after a note about a projection that
  /// shows nothing; may be empty.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// Total time of casting all 3D views, s.
  [[nodiscard]] double cast_seconds() const { return cast_seconds_; }

 private:
  Presenter(PresenterOptions options, ResolvedAppearance appearance,
            std::shared_ptr<const Volume> ct, std::unique_ptr<render::Engine> engine);
  [[nodiscard]] PanelContext context(const session::Epoch& epoch,
                                     const render::Camera& camera) const;
  [[nodiscard]] Eigen::Vector3d direction_to_eye() const;
  Result<void> choose_grey(const render::Scene& first);
  /// Name and settings of the appearance, as the 3D view shows them.
  [[nodiscard]] std::string appearance_words() const;
  /// The CT along a plane, in its grey window; black outside the CT. The pixels of the image.
  [[nodiscard]] Image2d<std::uint8_t> ct_on(const render::UltrasoundPlane& plane) const;
  /// Note in the 3D view of an epoch; may be empty.
  [[nodiscard]] std::string note_of(const session::Epoch& epoch) const;

  PresenterOptions options_;
  ResolvedAppearance appearance_;
  std::shared_ptr<const Volume> ct_;
  bool without_ct_ = false;          ///< The 3D view shows the ultrasound volume alone.
  std::vector<LegendEntry> legend_;  ///< Predicates of the ultrasound volume.
  bool asks_needle_ = false;         ///< A predicate needs the distance from the needle.
  std::unique_ptr<render::Engine> engine_;
  SessionFacts facts_;
  std::vector<LegendEntry> ct_legend_;        ///< Components of the CT's appearance.
  std::string modality_ = "CT";               ///< "MR" when values are not in HU.
  Image2d<Rgba8> view_;                       ///< The last 3D view of present().
  std::optional<Image2d<Rgba8>> empty_view_;  ///< The 3D view without plane and needle.
  std::string note_;       ///< grey_note_, then the engine's note about its last image.
  std::string grey_note_;  ///< Note about a projection that shows nothing.
  std::optional<render::GreyWindow> grey_;
  std::optional<render::StepChoice> step_;
  std::optional<render::StepChoice> step_of_ct_;  ///< Step for the CT alone, found once.
  struct SearchedFor {
    bool plane;
    bool registered;
  };
  SearchedFor searched_for_{};  ///< State of the epoch for which step_ was found.
  int views_cast_ = 0;
  int views_reused_ = 0;
  double cast_seconds_ = 0;
};

}  // namespace nav::app
