// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/render_adaptive.hpp"

#include <cmath>
#include <iomanip>
#include <sstream>

#include "bench/error_curve.hpp"
#include "bench/moving_camera.hpp"
#include "bench/scene_set.hpp"
#include "render/engine.hpp"

namespace nav::bench {
namespace {

/// Haze and bone, each with a single appearance.
Result<render::TransferFunction> flat_tissues() {
  return render::TransferFunction::create("flat tissues", {{-300, {0.9, 0.6, 0.5}, 0, 0.2},
                                                           {-200, {0.9, 0.6, 0.5}, 0.008, 0.2},
                                                           {250, {0.9, 0.6, 0.5}, 0.008, 0.2},
                                                           {350, {1, 1, 0.9}, 0.3, 0.8},
                                                           {3000, {1, 1, 0.9}, 0.3, 0.8}});
}

render::Scene few_pixels(render::Scene scene) {
  scene.width = 32;
  scene.height = 24;
  return scene;
}

/// Sets times, samples and errors of the points.
Result<void> measure_points(const render::Scene& scene, const Repeats& repeats,
                            std::vector<AdaptivePoint>& points) {
  render::Scene exact = few_pixels(scene);
  exact.quality.step_voxels = 1.0 / 16;
  const auto truth = render::make_reference_engine()->render(exact);
  if (!truth) return truth.error();
  std::vector<MovingCamera> cameras;
  std::vector<Task> tasks;
  for (AdaptivePoint& point : points) {
    render::Scene one = scene;
    one.quality.step_voxels = point.step_voxels;
    one.quality.adaptive_error = point.adaptive_error;
    const auto small = render::make_cpu_engine()->render(few_pixels(one));
    if (!small) return small.error();
    point.rms = render::rms_difference(small->pixels, truth->pixels);
    cameras.emplace_back(std::move(one));
  }
  for (MovingCamera& camera : cameras) {
    if (auto warm = camera.draw(0); !warm) return warm;
    tasks.push_back([&camera] { return camera.draw(); });
  }
  const auto taken = time_in_turn(tasks, repeats);
  if (!taken) return taken.error();
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].cpu_ms = 1e3 * (*taken)[i].cpu_s;
    points[i].samples = cameras[i].statistics().volume_samples;
  }
  return {};
}

double fixed_over_adaptive(const std::vector<AdaptivePoint>& points) {
  std::vector<CurvePoint> fixed;
  for (const AdaptivePoint& p : points) {
    if (p.adaptive_error == 0) fixed.push_back({p.rms, p.cpu_ms});
  }
  const ErrorCurve curve(fixed);
  std::vector<double> ratios;
  for (const AdaptivePoint& p : points) {
    const double same_error_ms = curve.time_at(p.rms);
    if (p.adaptive_error > 0 && std::isfinite(same_error_ms)) {
      ratios.push_back(same_error_ms / p.cpu_ms);
    }
  }
  return ratios.empty() ? std::nan("") : median(ratios);
}

}  // namespace

Result<std::vector<AdaptiveCurve>> measure_adaptive(const render::Scene& scene,
                                                    const Repeats& repeats) {
  auto flat = flat_tissues();
  if (!flat) return flat.error();
  std::vector<AdaptiveCurve> curves;
  for (const auto& transfer : {scene.transfer, *flat}) {
    render::Scene one = bare(scene);
    one.transfer = transfer;
    AdaptiveCurve curve{transfer.name(), {}, 0};
    for (const double step : {2.0, 1.0, 0.5, 0.25, 0.125}) curve.points.push_back({step});
    for (const double step : {0.5, 0.25}) {
      for (const double error : {0.001, 0.004, 0.016, 0.064}) {
        curve.points.push_back({step, error});
      }
    }
    if (auto ok = measure_points(one, repeats, curve.points); !ok) return ok.error();
    curve.fixed_over_adaptive = fixed_over_adaptive(curve.points);
    curves.push_back(std::move(curve));
  }
  return curves;
}

std::string to_text(const std::vector<AdaptiveCurve>& curves) {
  std::ostringstream out;
  out << "Adaptive step beside the fixed one, CPU engine, CT alone, unshaded; error: of a segment, "
         "0 for the\nfixed step; rms against the reference at 1/16 voxel.\n";
  for (const AdaptiveCurve& curve : curves) {
    out << '\n'
        << std::left << std::setw(24) << curve.scene << std::right << std::setw(8) << "step"
        << std::setw(10) << "error" << std::setw(12) << "ms" << std::setw(14) << "samples"
        << std::setw(12) << "rms" << '\n';
    for (const AdaptivePoint& p : curve.points) {
      out << std::string(24, ' ') << std::defaultfloat << std::setw(8) << p.step_voxels
          << std::setw(10) << p.adaptive_error << std::fixed << std::setprecision(1)
          << std::setw(12) << p.cpu_ms << std::setw(14) << p.samples << std::setprecision(6)
          << std::setw(12) << p.rms << '\n';
    }
    out << "at equal error the fixed step takes " << std::setprecision(2)
        << curve.fixed_over_adaptive << " of the adaptive one's time (median)\n";
  }
  return out.str();
}

}  // namespace nav::bench
