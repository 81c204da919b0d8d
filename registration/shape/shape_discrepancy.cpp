// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_discrepancy.hpp"

#include <array>
#include <cmath>
#include <map>

namespace nav::registration {
namespace {

constexpr double kNeighbourMm = 15;
constexpr double kStandardErrors = 2;
constexpr std::array<double, 3> kBlocksMm{20, 40, 80};
// Fewer blocks do not show their spread.
constexpr std::size_t kLeastBlocks = 8;

using Cell = std::array<int, 3>;

Cell cell_of(const Eigen::Vector3d& p, double side_mm) {
  const Eigen::Array3d at = (p / side_mm).array().floor();
  return {static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2])};
}

struct Cluster {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares = 0;
  int count = 0;
};

Matrix6d block_scatter(const std::vector<Eigen::Vector3d>& places,
                       const std::vector<Vector6d>& scores, const Eigen::Vector3d& centre,
                       double side_mm, std::size_t& count) {
  std::map<Cell, Vector6d> blocks;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Cell cell = cell_of(places[k] - centre, side_mm);
    blocks.try_emplace(cell, Vector6d::Zero()).first->second += scores[k];
  }
  Matrix6d scatter = Matrix6d::Zero();
  for (const auto& [cell, g] : blocks) scatter += g * g.transpose();
  count = blocks.size();
  const auto n = static_cast<double>(count);
  // A few blocks hardly show their spread: scale it up to be careful.
  return scatter * (n > 7 ? n / (n - 6) : n);
}

}  // namespace

double shape_discrepancy_mm(const std::vector<Eigen::Vector3d>& places_ct_mm,
                            const std::vector<Eigen::Vector3d>& offsets_mm, ShapeKind kind) {
  std::map<Cell, Cluster> clusters;
  double squares = 0;
  for (std::size_t k = 0; k < places_ct_mm.size(); ++k) {
    Cluster& cluster = clusters[cell_of(places_ct_mm[k], kNeighbourMm)];
    cluster.sum += offsets_mm[k];
    cluster.squares += offsets_mm[k].squaredNorm();
    ++cluster.count;
    squares += offsets_mm[k].squaredNorm() / static_cast<double>(places_ct_mm.size());
  }
  double products = 0;
  double pairs = 0;
  for (const auto& [cell, cluster] : clusters) {
    products += cluster.sum.squaredNorm() - cluster.squares;
    pairs += static_cast<double>(cluster.count) * (cluster.count - 1);
  }
  if (pairs < 2) return 0;
  // Number of axes that the offsets show: one across a surface, two across a line.
  const double axes = kind == ShapeKind::kSurface ? 1 : 2;
  const double covariance = products / pairs / axes;
  const double standard_error = squares / axes * std::sqrt(2 / (pairs * axes));
  return covariance > kStandardErrors * standard_error ? std::sqrt(covariance) : 0;
}

Matrix6d widest_block_scatter(const std::vector<Eigen::Vector3d>& places_ct_mm,
                              const std::vector<Vector6d>& scores,
                              const Eigen::Vector3d& centre_ct_mm, const Matrix6d& inverse,
                              double lever_mm) {
  Vector6d scale = Vector6d::Ones();
  scale.head<3>() *= lever_mm;
  const Matrix6d to_mm = scale.asDiagonal() * inverse;
  Matrix6d widest = Matrix6d::Zero();
  double largest = -1;
  for (const double side_mm : kBlocksMm) {
    std::size_t count = 0;
    const Matrix6d scatter = block_scatter(places_ct_mm, scores, centre_ct_mm, side_mm, count);
    const double size = (to_mm * scatter * to_mm.transpose()).trace();
    if (size <= largest || (largest >= 0 && count < kLeastBlocks)) continue;
    largest = size;
    widest = scatter;
  }
  return widest;
}

}  // namespace nav::registration
