// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "registration/motion/image_motion.hpp"
#include "registration/pose_solver.hpp"
#include "registration/similarity/patches.hpp"
#include "registration/twist.hpp"

/// Computes how each cause of a misfit moves patches, with as little work as possible: the
/// parameters of a cause, the sums of the patches' gradients and curvatures by them, and the
/// movements back from parameters.
namespace nav::registration {

struct LocalShape;

/// The data of a patch that every cause needs, in scaled parameters about the shape's centre.
struct Witness {
  const Patch* patch;
  const ImageMotion* motion;
  Eigen::Vector3d from_centre;  ///< Ct, mm.
  std::array<int, 3> cube;
  Vector6d gradient;
  Matrix6d hessian;  ///< Adjusted so that the sum of all is the true Hessian.
};

struct Witnesses {
  Eigen::Matrix3d rotation;  ///< Ct from Reference.
  Eigen::Vector3d centre_reference_mm;
  std::vector<Witness> all;
  Matrix6d hessian;                      ///< Sum over all patches.
  Vector6d gradient = Vector6d::Zero();  ///< Sum over all patches.
  /// Sum of DᵀD over all patches, D the displacements by the pose.
  Matrix6d pose_moves = Matrix6d::Zero();
};

/// The data of all patches of a shape at a pose. motions: of the images that the patches belong to.
Witnesses witnesses_of(const LocalShape& shape, const PatchSet& patches, const Pose& pose,
                       std::span<const ImageMotion> motions);

using ByPose = Eigen::Matrix<double, 3, 6>;
/// Displacement of a point by scaled parameters of the pose.
inline ByPose displacement_by_pose(const Eigen::Vector3d& from_centre) {
  ByPose out;
  out.leftCols<3>() = -cross_matrix(from_centre) / kRotationScaleMm;
  out.rightCols<3>().setIdentity();
  return out;
}

/// The linear system of a cause with n parameters: sums over the patches.
struct CauseSystem {
  explicit CauseSystem(Eigen::Index n)
      : hessian(Eigen::MatrixXd::Zero(n, n)),
        cross(Eigen::MatrixXd::Zero(6, n)),
        gradient(Eigen::VectorXd::Zero(n)),
        moves(Eigen::MatrixXd::Zero(n, n)),
        moves_pose(Eigen::MatrixXd::Zero(n, 6)) {}
  Eigen::MatrixXd hessian, cross;  ///< n × n; and 6 × n with the pose.
  Eigen::VectorXd gradient;
  Eigen::MatrixXd moves, moves_pose;  ///< DᵀD of displacements, n × n; and with those of the pose.
};

/// Base of causes whose parameters are used without a transform.
template <int L>
struct PlainNumbers {
  [[nodiscard]] static Eigen::Index count() { return L; }
  [[nodiscard]] static Eigen::Index raw_count() { return L; }
  [[nodiscard]] static const Eigen::VectorXd& raw(const Eigen::VectorXd& numbers) {
    return numbers;
  }
  [[nodiscard]] static const Eigen::VectorXd& folded(const Eigen::VectorXd& sum) { return sum; }
};

/// Causes that move every image as a whole: L twists of each image, scaled, about the shape's
/// centre.
template <int L>
class ImageCause : public PlainNumbers<L> {
 public:
  using Twists = Eigen::Matrix<double, 6, L>;
  /// twists_of: twists of an image, columns [rad | mm] about its middle, Reference.
  template <class TwistsOf>
  ImageCause(const Witnesses& witnesses, const TwistsOf& twists_of) {
    for (const Witness& witness : witnesses.all) {
      const auto [at, fresh] = twists_.try_emplace(witness.motion);
      if (!fresh) continue;
      const Twists twists = twists_of(*witness.motion);
      const Eigen::Vector3d r =
          witnesses.rotation * (witness.motion->middle_mm - witnesses.centre_reference_mm);
      const Eigen::Matrix<double, 3, L> turns = witnesses.rotation * twists.template topRows<3>();
      at->second.template topRows<3>() = kRotationScaleMm * turns;
      at->second.template bottomRows<3>() =
          witnesses.rotation * twists.template bottomRows<3>() + cross_matrix(r) * turns;
    }
  }
  [[nodiscard]] CauseSystem system(const Witnesses& witnesses) const {
    struct Sums {
      Vector6d gradient = Vector6d::Zero();
      Matrix6d hessian = Matrix6d::Zero(), moves = Matrix6d::Zero();
    };
    std::map<const ImageMotion*, Sums> images;
    for (const Witness& witness : witnesses.all) {
      Sums& sums = images[witness.motion];
      sums.gradient += witness.gradient;
      sums.hessian += witness.hessian;
      const ByPose d = displacement_by_pose(witness.from_centre);
      sums.moves += d.transpose() * d;
    }
    CauseSystem out(L);
    for (const auto& [image, sums] : images) {
      const Twists& c = twists_.at(image);
      const Twists hc = sums.hessian * c;
      const Twists mc = sums.moves * c;
      out.hessian += c.transpose().lazyProduct(hc);
      out.cross += hc;
      out.gradient += c.transpose().lazyProduct(sums.gradient);
      out.moves += c.transpose().lazyProduct(mc);
      out.moves_pose += mc.transpose();
    }
    return out;
  }
  /// Scaled twist of a patch for given parameters.
  [[nodiscard]] Vector6d moved(const Witness& witness, const Eigen::VectorXd& numbers) const {
    return twists_.at(witness.motion) * numbers;
  }
  /// Adds the derivative by the parameters of a scaled gradient to a sum.
  void add(const Witness& witness, const Vector6d& gradient, Eigen::VectorXd& sum) const {
    sum += twists_.at(witness.motion).transpose().lazyProduct(gradient);
  }

