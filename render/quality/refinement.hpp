// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "nav/time.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// When a picture may be coarse.
struct ProgressiveOptions {
  double budget_s = 0.033;  ///< A whole picture that is expected to take no longer is never made
                            ///< coarse; >= 0, infinite: none ever is.
  /// quality.pixel_error of coarse pictures, in [0, 1]; 0: as the scene says.
  double coarse_pixel_error = 0.1;
  /// Where that is not enough, they have 1 / this of the pixels per side, in [2, 8].
  int coarse_factor = 2;
  /// And where that takes longer than the budget, down to 1 / this, in [coarse_factor, 8].
  int largest_factor = 8;
  double refine_after_s = 0.1;  ///< Without a change of anything but ultrasound pixels; >= 0.
};

/// A scene as it is drawn with 1 / factor of its pixels per side.
Scene with_fewer_pixels(Scene scene, int factor);

/// Decides how the pictures of changing scenes are drawn so that they keep to a budget, learning
/// from what each took: plan(), draw, drawn(). Headless pictures and windows share it; it knows no
/// engine. Times are of one clock that does not run back. Not thread-safe.
class Refinement {
 public:
  /// The first pictures of another set of predicates are expected to take so many times as long as
  /// those of the last one: OpenGL draws them from tables until the set has a program of its own,
  /// and what the set itself costs is not known on any engine.
  static constexpr double kAnotherSet = 6;
  /// What is believed of pictures that were not drawn in a movement, after it: one slow picture,
  /// for whatever reason, is not held against the next ones for ever.
  static constexpr double kFading = 0.8;

  /// How a picture is drawn.
  struct Plan {
    Scene scene;   ///< To draw; of the size that was asked for.
    int factor;    ///< With 1 / this of its pixels per side; 1: all.
    bool refined;  ///< Of the quality that was asked for, unless it comes out provisional.
  };

  /// A bad option is a Bug.
  explicit Refinement(const ProgressiveOptions& options = {});

  /// How to draw a scene now.
  [[nodiscard]] Plan plan(const Scene& scene, Timestamp now);
  /// The last plan was carried out. took_s: rays alone; factor: what pixels were given up in truth;
  /// provisional: so was the picture, which is then not of the quality that was asked for.
  void drawn(double took_s, int factor, bool provisional = false);
  /// The last picture was of the quality that was asked for.
  [[nodiscard]] bool is_refined() const { return drawn_ && drawn_->plan.refined; }
  /// The last picture was coarse, and nothing else would make the next one be drawn.
  [[nodiscard]] bool wants_refinement() const { return drawn_ && !drawn_->plan.refined; }
  /// And by now it would be drawn in full.
  [[nodiscard]] bool wants_refinement(Timestamp now) const {
    return wants_refinement() && is_still(now);
  }

 private:
  struct Asked {
    Scene scene;  ///< As it was asked for.
    Plan plan;
    std::size_t cost;  ///< Of cost_s_.
    bool anew;         ///< Nothing of the picture before can have been kept.
    bool sparse;       ///< Fewer rays than was asked for.
  };

  [[nodiscard]] bool is_still(Timestamp now) const {
    return to_seconds(now - changed_) >= options_.refine_after_s;
  }
  [[nodiscard]] int small_factor(double all_pixels_s) const;
  void give_up(Asked& asked, double whole_s, double dearer, bool changed) const;
  void learn_whole(double took_s, bool after_coarse);

  ProgressiveOptions options_;
  std::optional<Asked> planned_;
  std::optional<Asked> drawn_;
  Timestamp changed_{};
  /// What the last whole picture took, by how much it differed from the picture before.
  std::array<double, 4> cost_s_{};
  double sparse_share_ = 0;  ///< Of that, what fewer rays took; 0: not known.
  /// What the last picture with fewer pixels would have taken with all of them, by their number;
  /// 0: not known.
  double all_pixels_s_ = 0;
};

}  // namespace nav::render
