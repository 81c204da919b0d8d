// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "render/features/packed_graph.hpp"

namespace nav::render::features {

struct SolveOptions {
  /// Root mean square of the estimated error at which the solve stops, in units of x, (0, 0.01].
  /// The estimate (ErrorEstimate) is within a factor of 3 of the true error. Residuals themselves
  /// say little if edges differ by factors of 10^5. Above 0.01 the first iterations know too little
  /// for an estimate.
  double error = 4e-3;
  int max_iterations = 200;  ///< Number of iterations of the inner solver, for all refinements
                             ///< together.
};

/// Approximate inverse of a graph's matrix: one multigrid cycle. Its coarse nodes are boxes of two
/// nodes across the scan lines. It visits the first two coarse levels twice. Its smoothing solves
/// whole lines exactly, along the axis of the strongest coupling. It solves the last level
/// directly. Weights have 16 bits, because memory limits its speed. The inverse is symmetric and
/// positive, so that conjugate gradients can use it. The result has the same bytes for any number
/// of threads. After a stop request the results are invalid.
class Multigrid {
 public:
  Multigrid(GridGraph fine, const RunOptions& run);
  ~Multigrid();
  Multigrid(Multigrid&&) noexcept;
  Multigrid& operator=(Multigrid&&) noexcept;

  [[nodiscard]] const GridGraph& fine() const { return fine_; }
  /// fine() with rounded weights.
  [[nodiscard]] const PackedGraph& packed() const;
  /// Number of nodes with an unknown value.
  [[nodiscard]] std::size_t open() const;
  /// Computes z = M r. Vectors have fine().cells() finite values. r must be 0 at nodes without
  /// edges and is unchanged afterwards; the content of scratch is lost. Returns z · z and r · z.
  Products apply(ZeroedArray<float>& r, ZeroedArray<float>& z, ZeroedArray<float>& scratch);
  [[nodiscard]] int levels() const;

 private:
  struct Level;
  struct Coarsest;
  enum class Start { kZero, kLast };  ///< Start of a cycle: x = 0, or the last x of the level.
  /// Runs one cycle on the level's b from that start. x becomes scale times the result.
  Products cycle(std::size_t level, Start start, float scale);
  GridGraph fine_;
  std::vector<Level> levels_;
  std::unique_ptr<Coarsest> coarsest_;
  RunOptions run_;
};

/// Solves A x = b from a start x. Conjugate gradients in float on packed() run inside an iterative
/// refinement, whose residuals are those of fine() in double. So the result is as good as double
/// arithmetic makes it. Reports the achieved accuracy. A stop request ends it early with
/// converged = false.
SolveReport solve(Multigrid& system, const FewRows& b, ZeroedArray<double>& x,
                  const SolveOptions& options, const RunOptions& run);

}  // namespace nav::render::features