 private:
  std::map<const ImageMotion*, Twists> twists_;
};

/// Causes that shift patches by Σ bᵢ(patch) nᵢ with raw parameters n in threes, along the axes of
/// Ct. If there is a fold, the raw parameters are fold · m with fewer parameters m.
template <class BasisOf>
class ShiftCause {
 public:
  /// basis_of: for a patch, the consecutive bᵢ that are not 0, and the index i of the first.
  ShiftCause(Eigen::Index functions, BasisOf basis_of, Eigen::MatrixXd fold = {})
      : functions_(functions), basis_of_(std::move(basis_of)), fold_(std::move(fold)) {}
  [[nodiscard]] Eigen::Index count() const { return fold_.size() > 0 ? fold_.cols() : raw_count(); }
  [[nodiscard]] Eigen::Index raw_count() const { return 3 * functions_; }
  [[nodiscard]] Eigen::VectorXd raw(const Eigen::VectorXd& numbers) const {
    return fold_.size() > 0 ? Eigen::VectorXd(fold_ * numbers) : numbers;
  }
  [[nodiscard]] Eigen::VectorXd folded(const Eigen::VectorXd& sum) const {
    return fold_.size() > 0 ? Eigen::VectorXd(fold_.transpose() * sum) : sum;
  }
  [[nodiscard]] CauseSystem system(const Witnesses& witnesses) const {
    CauseSystem out(raw_count());
    for (const Witness& witness : witnesses.all) add_to(witness, out);
    // The sums so far fill the lower triangle, and the moves of one axis only.
    for (Eigen::Index i = 0; i < functions_; ++i) {
      for (Eigen::Index k = 0; k <= i; ++k) {
        const double moves = out.moves(3 * i, 3 * k);
        for (Eigen::Index axis = 0; axis < 3; ++axis) out.moves(3 * i + axis, 3 * k + axis) = moves;
      }
    }
    out.hessian = Eigen::MatrixXd(out.hessian.selfadjointView<Eigen::Lower>());
    out.moves = Eigen::MatrixXd(out.moves.selfadjointView<Eigen::Lower>());
    if (fold_.size() == 0) return out;
    CauseSystem fewer(fold_.cols());
    fewer.hessian = fold_.transpose() * out.hessian * fold_;
    fewer.cross = out.cross * fold_;
    fewer.gradient = fold_.transpose() * out.gradient;
    fewer.moves = fold_.transpose() * out.moves * fold_;
    fewer.moves_pose = fold_.transpose() * out.moves_pose;
    return fewer;
  }
  [[nodiscard]] Vector6d moved(const Witness& witness, const Eigen::VectorXd& raw) const {
    const auto [basis, first] = basis_of_(witness);
    Vector6d out = Vector6d::Zero();
    for (Eigen::Index i = 0; i < basis.size(); ++i) {
      out.tail<3>() += basis[i] * raw.segment<3>(3 * (first + i));
    }
    return out;
  }
  void add(const Witness& witness, const Vector6d& gradient, Eigen::VectorXd& sum) const {
    const auto [basis, first] = basis_of_(witness);
    for (Eigen::Index i = 0; i < basis.size(); ++i) {
      sum.segment<3>(3 * (first + i)) += basis[i] * gradient.tail<3>();
    }
  }

