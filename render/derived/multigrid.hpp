// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "render/derived/grid_graph.hpp"
#include "render/derived/run.hpp"

namespace nav::render::derived {

struct SolveOptions {
  /// Root mean square of the estimated error at which the solve stops, in units of x, (0, 0.1]. The
  /// estimate is one multigrid cycle on the residual: residuals themselves say little where edges
  /// differ by factors of 10^5.
  double error = 1e-4;
  int max_iterations = 200;  ///< Of the inner solver, all refinements together.
};

/// Approximate inverse of a graph's matrix: one multigrid cycle with boxes of two nodes across the
/// scan lines as coarse nodes, smoothing that solves whole lines along the axis of the strongest
/// coupling exactly, and a direct solve on the last level. Symmetric and positive, so that
/// conjugate gradients can use it. The same bytes for any number of threads.
class Multigrid {
 public:
  Multigrid(GridGraph fine, int threads);
  ~Multigrid();
  Multigrid(Multigrid&&) noexcept;
  Multigrid& operator=(Multigrid&&) noexcept;

  [[nodiscard]] const GridGraph& fine() const;
  /// Nodes that there is something to solve for.
  [[nodiscard]] std::size_t open() const;
  /// z = M r; vectors of fine().cells(). r comes back as it was.
  void apply(std::vector<float>& r, std::vector<float>& z);
  [[nodiscard]] int levels() const;

 private:
  struct Level;
  struct Coarsest;
  void cycle(std::size_t level);
  std::vector<Level> levels_;
  std::unique_ptr<Coarsest> coarsest_;
  int threads_;
};

/// Solves A x = b from a start x: conjugate gradients in float within iterative refinement, whose
/// residuals are in double, so that the result is as good as double arithmetic makes it. Reports
/// what it reached; a stop request ends it early (converged = false).
SolveReport solve(Multigrid& system, const std::vector<float>& b, std::vector<double>& x,
                  const SolveOptions& options, const RunOptions& run);

}  // namespace nav::render::derived
