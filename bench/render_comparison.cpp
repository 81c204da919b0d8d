// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/render_comparison.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iomanip>
#include <limits>
#include <sstream>
#include <sys/resource.h>

#include "bench/vtk_baseline.hpp"
#include "render/engine.hpp"

namespace nav::bench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

using Picture = std::vector<Eigen::Vector3f>;

Picture colours(const Image2d<RgbaF>& image) {
  Picture out;
  for (const RgbaF& p : image.pixels()) out.emplace_back(p.r, p.g, p.b);
  return out;
}

Picture colours(const Image2d<Rgba8>& image) {
  Picture out;
  for (const Rgba8& p : image.pixels()) {
    out.emplace_back(static_cast<float>(p.r) / 255, static_cast<float>(p.g) / 255,
                     static_cast<float>(p.b) / 255);
  }
  return out;
}

/// Something that draws scenes, ours or VTK's.
struct Contestant {
  std::string name;
  std::function<Result<Picture>(const render::Scene&)> draw;
};

Contestant contestant(std::shared_ptr<render::Engine> engine) {
  std::string name = engine->name();
  return {std::move(name),
          [engine = std::move(engine)](const render::Scene& scene) -> Result<Picture> {
            auto image = engine->render(scene);
            if (!image) return image.error();
            return colours(image->pixels);
          }};
}

Contestant contestant(VtkBaseline::Mapper mapper, std::shared_ptr<VtkBaseline> baseline) {
  return {to_string(mapper), [baseline = std::move(baseline)](const render::Scene& scene) {
            return Result<Picture>(colours(baseline->render(scene)));
          }};
}

/// User and system time of the whole process, s.
double process_time_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// Times of one contestant at one step.
struct Times {
  std::vector<double> cpu_s, wall_s;
};

Result<void> time_frame(const Contestant& who, const render::Scene& scene, Times& times) {
  const double cpu = process_time_s();
  const auto wall = std::chrono::steady_clock::now();
  if (auto drawn = who.draw(scene); !drawn) return drawn.error();
  times.cpu_s.push_back(process_time_s() - cpu);
  times.wall_s.push_back(
      std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count());
  return {};
}

/// Root mean square and greatest difference over pixels and channels.
void set_error(const Picture& found, const Picture& truth, RenderBenchRow& row) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d d = (found[i] - truth[i]).cast<double>();
    sum += d.squaredNorm();
    row.max = std::max(row.max, d.cwiseAbs().maxCoeff());
  }
  row.rms = std::sqrt(sum / (3.0 * static_cast<double>(truth.size())));
}

Result<void> check(const NamedScene& named, const RenderBenchOptions& options) {
  const auto refused = [&](const std::string& text) {
    return Error{ErrorCode::kUsage, "scene " + named.name + ": " + text};
  };
  if (named.scene.plane || named.scene.needle || !named.scene.spheres.empty()) {
    return refused("expected CT alone, which VTK's mappers can draw, found a plane or shapes");
  }
  if (options.frames < 1) {
    return refused("expected at least 1 timed frame, found " + std::to_string(options.frames));
  }
  return render::validate(named.scene);
}

Result<std::vector<Contestant>> contestants_for(const render::Scene& scene,
                                                const RenderBenchOptions& options,
                                                Diagnostics& diagnostics,
                                                RenderBenchReport& report) {
  std::vector<Contestant> all;
  all.push_back(contestant(std::shared_ptr<render::Engine>(render::make_cpu_engine())));
  auto gl = render::make_gl_engine(diagnostics);
  if (!gl) return gl.error();
  report.gl_device = (*gl)->device();
  all.push_back(contestant(std::shared_ptr<render::Engine>(std::move(gl).value())));
  for (const auto& [wanted, mapper] :
       {std::pair{options.vtk_gpu, VtkBaseline::Mapper::kGpu},
        std::pair{options.vtk_fixed_point, VtkBaseline::Mapper::kFixedPoint}}) {
    if (!wanted) continue;
    auto baseline = VtkBaseline::create(mapper, scene);
    if (!baseline) return baseline.error();
    all.push_back(contestant(mapper, std::shared_ptr<VtkBaseline>(std::move(baseline).value())));
  }
  return all;
}

