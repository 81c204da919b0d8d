// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/two_volumes.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "bench/predicate_cases.hpp"
#include "bench/predicate_frames.hpp"
#include "render/gl/gl_device.hpp"
#include "render/two_volumes.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/ct_scanner.hpp"

namespace nav::bench {
namespace {

constexpr std::uint64_t kSeed = 2;  // Seed of "carotid".

Result<std::shared_ptr<const Volume>> ct_of_the_patient() {
  const auto patient = sim::make_patient("neck", {kSeed, sim::Contrast::kArterial});
  if (!patient) return patient.error();
  sim::CtOptions options;
  options.spacing_mm = {1, 1, 1};
  options.region = sim::region_of(*patient->anatomy);
  auto ct = sim::scan_ct(*patient->anatomy, options);
  if (!ct) return ct.error();
  return std::make_shared<const Volume>(*std::move(ct));
}

/// A camera aimed along the line into the neck, from the left, the front and a little above.
render::Camera camera_at(const Point<frames::Ct>& target, const Eigen::Vector3d& into) {
  constexpr double kDistanceMm = 230;
  constexpr double kAsideRad = 0.7;
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d aside = into.cross(up).normalized();
  render::Camera camera;
  camera.look_at_ct = target;
  camera.eye_ct = {target.mm + kDistanceMm * (-into * std::cos(kAsideRad) -
                                              aside * std::sin(kAsideRad) + 0.25 * up)};
  camera.up_ct = {up};
  return camera;
}

render::Scene with_step(render::Scene scene, double step) {
  scene.quality.step_voxels = step;
  return scene;
}

/// Number of volume samples of an image of a scene.
Result<std::uint64_t> samples_of(render::Engine& engine, const render::Scene& scene) {
  const auto image = engine.render(scene);
  if (!image) return image.error();
  return image->statistics.volume_samples;
}

bool is_software(const render::Engine& engine) {
  return engine.name() == "gl" && render::runs_in_software(engine.device());
}

/// Times of the CT alone, the ultrasound alone, and both.
struct Times {
  std::vector<std::unique_ptr<render::Engine>> engines;
  std::vector<Task> tasks;
  std::vector<double> cast_s[3];
  int frame = 0;

  Result<std::uint64_t> add(const EngineMaker& make, const render::Scene& scene) {
    auto made = make();
    if (!made) return made.error();
    engines.push_back(*std::move(made));
    const auto read = samples_of(*engines.back(), scene);
    if (!read) return read.error();
    tasks.push_back(frames(*engines.back(), scene, frame, &cast_s[tasks.size()]));
    // Warm-up until a predicate set has its own program.
    for (int warm = 0; engines.back()->name() == "gl" && warm < kWarm; ++warm) {
      if (auto ok = tasks.back()(); !ok) return ok.error();
    }
    cast_s[tasks.size() - 1].clear();
    return *read;
  }

