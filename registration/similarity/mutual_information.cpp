// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/mutual_information.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace nav::registration {
namespace {

constexpr int kGreyBins = 24;
constexpr int kCtBins = 24;
// f of CtChannels: clamp(HU, −150, 250)/100. Two bins beyond each end hold the window.
constexpr double kLowest = -1.5;
constexpr double kHighest = 2.5;
constexpr int kRim = 2;
constexpr double kBinsPerUnit = (kCtBins - 2 * kRim - 1) / (kHighest - kLowest);

/// Cubic B-spline weights of the four bins from floor(x) − 1 on, and their slopes by x.
struct Window {
  int first;
  std::array<double, 4> weight, slope;
};

Window window_at(double f) {
  const double x = (std::clamp(f, kLowest, kHighest) - kLowest) * kBinsPerUnit + kRim;
  const int whole = std::min(static_cast<int>(x), kCtBins - kRim - 1);
  const double t = x - whole;
  const double s = 1 - t;
  Window w{whole - 1, {}, {}};
  w.weight = {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6,
              (4 - 6 * s * s + 3 * s * s * s) / 6, t * t * t / 6};
  w.slope = {-s * s / 2, (-12 * t + 9 * t * t) / 6, (12 * s - 9 * s * s) / 6, t * t / 2};
  return w;
}

/// A sample of a patch that is finite in the CT.
struct Sample {
  std::size_t patch;
  int grey_bin;
  double weight;
  Window window;
  Vector6d motion;  ///< Derivative of f by a twist about the centre, Grid.
};

using Table = std::array<double, static_cast<std::size_t>(kGreyBins) * kCtBins>;

std::size_t cell(int grey, int ct) { return static_cast<std::size_t>(grey * kCtBins + ct); }

class Histogram {
 public:
  Histogram(const CtChannels& ct, const PatchSet& patches, const Pose& pose,
            const Eigen::Vector3d* centre_ct_mm)
      : patches_(patches) {
    const GridPose placed_at = grid_pose(ct, pose);
    const bool slopes = centre_ct_mm != nullptr;
    const Eigen::Vector3d centre = slopes ? ct.grid_of(*centre_ct_mm) : Eigen::Vector3d::Zero();
    const std::size_t n =
        static_cast<std::size_t>(patches.side) * static_cast<std::size_t>(patches.side);
    std::vector<float> f(n);
    std::vector<Eigen::Vector3f> df(slopes ? n : 0);
    samples_.reserve(patches.patches.size() * n);
    for (std::size_t i = 0; i < patches.patches.size(); ++i) {
      const PlacedPatch placed = place(patches, i, placed_at);
      if (!patch_intensities(ct, placed, f, df)) {
        ++non_finite_;
        continue;
      }
      add_patch(i, placed, f, df, centre);
    }
    fill();
  }

  [[nodiscard]] CostTerms cost() const {
    CostTerms terms;
    terms.cost = 1;
    terms.non_finite = non_finite_;
    if (!(grey_entropy_ > 0)) return terms;
    double information = 0;
    for (int i = 0; i < kGreyBins; ++i) {
      for (int j = 0; j < kCtBins; ++j) {
        const double p = joint_[cell(i, j)];
        if (p > 0) {
          information +=
              p *
              std::log(p / (grey_[static_cast<std::size_t>(i)] * ct_[static_cast<std::size_t>(j)]));
        }
      }
    }
    terms.cost = std::clamp(1 - information / grey_entropy_, 0.0, 1.0);
    return terms;
  }

