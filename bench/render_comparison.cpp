// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/render_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <limits>
#include <sstream>

#include "bench/gl_frames.hpp"
#include "bench/vtk_baseline.hpp"
#include "render/engine.hpp"
#include "render/gl/gl_device.hpp"

namespace nav::bench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kFineRms = 5e-3;
constexpr const char* kGlFragments = "gl-fragment";

using Colours = std::vector<Eigen::Vector3f>;

Colours colours(const Image2d<RgbaF>& image) {
  Colours out;
  for (const RgbaF& p : image.pixels()) out.emplace_back(p.r, p.g, p.b);
  return out;
}

Colours colours(const Image2d<Rgba8>& image) {
  Colours out;
  for (const Rgba8& p : image.pixels()) {
    out.emplace_back(static_cast<float>(p.r) / 255, static_cast<float>(p.g) / 255,
                     static_cast<float>(p.b) / 255);
  }
  return out;
}

/// Something that draws scenes, ours or VTK's.
struct Contestant {
  std::string name;
  bool ours;
  /// Without a pixel error no pixel depends on others: a small image shows the same error as a
  /// large one.
  bool by_rays;
  bool by_opengl;
  std::function<Result<void>(const render::Scene&)> draw;  ///< Operation that is timed.
  /// Image that is compared, 8 bits: middles() of an image.
  std::function<Result<Colours>(const render::Scene&, int factor)> image_of;
};

Contestant contestant(const std::shared_ptr<render::Engine>& engine) {
  const auto draw = [engine](const render::Scene& scene) -> Result<void> {
    if (auto image = engine->render(scene); !image) return image.error();
    return {};
  };
  const auto image_of = [engine](const render::Scene& scene, int factor) -> Result<Colours> {
    auto image = engine->render(scene);
    if (!image) return image.error();
    return colours(middles(render::to_8bit(image->pixels), factor));
  };
  return {.name = engine->name(),
          .ours = true,
          .by_rays = true,
          .by_opengl = engine->name() == "gl",
          .draw = draw,
          .image_of = image_of};
}

/// stays: the timed image is not read back.
Contestant contestant(VtkBaseline::Mapper mapper, const std::shared_ptr<VtkBaseline>& baseline,
                      bool stays) {
  const auto draw = [baseline, stays](const render::Scene& scene) -> Result<void> {
    stays ? baseline->draw(scene) : void(baseline->render(scene));
    return {};
  };
  const auto image_of = [baseline](const render::Scene& scene, int factor) {
    return Result<Colours>(colours(middles(baseline->render_unsmoothed(scene), factor)));
  };
  return {.name = to_string(mapper),
          .ours = false,
          .by_rays = mapper != VtkBaseline::Mapper::kGpuHalf,
          .by_opengl = mapper != VtkBaseline::Mapper::kFixedPoint,
          .draw = draw,
          .image_of = image_of};
}

/// Root mean square and largest difference over pixels and channels.
std::pair<double, double> difference(const Colours& found, const Colours& truth) {
  double sum = 0;
  double max = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d d = (found[i] - truth[i]).cast<double>();
    sum += d.squaredNorm();
    max = std::max(max, d.cwiseAbs().maxCoeff());
  }
  return {std::sqrt(sum / (3.0 * static_cast<double>(truth.size()))), max};
}

render::Scene at_step(render::Scene scene, double step) {
  scene.quality.step_voxels = step;
  return scene;
}

Result<void> check(const NamedScene& named, const RenderBenchOptions& options) {
  const auto refused = [&](const std::string& text) {
    return Error{ErrorCode::kUsage, "scene " + named.name + ": " + text};
  };
  const render::Scene& scene = named.scene;
  if (scene.plane || scene.needle || !scene.spheres.empty() || !scene.lines.empty()) {
    return refused(
        "expected a CT alone, because VTK's mappers draw nothing else, found a plane or shapes");
  }
  if (const auto ok = check_image(options, scene.width, scene.height); !ok) {
    return refused(ok.error().message);
  }
  if (options.repeats.times < 1) {
    return refused("expected at least 1 timed frame, found " +
                   std::to_string(options.repeats.times));
  }
  return render::validate(scene);
}