 private:
  void add_to(const Witness& witness, CauseSystem& out) const {
    const auto [basis, first] = basis_of_(witness);
    const Eigen::Matrix3d shifts = witness.hessian.template bottomRightCorner<3, 3>();
    const Eigen::Matrix<double, 6, 3> with_pose = witness.hessian.template rightCols<3>();
    const ByPose by_pose = displacement_by_pose(witness.from_centre);
    for (Eigen::Index i = 0; i < basis.size(); ++i) {
      const Eigen::Index row = 3 * (first + i);
      out.cross.middleCols<3>(row) += basis[i] * with_pose;
      out.gradient.segment<3>(row) += basis[i] * witness.gradient.template tail<3>();
      out.moves_pose.middleRows<3>(row) += basis[i] * by_pose;
      for (Eigen::Index k = 0; k <= i; ++k) {
        const Eigen::Index column = 3 * (first + k);
        out.hessian.block<3, 3>(row, column) += basis[i] * basis[k] * shifts;
        out.moves(row, column) += basis[i] * basis[k];
      }
    }
  }
  Eigen::Index functions_;
  BasisOf basis_of_;
  Eigen::MatrixXd fold_;
};

/// Two scale factors of the pixels: they shift a patch along the beam by its depth, and across by
/// its distance from the middle of the image.
class PixelCause : public PlainNumbers<2> {
 public:
  explicit PixelCause(const Witnesses& witnesses) : rotation_(witnesses.rotation) {}
  [[nodiscard]] CauseSystem system(const Witnesses& witnesses) const {
    CauseSystem out(2);
    for (const Witness& witness : witnesses.all) {
      const Shifts c = shifts_of(witness);
      const Eigen::Matrix<double, 6, 2> hc = witness.hessian.rightCols<3>() * c;
      out.hessian += c.transpose() * hc.bottomRows<3>();
      out.cross += hc;
      out.gradient += c.transpose() * witness.gradient.tail<3>();
      out.moves += c.transpose() * c;
      out.moves_pose += c.transpose() * displacement_by_pose(witness.from_centre);
    }
    return out;
  }
  [[nodiscard]] Vector6d moved(const Witness& witness, const Eigen::VectorXd& numbers) const {
    Vector6d out = Vector6d::Zero();
    out.tail<3>() = shifts_of(witness) * numbers;
    return out;
  }
  void add(const Witness& witness, const Vector6d& gradient, Eigen::VectorXd& sum) const {
    sum += shifts_of(witness).transpose() * gradient.tail<3>();
  }

 private:
  using Shifts = Eigen::Matrix<double, 3, 2>;
  [[nodiscard]] Shifts shifts_of(const Witness& witness) const {
    const Patch& patch = *witness.patch;
    const Eigen::Vector3d across = witness.motion->axes.col(0);
    Shifts out;
    out.col(0) = rotation_ * (patch.depth_mm * patch.beam);
    out.col(1) = rotation_ * (across.dot(patch.centre_mm - witness.motion->middle_mm) * across);
    return out;
  }
  Eigen::Matrix3d rotation_;
};

}  // namespace nav::registration
