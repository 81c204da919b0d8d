// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/multigrid.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "nav/index.hpp"
#include "render/features/graph_matrix.hpp"
#include "render/features/graph_rows.hpp"

namespace nav::render::features {
namespace {

/// The axis with the strongest coupling of neighbours, which is mostly that of the scan lines.
int line_axis(const PackedGraph& graph, const RunOptions& run) {
  const auto coupling = graph.coupling(run);
  int axis = 0;
  double strongest = -1;
  for (int a = 0; a < 3; ++a) {
    if (graph.size()[as_size(a)] == 1 || coupling[as_size(a)] <= strongest) continue;
    axis = a;
    strongest = coupling[as_size(a)];
  }
  return axis;
}

/// Boxes of 2 nodes across the lines, which are solved exactly; along the lines only if there is no
/// other axis.
std::array<int, 3> factors_of(const PackedGraph& graph, int axis) {
  std::array<int, 3> factor{1, 1, 1};
  bool across = false;
  for (int a = 0; a < 3; ++a) {
    if (a == axis || graph.size()[as_size(a)] == 1) continue;
    factor[as_size(a)] = 2;
    across = true;
  }
  if (!across) factor[as_size(axis)] = 2;
  return factor;
}

}  // namespace

struct Multigrid::Level {
  PackedGraph graph;
  int axis;  ///< Axis of the lines that smoothing solves exactly.
  /// Pivots of the factorisation of each line; 0 if there is nothing to solve.
  ZeroedArray<float> pivot;
  /// b is 0 at nodes with nothing to solve; x is not, until it is smoothed. The vectors of the
  /// first level are lent to it.
  ZeroedArray<float> x, b, smoothed;
  std::array<int, 3> factor;  ///< Reduction to the next level.

  Level(PackedGraph packed, const RunOptions& run)
      : graph(std::move(packed)),
        axis(line_axis(graph, run)),
        pivot(graph.cells()),
        factor(factors_of(graph, axis)) {
    for_each_plane(graph.size()[2], run, [&](int k) {
      for (int j = 0; j < graph.size()[1]; ++j) graph.degrees(j, k, &pivot[graph.at(0, j, k)]);
    });
    factorise(run);
  }

  void take_vectors() {
    for (auto* v : {&x, &b, &smoothed}) *v = ZeroedArray<float>(graph.cells());
  }

  /// Number of nodes in a box of the next level.
  [[nodiscard]] int nodes_of_box() const { return factor[0] * factor[1] * factor[2]; }

  /// Block Jacobi with whole lines has eigenvalues in (0, 2].
  static constexpr float kDamping = 0.9F;

  /// Smooths by one step from x = 0.
  void smooth_from_zero(const RunOptions& run) {
    for_each_slab(run, [&](const Slab& slab) {
      LineScratch& t = scratch(slab);
      for (int n = 0; n < slab.rows; ++n) std::copy_n(&b[slab.at(n)], length(), t.row(n));
      solve_lines(slab, t);
      for (int n = 0; n < slab.rows; ++n) {
        float* out = &x[slab.at(n)];
        const float* step = t.row(n);
        for (std::size_t i = 0; i < length(); ++i) out[i] = kDamping * step[i];
      }
    });
  }
  /// Smooths x by one step and multiplies the result by scale. Returns x · x and x · b.
  Products smooth(float scale, const RunOptions& run) {
    std::vector<Products> slabs(as_size(graph.size()[axis == 2 ? 1 : 2]));
    for_each_slab(run, [&](const Slab& slab) {
      LineScratch& t = scratch(slab);
      for (int n = 0; n < slab.rows; ++n) {
        residual(axis == 2 ? slab.number : n, axis == 2 ? n : slab.number, t.row(n));
      }
      solve_lines(slab, t);
      for (int n = 0; n < slab.rows; ++n) {
        const std::size_t first = slab.at(n);
        slabs[as_size(slab.number)] +=
            kernels().damped_step(&x[first], t.row(n), &pivot[first], &b[first], kDamping, scale,
                                  &smoothed[first], graph.row_length());
      }
    });
    x.swap(smoothed);
    return sum_of(slabs);
  }
  /// Sums the residual over the boxes of the next level.
  void restrict_to(Level& next, const RunOptions& run) {
    for_each_plane(next.graph.size()[2], run, [&](int bk) {
      std::vector<float> left(length() + kLanes);
      for (int bj = 0; bj < next.graph.size()[1]; ++bj) {
        float* box = &next.b[next.graph.at(0, bj, bk)];
        std::fill_n(box, next.graph.size()[0], 0.0F);
        for (int k = bk * factor[2]; k < std::min((bk + 1) * factor[2], graph.size()[2]); ++k) {
          for (int j = bj * factor[1]; j < std::min((bj + 1) * factor[1], graph.size()[1]); ++j) {
            residual(j, k, left.data());
            add_to_boxes(left.data(), next.graph.size()[0], box);
          }
        }
      }
    });
  }
  void add_from(const Level& next, const RunOptions& run) {
    for_each_plane(next.graph.size()[2], run, [&](int bk) {
      std::vector<float> there(length() + kLanes);
      for (int bj = 0; bj < next.graph.size()[1]; ++bj) {
        spread_boxes(&next.x[next.graph.at(0, bj, bk)], next.graph.size()[0], there.data());
        for (int k = bk * factor[2]; k < std::min((bk + 1) * factor[2], graph.size()[2]); ++k) {
          for (int j = bj * factor[1]; j < std::min((bj + 1) * factor[1], graph.size()[1]); ++j) {
            float* out = &x[graph.at(0, j, k)];
            for (std::size_t i = 0; i < as_size(graph.size()[0]); ++i) out[i] += there[i];
          }
        }
      }
    });
  }

