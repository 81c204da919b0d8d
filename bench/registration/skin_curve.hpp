// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "registration/search/skin_search.hpp"
#include "sim/motion/hand_path.hpp"
#include "sim/probe_model.hpp"

namespace nav::bench {

/// Setting of the search without a start pose: run time against the fraction of right results.
struct SkinCurvePoint {
  std::string axis;  ///< "tried", "spacing_mm", "turns": members of SkinSearchOptions.
  double x;
  /// Patient's own CT; right: targets off by less than kSuccessMm, RMS.
  int trials = 0, right = 0, accepted = 0;
  /// CTs of another patient, and own CTs without the region that the sweep shows.
  int hopeless = 0;
  int false_accepts = 0;       ///< In both groups: accepted, and not right within kFalseAcceptMm.
  double error_median_mm = 0;  ///< Error of the right results; NaN if there are none.
  double cpu_s = 0;  ///< Median with own CTs: everything, including the preparation of the CT.
  double hopeless_cpu_s = 0;
};

struct SkinCurveOptions {
  /// Seed of sim::make_patient(); the wrong CT is that of the next seed.
  std::uint64_t first_seed = 1;
  int patients = 3;
  sim::AcousticModel model = sim::AcousticModel::kRays;
  std::vector<sim::HandPathKind> paths{sim::HandPathKind::kSweep, sim::HandPathKind::kTilt,
                                       sim::HandPathKind::kFan, sim::HandPathKind::kRock};
  double duration_s = 4;
  double frame_rate_hz = 15;
  std::vector<double> tried{75, 150, 300, 600};
  std::vector<double> spacings_mm{15, 30};
  std::vector<double> turns{8, 18};
  bool hopeless = true;
};

/// Uses ultrasound images without their outline, like recordings. One thread. Errors: those of the
/// simulator.
Result<std::vector<SkinCurvePoint>> measure_skin(const SkinCurveOptions& options,
                                                 const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<SkinCurvePoint>& points);

}  // namespace nav::bench