Result<void> compare_one(const NamedScene& named, const RenderBenchOptions& options,
                         Diagnostics& diagnostics, RenderBenchReport& report) {
  if (auto ok = check(named, options); !ok) return ok;
  auto contestants = contestants_for(named.scene, options, diagnostics, report);
  if (!contestants) return contestants.error();
  render::Scene small = named.scene;
  small.width = options.reference_width;
  small.height = options.reference_height;
  render::Scene truth_scene = small;
  truth_scene.quality.step_voxels = options.reference_step;
  auto truth_image = render::make_reference_engine()->render(truth_scene);
  if (!truth_image) return truth_image.error();
  const Picture truth = colours(truth_image->pixels);
  for (const double step : options.step_voxels) {
    render::Scene scene = named.scene;
    scene.quality.step_voxels = step;
    small.quality.step_voxels = step;
    std::vector<RenderBenchRow> rows;
    for (const Contestant& who : *contestants) {
      RenderBenchRow row{named.name, who.name, step};
      auto drawn = who.draw(small);
      if (!drawn) return drawn.error();
      set_error(*drawn, truth, row);
      rows.push_back(std::move(row));
      // First frame of this size and step: uploads, gradients and compilation are not timed.
      if (auto warm = who.draw(scene); !warm) return warm.error();
    }
    std::vector<Times> times(rows.size());
    for (int frame = 0; frame < options.frames; ++frame) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (auto ok = time_frame((*contestants)[i], scene, times[i]); !ok) return ok;
      }
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].cpu_s = median(times[i].cpu_s);
      rows[i].wall_s = median(times[i].wall_s);
      report.rows.push_back(std::move(rows[i]));
    }
  }
  return {};
}

/// All ratios of one of our engines against one of VTK's mappers.
void add_ratios(const std::string& name, const std::string& ours, const std::string& theirs,
                RenderBenchReport& report) {
  for (const RenderBenchRow& their : report.rows) {
    if (their.engine != theirs) continue;
    RenderBenchRatio ratio{their.scene, name, their.step, kNone, kNone};
    double cheapest_s = std::numeric_limits<double>::infinity();
    for (const RenderBenchRow& our : report.rows) {
      if (our.engine != ours || our.scene != their.scene) continue;
      if (our.step == their.step) ratio.same_step = their.cpu_s / our.cpu_s;
      if (our.rms <= their.rms) cheapest_s = std::min(cheapest_s, our.cpu_s);
    }
    if (std::isfinite(cheapest_s)) ratio.equal_error = their.cpu_s / cheapest_s;
    report.ratios.push_back(std::move(ratio));
  }
}

}  // namespace

Result<RenderBenchReport> compare_renderers(const std::vector<NamedScene>& scenes,
                                            const RenderBenchOptions& options,
                                            Diagnostics& diagnostics) {
  RenderBenchReport report;
  report.reference_width = options.reference_width;
  report.reference_height = options.reference_height;
  for (const NamedScene& named : scenes) {
    if (auto ok = compare_one(named, options, diagnostics, report); !ok) return ok.error();
  }
  add_ratios("cpu_vs_vtk_gpu", "cpu", "vtk-gpu", report);
  add_ratios("gl_vs_vtk_gpu", "gl", "vtk-gpu", report);
  add_ratios("cpu_vs_vtk_fixedpoint", "cpu", "vtk-fixedpoint", report);
  return report;
}

std::string to_text(const RenderBenchReport& report) {
  std::ostringstream out;
  out << "OpenGL device: " << report.gl_device << '\n'
      << "Same camera, step, transfer function and shading flags; no plane or needle. VTK: no\n"
         "automatic sampling distance, no jitter, one ray per pixel, 8-bit pictures (0.0011 rms "
         "of\n"
         "rounding). All stop a ray at an opacity of about 1 - 1/255. Error: "
      << report.reference_width << " x " << report.reference_height
      << " pixels\nagainst the converged double-precision reference; with shading it includes that "
         "VTK lights\notherwise than the reference. VTK's fixed-point mapper smooths its picture "
         "when it draws it.\n\n"
      << std::fixed << std::left << std::setw(40) << "scene" << std::setw(16) << "engine"
      << std::right << std::setw(7) << "step" << std::setw(10) << "cpu ms" << std::setw(10)
      << "wall ms" << std::setw(10) << "rms" << std::setw(10) << "max" << '\n';
  for (const RenderBenchRow& row : report.rows) {
    out << std::left << std::setw(40) << row.scene << std::setw(16) << row.engine << std::right
        << std::setprecision(3) << std::setw(7) << row.step << std::setprecision(1) << std::setw(10)
        << 1e3 * row.cpu_s << std::setw(10) << 1e3 * row.wall_s << std::setprecision(5)
        << std::setw(10) << row.rms << std::setw(10) << row.max << '\n';
  }
  out << '\n'
      << std::left << std::setw(40) << "scene" << std::setw(24) << "times faster (cpu s)"
      << std::right << std::setw(7) << "step" << std::setw(12) << "same step" << std::setw(14)
      << "equal error" << '\n'
      << std::setprecision(2);
  for (const RenderBenchRatio& ratio : report.ratios) {
    out << std::left << std::setw(40) << ratio.scene << std::setw(24) << ratio.name << std::right
        << std::setprecision(3) << std::setw(7) << ratio.step << std::setprecision(2)
        << std::setw(12) << ratio.same_step << std::setw(14) << ratio.equal_error << '\n';
  }
  return out.str();
}

}  // namespace nav::bench
