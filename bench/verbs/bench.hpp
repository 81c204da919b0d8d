// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::bench {

/// True if a part of a bench is asked for; none named: all are.
bool asks_for(const std::vector<std::string>& parts, const std::string& part);
/// True if a part is named. For parts that run only if they are named.
bool names_part(const std::vector<std::string>& parts, const std::string& part);

struct BenchRenderOptions {
  std::filesystem::path ct;          ///< Instead of the scene set; empty: the set.
  std::string scene;                 ///< Only scenes whose name contains it; empty: all.
  std::vector<std::string> parts{};  ///< compare, live, skipping, costs; empty: the first two.
  bool quick = false;  ///< A few scenes, small images: about two minutes on two cores.
  bool costs = false;  ///< Also the cost of every element of an image.
  int width = 832;     ///< Width of the timed images, pixels, an odd multiple of 64.
  int height = 624;    ///< Height, pixels: 48 times that odd number.
  std::optional<std::string> json;
};

/// Run time against error of Sonde's engines beside VTK's volume mappers over the scene set, in one
/// run, then what the CPU engine skips, what cutaway, new images and edits cost, how fast it is
/// when the camera moves, and the agreement of the engines with the reference on the demo's scene.
/// Prints tables; JSON keys are in docs/json.md. The parts skipping and costs draw no
/// VTK: what is skipped in every scene, beside what could be; what each element of an image costs
/// in every scene, with plane, needle and the like in it.
Result<void> run_bench_render(const BenchRenderOptions& options, app::Console& console);

struct BenchScalingOptions {
  int largest = 768;  ///< Side of the largest volume, voxels, [64, 768]: 0.9 GB and more of memory.
  std::optional<std::string> json;
};

/// Time and memory of the CPU engine against volume size, pixels, threads and occupancy.
Result<void> run_bench_scaling(const BenchScalingOptions& options, app::Console& console);

struct BenchPredicatesOptions {
  bool quick = false;      ///< A phantom of 96 voxels a side, small images: some seconds.
  int side = 256;          ///< Side of the phantom, voxels, [32, 768].
  int width = 800;         ///< Width of images, pixels, [32, 4096]; halved if OpenGL is software.
  int height = 600;        ///< Height of images, pixels; range and halving of width.
  int threads = 0;         ///< 0: all cores.
  std::string volume;      ///< Only volumes whose name begins with this.
  std::string appearance;  ///< Only predicate sets whose name begins with this.
  std::string engine = "both";  ///< cpu, gl or both.
  std::optional<std::string> json;
};

/// Predicates beside a standard transfer function and beside brute force on the CPU engine, the
/// error of early termination, and the theorem on random rays. Prints a table; JSON keys are in
/// docs/json.md.
Result<void> run_bench_predicates(const BenchPredicatesOptions& options, app::Console& console);

}  // namespace nav::bench
