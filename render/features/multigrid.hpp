// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "render/features/packed_graph.hpp"

namespace nav::render::features {

struct SolveOptions {
  /// Root mean square of the estimated error at which the solve stops, in units of x, (0, 0.01]:
  /// ErrorEstimate, within a factor of 3 of the true one; residuals themselves say little where
  /// edges differ by factors of 10^5. Of more than 0.01 the first iterations know too little.
  double error = 4e-3;
  int max_iterations = 200;  ///< Of the inner solver, all refinements together.
};

/// Approximate inverse of a graph's matrix: one multigrid cycle with boxes of two nodes across the
/// scan lines as coarse nodes, the first two coarse levels visited twice, smoothing that solves
/// whole lines along the axis of the strongest coupling exactly, and a direct solve on the last
/// level; weights of 16 bits, since memory is what it waits for. Symmetric and positive, so that
/// conjugate gradients can use it. The same bytes for any number of threads. Where a stop is asked
/// for, nothing of it is to be used any more.
class Multigrid {
 public:
  Multigrid(GridGraph fine, const RunOptions& run);
  ~Multigrid();
  Multigrid(Multigrid&&) noexcept;
  Multigrid& operator=(Multigrid&&) noexcept;

  [[nodiscard]] const GridGraph& fine() const { return fine_; }
  /// fine(), rounded.
  [[nodiscard]] const PackedGraph& packed() const;
  /// Nodes that there is something to solve for.
  [[nodiscard]] std::size_t open() const;
  /// z = M r; vectors of fine().cells(), finite. r, 0 at nodes without edges, comes back as it was;
  /// what is in scratch is lost.
  /// Returns z · z and r · z.
  Products apply(ZeroedArray<float>& r, ZeroedArray<float>& z, ZeroedArray<float>& scratch);
  [[nodiscard]] int levels() const;

 private:
  struct Level;
  struct Coarsest;
  enum class Start { kZero, kLast };  ///< x of a level, or what it was left with.
  /// One cycle on the level's b from there; x is scale times what comes out.
  Products cycle(std::size_t level, Start start, float scale);
  GridGraph fine_;
  std::vector<Level> levels_;
  std::unique_ptr<Coarsest> coarsest_;
  RunOptions run_;
};

/// Solves A x = b from a start x: conjugate gradients in float on packed() within iterative
/// refinement, whose residuals are those of fine() in double, so that the result is as good as
/// double arithmetic makes it. Reports
/// what it reached; a stop request ends it early (converged = false).
SolveReport solve(Multigrid& system, const FewRows& b, ZeroedArray<double>& x,
                  const SolveOptions& options, const RunOptions& run);

}  // namespace nav::render::features
