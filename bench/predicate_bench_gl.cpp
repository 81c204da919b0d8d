// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/predicate_bench_gl.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>

#include "bench/gl_frames.hpp"
#include "bench/paper_shader.hpp"
#include "bench/predicate_frames.hpp"
#include "nav/stopwatch.hpp"
#include "render/gl/gl_device.hpp"
#include "render/gl/gl_raycaster.hpp"

namespace nav::bench {
namespace {

using render::Engine;
using render::RenderedImage;
using render::Scene;

/// The engines of one scene, so that none rebuilds data that another discarded.
struct Engines {
  std::shared_ptr<Engine> standard, predicates, brute, paper;  ///< Engines that are timed.
  /// Engines for images that are read back: on a device, timed images stay there.
  std::shared_ptr<Engine> read_predicates, read_paper;
  /// Engines with the device's own filter, on devices.
  std::shared_ptr<Engine> paper_own_filter, read_paper_own_filter;
  bool software = false;
  std::unique_ptr<Engine> cpu;  ///< If OpenGL runs on the same processor, else null.
};

/// An engine as an application uses it on a device: images stay there.
Result<std::unique_ptr<Engine>> make_timed(bool software) {
  CollectingDiagnostics unheard;
  return software ? render::make_gl_engine(unheard) : make_gl_frames();
}

Result<Engines> make_engines(Diagnostics& diagnostics, std::optional<bool> of_device) {
  auto read = render::make_gl_engine(diagnostics);
  if (!read) return read.error();
  Engines out;
  out.read_predicates = *std::move(read);
  out.software = of_device ? !*of_device : render::runs_in_software(out.read_predicates->device());
  const auto add_paper = [](std::shared_ptr<Engine>& into, bool reads,
                            std::optional<bool> manual_filter) -> Result<void> {
    auto made = make_paper_shader({.reads = reads, .compute = {}, .manual_filter = manual_filter});
    if (!made) return made.error();
    into = *std::move(made);
    return {};
  };
  if (auto ok = add_paper(out.read_paper, true, {}); !ok) return ok.error();
  out.predicates = out.read_predicates;
  out.paper = out.read_paper;
  std::vector<std::shared_ptr<Engine>*> timed{&out.standard, &out.brute};
  if (!out.software) {
    timed.push_back(&out.predicates);
    if (auto ok = add_paper(out.paper, false, {}); !ok) return ok.error();
    if (auto ok = add_paper(out.paper_own_filter, false, false); !ok) return ok.error();
    if (auto ok = add_paper(out.read_paper_own_filter, true, false); !ok) return ok.error();
  }
  for (auto* engine : timed) {
    auto made = make_timed(out.software);
    if (!made) return made.error();
    *engine = *std::move(made);
  }
  if (out.software) out.cpu = render::make_cpu_engine();
  return out;
}

/// Uses the paper's linear mean of hues, so that both draw the same image.
Scene as_printed(Scene scene) {
  scene.predicates->hue_mean = render::spec::HueMean::kLinear;
  return scene;
}

Result<void> time_frames(Engines& engines, const Scene& scene, int repeats, GlPredicateRow& row) {
  int frame = 0;
  std::vector<double> cast_s[5];
  std::vector<Task> tasks{frames(*engines.standard, standard_scene(scene), frame, &cast_s[0]),
                          frames(*engines.predicates, scene, frame, &cast_s[1]),
                          frames(*engines.brute, without_tricks(scene), frame, &cast_s[2]),
                          frames(*engines.paper, as_printed(scene), frame, &cast_s[3])};
  // Warm-up until each predicate set has its own program.
  for (int warm = 0; warm <= render::GlRaycaster::kSettledAfter; ++warm) {
    for (const Task& task : {tasks[1], tasks[2]}) {
      if (auto ok = task(); !ok) return ok;
    }
  }
  if (engines.cpu) tasks.push_back(frames(*engines.cpu, scene, frame));
  if (engines.paper_own_filter) {
    tasks.push_back(frames(*engines.paper_own_filter, as_printed(scene), frame, &cast_s[4]));
  }
  for (const Task& task : tasks) {
    if (auto ok = task(); !ok) return ok;
  }
  if (!engines.software) {
    if (auto ok = keep_busy(tasks); !ok) return ok;
  }
  for (auto& times : cast_s) times.clear();
  const auto taken = time_in_turn(tasks, {repeats, 4});
  if (!taken) return taken.error();
  double* const into[] = {&row.standard_ms, &row.predicate_ms, &row.brute_ms, &row.paper_ms};
  for (std::size_t i = 0; i < std::size(into); ++i) {
    *into[i] = 1e3 * (engines.software ? (*taken)[i].cpu_s : median(cast_s[i]));
  }
  if (engines.cpu) row.cpu_engine_ms = 1e3 * taken->back().cpu_s;
  if (engines.paper_own_filter) row.paper_own_filter_ms = 1e3 * median(cast_s[4]);
  return {};
}

Result<void> check_images(Engines& engines, const Scene& scene, GlPredicateRow& row) {
  const auto fast = engines.read_predicates->render(scene);
  if (!fast) return fast.error();
  Scene other = scene;
  other.quality.skip_empty_bricks = false;
  const auto unskipped = engines.read_predicates->render(other);
  if (!unskipped) return unskipped.error();
  const auto brute = engines.read_predicates->render(without_tricks(scene));
  if (!brute) return brute.error();
  const auto a = fast->pixels.pixels();
  const auto b = unskipped->pixels.pixels();
  row.identical = std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
  row.max_error = largest_difference(*fast, *brute);
  const auto printed = engines.read_predicates->render(as_printed(without_tricks(scene)));
  if (!printed) return printed.error();
  const auto paper = engines.read_paper->render(as_printed(scene));
  if (!paper) return paper.error();
  row.paper_difference = largest_difference(*printed, *paper);
  row.paper_rms = rms_difference(*printed, *paper);
  if (engines.read_paper_own_filter) {
    const auto own = engines.read_paper_own_filter->render(as_printed(scene));
    if (!own) return own.error();
    row.paper_own_filter_difference = largest_difference(*printed, *own);
  }
  if (!engines.cpu) return {};
  const auto cpu = engines.cpu->render(as_printed(without_tricks(scene)));
  if (!cpu) return cpu.error();
  row.cpu_paper_difference = largest_difference(*cpu, *paper);
  return {};
}

/// Process time if OpenGL runs in software, else wall time, ms.
Result<double> time_frame(Engine& engine, const Scene& scene, bool software) {
  const auto start = std::chrono::steady_clock::now();
  const double process_s = process_time_s();
  const auto image = engine.render(scene);
  if (!image) return image.error();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  return 1e3 * (software ? process_time_s() - process_s : wall.count());
}

Result<void> time_waiting(const Scene& scene, const Scene& other_set, bool software,
                          GlPredicateRow& row) {
  auto fresh = make_timed(software);
  if (!fresh) return fresh.error();
  const auto edit = time_progressive_edit(**fresh, scene, other_set);
  if (!edit) return edit.error();
  row.edit = *edit;
  return {};
}

/// Measures set_edit_ms on an engine that has drawn the volume with a set without features, but not
/// with this set.
Result<void> time_edits(Engines& engines, const Scene& scene, const Scene& other_set,
                        GlPredicateRow& row) {
  auto fresh = make_timed(engines.software);
  if (!fresh) return fresh.error();
  if (auto ok = time_frame(**fresh, other_set, engines.software); !ok) return ok.error();
  const auto first = time_frame(**fresh, scene, engines.software);
  if (!first) return first.error();
  std::vector<double> later;
  constexpr int kSettling = render::GlRaycaster::kSettledAfter;
  constexpr int kSettled = 5;
  for (int i = 1; i <= kSettling + kSettled; ++i) {
    const auto next = time_frame(**fresh, nudged(scene, i), engines.software);
    if (!next) return next.error();
    later.push_back(*next);
  }
  const double usual = median({later.end() - kSettled, later.end()});
  row.set_edit_ms = std::max(0.0, *first - usual);
  row.settle_ms = std::max(0.0, *std::max_element(later.begin(), later.end()) - usual);
  std::vector<double> edits;
  Scene edited = scene;
  for (int i = 0; i < 5; ++i) {
    edited.predicates->model.histogram.drag(0, 0.3 + 0.05 * i);
    const auto image = engines.predicates->render(edited);
    if (!image) return image.error();
    edits.push_back(1e3 * image->statistics.prepare_s);
  }
  row.edit_ms = median(edits);
  return {};
}

double median_of(const std::vector<GlPredicateRow>& rows,
                 const std::function<double(const GlPredicateRow&)>& value) {
  std::vector<double> all;
  for (const auto& row : rows) all.push_back(value(row));
  return median(all);
}

/// value: a member, or a function of a row.
template <class Value>
double most_of(const std::vector<GlPredicateRow>& rows, const Value& value) {
  double most = 0;
  for (const auto& row : rows) most = std::max(most, std::invoke(value, row));
  return most;
}

}  // namespace

double GlPredicateReport::predicate_over_standard() const {
  return median_of(rows, [](const auto& r) { return r.standard_ms / r.predicate_ms; });
}

std::optional<double> GlPredicateReport::vs_paper_shader() const {
  const auto same = [](const GlPredicateRow& row) { return row.paper_rms <= kSameImageRms; };
  if (!std::all_of(rows.begin(), rows.end(), same)) return std::nullopt;
  return median_of(rows, [](const auto& r) { return r.paper_ms / r.predicate_ms; });
}

std::optional<double> GlPredicateReport::vs_paper_shader_own_filter() const {
  if (rows.empty() || !rows.front().paper_own_filter_ms) return std::nullopt;
  return median_of(rows,
                   [](const auto& r) { return r.paper_own_filter_ms.value() / r.predicate_ms; });
}

std::optional<double> GlPredicateReport::cpu_vs_paper_shader() const {
  if (rows.empty() || !rows.front().cpu_engine_ms || !vs_paper_shader()) return std::nullopt;
  return median_of(rows, [](const auto& r) { return r.paper_ms / r.cpu_engine_ms.value(); });
}

double GlPredicateReport::max_error() const { return most_of(rows, &GlPredicateRow::max_error); }

double GlPredicateReport::worst_set_edit_ms() const {
  return most_of(rows, &GlPredicateRow::set_edit_ms);
}

double GlPredicateReport::worst_set_edit_wall_ms() const {
  return most_of(rows, [](const GlPredicateRow& row) { return row.edit.first_ms; });
}

Result<GlPredicateReport> measure_gl_predicates(const std::vector<PredicateVolume>& volumes,
                                                int width, int height, int repeats,
                                                Diagnostics& diagnostics,
                                                const std::function<void()>& done,
                                                std::optional<bool> of_device) {
  GlPredicateReport report;
  CollectingDiagnostics unheard;
  for (const auto& volume : volumes) {
    for (const auto& appearance : volume.appearances) {
      auto engines = make_engines(report.rows.empty() ? diagnostics : unheard, of_device);
      if (!engines) return engines.error();
      report.device = engines->standard->device();
      report.width = engines->software ? width / 2 : width;
      report.height = engines->software ? height / 2 : height;
      const Scene scene = predicate_scene(volume, appearance.model, report.width, report.height);
      GlPredicateRow row;
      row.scene = volume.name + "/" + appearance.name;
      if (auto ok = time_frames(*engines, scene, repeats, row); !ok) return ok.error();
      if (auto ok = check_images(*engines, scene, row); !ok) return ok.error();
      const Scene plain = plain_set(scene);
      if (auto ok = time_edits(*engines, scene, plain, row); !ok) return ok.error();
      if (auto ok = time_waiting(scene, plain, engines->software, row); !ok) return ok.error();
      report.rows.push_back(std::move(row));
      done();
    }
  }
  return report;
}

std::string to_text(const GlPredicateReport& report) {
  char line[256];
  std::snprintf(line, sizeof line, "\nGL engine on %s, %d x %d, ms per image\n",
                report.device.c_str(), report.width, report.height);
  std::string out = line;
  out +=
      "scene                          standard  predicates      brute      paper   ratios: "
      "standard "
      " paper   max error /255  paper differs /255   by rms  identical  edit ms  set ms  set wall "
      "ms  "
      "set whole ms  settle ms\n";
  for (const auto& row : report.rows) {
    std::snprintf(
        line, sizeof line,
        "%-30s %8.2f %11.2f %10.2f %10.2f %17.2f %6.1f %16.3f %19.3f %8.3f %10s %8.1f %7.1f "
        "%12.1f %13.1f %10.1f\n",
        row.scene.c_str(), row.standard_ms, row.predicate_ms, row.brute_ms, row.paper_ms,
        row.standard_ms / row.predicate_ms, row.paper_ms / row.predicate_ms, 255 * row.max_error,
        255 * row.paper_difference, 255 * row.paper_rms, row.identical ? "yes" : "NO", row.edit_ms,
        row.set_edit_ms, row.edit.first_ms, row.edit.whole_ms, row.settle_ms);
    out += line;
  }
  std::snprintf(line, sizeof line, "median predicates / standard (frame rates): %.2f; ",
                report.predicate_over_standard());
  out += line;
  if (const auto paper = report.vs_paper_shader()) {
    std::snprintf(line, sizeof line, "predicates / the paper's shader: %.2f\n", *paper);
    out += line;
  } else {
    out += "the paper's shader draws another image: not compared\n";
  }
  if (const auto own = report.vs_paper_shader_own_filter()) {
    std::snprintf(line, sizeof line,
                  "predicates / the paper's shader with the filter of the device: %.2f; ms per "
                  "image (difference /255):",
                  *own);
    out += line;
    for (const auto& row : report.rows) {
      std::snprintf(line, sizeof line, " %.2f (%.1f)", row.paper_own_filter_ms.value(),
                    255 * row.paper_own_filter_difference.value_or(0));
      out += line;
    }
    out += '\n';
  }
  if (const auto cpu = report.cpu_vs_paper_shader()) {
    std::snprintf(line, sizeof line,
                  "median CPU engine / the paper's shader on the same processor: %.2f\n", *cpu);
    out += line;
  }
  return out;
}

}  // namespace nav::bench