/// Runs the scenes in order and collects the report.
class Comparison {
 public:
  Comparison(const RenderBenchOptions& options, Diagnostics& diagnostics)
      : options_(options), diagnostics_(diagnostics) {}

  Result<void> start() {
    report_.reference_width = options_.reference_width;
    report_.reference_height = options_.reference_height;
    report_.reference_step = options_.reference_step;
    ours_.push_back(contestant(std::shared_ptr<render::Engine>(render::make_cpu_engine())));
    if (!options_.gl) return {};
    auto gl = render::make_gl_engine(diagnostics_);
    if (!gl) return gl.error();
    report_.gl_device = (*gl)->device();
    report_.of_device = options_.of_device.value_or(!render::runs_in_software(report_.gl_device));
    ours_.push_back(contestant(std::shared_ptr<render::Engine>(std::move(gl).value())));
    if (!report_.of_device) return {};
    if (auto ok = draw_on_device({}); !ok) return ok;
    // Fragment shaders like VTK's mapper, even if compute shaders are faster on the device.
    const render::GlOptions fragments{.compute = false};
    auto other = render::make_gl_engine(diagnostics_, fragments);
    if (!other) return other.error();
    ours_.push_back(contestant(std::shared_ptr<render::Engine>(std::move(other).value())));
    ours_.back().name = kGlFragments;
    return draw_on_device(fragments);
  }
  Result<void> run(const NamedScene& named);
  RenderBenchReport finish();

 private:
  /// Timed images of the last contestant stay on the device.
  Result<void> draw_on_device(const render::GlOptions& options) {
    auto frames = make_gl_frames(options);
    if (!frames) return frames.error();
    ours_.back().draw = contestant(std::shared_ptr<render::Engine>(*std::move(frames))).draw;
    return {};
  }
  Result<Colours> truth_of(const render::Scene& scene, double step) const;
  Result<std::vector<Contestant>> theirs(const render::Scene& scene);
  Result<void> run_step(const NamedScene& named, const std::vector<Contestant>& all,
                        const SparsePoint& quality, const Colours& truth,
                        const std::vector<Colours>& own_truths);
  Result<void> run_chosen(const NamedScene& named, const Colours& truth,
                          const std::vector<Colours>& own_truths);
  Result<std::vector<Taken>> time_on_device(const std::vector<Task>& tasks);
  void add_ratios(const NamedScene& named);
  void add_ratio(const NamedScene& named, const std::string& name, const RenderBenchCurve& ours,
                 const RenderBenchCurve& theirs);
  [[nodiscard]] render::Scene small(const render::Scene& scene) const {
    render::Scene out = scene;
    out.width = options_.reference_width;
    out.height = options_.reference_height;
    return out;
  }
  /// Colours of a contestant at the positions of the reference's pixels.
  [[nodiscard]] Result<Colours> seen(const Contestant& who, const render::Scene& scene) const;

  const RenderBenchOptions& options_;
  Diagnostics& diagnostics_;
  std::vector<Contestant> ours_;
  RenderBenchReport report_;
};

Result<Colours> Comparison::truth_of(const render::Scene& scene, double step) const {
  auto image = render::make_reference_engine()->render(at_step(small(scene), step));
  if (!image) return image.error();
  return colours(image->pixels);
}

Result<Colours> Comparison::seen(const Contestant& who, const render::Scene& scene) const {
  if (who.by_rays && scene.quality.pixel_error == 0) return who.image_of(small(scene), 1);
  return who.image_of(scene, scene.width / options_.reference_width);
}

Result<std::vector<Contestant>> Comparison::theirs(const render::Scene& scene) {
  std::vector<Contestant> all;
  for (const auto& [wanted, mapper] :
       {std::pair{options_.vtk_gpu, VtkBaseline::Mapper::kGpu},
        std::pair{options_.vtk_gpu_half, VtkBaseline::Mapper::kGpuHalf},
        std::pair{options_.vtk_fixed_point, VtkBaseline::Mapper::kFixedPoint}}) {
    if (!wanted || (mapper == VtkBaseline::Mapper::kGpuHalf && !options_.vtk_gpu)) continue;
    auto baseline = VtkBaseline::create(mapper, scene);
    if (!baseline) return baseline.error();
    all.push_back(contestant(mapper, std::shared_ptr<VtkBaseline>(std::move(baseline).value()),
                             report_.of_device));
  }
  return all;
}

