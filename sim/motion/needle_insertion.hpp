// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "nav/plan.hpp"
#include "nav/time.hpp"
#include "sim/motion/needle_bending.hpp"

namespace nav::sim {

/// Tracked body on a needle's hub: axes of frames::Needle, origin where shaft and hub meet.
struct NeedleHub {
  static constexpr std::string_view kName = "NeedleHub";
};

struct NeedleInsertionOptions {
  NeedleBending bending;
  /// Sideways deflection of the tip at the target, mm, >= 0: determines the bevel's curvature or
  /// the tip's load. Absent: those of bending.
  std::optional<double> aside_at_target_mm;
  double speed_mm_s = 0;   ///< Mean speed along the path, > 0; 0: the target is reached at the end.
  double length_mm = 150;  ///< Length from hub to tip; at least the path, at most 1000.
  double outside_mm = 0;   ///< Distance of the tip from the skin before the start, [0, 500].
};

/// Rejects invalid options; the message names the first one out of range.
Result<void> validate(const NeedleInsertionOptions& options);

/// True position of a needle at a time, CT coordinates of the patient at rest on the reference.
struct NeedleTruth {
  double inserted_mm;                                    ///< Length along the path, from the skin.
  Transform<frames::Ct, frames::Needle> ct_from_needle;  ///< Straight needle of the hub.
  Point<frames::Ct> tip_ct;                              ///< True tip.
  Point<frames::Ct> straight_tip_ct;                     ///< Tip that the hub indicates.
  double tip_error_mm;                                   ///< Distance between the two tips.
};

/// Needle that is inserted through the skin straight to a target: at constant speed from the skin,
/// or, from outside, with a gentle start and stop. Its shaft bends in the tissue; its hub stays on
/// the planned line. It rests at its start before, and at the target after the arrival. Immutable,
/// thread-safe.
class NeedleInsertion {
 public:
  /// \p begin: start of the insertion. \p end: arrival when no speed is given. Errors: kUsage by
  /// name, also for a needle shorter than the path, and a tip deflection beyond the bending model.
  static Result<NeedleInsertion> create(const NeedlePlan& plan,
                                        const NeedleInsertionOptions& options, Timestamp begin,
                                        Timestamp end);

  [[nodiscard]] const NeedlePlan& plan() const { return plan_; }
  /// The given options, with the bending that gives aside_at_target_mm.
  [[nodiscard]] const NeedleInsertionOptions& options() const { return options_; }
  [[nodiscard]] double path_mm() const { return path_mm_; }
  [[nodiscard]] double speed_mm_s() const { return speed_mm_s_; }
  [[nodiscard]] double inserted_mm(Timestamp time) const;
  [[nodiscard]] Transform<frames::Ct, frames::Needle> ct_from_needle(Timestamp time) const;
  [[nodiscard]] Transform<frames::Ct, NeedleHub> ct_from_hub(Timestamp time) const;
  /// Calibration: tip of the straight needle relative to the tracked body.
  [[nodiscard]] Transform<NeedleHub, frames::Needle> hub_from_needle() const;
  [[nodiscard]] NeedleTruth truth(Timestamp time) const;
  /// Points of the bent shaft, tip first, then of the straight part outside, to the hub.
  [[nodiscard]] std::vector<Point<frames::Ct>> shaft_ct(Timestamp time) const;

 private:
  NeedleInsertion(const NeedlePlan& plan, const NeedleInsertionOptions& options, Timestamp begin,
                  double speed_mm_s);
  /// Position of the tip along the path, from the skin; negative outside the patient.
  [[nodiscard]] double along_mm(Timestamp time) const;
  NeedlePlan plan_;
  NeedleInsertionOptions options_;
  Timestamp begin_;
  double path_mm_;
  double speed_mm_s_;
};

}  // namespace nav::sim