 private:
  [[nodiscard]] std::size_t length() const { return as_size(graph.row_length()); }

  /// The rows that lines connect. They form a plane, so that the result of one step below is still
  /// in the cache when the next step reads it. Memory limits the speed of a cycle.
  struct Slab {
    int number, rows;
    std::size_t first, step;
    [[nodiscard]] std::size_t at(int n) const { return first + as_size(n) * step; }
  };
  /// Rows of a slab, with a border of zeros.
  struct LineScratch {
    std::size_t stride = 0;
    std::vector<float> values;
    float* row(int n) { return &values[as_size(n + 1) * stride + kLanes]; }
  };

  template <class Work>
  void for_each_slab(const RunOptions& run, const Work& work) const {
    const bool deep = axis == 2;
    for_each_plane(graph.size()[deep ? 1 : 2], run, [&](int number) {
      work(Slab{number, graph.size()[deep ? 2 : 1],
                deep ? graph.at(0, number, 0) : graph.at(0, 0, number),
                static_cast<std::size_t>(graph.offset(deep ? 2 : 1))});
    });
  }
  LineScratch& scratch(const Slab& slab) const {
    thread_local LineScratch lines;
    const std::size_t stride = length() + 2 * kLanes;
    const std::size_t size = stride * as_size(slab.rows + 2);
    if (lines.stride != stride || lines.values.size() != size) {
      lines.stride = stride;
      lines.values.assign(size, 0.0F);
    }
    return lines;
  }

  /// A row of b - A x; 0 where there is nothing to solve.
  void residual(int j, int k, float* out) const {
    const std::size_t first = graph.at(0, j, k);
    kernels().packed_residual(graph.row(j, k), &b[first], &x[first], out, graph.row_length());
  }
  /// Nodes after the end of the row have no residual.
  void add_to_boxes(const float* left, int boxes, float* box) const {
    for (std::size_t i = 0; i < as_size(boxes); ++i) {
      box[i] += factor[0] == 1 ? left[i] : left[2 * i] + left[2 * i + 1];
    }
  }
  void spread_boxes(const float* box, int boxes, float* out) const {
    for (std::size_t i = 0; i < as_size(boxes); ++i) {
      if (factor[0] == 1) {
        out[i] = box[i];
      } else {
        out[2 * i] = out[2 * i + 1] = box[i];
      }
    }
  }
  /// Turns degrees into pivots: 1 / (degree - w^2 pivot of the node before).
  void factorise(const RunOptions& run) {
    const auto back = static_cast<std::size_t>(graph.offset(axis));
    for_each_slab(run, [&](const Slab& slab) {
      for (int n = 0; n < slab.rows; ++n) {
        const std::uint16_t* edge = graph.edges(axis, slab.at(n) - back);
        float* p = &pivot[slab.at(n)];
        const float* before = p - back;
        for (std::size_t i = 0; i < length(); ++i) {
          const float w = unpacked_weight(edge[i]);
          p[i] = p[i] > 0 ? 1 / (p[i] - w * w * before[i]) : 0.0F;
        }
      }
    });
  }
  /// t = T^-1 t; T holds the degrees and the couplings along the lines.
  void solve_lines(const Slab& slab, LineScratch& t) const {
    const auto back = static_cast<std::size_t>(graph.offset(axis));
    for (int n = 0; n < slab.rows; ++n) {
      const std::uint16_t* w = graph.edges(axis, slab.at(n) - back);
      const float* p = &pivot[slab.at(n)];
      if (axis != 0) {
        kernels().line_forward(w, p, t.row(n - 1), t.row(n), graph.row_length());
        continue;
      }
      float* v = t.row(n);
      for (std::ptrdiff_t i = 0; i < graph.row_length(); ++i) {
        v[i] = (v[i] + unpacked_weight(w[i]) * v[i - 1]) * p[i];
      }
    }
    for (int n = slab.rows - 1; n >= 0; --n) {
      const std::uint16_t* w = graph.edges(axis, slab.at(n));
      const float* p = &pivot[slab.at(n)];
      if (axis != 0) {
        kernels().line_backward(w, p, t.row(n + 1), t.row(n), graph.row_length());
        continue;
      }
      float* v = t.row(n);
      for (std::ptrdiff_t i = graph.row_length() - 1; i >= 0; --i) {
        v[i] += p[i] * unpacked_weight(w[i]) * v[i + 1];
      }
    }
  }
};

/// The last level, solved directly.
struct Multigrid::Coarsest {
  explicit Coarsest(const PackedGraph& graph) {
    // A tiny excess on the diagonal keeps parts without a fixed value solvable.
    const auto weight = [&](int e, std::size_t node) {
      return unpacked_weight(*graph.edges(e, node));
    };
    GraphMatrix system = matrix_of(graph, graph.leak(), weight, 1e-9);
    nodes = std::move(system.nodes);
    factors.compute(system.matrix);
    NAV_CHECK(factors.info() == Eigen::Success, nodes.size());
  }
  void solve(const ZeroedArray<float>& b, ZeroedArray<float>& x) const {
    Eigen::VectorXd right(static_cast<Eigen::Index>(nodes.size()));
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      right[static_cast<Eigen::Index>(n)] = static_cast<double>(b[nodes[n]]);
    }
    const Eigen::VectorXd solved = factors.solve(right);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      x[nodes[n]] = static_cast<float>(solved[static_cast<Eigen::Index>(n)]);
    }
  }
  std::vector<std::size_t> nodes;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors;
};

