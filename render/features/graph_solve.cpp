// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "nav/index.hpp"
#include "render/features/error_estimate.hpp"
#include "render/features/graph_rows.hpp"
#include "render/features/multigrid.hpp"

namespace nav::render::features {
namespace {

/// Conjugate gradients for corrections, with float vectors. Sums are in double, over whole planes
/// in order.
class Inner {
 public:
  Inner(Multigrid& system, const RunOptions& run)
      : system_(system), graph_(system.fine()), run_(run), planes_(as_size(graph_.size()[2])) {
    for (auto* v : {&r_, &z_, &p_, &ap_, &e_}) *v = ZeroedArray<float>(graph_.cells());
  }
  [[nodiscard]] ZeroedArray<float>& residual() { return r_; }
  [[nodiscard]] const ZeroedArray<float>& correction() const { return e_; }
  [[nodiscard]] double estimate() const { return estimate_; }
  /// Estimate before the iterations of the last run().
  [[nodiscard]] double start_estimate() const { return start_estimate_; }

  /// Iterates until the estimated error is below goal, or the residual is below kReduction of its
  /// start. Returns the number of iterations.
  int run(double goal, int most) {
    std::fill(e_.begin(), e_.end(), 0.0F);
    known_.restart();
    const double start = std::sqrt(dot(r_, r_));
    double rz = 0;
    int iteration = 0;
    bool solved = false;
    constexpr double kReduction = 1e-4;  // Below it, the rounding of the weights matters.
    while (iteration < most && !run_.stop.stop_requested()) {
      const auto [zz, rz_new] = system_.apply(r_, z_, ap_);
      if (run_.stop.stop_requested()) break;
      const bool direct = system_.levels() == 1;
      estimate_ = direct ? std::sqrt(zz) : known_.error(rz_new);
      if (!std::isfinite(first_estimate_)) first_estimate_ = estimate_;
      if (iteration == 0) start_estimate_ = estimate_;
      report_progress(goal);
      if (estimate_ <= goal) break;
      if (!(rz_new > 0)) break;
      advance_direction(iteration == 0 ? 0 : rz_new / rz);
      rz = rz_new;
      const auto [pp, pap] = multiply();
      if (!(pap > 0)) break;
      known_.add_step(rz, pap, pp);
      const double left = std::sqrt(step(static_cast<float>(rz / pap)));
      ++iteration;
      solved = left <= kReduction * start;
      if (solved) break;
    }
    // The solve may end before the estimate has enough steps, if only one or two directions have an
    // error.
    if (!std::isfinite(estimate_) && solved && !run_.stop.stop_requested()) {
      estimate_ = known_.error_of_few(system_.apply(r_, z_, ap_).rz);
    }
    return iteration;
  }

 private:
  template <class Work>
  double sum(const Work& work) {
    for_each_plane(graph_.size()[2], run_, [&](int k) {
      double plane = 0;
      for (int j = 0; j < graph_.size()[1]; ++j) plane += work(j, k, graph_.at(0, j, k));
      planes_[as_size(k)] = plane;
    });
    double total = 0;
    for (const double plane : planes_) total += plane;
    return total;
  }
  /// Errors fall by a constant factor per iteration, so progress is measured by their logarithm.
  void report_progress(double goal) const {
    if (!run_.progress || !std::isfinite(estimate_) || !(first_estimate_ > goal)) return;
    const double share = std::log(first_estimate_ / estimate_) / std::log(first_estimate_ / goal);
    run_.progress(std::clamp(share, 0.0, 1.0));
  }
  double dot(const ZeroedArray<float>& a, const ZeroedArray<float>& b) {
    return sum([&](int, int, std::size_t first) {
      return kernels().dot(&a[first], &b[first], graph_.row_length());
    });
  }
  void advance_direction(double beta) {
    const auto factor = static_cast<float>(beta);
    for_each_row(graph_, run_, [&](int, int, std::size_t first) {
      float* p = &p_[first];
      const float* z = &z_[first];
      for (std::size_t i = 0; i < as_size(graph_.row_length()); ++i) p[i] = z[i] + factor * p[i];
    });
  }
  /// Multiplies the direction by A; returns p · p and p · A p.
  Products multiply() {
    std::vector<Products> planes(planes_.size());
    for_each_row(graph_, run_, [&](int j, int k, std::size_t first) {
      planes[as_size(k)] += kernels().packed_laplacian(system_.packed().row(j, k), &p_[first],
                                                       &ap_[first], graph_.row_length());
    });
    return sum_of(planes);
  }
  double step(float alpha) {
    return sum([&](int, int, std::size_t first) {
      return kernels().step(alpha, &p_[first], &ap_[first], &e_[first], &r_[first],
                            graph_.row_length());
    });
  }