Result<void> Comparison::run(const NamedScene& named) {
  if (auto ok = check(named, options_); !ok) return ok;
  const auto truth = truth_of(named.scene, options_.reference_step);
  if (!truth) return truth.error();
  const auto coarser = truth_of(named.scene, 2 * options_.reference_step);
  if (!coarser) return coarser.error();
  report_.truths.push_back({named.name, difference(*coarser, *truth).first});

  auto vtk = theirs(named.scene);
  if (!vtk) return vtk.error();
  std::vector<Contestant> all = ours_;
  all.insert(all.end(), vtk->begin(), vtk->end());
  std::vector<Colours> own_truths(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    // First image at full size, so that uploads, gradients and compilation are not timed.
    render::Scene first = named.scene;
    first.quality.step_voxels = options_.step_voxels.front();
    if (auto warm = all[i].draw(first); !warm) return warm;
    if (all[i].ours) continue;
    if (!all[i].by_rays) {  // This mapper with all rays precedes it.
      own_truths[i] = own_truths[i - 1];
      continue;
    }
    auto own = all[i].image_of(at_step(small(named.scene), options_.reference_step), 1);
    if (!own) return own.error();
    own_truths[i] = std::move(*own);
  }
  for (const double step : options_.step_voxels) {
    if (auto ok = run_step(named, all, {step, 0}, *truth, own_truths); !ok) return ok;
  }
  std::vector<SparsePoint> own;
  if (!report_.of_device) own = options_.own_sparse;  // A device always has a ray for every pixel.
  for (const double step : options_.own_step_voxels) own.push_back({step, 0});
  for (const SparsePoint& quality : own) {
    if (auto ok = run_step(named, ours_, quality, *truth, own_truths); !ok) return ok;
  }
  // The chosen step is compared with VTK on the same processor only.
  if (!report_.of_device) {
    if (auto ok = run_chosen(named, *truth, own_truths); !ok) return ok;
  }
  add_ratios(named);
  return {};
}

/// Computes ChosenStep::rms_whole.
Result<double> whole_error(render::Engine& engine, render::Scene scene,
                           const render::StepChoice& choice) {
  scene.quality.pixel_error = choice.pixel_error;
  const auto image = engine.render(at_step(scene, choice.step_voxels));
  if (!image) return image.error();
  scene.quality.pixel_error = 0;
  scene.quality.opaque_at = 1;
  const auto truth = engine.render(at_step(scene, choice.step_voxels / 8));
  if (!truth) return truth.error();
  return difference(colours(render::to_8bit(image->pixels)), colours(truth->pixels)).first;
}

Result<void> Comparison::run_chosen(const NamedScene& named, const Colours& truth,
                                    const std::vector<Colours>& own_truths) {
  const auto engine = render::make_cpu_engine();
  // Prepares the volume first: every image needs this, so it is not part of the search time.
  if (auto warm = engine->render(small(named.scene)); !warm) return warm.error();
  const double start = process_time_s();
  const auto choice = render::step_for_error(*engine, named.scene, render::kDefaultRms);
  if (!choice) return choice.error();
  const double search_cpu_s = process_time_s() - start;
  const auto rms_whole = whole_error(*engine, named.scene, *choice);
  if (!rms_whole) return rms_whole.error();
  report_.chosen.push_back({named.name, *choice, search_cpu_s, *rms_whole});
  const auto cpu = std::find_if(ours_.begin(), ours_.end(),
                                [](const Contestant& who) { return who.name == "cpu"; });
  NAV_CHECK(cpu != ours_.end());
  return run_step(named, {*cpu}, {choice->step_voxels, choice->pixel_error}, truth, own_truths);
}

