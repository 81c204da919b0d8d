// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/observability.hpp"

#include <Eigen/Core>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "nav/check.hpp"
#include "nav/matrices.hpp"

namespace nav::registration {
namespace {

// A combination of unseen directions whose rotational part is less than this, for a unit vector,
// counts as a translation.
constexpr double kNoTurn = 0.05;

std::string text_of(const Eigen::Vector3d& v, int digits) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << '(';
  for (Eigen::Index i = 0; i < 3; ++i) {
    // Avoids "-0.00".
    const double unit = std::pow(10.0, digits);
    text << (i > 0 ? ", " : "") << std::round(v[i] * unit) / unit + 0.0;
  }
  text << ')';
  return text.str();
}

/// The vector with the sign that makes its largest component positive.
Eigen::Vector3d upright(Eigen::Vector3d v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  return v[largest] < 0 ? Eigen::Vector3d(-v) : v;
}

SlidingDirection translation(const Eigen::Vector3d& t) {
  SlidingDirection out{Vector6d::Zero(), ""};
  out.twist.tail<3>() = upright(t.normalized());
  out.description = "translation along Ct " + text_of(out.twist.tail<3>(), 2);
  return out;
}

SlidingDirection rotation(const Eigen::Vector3d& omega, const Eigen::Vector3d& t,
                          const Eigen::Vector3d& centre) {
  const Eigen::Vector3d axis = upright(omega.normalized());
  const Eigen::Vector3d through = centre + omega.cross(t) / omega.squaredNorm();
  const double pitch = omega.dot(t) / omega.squaredNorm();
  SlidingDirection out{Vector6d::Zero(), ""};
  out.twist << omega, t;
  out.twist.normalize();
  out.description =
      "rotation about Ct " + text_of(axis, 2) + " through " + text_of(through, 1) + " mm";
  // A screw motion that advances less than a millimetre per radian counts as a rotation.
  if (std::abs(pitch) > 1) {
    std::ostringstream text;
    text << ", advancing " << std::setprecision(3) << pitch << " mm per radian";
    out.description += text.str();
  }
  return out;
}

}  // namespace

Vector6d Observability::twist(Eigen::Index column) const {
  Vector6d out = directions.col(column);
  out.head<3>() /= lever_mm;
  return out;
}

Observability observability(const Matrix6d& curvature, double lever_mm, double least) {
  NAV_CHECK(lever_mm > 0, lever_mm);
  Vector6d scale = Vector6d::Ones();
  scale.head<3>() /= lever_mm;
  const Matrix6d scaled = scale.asDiagonal() * curvature * scale.asDiagonal();
  const auto eigen = eigenpairs<6>(0.5 * (scaled + scaled.transpose()));
  Observability out{eigen.values, eigen.vectors, lever_mm, 0};
  while (out.unseen < 6 && !(out.strengths[out.unseen] >= least)) ++out.unseen;
  return out;
}

std::vector<SlidingDirection> sliding_directions(const Observability& seen,
                                                 const Eigen::Vector3d& centre_ct_mm) {
  std::vector<SlidingDirection> out;
  if (seen.unseen == 0) return out;
  const Eigen::MatrixXd free = seen.directions.leftCols(seen.unseen);
  // Right singular vectors of the rotational part: combinations from most to least rotation.
  const Eigen::MatrixXd squares = free.topRows<3>().transpose() * free.topRows<3>();
  const Eigen::MatrixXd mixed =
      free * eigenpairs<Eigen::Dynamic>(squares).vectors.rowwise().reverse();
  const auto turns = [&](Eigen::Index i) { return mixed.col(i).head<3>().norm() > kNoTurn; };
  Eigen::Matrix3d shifts = Eigen::Matrix3d::Zero();  // Projection onto the free translations.
  for (Eigen::Index i = 0; i < seen.unseen; ++i) {
    if (turns(i)) continue;
    const Eigen::Vector3d t = mixed.col(i).tail<3>();
    shifts += t * t.transpose() / t.squaredNorm();
    out.push_back(translation(t));
  }
  for (Eigen::Index i = 0; i < seen.unseen; ++i) {
    if (!turns(i)) continue;
    const Eigen::Vector3d omega = mixed.col(i).head<3>() / seen.lever_mm;
    const Eigen::Vector3d t = mixed.col(i).tail<3>();
    out.push_back(rotation(omega, t - shifts * t, centre_ct_mm));
  }
  return out;
}

}  // namespace nav::registration
