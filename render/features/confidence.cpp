// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/confidence.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "render/features/graph_matrix.hpp"

namespace nav::render::features {
namespace {

/// Visits every voxel with its node in a vector on the graph's layout.
template <class Visit>
void for_each_voxel(const GridGraph& graph, const Visit& visit) {
  std::size_t voxel = 0;
  for (int k = 0; k < graph.size()[2]; ++k) {
    for (int j = 0; j < graph.size()[1]; ++j) {
      for (int i = 0; i < graph.size()[0]; ++i) visit(voxel++, graph.at(i, j, k));
    }
  }
}

/// Sets unknown voxels to 0 and returns them. They have no edges, but 0 times NaN would still be
/// NaN.
std::vector<std::size_t> without_unknown(ConfidenceSystem& system) {
  std::vector<std::size_t> unknown;
  for (std::size_t node = 0; node < system.x.size(); ++node) {
    if (!std::isnan(system.x[node])) continue;
    unknown.push_back(node);
    system.x[node] = 0;
  }
  return unknown;
}

/// Memory of the graph and its coarser graphs, bytes per voxel. In thin volumes the border
/// outweighs the voxels.
double bytes_for_voxel(const VoxelGrid& grid, const ScanLines& lines) {
  constexpr double kPerNode = 80;
  constexpr double kPerNodeOfThin = 105;  // Coarser graphs are then halves, not quarters.
  constexpr double kKeptEdges = 40;       // When the scan lines differ in direction.
  const bool thin = std::ranges::find(grid.size, 1) != grid.size.end();
  return ((thin ? kPerNodeOfThin : kPerNode) + (lines.common() ? 0 : kKeptEdges)) *
         static_cast<double>(GridGraph::cells_of(grid.size)) /
         static_cast<double>(grid.voxel_count());
}

Error not_converged(const std::string& name, const ConfidenceOptions& options,
                    const SolveReport& report) {
  std::ostringstream text;
  text << name << ": expected an estimated error of " << options.solve.error << " within "
       << options.solve.max_iterations << " iterations, found ";
  if (std::isfinite(report.estimated_error)) {
    text << report.estimated_error;
  } else {
    text << "an unknown one";
  }
  text << " after " << report.iterations << " iterations";
  return {ErrorCode::kNumerical, text.str()};
}

}  // namespace

Result<void> validate(const ConfidenceOptions& options) {
  struct Range {
    const char* name;
    double value, low, high;
  };
  const Range ranges[] = {
      {"alpha", options.alpha, 0, 20},
      {"beta", options.beta, 0, 1000},
      {"gamma", options.gamma, 0, 1},
      {"error", options.solve.error, 1e-12, 0.01},
      {"max_iterations", static_cast<double>(options.solve.max_iterations), 1, 1e6},
  };
  for (const Range& r : ranges) {
    if (r.value >= r.low && r.value <= r.high) continue;
    std::ostringstream text;
    text << "confidence: expected " << r.name << " in [" << r.low << ", " << r.high << "], found "
         << r.value;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return {};
}

Result<Confidence> confidence(const ScalarVolume& volume, const ScanLines& lines,
                              const ConfidenceOptions& options, const RunOptions& run) {
  if (const auto ok = validate(options); !ok) return ok.error();
  const VoxelGrid& grid = volume.grid();
  const std::string name = volume.name() + ": confidence";
  if (auto ok =
          check_memory(name, grid.voxel_count(), bytes_for_voxel(grid, lines), run.memory_limit);
      !ok) {
    return ok.error();
  }
  auto system = confidence_system(volume, lines, options, run);
  if (!system) return system.error();
  const auto unknown = without_unknown(*system);
  Multigrid multigrid(std::move(system->graph), run);
  if (run.stop.stop_requested()) return cancelled(name);
  SolveReport report = solve(multigrid, system->b, system->x, options.solve, run);
  if (run.stop.stop_requested()) return cancelled(name);
  if (!report.converged) return not_converged(name, options, report);
  // With so little gamma, voxels of equal value form layers that are coupled more than 10^5 times
  // as strongly within themselves as to other voxels. The estimate then misses the common error of
  // a layer.
  if (options.gamma < kKnownErrorGamma) report.estimated_error = std::nan("");
  for (const std::size_t node : unknown) system->x[node] = std::nan("");
  std::vector<float> values(grid.voxel_count());
  for_each_voxel(multigrid.fine(), [&](std::size_t voxel, std::size_t node) {
    const double x = system->x[node];
    values[voxel] = std::isnan(x) ? kUnknown : static_cast<float>(std::clamp(x, 0.0, 1.0));
  });
  return Confidence{{grid, std::make_shared<const std::vector<float>>(std::move(values))}, report};
}

namespace definition {

Result<std::vector<double>> confidence(const ScalarVolume& volume, const ScanLines& lines,
                                       const ConfidenceOptions& options) {
  RunOptions run;
  run.threads = 1;
  auto system = confidence_system(volume, lines, options, run);
  if (!system) return system.error();
  const GridGraph& graph = system->graph;
  const auto weight = [&](int e, std::size_t node) { return graph.weight(e, node); };
  const GraphMatrix direct = matrix_of(graph, graph.leak, weight, 0);
  Eigen::VectorXd right(direct.degree.size());
  Eigen::Index row = 0;
  for (int k = 0; k < graph.size()[2]; ++k) {
    for (int j = 0; j < graph.size()[1]; ++j) {
      for (int i = 0; i < graph.size()[0]; ++i) {
        right[row++] = static_cast<double>(system->b.row(j, k)[i]);
      }
    }
  }
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(direct.matrix);
  const Eigen::VectorXd solved = factors.solve(right);
  for (std::size_t n = 0; n < direct.nodes.size(); ++n) {
    const auto at = static_cast<Eigen::Index>(n);
    if (direct.degree[at] > 0) system->x[direct.nodes[n]] = solved[at];
  }
  std::vector<double> out(volume.grid().voxel_count());
  for_each_voxel(graph, [&](std::size_t voxel, std::size_t node) { out[voxel] = system->x[node]; });
  return out;
}

}  // namespace definition

}  // namespace nav::render::features
