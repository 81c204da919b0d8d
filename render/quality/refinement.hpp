// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "nav/time.hpp"
#include "render/scene.hpp"
#include "render/scene_compare.hpp"

namespace nav::render {

/// Options that say when an image may be coarse.
struct ProgressiveOptions {
  double budget_s = 0.033;  ///< A whole image with at most this expected time is never
                            ///< coarse; >= 0; infinite: no image is.
  /// quality.pixel_error of coarse images, [0, 1]; 0: as in the scene.
  double coarse_pixel_error = 0.1;
  /// If that is not enough, a coarse image has 1 / coarse_factor of the pixels per side, [2, 8].
  int coarse_factor = 2;
  /// If that takes longer than the budget, it has down to 1 / largest_factor, [coarse_factor, 8].
  int largest_factor = 8;
  double refine_after_s = 0.1;  ///< Time without changes other than ultrasound pixels; >= 0.
  /// Time after which coarse images of a resting view, in which only plane, needle and other
  /// objects move, get as many pixels as the budget allows for the rays that these affect; >= 0.
  double finer_after_s = 0.25;
  /// Greatest expected time of the first image with more pixels, which casts all its rays; >= 0.
  double finer_step_s = 0.2;
};

/// The scene with 1 / factor of its pixels per side.
Scene with_fewer_pixels(Scene scene, int factor);

/// Decides how images of changing scenes are drawn within a time budget, and learns from the time
/// that each took: plan(), draw, drawn(). Shared by headless images and windows; it knows no
/// engine. All times are of one clock that does not run backwards. Not thread-safe.
class Refinement {
 public:
  /// The first images of another predicate set are expected to take this many times as long as
  /// those of the last one. OpenGL draws them from tables until the set has a program of its own,
  /// and no engine knows the cost of the set itself in advance.
  static constexpr double kAnotherSet = 6;
  /// After a movement, the expected times of images that were not drawn during it are multiplied by
  /// this, so that one slow image does not count against the next ones for ever.
  static constexpr double kFading = 0.8;

  /// A plan for how to draw an image.
  struct Plan {
    Scene scene;   ///< The scene to draw, in the requested size.
    int factor;    ///< Draw 1 / factor of the pixels per side; 1: all.
    bool refined;  ///< true: the requested quality, unless provisional.
    /// The least change to a newer scene that makes it worth giving this image up; absent: none,
    /// because a coarse image is soon there and shows that something moves. The first coarse image
    /// of its kind, of which nothing is known, may be given up.
    std::optional<SceneChange> yields_to;
  };

  /// An invalid option is a Bug.
  explicit Refinement(const ProgressiveOptions& options = {});

  /// Plans how to draw a scene now.
  [[nodiscard]] Plan plan(const Scene& scene, Timestamp now);
  /// Reports that the last plan was carried out. took_s: time of the rays alone. factor: the factor
  /// that was really used. provisional: the image was provisional, so it does not have the
  /// requested quality.
  void drawn(double took_s, int factor, bool provisional = false);
  /// Reports that the last plan was given up for a newer scene after a time. The next image is
  /// coarse if it shows another scene, so that images are shown however often the scene changes.
  void interrupted(double after_s);
  /// Changes options.budget_s, >= 0.
  void set_budget(double budget_s);
  [[nodiscard]] double budget_s() const { return options_.budget_s; }
  /// True if the last image had the requested quality.
  [[nodiscard]] bool is_refined() const { return drawn_ && drawn_->plan.refined; }
  /// True if the last image was coarse and no other event makes the next one be drawn.
  [[nodiscard]] bool wants_refinement() const { return drawn_ && !drawn_->plan.refined; }
  /// True if, in addition, it would now be drawn in full.
  [[nodiscard]] bool wants_refinement(Timestamp now) const {
    return wants_refinement() && is_still(now);
  }

 private:
  struct Asked {
    Scene scene;  ///< The requested scene.
    Plan plan;
    std::size_t cost;   ///< Index into cost_s_.
    SceneChange since;  ///< From the last image as it was drawn: kView if no part can be kept.
    bool sparse;        ///< true: fewer rays than requested.
  };

  [[nodiscard]] bool is_still(Timestamp now) const {
    return to_seconds(now - changed_) >= options_.refine_after_s;
  }
  [[nodiscard]] int small_factor(double all_pixels_s) const;
  [[nodiscard]] int factor_at_rest(int for_view, Timestamp now) const;
  void give_up(Asked& asked, double whole_s, double dearer, SceneChange change,
               Timestamp now) const;
  void learn_whole(double took_s, bool after_coarse);
  void learn_kept(double all_pixels_s);

  ProgressiveOptions options_;
  std::optional<Asked> planned_;
  std::optional<Asked> drawn_;
  bool interrupted_ = false;  ///< The last image was given up.
  Timestamp changed_{};
  Timestamp view_changed_{};
  /// Time of the last whole image, by its SceneChange from the image before.
  std::array<double, 4> cost_s_{};
  double sparse_share_ = 0;  ///< Share of that time that fewer rays took; 0: unknown.
  /// Time that the last image with fewer pixels would have taken with all of them, by their number;
  /// 0: unknown.
  double all_pixels_s_ = 0;
  double kept_pixels_s_ =
      0;  ///< all_pixels_s_ if it could keep the rays that nothing moving affects.
};

}  // namespace nav::render
