// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_vessels.hpp"

#include <cstdio>
#include <iostream>

#include "app/appearance/preset_folder.hpp"
#include "app/report.hpp"
#include "bench/scene_set.hpp"
#include "bench/vessel_bench.hpp"
#include "io/ct.hpp"
#include "render/transfer/transfer_presets.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/ct_scanner.hpp"

namespace nav::bench {
namespace {

/// A CT whose blood and bone are known.
struct VesselCase {
  std::string name;
  Volume ct;
  VesselTruth truth;
};

Result<void> add_label(const std::filesystem::path& file, const Volume& ct,
                       std::vector<std::uint8_t>& label, app::Console& console) {
  const auto read = io::read_ct(file, console);
  if (!read) return read.error();
  if (read->values().size() != ct.values().size()) {
    return Error{ErrorCode::kMalformedData,
                 file.string() + ": expected the grid of the CT, found another"};
  }
  label.resize(ct.values().size(), 0);
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (read->values()[i] > 0) label[i] = 1;
  }
  return {};
}

Result<VesselCase> angiography(const std::filesystem::path& folder, app::Console& console) {
  auto ct = io::read_ct(folder / "ct_cropped.nii.gz", console);
  if (!ct) return ct.error();
  VesselTruth truth;
  for (const char* name :
       {"aorta", "brachiocephalic_trunk", "celiac_trunk", "common_carotid_artery_left",
        "subclavian_artery_left", "superior_mesenteric_artery"}) {
    const auto ok = add_label(folder / (std::string(name) + ".nii.gz"), *ct, truth.blood, console);
    if (!ok) return ok.error();
  }
  std::vector<std::uint8_t> vertebra;
  if (const auto ok = add_label(folder / "vertebrae_T12.nii.gz", *ct, vertebra, console); !ok) {
    return ok.error();
  }
  truth.bone = bone_by_density(*ct, truth.blood, vertebra);
  // The label of the aorta holds its wall, thrombus and stents too.
  constexpr int kLeastBloodHu = 200;
  constexpr int kMostBloodHu = 700;
  for (std::size_t i = 0; i < truth.blood.size(); ++i) {
    const int hu = ct->hu()[i];
    if (hu < kLeastBloodHu || hu > kMostBloodHu) truth.blood[i] = 0;
  }
  return VesselCase{"recorded CT angiography", *std::move(ct), std::move(truth)};
}

Result<VesselCase> simulated(sim::Contrast contrast) {
  const sim::AbdomenPhantom phantom({1, contrast});
  auto ct = sim::scan_ct(phantom, {});
  if (!ct) return ct.error();
  VesselTruth truth;
  const auto& grid = ct->grid();
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        using enum sim::Tissue;
        const auto tissue = phantom.tissue(grid.at({1.0 * i, 1.0 * j, 1.0 * k}));
        const bool arterial = tissue == kAorta;
        const bool venous = tissue == kPortalVein || tissue == kHepaticVein || tissue == kVenaCava;
        const bool blood = arterial || (venous && contrast == sim::Contrast::kPortal);
        truth.blood.push_back(blood ? 1 : 0);
        truth.bone.push_back(tissue == kBone || tissue == kMarrow ? 1 : 0);
      }
    }
  }
  return VesselCase{std::string("simulated CT, ") + sim::to_string(contrast), *std::move(ct),
                    std::move(truth)};
}

io::Json json_of(const VesselFigures& figures) {
  return {{"blood_visible", figures.blood_visible},
          {"bone_share", figures.bone_share},
          {"visible_ml", figures.visible_ml}};
}

}  // namespace

Result<void> run_bench_vessels(const BenchVesselsOptions& options, app::Console& console) {
  std::vector<VesselCase> cases;
  const auto folder = bench_data_dir() / "cta-aorta-totalseg";
  if (std::filesystem::exists(folder / "ct_cropped.nii.gz")) {
    auto recorded = angiography(folder, console);
    if (!recorded) return recorded.error();
    cases.push_back(*std::move(recorded));
  } else {
    console.report(Severity::kWarning, "bench vessels",
                   "recorded CT skipped: expected " + folder.string() +
                       ", found nothing (set SONDE_DATA_DIR)");
  }
  for (const auto contrast : {sim::Contrast::kArterial, sim::Contrast::kPortal}) {
    auto made = simulated(contrast);
    if (!made) return made.error();
    cases.push_back(*std::move(made));
  }
  std::vector<render::TransferFunction> presets;
  for (const char* name : {"cta-vessels", "cta-liver-vessels"}) {
    presets.push_back(*render::preset_transfer_function(name));
  }
  const auto contextual = app::read_preset("ct-contextual");
  if (!contextual) return contextual.error();
  presets.push_back(contextual->transfer);
  io::Json rows = io::Json::array();
  std::cout << "Share of labelled blood visible as vessel, and of visible vessel in bone, %\n"
            << "Truth: of the simulation. Recorded: blood is what the labels of arteries hold from "
               "200 to 700 HU\n(not wall, thrombus and stents); bone is T12, and what lies within "
               "2 voxels of more than 700 HU,\nfarther than 3 voxels from labelled arteries.\n";
  for (const VesselCase& one : cases) {
    for (const render::TransferFunction& preset : presets) {
      const VesselFigures before = figures_as_it_is(one.ct, preset, one.truth);
      const auto after = figures_fitted(one.ct, preset, one.truth);
      if (!after) return after.error();
      char line[240];
      std::snprintf(line, sizeof line,
                    "%-26s %-18s fixed: blood %5.1f bone %5.1f   fitted: blood %5.1f bone %5.1f"
                    "   pool %s%.0f HU, window %.0f to %.0f, %.2f s\n",
                    one.name.c_str(), preset.name().c_str(), 100 * before.blood_visible,
                    100 * before.bone_share, 100 * after->figures.blood_visible,
                    100 * after->figures.bone_share, after->pool ? "" : "not found, ",
                    after->pool ? after->pool->mean_hu : 0, after->window.zero_below,
                    after->window.zero_above, after->classify_s);
      std::cout << line << std::flush;
      rows.push_back({{"ct", one.name},
                      {"preset", preset.name()},
                      {"fixed", json_of(before)},
                      {"fitted", json_of(after->figures)},
                      {"pool_hu", after->pool ? io::Json(after->pool->mean_hu) : io::Json()},
                      {"window_hu",
                       {after->window.zero_below, after->window.full_from, after->window.full_to,
                        after->window.zero_above}},
                      {"seconds", after->classify_s}});
    }
  }
  if (!options.json) return {};
  io::Json json;
  json["verb"] = "bench vessels";
  json["version"] = SONDE_VERSION;
  json["cases"] = std::move(rows);
  return app::write_json(json, *options.json);
}

}  // namespace nav::bench
