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

/// A setting of the search without a start pose: run time against how often it is right.
struct SkinCurvePoint {
  std::string axis;  ///< "tried", "spacing_mm", "turns": of SkinSearchOptions.
  double x;
  int trials, right, accepted;  ///< Own CT; right: targets off by less than kSuccessMm, RMS.
  /// CTs of another patient, and own ones without what the sweep shows.
  int hopeless;
  int false_accepts;       ///< Of both: accepted, and not right within kFalseAcceptMm.
  double error_median_mm;  ///< Of the right ones; NaN without.
  double cpu_s;            ///< Median of the own: everything, preparation of the CT included.
  double hopeless_cpu_s;
};

struct SkinCurveOptions {
  std::uint64_t first_seed = 1;  ///< Of sim::make_patient(); the next one's CT is the wrong one.
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

/// Pictures without their outline, as recordings are. One thread. Errors: those of the simulator.
Result<std::vector<SkinCurvePoint>> measure_skin(const SkinCurveOptions& options,
                                                 const std::function<void(double)>& progress = {});

std::string to_text(const std::vector<SkinCurvePoint>& points);

}  // namespace nav::bench