void Comparison::add_ratios(const NamedScene& named) {
  const RenderBenchCurve vtk{{"vtk-gpu"}, false};
  for (const Contestant& who : ours_) {
    const RenderBenchCurve all{{who.name}, true};
    if (options_.vtk_gpu) {
      add_ratio(named, who.name + "_vs_vtk_gpu", all, vtk);
      add_ratio(named, who.name + "_dense_vs_vtk_gpu", {{who.name}, false}, vtk);
    }
    if (options_.vtk_gpu && options_.vtk_gpu_half) {
      add_ratio(named, who.name + "_vs_vtk_gpu_any", all, {{"vtk-gpu", "vtk-gpu-half"}, false});
    }
  }
  if (options_.vtk_fixed_point) {
    add_ratio(named, "cpu_vs_vtk_fixedpoint", {{"cpu"}, true}, {{"vtk-fixedpoint"}, false});
  }
}

Result<void> Comparison::run_step(const NamedScene& named, const std::vector<Contestant>& all,
                                  const SparsePoint& quality, const Colours& truth,
                                  const std::vector<Colours>& own_truths) {
  render::Scene scene = at_step(named.scene, quality.step_voxels);
  scene.quality.pixel_error = quality.pixel_error;
  std::vector<RenderBenchRow> rows;
  std::vector<Task> tasks;
  std::vector<Task> on_device;  // Timed separately, because the other tasks let the device idle.
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Contestant& who = all[i];
    const auto found = seen(who, scene);
    if (!found) return found.error();
    RenderBenchRow row{.scene = named.name,
                       .engine = who.name,
                       .step = quality.step_voxels,
                       .pixel_error = quality.pixel_error,
                       .rms_own = kNone};
    std::tie(row.rms, row.max) = difference(*found, truth);
    if (!who.ours) row.rms_own = difference(*found, own_truths[i]).first;
    rows.push_back(std::move(row));
    (report_.of_device && who.by_opengl ? on_device : tasks)
        .push_back(
            [&who, &scene, frame = 0]() mutable { return who.draw(nudged(scene, ++frame)); });
  }
  const auto of_device = time_on_device(on_device);
  if (!of_device) return of_device.error();
  const auto taken = time_in_turn(tasks, options_.repeats);
  if (!taken) return taken.error();
  auto next_of_device = of_device->begin();
  auto next = taken->begin();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Taken& own = report_.of_device && all[i].by_opengl ? *next_of_device++ : *next++;
    rows[i].cpu_s = own.cpu_s;
    rows[i].wall_s = own.wall_s;
    report_.rows.push_back(std::move(rows[i]));
  }
  return {};
}

Result<std::vector<Taken>> Comparison::time_on_device(const std::vector<Task>& tasks) {
  if (tasks.empty()) return std::vector<Taken>{};
  if (auto busy = keep_busy(tasks); !busy) return busy.error();
  constexpr int kTimes = 9;  // Each takes only milliseconds.
  return time_in_turn(tasks, {std::max(options_.repeats.times, kTimes), options_.repeats.enough_s});
}

void Comparison::add_ratio(const NamedScene& named, const std::string& name,
                           const RenderBenchCurve& ours, const RenderBenchCurve& theirs) {
  const ErrorCurve our = curve_of(report_, named.name, ours);
  const ErrorCurve their = curve_of(report_, named.name, theirs);
  const double cheapest_s = their.front().empty() ? kNone : their.front().front().time_s;
  report_.ratios.push_back({.scene = named.name,
                            .name = name,
                            .shaded = named.scene.shading.enabled,
                            .levels = equal_error_ratios(our, their, options_.levels),
                            .fine_over_their_cheapest = our.time_at(kFineRms) / cheapest_s});
}

RenderBenchReport Comparison::finish() { return std::move(report_); }

}  // namespace

Result<RenderBenchReport> compare_renderers(const std::vector<NamedScene>& scenes,
                                            const RenderBenchOptions& options,
                                            Diagnostics& diagnostics,
                                            const std::function<void(std::size_t)>& progress) {
  Comparison comparison(options, diagnostics);
  if (auto ok = comparison.start(); !ok) return ok.error();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (auto ok = comparison.run(scenes[i]); !ok) return ok.error();
    if (progress) progress(i + 1);
  }
  return comparison.finish();
}

ErrorCurve curve_of(const RenderBenchReport& report, const std::string& scene,
                    const RenderBenchCurve& curve) {
  std::vector<CurvePoint> points;
  for (const RenderBenchRow& row : report.rows) {
    const bool wanted =
        std::find(curve.engines.begin(), curve.engines.end(), row.engine) != curve.engines.end();
    if (row.scene != scene || !wanted || (row.pixel_error > 0 && !curve.sparse)) continue;
    points.push_back({row.error(), report.of_device ? row.wall_s : row.cpu_s});
  }
  return ErrorCurve(std::move(points));
}

