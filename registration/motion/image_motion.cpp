// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/image_motion.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "nav/check.hpp"

namespace nav::registration {
namespace {

// Half of the time window: long enough that the noise of a tracker is small against the distance,
// short enough that the hand hardly changes its speed.
constexpr double kAboutS = 0.15;

Point<frames::Image> middle_of(const UltrasoundImage& frame) {
  return frame.grid.at(0.5 * (frame.pixels.width() - 1), 0.5 * (frame.pixels.height() - 1));
}

/// Sets the motion of an image from an image before and an image after it.
void set_motion(const TrackedImage& from, const TrackedImage& to,
                const Point<frames::Image>& middle, ImageMotion& motion) {
  const double seconds = to_seconds(to.frame.acquired - from.frame.acquired);
  if (!(seconds > 0)) return;
  const Eigen::AngleAxisd turn(to.reference_from_image.rotation() *
                               from.reference_from_image.rotation().conjugate());
  motion.turn_rad_s = turn.angle() / seconds * turn.axis();
  motion.velocity_mm_s =
      ((to.reference_from_image * middle) - (from.reference_from_image * middle)).v / seconds;
}

}  // namespace

std::vector<ImageMotion> image_motions(const Sweep& images, const Sweep& recorded) {
  const auto& all = recorded.frames();
  const Timestamp first = all.front().frame.acquired;
  const auto before = [](const TrackedImage& tracked, Timestamp time) {
    return tracked.frame.acquired < time;
  };
  std::vector<ImageMotion> motions;
  for (const TrackedImage& image : images.frames()) {
    const Timestamp time = image.frame.acquired;
    auto from = std::lower_bound(all.begin(), all.end(), time, before);
    NAV_CHECK(from != all.end() && from->frame.acquired == time, to_seconds(time - first));
    auto to = from;
    while (from != all.begin() && to_seconds(time - std::prev(from)->frame.acquired) <= kAboutS) {
      --from;
    }
    while (std::next(to) != all.end() &&
           to_seconds(std::next(to)->frame.acquired - time) <= kAboutS) {
      ++to;
    }
    const Point<frames::Image> middle = middle_of(image.frame);
    ImageMotion motion{.time_s = to_seconds(time - first),
                       .middle_mm = (image.reference_from_image * middle).mm,
                       .axes = image.reference_from_image.rotation().toRotationMatrix(),
                       .turn_rad_s = Eigen::Vector3d::Zero(),
                       .velocity_mm_s = Eigen::Vector3d::Zero()};
    set_motion(*from, *to, middle, motion);
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace nav::registration