  void differentiate(CostTerms& terms, std::vector<Vector6d>* by_patch) const {
    if (!(grey_entropy_ > 0)) return;
    std::vector<Vector6d> by_cell(joint_.size(), Vector6d::Zero());
    for (const Sample& sample : samples_) {
      double pull = 0;
      for (std::size_t b = 0; b < 4; ++b) {
        const int j = sample.window.first + static_cast<int>(b);
        const double p = joint_[cell(sample.grey_bin, j)];
        const double share = sample.weight * sample.window.slope[b] * kBinsPerUnit;
        by_cell[cell(sample.grey_bin, j)] += share * sample.motion;
        if (p > 0) pull += share * std::log(p / ct_[static_cast<std::size_t>(j)]);
      }
      const Vector6d g = -0.5 / grey_entropy_ * pull * sample.motion;
      terms.gradient += g;
      if (by_patch != nullptr) (*by_patch)[sample.patch] += g;
    }
    for (int i = 0; i < kGreyBins; ++i) {
      for (int j = 0; j < kCtBins; ++j) {
        const double p = joint_[cell(i, j)];
        if (!(p > 0)) continue;
        const double curvature = 1 / p - 1 / ct_[static_cast<std::size_t>(j)];
        const Vector6d& d = by_cell[cell(i, j)];
        terms.hessian += 0.5 / grey_entropy_ * std::max(curvature, 0.0) * d * d.transpose();
      }
    }
  }

 private:
  void add_patch(std::size_t index, const PlacedPatch& placed, const std::vector<float>& f,
                 const std::vector<Eigen::Vector3f>& df, const Eigen::Vector3d& centre) {
    const Patch& patch = patches_.patches[index];
    const int half = (placed.side - 1) / 2;
    std::size_t k = 0;
    for (int b = -half; b <= half; ++b) {
      for (int a = -half; a <= half; ++a, ++k) {
        const double grey = patch.mean_grey + patch.norm_grey * static_cast<double>(placed.u[k]);
        Sample sample{
            .patch = index,
            .grey_bin = std::clamp(static_cast<int>(grey * kGreyBins / 256.0), 0, kGreyBins - 1),
            .weight = patch.weight / static_cast<double>(f.size()),
            .window = window_at(f[k]),
            .motion = Vector6d::Zero()};
        if (!df.empty() && f[k] > kLowest && f[k] < kHighest) {
          const Eigen::Vector3d slope = df[k].cast<double>();
          const Eigen::Vector3d r = placed.centre + a * placed.step_a + b * placed.step_b - centre;
          sample.motion << r.cross(slope), slope;
        }
        samples_.push_back(sample);
      }
    }
  }

  void fill() {
    double total = 0;
    for (const Sample& sample : samples_) total += sample.weight;
    if (!(total > 0)) return;
    for (Sample& sample : samples_) {
      sample.weight /= total;
      for (std::size_t b = 0; b < 4; ++b) {
        const int j = sample.window.first + static_cast<int>(b);
        const double share = sample.weight * sample.window.weight[b];
        joint_[cell(sample.grey_bin, j)] += share;
        ct_[static_cast<std::size_t>(j)] += share;
      }
      grey_[static_cast<std::size_t>(sample.grey_bin)] += sample.weight;
    }
    for (const double p : grey_) grey_entropy_ -= p > 0 ? p * std::log(p) : 0;
    // A single grey has zero entropy, apart from the rounding of the weights' sum.
    constexpr double kLeastEntropy = 1e-9;
    if (grey_entropy_ < kLeastEntropy) grey_entropy_ = 0;
  }

  const PatchSet& patches_;
  std::vector<Sample> samples_;
  Table joint_{};
  std::array<double, kGreyBins> grey_{};
  std::array<double, kCtBins> ct_{};
  double grey_entropy_ = 0;
  int non_finite_ = 0;
};

}  // namespace

CostTerms mutual_information(const CtChannels& ct, const PatchSet& patches, const Pose& pose) {
  return Histogram(ct, patches, pose, nullptr).cost();
}

CostTerms mutual_information_terms(const CtChannels& ct, const PatchSet& patches, const Pose& pose,
                                   const Eigen::Vector3d& centre_ct_mm, bool keep_patch_gradients) {
  const Histogram histogram(ct, patches, pose, &centre_ct_mm);
  CostTerms terms = histogram.cost();
  if (keep_patch_gradients) terms.patch_gradients.assign(patches.patches.size(), Vector6d::Zero());
  histogram.differentiate(terms, keep_patch_gradients ? &terms.patch_gradients : nullptr);
  const Matrix6d to_grid = grid_from_ct(ct);
  terms.gradient = to_grid.transpose() * terms.gradient;
  terms.hessian = to_grid.transpose() * terms.hessian * to_grid;
  for (Vector6d& g : terms.patch_gradients) g = to_grid.transpose() * g;
  return terms;
}

}  // namespace nav::registration