  Multigrid& system_;
  const GridGraph& graph_;
  const RunOptions& run_;
  std::vector<double> planes_;
  ZeroedArray<float> r_, z_, p_, e_;
  ZeroedArray<float> ap_;  ///< Free for other use while z_ is computed.
  ErrorEstimate known_;
  double estimate_ = std::numeric_limits<double>::infinity();
  double first_estimate_ = std::numeric_limits<double>::infinity();
  double start_estimate_ = std::numeric_limits<double>::infinity();
};

/// Computes r = b - A x in double and returns |r|. Nodes without edges have no residual.
double true_residual(const GridGraph& graph, const FewRows& b, const ZeroedArray<double>& x,
                     ZeroedArray<float>& r, const RunOptions& run) {
  std::vector<double> planes(as_size(graph.size()[2]));
  for_each_plane(graph.size()[2], run, [&](int k) {
    std::vector<double> ax(as_size(graph.row_length()));
    GridGraph::Scratch scratch;
    double plane = 0;
    for (int j = 0; j < graph.size()[1]; ++j) {
      const std::size_t first = graph.at(0, j, k);
      kernels().laplacian(graph.row(j, k, scratch), &x[first], ax.data(), graph.row_length());
      const float* right = b.row(j, k);
      for (std::size_t i = 0; i < as_size(graph.size()[0]); ++i) {
        const double left = static_cast<double>(right[i]) - ax[i];
        r[first + i] = static_cast<float>(left);
        plane += left * left;
      }
    }
    planes[as_size(k)] = plane;
  });
  double total = 0;
  for (const double plane : planes) total += plane;
  return std::sqrt(total);
}

}  // namespace

SolveReport solve(Multigrid& system, const FewRows& b, ZeroedArray<double>& x,
                  const SolveOptions& options, const RunOptions& run) {
  const GridGraph& graph = system.fine();
  SolveReport report;
  Inner inner(system, run);
  const double length = b.norm();
  const double scale = length > 0 ? length : 1;
  const double root = std::sqrt(static_cast<double>(std::max<std::size_t>(system.open(), 1)));
  bool settled = false;
  while (!settled) {
    report.relative_residual = true_residual(graph, b, x, inner.residual(), run) / scale;
    report.converged = report.relative_residual <= 1e-12;  // No open node, or already solved.
    if (report.converged || report.iterations >= options.max_iterations) break;
    // A goal slightly below the required error, so that the true residual rarely lies slightly
    // above it.
    constexpr double kMargin = 0.95;
    const double goal = (report.iterations == 0 ? kMargin : 1) * options.error * root;
    const int used = inner.run(goal, options.max_iterations - report.iterations);
    report.estimated_error = inner.estimate() / root;
    report.converged = report.estimated_error <= options.error;
    report.iterations += used;
    if (used == 0 || run.stop.stop_requested()) break;
    ++report.refinements;
    // Rounded weights leave about 1/256 of the error at the start of the run. If that is small
    // compared with the required error, a new residual would only confirm it.
    constexpr double kLittle = 16;
    if (report.converged && inner.start_estimate() <= kLittle * goal) settled = true;
    for_each_row(graph, run, [&](int, int, std::size_t first) {
      for (std::size_t i = first; i < first + as_size(graph.size()[0]); ++i) {
        x[i] += static_cast<double>(inner.correction()[i]);
      }
    });
  }
  return report;
}

}  // namespace nav::render::features
