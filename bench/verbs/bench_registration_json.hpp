// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/report.hpp"
#include "bench/registration/bone_curve.hpp"
#include "bench/registration/bootstrap_curve.hpp"
#include "bench/registration/effort_curve.hpp"
#include "bench/registration/fault_curve.hpp"
#include "bench/registration/live_curve.hpp"
#include "bench/registration/motion_curve.hpp"
#include "bench/registration/peer.hpp"
#include "bench/registration/shape_cohort.hpp"
#include "bench/registration/skin_curve.hpp"
#include "bench/registration/start_curve.hpp"
#include "bench/registration/summary.hpp"

/// Parts of 'sonde bench registration --json'; the keys are in docs/json.md.
namespace nav::bench {

io::Json json_of(const CohortSummary& s);
/// The rows of json_of(CohortSummary), each with its "level".
io::Json json_of(const std::vector<LevelSummary>& levels);
io::Json json_of(const PeerComparison& comparison);
io::Json json_of(const std::vector<StartPoint>& points);
io::Json json_of(const std::vector<EffortPoint>& points);
io::Json json_of(const std::vector<SkinCurvePoint>& points);
io::Json json_of(const std::vector<MotionPoint>& points);
/// Null when nothing was measured.
io::Json json_of(const BootstrapCurve& curve);
io::Json json_of(const LiveCurve& curve);
io::Json json_of(const std::vector<BoneTrial>& trials);
io::Json json_of(const std::vector<BoneFinding>& findings);
/// seeds: "development" or "evaluation".
io::Json json_of(const std::vector<FaultPoint>& points, const std::string& seeds);
/// Adds "fault_runs" and "fault_false_accepts" of all of them; null without points.
void add_totals(const std::vector<FaultPoint>& points, io::Json& summary);

}  // namespace nav::bench