 private:
  static constexpr int kWarm = 5;
};

Result<TwoVolumesRow> measure(const EngineMaker& make, const render::Scene& both,
                              const Repeats& repeats) {
  render::Scene ct = both;
  ct.ultrasound.reset();
  const render::Scene alone = render::ultrasound_scene(both);
  TwoVolumesRow row;
  row.step_voxels = both.quality.step_voxels;
  Times times;
  using Drawn = std::pair<const render::Scene*, std::uint64_t*>;
  for (const auto& [scene, samples] :
       {Drawn{&ct, &row.ct_samples}, Drawn{&alone, &row.ultrasound_samples},
        Drawn{&both, &row.both_samples}}) {
    const auto read = times.add(make, *scene);
    if (!read) return read.error();
    *samples = *read;
  }
  const auto taken = time_in_turn(times.tasks, repeats);
  if (!taken) return taken.error();
  const render::Engine& engine = *times.engines.front();
  const bool of_device = engine.name() == "gl" && !is_software(engine);
  double* const into[] = {&row.ct_ms, &row.ultrasound_ms, &row.both_ms};
  for (std::size_t i = 0; i < times.tasks.size(); ++i) {
    *into[i] = 1e3 * (of_device ? median(times.cast_s[i]) : (*taken)[i].cpu_s);
  }
  return row;
}

Result<double> edit_ms(render::Engine& engine, render::Scene scene) {
  std::vector<double> all;
  for (int i = 0; i < 6; ++i) {
    scene.ultrasound->ct_importance = 0.2 * i;
    const auto image = engine.render(scene);
    if (!image) return image.error();
    if (i > 0) all.push_back(1e3 * image->statistics.prepare_s);
  }
  return median(all);
}

/// Reference for all engines.
struct Truth {
  render::Scene scene;  ///< At low resolution.
  Image2d<RgbaF> pixels;
  double rms = 0;
};

Result<Truth> make_truth(const render::Scene& scene) {
  Truth truth{scene, {}, 0};
  truth.scene.width = std::max(scene.width / 8, 1);
  truth.scene.height = std::max(scene.height / 8, 1);
  const auto reference = render::make_reference_engine();
  auto fine = reference->render(with_step(truth.scene, 1.0 / 16));
  if (!fine) return fine.error();
  const auto coarser = reference->render(with_step(truth.scene, 1.0 / 8));
  if (!coarser) return coarser.error();
  truth.pixels = std::move(fine->pixels);
  truth.rms = render::rms_difference(coarser->pixels, truth.pixels);
  return truth;
}

Result<TwoVolumesReport> measure_engine(const EngineMaker& make, render::Scene scene,
                                        const Truth& truth, const Repeats& repeats) {
  const auto engine = make();
  if (!engine) return engine.error();
  const int divisor = is_software(**engine) ? 2 : 1;
  scene.width = std::max(scene.width / divisor, 1);
  scene.height = std::max(scene.height / divisor, 1);
  TwoVolumesReport report;
  report.engine = (*engine)->name();
  report.device = (*engine)->device();
  report.width = scene.width;
  report.height = scene.height;
  report.reference_rms = truth.rms;
  for (const double step : {2.0, 1.0, 0.5, 0.25}) {
    auto row = measure(make, with_step(scene, step), repeats);
    if (!row) return row.error();
    const auto drawn = (*engine)->render(with_step(truth.scene, step));
    if (!drawn) return drawn.error();
    row->rms = render::rms_difference(drawn->pixels, truth.pixels);
    report.rows.push_back(*row);
  }
  const auto edit = edit_ms(**engine, truth.scene);
  if (!edit) return edit.error();
  report.edit_ms = *edit;
  return report;
}

}  // namespace

Result<render::Scene> two_volumes_scene(int side, int width, int height) {
  auto volume = patient_volume("carotid", side);
  if (!volume) return volume.error();
  const auto ct = ct_of_the_patient();
  if (!ct) return ct.error();
  const auto& appearance = volume->appearances.back();
  if (auto ok = add_features(appearance.model, *volume); !ok) return ok.error();
  const auto& into = std::get<render::ParallelScan>(*volume->predicates.scan).into_ct.v;
  render::Scene scene{.ct = *ct,
                      .transfer = *render::preset_transfer_function("ct-bone"),
                      .camera = camera_at(volume->ultrasound->grid().centre(), into)};
  scene.width = width;
  scene.height = height;
  scene.ultrasound = render::UltrasoundVolume{volume->ultrasound, volume->predicates};
  return scene;
}

Result<std::vector<TwoVolumesReport>> measure_two_volumes(int side, int width, int height,
                                                          const Repeats& repeats,
                                                          const std::vector<EngineMaker>& engines) {
  const auto scene = two_volumes_scene(side, width, height);
  if (!scene) return scene.error();
  const auto truth = make_truth(*scene);
  if (!truth) return truth.error();
  std::vector<TwoVolumesReport> reports;
  for (const EngineMaker& make : engines) {
    auto report = measure_engine(make, *scene, *truth, repeats);
    if (!report) return report.error();
    reports.push_back(*std::move(report));
  }
  return reports;
}

std::string to_text(const TwoVolumesReport& report) {
  std::ostringstream out;
  out << "CT with an ultrasound volume in it, " << report.engine << " engine on " << report.device
      << ", " << report.width << " x " << report.height << " (reference converged to "
      << std::setprecision(2) << report.reference_rms << " rms; a new importance of the CT takes "
      << report.edit_ms << " ms before the first ray)\n"
      << "  step | rms     | CT ms | ultrasound ms | both ms | both / sum | samples: CT, "
         "ultrasound, both\n";
  out << std::fixed;
  for (const TwoVolumesRow& row : report.rows) {
    out << std::setprecision(2) << std::setw(6) << row.step_voxels << " | " << std::setprecision(5)
        << row.rms << " | " << std::setprecision(0) << std::setw(5) << row.ct_ms << " | "
        << std::setw(13) << row.ultrasound_ms << " | " << std::setw(7) << row.both_ms << " | "
        << std::setprecision(2) << std::setw(10) << row.both_ms / (row.ct_ms + row.ultrasound_ms)
        << " | " << row.ct_samples << ", " << row.ultrasound_samples << ", " << row.both_samples
        << '\n';
  }
  return out.str();
}

}  // namespace nav::bench
