// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_registration_json.hpp"

namespace nav::bench {

io::Json json_of(const CohortSummary& s) {
  io::Json distances = io::Json::array();
  for (const auto& row : s.distances) {
    distances.push_back({{"global", row.global},
                         {"start_mm", row.start_mm},
                         {"trials", row.trials},
                         {"right", row.right},
                         {"accepted", row.accepted},
                         {"false_accepts", row.false_accepts},
                         {"error_median_mm", app::json_number(row.error_median_mm)}});
  }
  io::Json hopeless = io::Json::array();
  for (const auto& row : s.hopeless) {
    hopeless.push_back({{"kind", to_string(row.kind)},
                        {"trials", row.trials},
                        {"refused", row.refused},
                        {"false_accepts", row.false_accepts}});
  }
  return {{"trials", s.trials},
          {"tre_median_mm", app::json_number(s.tre_median_mm)},
          {"tre_p95_mm", app::json_number(s.tre_p95_mm)},
          {"success_from_40mm", app::json_number(s.success_from_40mm)},
          {"success_from_40mm_95", {s.success_from_40mm_95.low, s.success_from_40mm_95.high}},
          {"success_local_10mm", app::json_number(s.success_local_10mm)},
          {"success_local_10mm_95", {s.success_local_10mm_95.low, s.success_local_10mm_95.high}},
          {"false_accepts", s.false_accepts},
          {"false_accept_bound", s.false_accept_bound},
          {"false_refusals", s.false_refusals},
          {"right", s.right},
          {"accepted", s.accepted},
          {"warned", s.warned},
          {"clear_median_mm", app::json_number(s.clear_median_mm)},
          {"clear_p95_mm", app::json_number(s.clear_p95_mm)},
          {"warned_median_mm", app::json_number(s.warned_median_mm)},
          {"warned_p95_mm", app::json_number(s.warned_p95_mm)},
          {"hopeless_refused", app::json_number(s.hopeless_refused)},
          {"coverage_95", app::json_number(s.coverage_95)},
          {"coverage_95_se", app::json_number(s.coverage_95_se)},
          {"coverage_95_clusters", app::json_number(s.coverage_95_clusters)},
          {"coverage_95_bootstrap", app::json_number(s.coverage_95_bootstrap)},
          {"predicted_over_actual", app::json_number(s.predicted_over_actual)},
          {"local_cpu_s", app::json_number(s.local_cpu_s)},
          {"global_cpu_s", app::json_number(s.global_cpu_s)},
          {"local_solve_cpu_s", app::json_number(s.local_solve_cpu_s)},
          {"global_solve_cpu_s", app::json_number(s.global_solve_cpu_s)},
          {"ct_cpu_s", app::json_number(s.ct_cpu_s)},
          {"distances", distances},
          {"hopeless", hopeless}};
}

io::Json json_of(const PeerComparison& comparison) {
  io::Json rows = io::Json::array();
  for (const auto& row : comparison.rows) {
    rows.push_back({{"name", row.name},
                    {"start_mm", row.start_mm},
                    {"trials", row.trials},
                    {"right", row.right},
                    {"error_median_mm", app::json_number(row.error_median_mm)},
                    {"cpu_s", app::json_number(row.cpu_s)},
                    {"solve_cpu_s", app::json_number(row.solve_cpu_s)},
                    {"end_to_end_cpu_s", app::json_number(row.end_to_end_cpu_s)}});
  }
  return rows;
}

io::Json json_of(const std::vector<LevelSummary>& levels) {
  io::Json rows = io::Json::array();
  for (const LevelSummary& one : levels) {
    io::Json row = json_of(one.summary);
    row["level"] = to_string(one.level);
    rows.push_back(std::move(row));
  }
  return rows;
}

io::Json json_of(const std::vector<StartPoint>& points) {
  io::Json rows = io::Json::array();
  for (const auto& p : points) {
    rows.push_back({{"path", p.path},
                    {"own_ct", p.own_ct},
                    {"sweeps", p.sweeps},
                    {"registrations", p.registrations},
                    {"same", p.same},
                    {"accepted", p.accepted},
                    {"elsewhere", p.elsewhere},
                    {"split", p.split},
                    {"apart_mm", app::json_number(p.apart_mm)},
                    {"apart_max_mm", app::json_number(p.apart_max_mm)},
                    {"predicted_ratio", app::json_number(p.predicted_ratio)},
                    {"predicted_ratio_max", app::json_number(p.predicted_ratio_max)},
                    {"hidden_least_mm", app::json_number(p.hidden_least_mm)},
                    {"hidden_most_mm", app::json_number(p.hidden_most_mm)}});
  }
  return rows;
}

io::Json json_of(const std::vector<EffortPoint>& points) {
  io::Json rows = io::Json::array();
  for (const auto& p : points) {
    rows.push_back({{"axis", p.axis},
                    {"x", p.x},
                    {"trials", p.trials},
                    {"right", p.right},
                    {"error_median_mm", app::json_number(p.error_median_mm)},
                    {"error_p95_mm", app::json_number(p.error_p95_mm)},
                    {"solve_cpu_s", app::json_number(p.solve_cpu_s)},
                    {"cpu_s", app::json_number(p.cpu_s)}});
  }
  return rows;
}

io::Json json_of(const std::vector<SkinCurvePoint>& points) {
  io::Json rows = io::Json::array();
  for (const auto& p : points) {
    rows.push_back({{"axis", p.axis},
                    {"x", p.x},
                    {"trials", p.trials},
                    {"right", p.right},
                    {"accepted", p.accepted},
                    {"hopeless", p.hopeless},
                    {"false_accepts", p.false_accepts},
                    {"error_median_mm", app::json_number(p.error_median_mm)},
                    {"cpu_s", app::json_number(p.cpu_s)},
                    {"hopeless_cpu_s", app::json_number(p.hopeless_cpu_s)}});
  }
  return rows;
}

io::Json json_of(const std::vector<MotionPoint>& points) {
  io::Json rows = io::Json::array();
  for (const auto& p : points) {
    rows.push_back({{"breathing", sim::to_string(p.kind)},
                    {"pictures", p.images},
                    {"harmonics", p.harmonics},
                    {"trials", p.trials},
                    {"supported", p.supported},
                    {"common_mm", app::json_number(p.common_mm)},
                    {"error_median_mm", app::json_number(p.error_median_mm)},
                    {"error_worst_mm", app::json_number(p.error_worst_mm)},
                    {"motion_cpu_s", app::json_number(p.motion_cpu_s)},
                    {"motion_wall_s", app::json_number(p.motion_wall_s)}});
  }
  return rows;
}

io::Json json_of(const BootstrapCurve& curve) {
  if (curve.points.empty()) return nullptr;
  io::Json json;
  json["replicates"] = io::Json::array();
  for (const auto& p : curve.points) {
    json["replicates"].push_back(
        {{"replicates", p.replicates}, {"cpu_us", p.cpu_us}, {"off", app::json_number(p.off)}});
  }
  json["solved"] = io::Json::array();
  for (const auto& r : curve.references) {
    json["solved"].push_back({{"patient", r.patient},
                              {"path", to_string(r.path)},
                              {"pictures", r.images},
                              {"block_pictures", r.block},
                              {"error_mm", app::json_number(r.error_mm)},
                              {"clusters_mm", app::json_number(r.clusters_mm)},
                              {"step_mm", app::json_number(r.step_mm)},
                              {"solved_mm", app::json_number(r.solved_mm)},
                              {"apart", app::json_number(r.apart)},
                              {"solved_cpu_s", app::json_number(r.solved_cpu_s)}});
  }
  return json;
}

io::Json json_of(const LiveCurve& curve) {
  if (curve.points.empty()) return nullptr;
  io::Json json;
  json["settings"] = io::Json::array();
  for (const auto& p : curve.points) {
    json["settings"].push_back({{"breathing", sim::to_string(p.kind)},
                                {"window", p.window},
                                {"patches", p.patches},
                                {"trials", p.trials},
                                {"shown", p.shown},
                                {"still_mm", app::json_number(p.still_mm)},
                                {"following_mm", app::json_number(p.following_mm)},
                                {"p95_mm", app::json_number(p.p95_mm)},
                                {"predicted_mm", app::json_number(p.predicted_mm)},
                                {"update_cpu_ms", app::json_number(p.update_cpu_ms)}});
  }
  const LiveEvidence& e = curve.evidence;
  json["evidence"] = {{"own", e.own},
                      {"own_withdrawn", e.own_withdrawn},
                      {"others", e.others},
                      {"others_withdrawn", e.others_withdrawn},
                      {"pictures_median", app::json_number(e.images_median)}};
  return json;
}

io::Json json_of(const std::vector<FaultPoint>& points, const std::string& seeds) {
  io::Json rows = io::Json::array();
  for (const auto& p : points) {
    rows.push_back({{"seeds", seeds},
                    {"fault", to_string(p.fault.kind)},
                    {"size", p.fault.size},
                    {"unit", unit_of(p.fault.kind)},
                    {"runs", p.runs},
                    {"solved", p.solved},
                    {"clear", p.clear},
                    {"warned", p.warned},
                    {"refused", p.refused},
                    {"false_accepts", p.false_accepts},
                    {"error_mean_mm", app::json_number(p.error_mean_mm)},
                    {"error_max_mm", app::json_number(p.error_max_mm)},
                    {"actual_over_predicted", app::json_number(p.actual_over_predicted)},
                    {"named", p.named},
                    {"named_right", p.named_right},
                    {"misfits_cpu_ms", app::json_number(p.misfits_cpu_ms)}});
  }
  return rows;
}

void add_totals(const std::vector<FaultPoint>& points, io::Json& summary) {
  int runs = 0;
  int false_accepts = 0;
  for (const auto& p : points) {
    runs += p.runs;
    false_accepts += p.false_accepts;
  }
  summary["fault_runs"] = points.empty() ? io::Json(nullptr) : io::Json(runs);
  summary["fault_false_accepts"] = points.empty() ? io::Json(nullptr) : io::Json(false_accepts);
}

io::Json json_of(const std::vector<BoneTrial>& trials) {
  io::Json json = io::Json::array();
  for (const BoneCount& one : count_bones(trials)) {
    json.push_back({{"case", to_string(one.bone_case)},
                    {"kind", to_string(one.kind)},
                    {"runs", one.runs},
                    {"accepted", one.accepted},
                    {"undetermined", one.undetermined},
                    {"false_accepts", one.false_accepts},
                    {"cpu_s", one.seconds / one.runs}});
  }
  return json;
}

io::Json json_of(const std::vector<BoneFinding>& findings) {
  io::Json json = io::Json::array();
  for (const BoneFinding& one : findings) {
    json.push_back({{"site", to_string(one.site)},
                    {"errors", to_string(one.level)},
                    {"lines_with_bone", one.with_bone},
                    {"found", one.found},
                    {"far", one.far},
                    {"without_bone", one.without_bone},
                    {"detect_ms", one.detect_ms},
                    {"runs", one.runs},
                    {"errors_mm", one.errors_mm},
                    {"accepted", one.accepted},
                    {"wrong_accepted", one.wrong_accepted},
                    {"undetermined", one.undetermined},
                    {"mirrored", one.mirrored},
                    {"mirrored_accepted", one.mirrored_accepted}});
  }
  return json;
}

}  // namespace nav::bench