Result<void> check_image(const RenderBenchOptions& options, int width, int height) {
  const int factor = width / options.reference_width;
  if (factor % 2 == 1 && width == factor * options.reference_width &&
      height == factor * options.reference_height) {
    return {};
  }
  return Error{ErrorCode::kUsage, "expected an image of an odd multiple of " +
                                      std::to_string(options.reference_width) + " x " +
                                      std::to_string(options.reference_height) + " pixels, found " +
                                      std::to_string(width) + " x " + std::to_string(height)};
}

const RenderBenchRow* find_row(const RenderBenchReport& report, const std::string& scene,
                               const std::string& engine, const SparsePoint& quality) {
  for (const RenderBenchRow& row : report.rows) {
    const bool same = row.step == quality.step_voxels && row.pixel_error == quality.pixel_error;
    if (row.scene == scene && row.engine == engine && same) return &row;
  }
  return nullptr;
}

const RenderBenchRow* find_row(const RenderBenchReport& report, const std::string& scene,
                               const std::string& engine, double step) {
  return find_row(report, scene, engine, SparsePoint{step, 0});
}

std::string to_text(const RenderBenchReport& report) {
  std::ostringstream out;
  out << "OpenGL device: " << report.gl_device << '\n'
      << "Same camera, step, transfer function and shading flags; CT alone. VTK: no automatic\n"
         "sampling distance, no jitter; one ray per pixel, or with -half a quarter of them. All "
         "stop a ray at an opacity of about\n"
         "1 - 1/255. rms, max: 8-bit colours of "
      << report.reference_width << " x " << report.reference_height
      << " of the image's pixels against the double-precision reference at 1/"
      << std::lround(1 / report.reference_step)
      << " voxel;\nown: VTK against itself at that step, without the difference of its lighting. "
         "Equal error: along\nthe curves of time over error; for VTK with the smaller of rms and "
         "own.\n\n"
      << std::fixed << std::left << std::setw(54) << "scene" << std::setw(16) << "engine"
      << std::right << std::setw(7) << "step" << std::setw(7) << "pixel" << std::setw(10)
      << "cpu ms" << std::setw(10) << "wall ms" << std::setw(10) << "rms" << std::setw(8) << "max"
      << std::setw(10) << "own" << '\n';
  for (const RenderBenchRow& row : report.rows) {
    out << std::left << std::setw(54) << row.scene << std::setw(16) << row.engine << std::right
        << std::setprecision(3) << std::setw(7) << row.step << std::setprecision(2) << std::setw(7)
        << row.pixel_error << std::setprecision(1) << std::setw(10) << 1e3 * row.cpu_s
        << std::setw(10) << 1e3 * row.wall_s << std::setprecision(5) << std::setw(10) << row.rms
        << std::setprecision(3) << std::setw(8) << row.max;
    if (std::isfinite(row.rms_own)) out << std::setprecision(5) << std::setw(10) << row.rms_own;
    out << '\n';
  }
  out << "\nTimes faster at equal error (VTK's "
      << (report.of_device ? "wall time of a frame that stays on the device" : "process time")
      << " over Sonde's), at each rms; \"-\": Sonde's curve does not reach it.\n";
  for (const RenderBenchRatio& ratio : report.ratios) {
    out << std::left << std::setw(54) << ratio.scene << std::setw(28) << ratio.name << std::right;
    for (const ErrorLevelRatio& level : ratio.levels) {
      out << "  " << std::setprecision(4) << level.rms << ": " << std::setprecision(1);
      if (std::isfinite(level.ratio)) {
        out << level.ratio;
      } else {
        out << '-';
      }
    }
    out << '\n';
  }
  out << "\nReference: rms between its step and twice that\n";
  for (const SceneTruth& truth : report.truths) {
    out << std::left << std::setw(54) << truth.scene << std::setprecision(6)
        << truth.self_convergence << '\n';
  }
  return out.str();
}

}  // namespace nav::bench
