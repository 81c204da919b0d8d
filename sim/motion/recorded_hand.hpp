// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/result.hpp"
#include "nav/time.hpp"
#include "nav/transform.hpp"

namespace nav::sim {

/// Motion of a hand that held a probe, as recorded: the image's poses relative to the one in the
/// middle of the motion (x along the face, y along the beam, z across the image, mm).
class RecordedHand {
 public:
  using Step = Transform<frames::Image, frames::Image>;
  struct Sample {
    Timestamp time;
    Step step;
  };
  struct Pose {
    Timestamp time;
    Transform<frames::Reference, frames::Image> reference_from_image;
  };
  /// Rejects (kMalformedData) fewer than 2 poses, times that do not increase, values that are not
  /// finite, and a motion of more than 500 mm. The pose that is nearest to the mean position is the
  /// middle.
  static Result<RecordedHand> create(const std::vector<Pose>& poses);

  /// At least 2; times from 0 on.
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] Duration duration() const { return samples_.back().time.time_since_epoch(); }

 private:
  explicit RecordedHand(std::vector<Sample> samples) : samples_(std::move(samples)) {}
  std::vector<Sample> samples_;
};

}  // namespace nav::sim