Multigrid::Multigrid(GridGraph fine, const RunOptions& run) : fine_(std::move(fine)), run_(run) {
  constexpr double kDirectNodes = 1500;
  levels_.emplace_back(PackedGraph(fine_, run_), run_);
  while (true) {
    if (run_.stop.stop_requested()) return;
    const Level& last = levels_.back();
    const auto& size = last.graph.size();
    if (static_cast<double>(size[0]) * size[1] * size[2] <= kDirectNodes) break;
    levels_.emplace_back(last.graph.coarse(last.factor, run_), run_);
    levels_.back().take_vectors();
  }
  coarsest_ = std::make_unique<Coarsest>(levels_.back().graph);
}
Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;
Multigrid& Multigrid::operator=(Multigrid&&) noexcept = default;

const PackedGraph& Multigrid::packed() const { return levels_.front().graph; }
std::size_t Multigrid::open() const {
  const auto& pivot = levels_.front().pivot;
  return static_cast<std::size_t>(
      std::count_if(pivot.begin(), pivot.end(), [](float p) { return p > 0; }));
}
int Multigrid::levels() const { return static_cast<int>(levels_.size()); }

/// A coarse level answers with two cycles, and the answer of the first is doubled. A part of the
/// error that one cycle reduces to 1 - l of itself is then reduced to (1 - 2 l)(1 - l). This lies
/// between -1/8 and 1 for l in (0, 9/8], so the level above has its l in (0, 9/8] again, and all
/// levels stay positive (Axelsson and Vassilevski 1989). Below the second coarse level this changes
/// little. In volumes of one slice, whose levels shrink only by halves, it would take as long as it
/// saves.
constexpr std::size_t kAnsweredTwice = 2;
constexpr float kFirstAnswer = 2.0F;

Products Multigrid::cycle(std::size_t number, Start start, float scale) {
  Level& level = levels_[number];
  if (number + 1 == levels_.size()) {
    coarsest_->solve(level.b, level.x);
    return {};
  }
  Level& next = levels_[number + 1];
  if (start == Start::kZero) {
    level.smooth_from_zero(run_);
  } else {
    level.smooth(1, run_);
  }
  level.restrict_to(next, run_);
  const bool twice =
      number < kAnsweredTwice && number + 2 < levels_.size() && level.nodes_of_box() >= 4;
  cycle(number + 1, Start::kZero, twice ? kFirstAnswer : 1);
  if (twice) cycle(number + 1, Start::kLast, 1);
  level.add_from(next, run_);
  return level.smooth(scale, run_);
}

Products Multigrid::apply(ZeroedArray<float>& r, ZeroedArray<float>& z,
                          ZeroedArray<float>& scratch) {
  Level& top = levels_.front();
  top.b.swap(r);
  top.x.swap(scratch);
  top.smoothed.swap(z);
  Products sum = cycle(0, Start::kZero, 1);
  if (levels_.size() == 1) {
    const int count = static_cast<int>(top.x.size()) / kLanes * kLanes;
    sum = {kernels().dot(top.x.data(), top.x.data(), count),
           kernels().dot(top.x.data(), top.b.data(), count)};
  }
  top.b.swap(r);
  top.x.swap(z);
  top.smoothed.swap(scratch);
  return sum;
}

}  // namespace nav::render::features
