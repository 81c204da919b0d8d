// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/misfit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/of_values.hpp"
#include "registration/patches.hpp"
#include "registration/pose_solver.hpp"
#include "registration/sandwich.hpp"

namespace nav::registration {
namespace {

using Eigen::Index;

constexpr double kCubeMm = 20;
constexpr std::size_t kLeastClusters = 12;
constexpr double kNoiseShare = 3;
// Curvature by a millimetre that a cause moves the patches, over that by a shift of the pose: less
// rests on noise.
constexpr double kLeastCurvature = 0.02;
// Of what a cause moves: less is what a pose takes up.
constexpr double kLeastNet = 1e-6;
// Motion is followed by shifts at moments so far apart, between which it is linear.
constexpr double kMomentsS = 1;
constexpr int kMostMoments = 17;
constexpr int kPicturesPerMoment = 2;
constexpr int kCubesPerMoment = 6;
constexpr double kPolynomialMm = 60;

/// A patch as every cause sees it, in scaled parameters about the shape's centre.
struct Witness {
  const Patch* patch;
  const PictureMotion* motion;
  Eigen::Vector3d from_centre;  ///< Ct, mm.
  std::array<int, 3> cube;
  Vector6d gradient;
  Matrix6d hessian;  ///< True on the whole.
};

struct Witnesses {
  Eigen::Matrix3d rotation;  ///< Ct from Reference.
  Eigen::Vector3d centre_reference_mm;
  std::vector<Witness> all;
  Matrix6d hessian;  ///< Of all.
};

/// How L numbers of a cause move a patch: columns of twists about its middle, Reference,
/// [rad | mm], for one of each number; which numbers of all.
template <int L>
struct Chain {
  Eigen::Matrix<double, 6, L> twists = Eigen::Matrix<double, 6, L>::Zero();
  Index first = 0;
};

/// The linear system of one cause.
struct System {
  Eigen::MatrixXd hessian, cross;  ///< n × n; 6 × n with the pose.
  Eigen::VectorXd gradient;
  Eigen::MatrixXd moves, moves_pose;  ///< Mean DᵀD of displacements, n × n; and with the pose's.
  Matrix6d pose_moves = Matrix6d::Zero();
};

/// Displacement of a patch's middle by scaled parameters of the pose.
Eigen::Matrix<double, 3, 6> by_pose(const Witness& witness) {
  Eigen::Matrix<double, 3, 6> out;
  out.leftCols<3>() = -cross_matrix(witness.from_centre) / kRotationScaleMm;
  out.rightCols<3>().setIdentity();
  return out;
}

/// A chain in Ct as scaled parameters about the common centre.
template <int L>
Eigen::Matrix<double, 6, L> about_centre(const Chain<L>& chain, const Witnesses& witnesses,
                                         const Witness& witness) {
  Eigen::Matrix<double, 6, L> out;
  const Eigen::Matrix<double, 3, L> turns = witnesses.rotation * chain.twists.template topRows<3>();
  out.template topRows<3>() = kRotationScaleMm * turns;
  out.template bottomRows<3>() = witnesses.rotation * chain.twists.template bottomRows<3>() +
                                 cross_matrix(witness.from_centre) * turns;
  return out;
}

template <int L, class ChainOf>
System system_of(const Witnesses& witnesses, Index count, const ChainOf& chain_of) {
  System out{Eigen::MatrixXd::Zero(count, count), Eigen::MatrixXd::Zero(6, count),
             Eigen::VectorXd::Zero(count), Eigen::MatrixXd::Zero(count, count),
             Eigen::MatrixXd::Zero(count, 6)};
  const double share = 1 / static_cast<double>(witnesses.all.size());
  for (const Witness& witness : witnesses.all) {
    const Chain<L> chain = chain_of(witness);
    const Eigen::Matrix<double, 6, L> c = about_centre(chain, witnesses, witness);
    const Eigen::Matrix<double, 6, L> hc = witness.hessian * c;
    const Eigen::Matrix<double, 3, L> d =
        witnesses.rotation * chain.twists.template bottomRows<3>();
    const Eigen::Matrix<double, 3, 6> j = by_pose(witness);
    out.hessian.template block<L, L>(chain.first, chain.first) += c.transpose() * hc;
    out.cross.template middleCols<L>(chain.first) += hc;
    out.gradient.template segment<L>(chain.first) += c.transpose() * witness.gradient;
    out.moves.template block<L, L>(chain.first, chain.first) += share * d.transpose() * d;
    out.moves_pose.template middleRows<L>(chain.first) += share * d.transpose() * j;
    out.pose_moves += share * j.transpose() * j;
  }
  return out;
}

/// The inverse of a symmetric matrix in the directions whose values are at least so large, and how
/// many these are.
std::pair<Eigen::MatrixXd, Index> inverse_above(const Eigen::MatrixXd& m, double least) {
  const auto pairs = eigenpairs<Eigen::Dynamic>(m);
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(m.rows());
  Index kept = 0;
  for (Index i = 0; i < m.rows(); ++i) {
    if (!(pairs.values[i] >= least)) continue;
    inverse[i] = 1 / pairs.values[i];
    ++kept;
  }
  return {pairs.vectors * inverse.asDiagonal() * pairs.vectors.transpose(), kept};
}

/// Joint step and its noise of a cause with count numbers, L of which move any one patch.
template <int L, class ChainOf>
Misfit fit(MisfitCause cause, const Witnesses& witnesses, Index count, const ChainOf& chain_of,
           bool with_values) {
  Misfit out{cause};
  const System system = system_of<L>(witnesses, count, chain_of);
  // With the pose found anew for each: P of its scaled parameters are given up for one number.
  const Eigen::LLT<Matrix6d> pose(witnesses.hessian);
  const Eigen::MatrixXd given_up = pose.solve(system.cross);
  const Eigen::MatrixXd crossed = system.moves_pose * given_up;
  Eigen::MatrixXd moves = system.moves - crossed - crossed.transpose() +
                          given_up.transpose() * system.pose_moves * given_up;
  Eigen::VectorXd scale(count);  // Numbers for a millimetre.
  for (Index i = 0; i < count; ++i) {
    const bool net = moves(i, i) > kLeastNet * system.moves(i, i);
    scale[i] = net ? 1 / std::sqrt(moves(i, i)) : 0;
  }
  const Eigen::MatrixXd curvature = scale.asDiagonal() *
                                    (system.hessian - system.cross.transpose() * given_up) *
                                    scale.asDiagonal();
  moves = scale.asDiagonal() * moves * scale.asDiagonal();
  const double by_shift = witnesses.hessian.bottomRightCorner<3, 3>().trace() / 3;
  const auto [inverse, kept] = inverse_above(curvature, kLeastCurvature * by_shift);
  if (kept == 0) return out;
  Vector6d pull = Vector6d::Zero();
  for (const Witness& witness : witnesses.all) pull += witness.gradient;
  const Eigen::VectorXd score = scale.cwiseProduct(system.gradient - given_up.transpose() * pull);
  const Eigen::VectorXd step = -(inverse * score);
  const Eigen::VectorXd numbers = scale.cwiseProduct(step);
  const Vector6d pose_step = given_up * numbers;
  // What of the gradients is left after the step, by clusters.
  struct Cluster {
    Eigen::VectorXd numbers;
    Vector6d pose;
  };
  std::map<std::array<int, 3>, Cluster> clusters;
  for (const Witness& witness : witnesses.all) {
    const Chain<L> chain = chain_of(witness);
    const Eigen::Matrix<double, 6, L> c = about_centre(chain, witnesses, witness);
    const Vector6d moved = c * numbers.template segment<L>(chain.first) - pose_step;
    const Vector6d left = witness.gradient + witness.hessian * moved;
    const auto [at, fresh] =
        clusters.try_emplace(witness.cube, Cluster{Eigen::VectorXd::Zero(count), Vector6d::Zero()});
    at->second.numbers.template segment<L>(chain.first) += c.transpose() * left;
    at->second.pose += left;
  }
  if (clusters.size() < kLeastClusters) return out;
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(count, count);
  for (const auto& [key, cluster] : clusters) {
    const Eigen::VectorXd left =
        scale.cwiseProduct(cluster.numbers - given_up.transpose() * cluster.pose);
    scatter += left * left.transpose();
  }
  const auto n = static_cast<double>(clusters.size());
  scatter *= n / (n - std::min(static_cast<double>(kept) + 6, n / 2));
  const Eigen::MatrixXd covariance = inverse * scatter * inverse;
  out.found_mm = square_root(step.dot(moves * step));
  out.noise_mm = square_root((moves * covariance).trace());
  out.gain = -score.dot(step);
  if (with_values) out.values.assign(numbers.begin(), numbers.end());
  return out;
}

Chain<1> delay_of(const Witness& witness) {
  const PictureMotion& motion = *witness.motion;
  Chain<1> chain;
  const Eigen::Vector3d from_middle = witness.patch->centre_mm - motion.middle_mm;
  chain.twists << motion.turn_rad_s, motion.velocity_mm_s + motion.turn_rad_s.cross(from_middle);
  return chain;
}

Chain<2> pixel_size_of(const Witness& witness) {
  const Patch& patch = *witness.patch;
  const Eigen::Vector3d across = witness.motion->axes.col(0);
  Chain<2> chain;
  chain.twists.col(0).tail<3>() = patch.depth_mm * patch.beam;
  chain.twists.col(1).tail<3>() = across.dot(patch.centre_mm - witness.motion->middle_mm) * across;
  return chain;
}

Chain<6> calibration_of(const Witness& witness) {
  const PictureMotion& motion = *witness.motion;
  Chain<6> chain;
  chain.twists.topLeftCorner<3, 3>() = motion.axes;
  chain.twists.bottomRightCorner<3, 3>() = motion.axes;
  chain.twists.bottomLeftCorner<3, 3>() =
      -cross_matrix(witness.patch->centre_mm - motion.middle_mm) * motion.axes;
  return chain;
}

/// Shifts at moments evenly over the sweep.
Chain<6> motion_of(const Witness& witness, double first_s, double last_s, int moments) {
  const double at = (witness.motion->time_s - first_s) / (last_s - first_s) * (moments - 1);
  Chain<6> chain;
  const int before = std::clamp(static_cast<int>(at), 0, moments - 2);
  chain.first = 3 * before;
  const double share = at - before;
  chain.twists.bottomLeftCorner<3, 3>().diagonal().setConstant(1 - share);
  chain.twists.bottomRightCorner<3, 3>().diagonal().setConstant(share);
  return chain;
}

/// Six strains and a shift for each of six products of coordinates.
Chain<24> bend_of(const Witness& witness, const Eigen::Vector3d& centre_mm) {
  const Eigen::Vector3d r = (witness.patch->centre_mm - centre_mm) / kPolynomialMm;
  const std::array<double, 6> products{r.x() * r.x(), r.y() * r.y(), r.z() * r.z(),
                                       r.x() * r.y(), r.y() * r.z(), r.z() * r.x()};
  Chain<24> chain;
  chain.twists.bottomLeftCorner<3, 6>() << r.x(), 0, 0, r.y(), r.z(), 0,  //
      0, r.y(), 0, r.x(), 0, r.z(),                                       //
      0, 0, r.z(), 0, r.x(), r.y();
  for (int i = 0; i < 6; ++i) {
    chain.twists.block<3, 3>(3, 6 + 3 * i).diagonal().setConstant(products[as_size(i)]);
  }
  return chain;
}

/// Moments that the pictures with patches tell apart; 0 where those are too few.
int moments_of(const Witnesses& witnesses, double seconds) {
  std::set<double> times;
  std::set<std::array<int, 3>> cubes;
  for (const Witness& witness : witnesses.all) {
    times.insert(witness.motion->time_s);
    cubes.insert(witness.cube);
  }
  const int by_time = 1 + static_cast<int>(std::lround(std::min(seconds / kMomentsS, 1e3)));
  const int by_pictures = static_cast<int>(times.size()) / kPicturesPerMoment;
  const int by_cubes = static_cast<int>(cubes.size()) / kCubesPerMoment;
  const int moments = std::min({std::max(by_time, 4), by_pictures, by_cubes, kMostMoments});
  return moments >= 3 ? moments : 0;
}

Witnesses witnesses_of(const LocalShape& shape, const PatchSet& patches, const Pose& pose,
                       std::span<const PictureMotion> motions) {
  Witnesses out{
      pose.rotation().toRotationMatrix(), (pose.inverse() * shape.centre_ct).mm, {}, shape.hessian};
  const Matrix6d scale = twist_from_scaled();
  Matrix6d sum = Matrix6d::Zero();
  for (const Matrix6d& hessian : shape.patch_hessians) sum += hessian;
  const Matrix6d softer = turning_into(shape.hessian, scale * sum * scale) * scale;
  for (std::size_t i = 0; i < shape.patch_hessians.size(); ++i) {
    const Patch& patch = patches.patches[i];
    NAV_CHECK(as_size(patch.frame) < motions.size(), patch.frame);
    const Eigen::Vector3d r =
        (pose * Point<frames::Reference>{patch.centre_mm} - shape.centre_ct).v;
    const Eigen::Array3d cell = (r / kCubeMm).array().floor();
    out.all.push_back(
        {&patch,
         &motions[as_size(patch.frame)],
         r,
         {static_cast<int>(cell[0]), static_cast<int>(cell[1]), static_cast<int>(cell[2])},
         shape.patch_gradients[i],
         softer * shape.patch_hessians[i] * softer.transpose()});
  }
  return out;
}

}  // namespace

const char* to_string(MisfitCause cause) {
  switch (cause) {
    case MisfitCause::kDelay:
      return "delay";
    case MisfitCause::kPixelSize:
      return "pixel_size";
    case MisfitCause::kCalibration:
      return "calibration";
    case MisfitCause::kMotion:
      return "motion";
    case MisfitCause::kBend:
      return "bend";
  }
  return "bend";
}

double Misfit::excess_mm() const {
  return square_root(found_mm * found_mm - kNoiseShare * noise_mm * noise_mm);
}

std::vector<Misfit> find_misfits(const LocalShape& shape, const PatchSet& patches, const Pose& pose,
                                 std::span<const PictureMotion> motions) {
  if (shape.patch_hessians.empty() || !curvature_fault(shape.hessian).empty()) return {};
  const Witnesses witnesses = witnesses_of(shape, patches, pose, motions);
  std::vector<Misfit> out;
  out.push_back(fit<1>(MisfitCause::kDelay, witnesses, 1, delay_of, true));
  out.push_back(fit<2>(MisfitCause::kPixelSize, witnesses, 2, pixel_size_of, true));
  out.push_back(fit<6>(MisfitCause::kCalibration, witnesses, 6, calibration_of, true));
  const double first_s = motions.front().time_s;
  const double last_s = motions.back().time_s;
  if (const int moments = moments_of(witnesses, last_s - first_s); moments > 0) {
    const auto motion = [&](const Witness& witness) {
      return motion_of(witness, first_s, last_s, moments);
    };
    out.push_back(fit<6>(MisfitCause::kMotion, witnesses, 3 * moments, motion, false));
  }
  const auto bend = [&](const Witness& witness) {
    return bend_of(witness, witnesses.centre_reference_mm);
  };
  out.push_back(fit<24>(MisfitCause::kBend, witnesses, 24, bend, false));
  return out;
}

std::string in_words(const Misfit& misfit) {
  const std::vector<double>& values = misfit.values;
  std::ostringstream text;
  text.precision(2);
  switch (misfit.cause) {
    case MisfitCause::kDelay:
      text << "pictures and poses of different moments";
      if (values.size() == 1) {
        text << " (pictures about " << 10 * std::lround(std::abs(100 * values[0])) << " ms "
             << (values[0] > 0 ? "later than their poses: lower"
                               : "earlier than their poses: raise")
             << " --temporal-offset-ms)";
      }
      break;
    case MisfitCause::kPixelSize:
      text << "pixels of another size, or another speed of sound";
      if (values.size() == 2) {
        text << std::showpos << " (" << 100 * values[0] << " % deep, " << 100 * values[1]
             << " % wide; calibrate the probe)";
      }
      break;
    case MisfitCause::kCalibration:
      text << "pictures that lie elsewhere on the probe (calibrate it)";
      break;
    case MisfitCause::kMotion:
      text << "a patient who moved while the sweep was taken (sweep while the breath is held, or "
              "give --breath-period)";
      break;
    case MisfitCause::kBend:
      text << "tissue that lies otherwise than in the CT (try --deformable)";
      break;
  }
  return text.str();
}

double largest_excess_mm(const std::vector<Misfit>& misfits) {
  double largest = 0;
  for (const Misfit& misfit : misfits) largest = std::max(largest, misfit.excess_mm());
  return largest;
}

}  // namespace nav::registration
