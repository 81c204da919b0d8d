// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/predicate_bench.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <malloc.h>
#include <memory>
#include <random>

#include "bench/predicate_cases.hpp"
#include "bench/predicate_frames.hpp"
#include "bench/scene_set.hpp"
#include "render/engine.hpp"
#include "render/spec/predicate_spec.hpp"

namespace nav::bench {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

using render::Engine;
using render::RenderedImage;
using render::Scene;

Result<void> check_images(Engine& engine, const Scene& scene, PredicateBenchRow& row) {
  auto fast = engine.render(scene);
  if (!fast) return fast.error();
  Scene other = scene;
  other.quality.skip_empty_bricks = false;
  auto unskipped = engine.render(other);
  if (!unskipped) return unskipped.error();
  auto brute = engine.render(without_tricks(scene));
  if (!brute) return brute.error();
  const auto a = fast->pixels.pixels();
  const auto b = unskipped->pixels.pixels();
  row.identical = std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
  row.max_error = largest_difference(*fast, *brute);
  row.predicate_samples = fast->statistics.volume_samples;
  row.brute_samples = brute->statistics.volume_samples;
  return {};
}

/// Memory of one engine with a scene, bytes, without the scene's volumes and features.
Result<double> engine_bytes(const Scene& scene, int threads) {
  const auto engine = render::make_cpu_engine({threads});
  malloc_trim(0);  // Memory left by earlier engines would hide the memory of this one.
  const std::size_t before = resident_bytes();
  int frame = 0;
  const Task draw = frames(*engine, scene, frame);
  for (int i = 0; i < 2; ++i) {
    if (auto ok = draw(); !ok) return ok.error();
  }
  malloc_trim(0);  // Releases memory that was needed only during drawing.
  return static_cast<double>(resident_bytes()) - static_cast<double>(before);
}

/// Process time that an edit needs before its first ray; for a set: after a change from the other
/// set.
Result<void> time_edits(Engine& engine, const Scene& scene, const Scene& other_set,
                        PredicateBenchRow& row) {
  std::vector<double> importance;
  std::vector<double> sets;
  Scene edited = scene;
  for (int i = 0; i < 5; ++i) {
    edited.predicates->model.histogram.drag(0, 0.3 + 0.05 * i);
    auto image = engine.render(edited);
    if (!image) return image.error();
    importance.push_back(1e3 * image->statistics.prepare_s);
    if (auto other = engine.render(other_set); !other) return other.error();
    auto changed = engine.render(scene);
    if (!changed) return changed.error();
    sets.push_back(1e3 * changed->statistics.prepare_s);
  }
  row.prepare_ms = median(importance);
  row.set_edit_ms = median(sets);
  return {};
}

Result<PredicateBenchRow> measure_scene(const PredicateVolume& volume,
                                        const PredicateVolume::Appearance& appearance,
                                        const PredicateBenchOptions& options) {
  PredicateBenchRow row;
  row.scene = volume.name + "/" + appearance.name;
  const Scene scene = predicate_scene(volume, appearance.model, options.width, options.height);
  const Scene standard = standard_scene(scene);
  const auto held = engine_bytes(scene, options.threads);
  if (!held) return held.error();
  row.engine_bytes = *held;
  // One engine each, so that none rebuilds data that another discarded.
  std::unique_ptr<Engine> engines[3];
  for (auto& engine : engines) engine = render::make_cpu_engine({options.threads});
  int frame = 0;
  std::vector<Task> tasks{frames(*engines[0], standard, frame), frames(*engines[1], scene, frame),
                          frames(*engines[2], without_tricks(scene), frame)};
  for (const Task& task : tasks) {
    if (auto ok = task(); !ok) return ok.error();
  }
  const auto taken = time_in_turn(tasks, options.repeats);
  if (!taken) return taken.error();
  row.standard_cpu_ms = 1e3 * (*taken)[0].cpu_s;
  row.predicate_cpu_ms = 1e3 * (*taken)[1].cpu_s;
  row.brute_cpu_ms = 1e3 * (*taken)[2].cpu_s;
  row.standard_wall_ms = 1e3 * (*taken)[0].wall_s;
  row.predicate_wall_ms = 1e3 * (*taken)[1].wall_s;
  const auto image = engines[0]->render(nudged(standard, ++frame));
  if (!image) return image.error();
  row.standard_samples = image->statistics.volume_samples;
  if (auto ok = check_images(*engines[1], scene, row); !ok) return ok.error();
  const Scene plain = plain_set(scene);
  if (auto ok = time_edits(*engines[1], scene, plain, row); !ok) return ok.error();
  const auto fresh = render::make_cpu_engine({options.threads});
  const auto edit = time_progressive_edit(*fresh, scene, plain);
  if (!edit) return edit.error();
  row.edit = *edit;
  Scene dragged = scene;
  dragged.predicates->model.histogram.drag(0, 0.35);
  const auto other = render::make_cpu_engine({options.threads});
  const auto bar = time_progressive_edit(*other, dragged, scene);
  if (!bar) return bar.error();
  row.bar = *bar;
  return row;
}

/// Tests the theorem of render/spec/predicate_spec.hpp on random and on adversarial rays.
void check_theorem(PredicateBenchReport& report) {
  constexpr int kRays = 100'000;
  constexpr double kRounding = 1e-12;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int ray = 0; ray < kRays; ++ray) {
    const bool adversarial = ray % 4 == 0;
    const int count = 2 + static_cast<int>(random() % 40);
    const int stop = 1 + static_cast<int>(random() % static_cast<unsigned>(count - 1));
    const double more = std::pow(10, -6 + 7 * unit(random));
    render::spec::ImportanceState<double> state;
    render::spec::ImportanceState<double> at_stop;
    double greatest = 0;
    for (int i = 0; i < count; ++i) {
      if (i == stop) at_stop = state;
      const bool behind = i >= stop;
      const double alpha = adversarial && !behind ? 0.9 : unit(random);
      const double importance = adversarial ? (behind ? 2 + more : 2) : 6 * unit(random);
      const double grey = adversarial ? (behind ? 1 : 0) : unit(random);
      if (behind) greatest = std::max(greatest, importance);
      render::spec::composite_log<double>(state, render::spec::Rgb<double>::Constant(grey), alpha,
                                          importance);
    }
    const double bound =
        render::spec::remaining_change(at_stop.alpha, at_stop.importance, greatest);
    const double found = std::abs(state.alpha * state.rgb.x() - at_stop.alpha * at_stop.rgb.x());
    if (found > bound + kRounding) ++report.bound_violations;
    if (at_stop.alpha >= 1 - 1.0 / 255) report.naive_error = std::max(report.naive_error, found);
  }
  report.rays_checked = kRays;
}

