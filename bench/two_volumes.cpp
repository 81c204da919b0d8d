// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/two_volumes.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "bench/predicate_frames.hpp"
#include "bench/predicate_patient.hpp"
#include "render/two_volumes.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/ct_scanner.hpp"

namespace nav::bench {
namespace {

constexpr std::uint64_t kSeed = 2;  // Of "carotid".

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

/// On the line into the neck, from the left, the front and a little above.
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

/// What a picture of a scene reads.
Result<std::uint64_t> samples_of(render::Engine& engine, const render::Scene& scene) {
  const auto image = engine.render(scene);
  if (!image) return image.error();
  return image->statistics.volume_samples;
}

Result<TwoVolumesRow> measure(const render::Scene& both, const Repeats& repeats) {
  render::Scene ct = both;
  ct.ultrasound.reset();
  const render::Scene alone = render::ultrasound_scene(both);
  TwoVolumesRow row;
  row.step_voxels = both.quality.step_voxels;
  std::vector<std::unique_ptr<render::Engine>> engines;
  std::vector<Task> tasks;
  int frame = 0;
  using Drawn = std::pair<const render::Scene*, std::uint64_t*>;
  for (const auto& [scene, samples] :
       {Drawn{&ct, &row.ct_samples}, Drawn{&alone, &row.ultrasound_samples},
        Drawn{&both, &row.both_samples}}) {
    engines.push_back(render::make_cpu_engine({.threads = 1}));
    const auto read = samples_of(*engines.back(), *scene);
    if (!read) return read.error();
    *samples = *read;
    tasks.push_back(frames(*engines.back(), *scene, frame));
  }
  const auto taken = time_in_turn(tasks, repeats);
  if (!taken) return taken.error();
  row.ct_cpu_ms = 1e3 * (*taken)[0].cpu_s;
  row.ultrasound_cpu_ms = 1e3 * (*taken)[1].cpu_s;
  row.both_cpu_ms = 1e3 * (*taken)[2].cpu_s;
  return row;
}

}  // namespace

Result<render::Scene> two_volumes_scene(int side, int width, int height) {
  auto volume = simulated_ultrasound("carotid", side);
  if (!volume) return volume.error();
  const auto ct = ct_of_the_patient();
  if (!ct) return ct.error();
  const auto& look = volume->looks.back();
  if (auto ok = add_features(look.model, *volume); !ok) return ok.error();
  const auto& into = std::get<render::ParallelScan>(*volume->predicates.scan).into_ct.v;
  render::Scene scene{*ct, *render::preset_transfer_function("ct-bone"),         {}, {}, {},
                      {},  camera_at(volume->ultrasound->grid().centre(), into), {}};
  scene.width = width;
  scene.height = height;
  scene.ultrasound = render::UltrasoundVolume{volume->ultrasound, volume->predicates};
  return scene;
}

Result<TwoVolumesReport> measure_two_volumes(int side, int width, int height,
                                             const Repeats& repeats) {
  const auto scene = two_volumes_scene(side, width, height);
  if (!scene) return scene.error();
  render::Scene small = *scene;
  small.width = std::max(width / 8, 1);
  small.height = std::max(height / 8, 1);
  const auto reference = render::make_reference_engine();
  const auto truth = reference->render(with_step(small, 1.0 / 16));
  if (!truth) return truth.error();
  const auto coarser = reference->render(with_step(small, 1.0 / 8));
  if (!coarser) return coarser.error();
  TwoVolumesReport report;
  report.reference_rms = rms_difference(coarser->pixels, truth->pixels);
  const auto engine = render::make_cpu_engine({.threads = 1});
  for (const double step : {2.0, 1.0, 0.5, 0.25}) {
    auto row = measure(with_step(*scene, step), repeats);
    if (!row) return row.error();
    const auto drawn = engine->render(with_step(small, step));
    if (!drawn) return drawn.error();
    row->rms = rms_difference(drawn->pixels, truth->pixels);
    report.rows.push_back(*row);
  }
  return report;
}

std::string to_text(const TwoVolumesReport& report) {
  std::ostringstream out;
  out << "CT with an ultrasound volume in it, CPU engine, one thread (reference converged to "
      << std::setprecision(2) << report.reference_rms << " rms)\n"
      << "  step | rms     | CT ms | ultrasound ms | both ms | both / sum | samples: CT, "
         "ultrasound, both\n";
  out << std::fixed;
  for (const TwoVolumesRow& row : report.rows) {
    out << std::setprecision(2) << std::setw(6) << row.step_voxels << " | " << std::setprecision(5)
        << row.rms << " | " << std::setprecision(0) << std::setw(5) << row.ct_cpu_ms << " | "
        << std::setw(13) << row.ultrasound_cpu_ms << " | " << std::setw(7) << row.both_cpu_ms
        << " | " << std::setprecision(2) << std::setw(10)
        << row.both_cpu_ms / (row.ct_cpu_ms + row.ultrasound_cpu_ms) << " | " << row.ct_samples
        << ", " << row.ultrasound_samples << ", " << row.both_samples << '\n';
  }
  return out.str();
}

}  // namespace nav::bench