bool wanted(const std::string& name, const PredicateBenchOptions& options) {
  return name.starts_with(options.volume);
}

/// Keeps the requested predicate sets, and adds the volume if any remain.
void add_wanted(PredicateVolume volume, const PredicateBenchOptions& options,
                std::vector<PredicateVolume>& volumes) {
  std::erase_if(volume.appearances, [&](const auto& appearance) {
    return !appearance.name.starts_with(options.appearance);
  });
  if (!volume.appearances.empty()) volumes.push_back(std::move(volume));
}

/// The paper's patients, simulated, with every feature that their predicate sets read. At most 256
/// voxels a side: the simulation of larger volumes takes memory that has nothing to do with drawing
/// them.
Result<void> add_patients(const PredicateBenchOptions& options,
                          std::vector<PredicateVolume>& volumes) {
  for (const char* name : {"carotid", "shoulder", "tendon"}) {
    if (!wanted(name, options)) continue;
    auto volume = patient_volume(name, std::min(options.side, 256));
    if (!volume) return volume.error();
    for (const auto& appearance : volume->appearances) {
      if (!appearance.name.starts_with(options.appearance)) continue;
      if (auto ok = add_features(appearance.model, *volume); !ok) return ok.error();
    }
    add_wanted(*std::move(volume), options, volumes);
  }
  return {};
}

Result<std::vector<PredicateVolume>> volumes_of(const PredicateBenchOptions& options,
                                                Diagnostics& diagnostics) {
  std::vector<PredicateVolume> volumes;
  if (wanted("neck", options)) {
    auto neck = neck_phantom(options.side);
    if (!neck) return neck.error();
    add_wanted(*std::move(neck), options, volumes);
  }
  if (options.patients) {
    if (auto ok = add_patients(options, volumes); !ok) return ok.error();
  }
  if (wanted("prostate phantom", options)) {
    auto prostate = prostate_volume(diagnostics);
    if (prostate) {
      add_wanted(*std::move(prostate), options, volumes);
    } else if (!options.volume.empty() && volumes.empty()) {
      return prostate.error();  // No other volume was requested.
    } else {
      diagnostics.report(Severity::kWarning, "bench", "skipped: " + prostate.error().message);
    }
  }
  if (!volumes.empty()) return volumes;
  if (!options.appearance.empty()) {
    return Error{ErrorCode::kUsage,
                 "--look: expected the beginning of the name of a predicate set (vessel, "
                 "interfaces, …), found " +
                     options.appearance};
  }
  return Error{ErrorCode::kUsage,
               "--volume: expected the beginning of neck, carotid, shoulder, tendon, prostate, "
               "two-volumes or features, found " +
                   options.volume};
}

Result<void> measure_gl(const std::vector<PredicateVolume>& volumes,
                        const PredicateBenchOptions& options, Diagnostics& diagnostics,
                        const std::function<void()>& one_done, PredicateBenchReport& report) {
  constexpr int kGlRepeats = 3;
  auto gl = measure_gl_predicates(volumes, options.width, options.height, kGlRepeats, diagnostics,
                                  one_done);
  if (gl) {
    report.gl = *std::move(gl);
  } else if (gl.error().code == ErrorCode::kUnavailable) {
    diagnostics.report(Severity::kWarning, "bench", "skipped: " + gl.error().message);
  } else {
    return gl.error();
  }
  return {};
}

std::string cpu_text(const PredicateBenchReport& report) {
  std::string out =
      "\nCPU engine, process time per image, ms; samples in millions\n"
      "scene                          standard  predicates      brute   ratio   samples: standard "
      "predicates  brute   max error /255  identical  edit ms  set ms  set "
      "wall ms  set whole ms  bar wall ms  bar whole ms  fps (wall)\n";
  char line[320];
  for (const auto& row : report.rows) {
    std::snprintf(line, sizeof line,
                  "%-30s %8.1f %11.1f %10.1f %7.2f %18.1f %10.1f %6.1f %16.3f %10s %8.1f %7.1f "
                  "%12.1f %13.1f %12.1f %13.1f %11.1f\n",
                  row.scene.c_str(), row.standard_cpu_ms, row.predicate_cpu_ms, row.brute_cpu_ms,
                  row.standard_cpu_ms / row.predicate_cpu_ms,
                  1e-6 * static_cast<double>(row.standard_samples),
                  1e-6 * static_cast<double>(row.predicate_samples),
                  1e-6 * static_cast<double>(row.brute_samples), 255 * row.max_error,
                  row.identical ? "yes" : "NO", row.prepare_ms, row.set_edit_ms, row.edit.first_ms,
                  row.edit.whole_ms, row.bar.first_ms, row.bar.whole_ms,
                  1e3 / row.predicate_wall_ms);
    out += line;
  }
  std::snprintf(line, sizeof line,
                "median predicates / standard (frame rates): %.2f; predicates / brute force: %.2f\n"
                "memory of one engine, without the volume and its features: at most %.1f MB\n",
                report.predicate_over_standard(), report.brute_over_predicate(),
                report.megabytes.value_or(0));
  return out + line;
}

}  // namespace

double PredicateBenchReport::predicate_over_standard() const {
  std::vector<double> all;
  for (const auto& row : rows) all.push_back(row.standard_cpu_ms / row.predicate_cpu_ms);
  return median(all);
}

double PredicateBenchReport::brute_over_predicate() const {
  std::vector<double> all;
  for (const auto& row : rows) all.push_back(row.brute_cpu_ms / row.predicate_cpu_ms);
  return median(all);
}

double PredicateBenchReport::worst_whole_ms() const {
  double most = rows.empty() ? std::numeric_limits<double>::quiet_NaN() : 0;
  for (const auto& row : rows) most = std::max({most, row.edit.whole_ms, row.bar.whole_ms});
  return most;
}

double PredicateBenchReport::worst_set_edit_wall_ms() const {
  double most = rows.empty() ? kNotMeasured : 0;
  for (const auto& row : rows) most = std::max(most, row.edit.first_ms);
  return most;
}

double PredicateBenchReport::max_error() const {
  double most = rows.empty() ? kNotMeasured : 0;
  for (const auto& row : rows) most = std::max(most, row.max_error);
  return most;
}

Result<PredicateBenchReport> measure_predicates(const PredicateBenchOptions& options,
                                                Diagnostics& diagnostics,
                                                const std::function<void(double)>& progress) {
  PredicateBenchReport report;
  check_theorem(report);
  const auto made = volumes_of(options, diagnostics);
  if (!made) return made.error();
  const std::vector<PredicateVolume>& volumes = *made;
  std::size_t total = 0;
  const std::size_t engines = std::size_t{options.cpu} + std::size_t{options.gl};
  for (const auto& volume : volumes) total += engines * volume.appearances.size();
  std::size_t done = 0;
  const auto one_done = [&] {
    ++done;
    if (progress) progress(static_cast<double>(done) / static_cast<double>(total));
  };
  for (const auto& volume : volumes) {
    if (!options.cpu) break;
    for (const auto& appearance : volume.appearances) {
      auto row = measure_scene(volume, appearance, options);
      if (!row) return row.error();
      report.megabytes = std::max(report.megabytes.value_or(0), 1e-6 * row->engine_bytes);
      report.rows.push_back(*std::move(row));
      one_done();
    }
  }
  if (options.gl) {
    if (auto ok = measure_gl(volumes, options, diagnostics, one_done, report); !ok) {
      return ok.error();
    }
  }
  return report;
}

std::string to_text(const PredicateBenchReport& report) {
  char line[256];
  std::snprintf(line, sizeof line,
                "early termination: %d violations of the bound in %d rays; termination by opacity "
                "alone has errors up to %.2f\n",
                report.bound_violations, report.rays_checked, report.naive_error);
  return (report.rows.empty() ? "" : cpu_text(report)) + line +
         (report.gl ? to_text(*report.gl) : "");
}

}  // namespace nav::bench
