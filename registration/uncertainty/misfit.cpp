// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/misfit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/of_values.hpp"
#include "registration/uncertainty/misfit_causes.hpp"
#include "registration/uncertainty/sandwich.hpp"

namespace nav::registration {
namespace {

using Eigen::Index;

constexpr double kCubeMm = 20;
constexpr std::size_t kLeastClusters = 12;
constexpr double kNoiseShare = 3;
// Least curvature of the cost per millimetre that a cause moves the patches, relative to that of a
// shift of the pose: a lower one rests on noise.
constexpr double kLeastCurvature = 0.02;
// Least remaining fraction of the movement of a cause: the pose absorbs a cause with less.
constexpr double kLeastNet = 1e-6;
// A motion is modelled by shifts at moments this far apart, and is linear in between.
constexpr double kMomentsS = 1;
constexpr int kMostMoments = 17;
constexpr int kImagesPerMoment = 2;
constexpr int kCubesPerMoment = 6;
constexpr double kPolynomialMm = 60;
constexpr double k95 = 1.96;

/// The inverse of a symmetric matrix in the directions with eigenvalues of at least \p least, and
/// the number of these directions.
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

/// A cause with its parameters scaled so that each moves the patches by 1 mm RMS after the pose is
/// found again.
struct Reduced {
  /// Parameter values for a millimetre; 0 if a pose absorbs the whole movement.
  Eigen::VectorXd scale;
  Eigen::MatrixXd given_up;  ///< Scaled parameters of the pose for one parameter.
  Eigen::MatrixXd curvature, moves;
  Eigen::VectorXd score;
};

Reduced reduced(const CauseSystem& system, const Witnesses& witnesses) {
  const double share = 1 / static_cast<double>(witnesses.all.size());
  const Eigen::LLT<Matrix6d> pose(witnesses.hessian);
  Reduced out;
  out.given_up = pose.solve(system.cross);
  const Eigen::MatrixXd crossed = system.moves_pose * out.given_up;
  out.moves = share * (system.moves - crossed - crossed.transpose() +
                       out.given_up.transpose() * witnesses.pose_moves * out.given_up);
  const Index count = system.gradient.size();
  out.scale.resize(count);
  for (Index i = 0; i < count; ++i) {
    const bool net = out.moves(i, i) > kLeastNet * share * system.moves(i, i);
    out.scale[i] = net ? 1 / std::sqrt(out.moves(i, i)) : 0;
  }
  const auto scaled = [&](const Eigen::MatrixXd& m) -> Eigen::MatrixXd {
    return out.scale.asDiagonal() * m * out.scale.asDiagonal();
  };
  out.moves = scaled(out.moves);
  out.curvature = scaled(system.hessian - system.cross.transpose() * out.given_up);
  out.score =
      out.scale.cwiseProduct(system.gradient - out.given_up.transpose() * witnesses.gradient);
  return out;
}

/// Scatter over cubes of the gradients that remain after a step, and the number of cubes.
template <class Cause>
std::pair<Eigen::MatrixXd, std::size_t> scatter_after(const Cause& cause,
                                                      const Eigen::VectorXd& numbers,
                                                      const Reduced& by,
                                                      const Witnesses& witnesses) {
  struct Cluster {
    Eigen::VectorXd numbers;
    Vector6d pose = Vector6d::Zero();
  };
  std::map<std::array<int, 3>, Cluster> clusters;
  const Eigen::VectorXd raw = cause.raw(numbers);
  const Vector6d pose_step = by.given_up * numbers;
  for (const Witness& witness : witnesses.all) {
    const auto [at, fresh] = clusters.try_emplace(witness.cube);
    Cluster& cluster = at->second;
    if (fresh) cluster.numbers.setZero(cause.raw_count());
    const Vector6d left =
        witness.gradient + witness.hessian * (cause.moved(witness, raw) - pose_step);
    cause.add(witness, left, cluster.numbers);
    cluster.pose += left;
  }
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(cause.count(), cause.count());
  for (const auto& [cube, cluster] : clusters) {
    const Eigen::VectorXd left = by.scale.cwiseProduct(cause.folded(cluster.numbers) -
                                                       by.given_up.transpose() * cluster.pose);
    scatter += left * left.transpose();
  }
  return {std::move(scatter), clusters.size()};
}

/// The parameters of a cause that give its size: count of them from first on; none if it has no
/// size.
struct Sized {
  Index first = 0, count = 0;
};

double telling_mm(const Misfit& misfit) {
  return kTellingMm[static_cast<std::size_t>(misfit.cause)];
}

/// Movement of the patches that a cause must explain for a warning, mm.
double least_noticed_mm(const Misfit& misfit) {
  return std::hypot(telling_mm(misfit), std::sqrt(kNoiseShare) * misfit.noise_mm);
}

/// Computes Misfit::unnoticed and unnoticed_along: for the direction of a cause's sized parameters
/// that is found least.
void find_unnoticed(const Reduced& by, const Eigen::MatrixXd& inverse, const Sized& sized,
                    Misfit& out) {
  const Eigen::MatrixXd step = inverse * by.curvature;  // Found fraction of a true parameter.
  const Eigen::MatrixXd squares = step.transpose() * by.moves * step;
  const Eigen::VectorXd to_scaled =
      by.scale.unaryExpr([](double mm) { return mm > 0 ? 1 / mm : 0; });
  const auto block = [&](const Eigen::MatrixXd& m) -> Eigen::MatrixXd {
    return (to_scaled.asDiagonal() * m * to_scaled.asDiagonal())
        .block(sized.first, sized.first, sized.count, sized.count);
  };
  const auto found = eigenpairs<Eigen::Dynamic>(block(squares));
  const Eigen::VectorXd along = found.vectors.col(0);
  out.unnoticed_along.assign(along.begin(), along.end());
  const bool some = found.values[0] > kLeastNet * std::max(found.values[sized.count - 1], 1.0);
  if (some) out.unnoticed = least_noticed_mm(out) / std::sqrt(found.values[0]);
}

/// Joint step of pose and cause, and its noise. corrected: what the patches were corrected by
/// before, which is a part of the misfit; empty: nothing.
template <class Cause>
Misfit fit(MisfitCause kind, const Cause& cause, const Witnesses& witnesses,
           const Sized& sized = {}, const Eigen::VectorXd& corrected = {}) {
  Misfit out{kind};
  out.unnoticed = std::numeric_limits<double>::infinity();
  const Reduced by = reduced(cause.system(witnesses), witnesses);
  const double by_shift = witnesses.hessian.bottomRightCorner<3, 3>().trace() / 3;
  const auto [inverse, kept] = inverse_above(by.curvature, kLeastCurvature * by_shift);
  if (kept == 0) return out;
  Eigen::VectorXd step = -(inverse * by.score);
  if (corrected.size() > 0) {
    step += (by.scale.array() > 0)
                .select(corrected.array() / by.scale.array().max(1e-300), 0.0)
                .matrix();
  }
  const Eigen::VectorXd numbers = by.scale.cwiseProduct(step);
  const Eigen::VectorXd left = by.scale.cwiseProduct(-(inverse * by.score));
  auto [scatter, clusters] = scatter_after(cause, left, by, witnesses);
  if (clusters < kLeastClusters) return out;
  const auto n = static_cast<double>(clusters);
  scatter *= n / (n - std::min(static_cast<double>(kept) + 6, n / 2));
  out.found_mm = square_root(step.dot(by.moves * step));
  out.noise_mm = square_root((by.moves * inverse * scatter * inverse).trace());
  out.gain = step.dot(by.curvature * step);
  if (sized.count == 0) {
    out.unnoticed = least_noticed_mm(out);
    return out;
  }
  out.values.assign(numbers.begin(), numbers.end());
  find_unnoticed(by, inverse, sized, out);
  return out;
}

Misfit fit_delay(const Witnesses& witnesses, const ErrorVector& corrected) {
  const ImageCause<1> cause(witnesses, [](const ImageMotion& motion) {
    Vector6d twist;
    twist << motion.turn_rad_s, motion.velocity_mm_s;
    return twist;
  });
  return fit(MisfitCause::kDelay, cause, witnesses, {0, 1}, corrected.head<1>());
}

/// Rotations and translations of the images along their own axes.
ImageCause<6> calibration_of(const Witnesses& witnesses) {
  return {witnesses, [](const ImageMotion& motion) {
            Matrix6d twists = Matrix6d::Zero();
            twists.topLeftCorner<3, 3>() = motion.axes;
            twists.bottomRightCorner<3, 3>() = motion.axes;
            return twists;
          }};
}

Misfit fit_calibration(const Witnesses& witnesses, const ErrorVector& corrected) {
  constexpr Sized kShifts{3, 3};  // They follow the rotations.
  return fit(MisfitCause::kCalibration, calibration_of(witnesses), witnesses, kShifts,
             corrected.tail<6>());
}

/// Shifts at moments spread evenly over the sweep, linear between them.
Misfit fit_motion(const Witnesses& witnesses, double first_s, double last_s, int moments) {
  const auto basis_of = [&](const Witness& witness) {
    const double at = (witness.motion->time_s - first_s) / (last_s - first_s) * (moments - 1);
    const int before = std::clamp(static_cast<int>(at), 0, moments - 2);
    return std::pair{Eigen::Vector2d(1 - (at - before), at - before), Index{before}};
  };
  return fit(MisfitCause::kMotion, ShiftCause(moments, basis_of), witnesses);
}

/// Six strains, and a shift for each of six products of coordinates.
Misfit fit_bend(const Witnesses& witnesses) {
  using Basis = Eigen::Matrix<double, 9, 1>;
  const auto basis_of = [](const Witness& witness) {
    const Eigen::Vector3d r = witness.from_centre / kPolynomialMm;
    Basis basis;
    basis << r, r.cwiseProduct(r), r.x() * r.y(), r.y() * r.z(), r.z() * r.x();
    return std::pair{basis, Index{0}};
  };
  constexpr Index kStrains = 6;
  constexpr Index kProducts = 18;
  Eigen::MatrixXd fold = Eigen::MatrixXd::Zero(9 + kProducts, kStrains + kProducts);
  // The shift along one axis by the coordinate along another equals the reverse one.
  const auto raw = [](Index coordinate, Index axis) { return 3 * coordinate + axis; };
  for (Index i = 0; i < 3; ++i) {
    const Index next = (i + 1) % 3;
    fold(raw(i, i), i) = 1;
    fold(raw(i, next), 3 + i) = 1;
    fold(raw(next, i), 3 + i) = 1;
  }
  fold.bottomRightCorner<kProducts, kProducts>().setIdentity();
  return fit(MisfitCause::kBend, ShiftCause(9, basis_of, fold), witnesses);
}

/// Number of moments that the images with patches can distinguish; 0 if they are too few.
int moments_of(const Witnesses& witnesses, double seconds) {
  std::set<double> times;
  std::set<std::array<int, 3>> cubes;
  for (const Witness& witness : witnesses.all) {
    times.insert(witness.motion->time_s);
    cubes.insert(witness.cube);
  }
  const int by_time = 1 + static_cast<int>(std::lround(std::min(seconds / kMomentsS, 1e3)));
  const int by_images = static_cast<int>(times.size()) / kImagesPerMoment;
  const int by_cubes = static_cast<int>(cubes.size()) / kCubesPerMoment;
  const int moments = std::min({std::max(by_time, 4), by_images, by_cubes, kMostMoments});
  return moments >= 3 ? moments : 0;
}

/// Text for a direction in the axes of an image; an empty direction is unknown and may be any.
std::string image_direction(const std::vector<double>& along) {
  if (along.empty()) return "in any direction";
  constexpr double kMostly = 0.9;
  constexpr const char* kNames[] = {"across the images", "in depth", "out of the image plane"};
  for (std::size_t axis = 0; axis < along.size(); ++axis) {
    if (std::abs(along[axis]) > kMostly) return kNames[axis];
  }
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << "along (";
  for (std::size_t axis = 0; axis < along.size(); ++axis) {
    text << (axis == 0 ? "" : ", ") << along[axis];
  }
  text << ") of the image axes";
  return text.str();
}

/// Text for a fault that is only just not noticed.
std::string fault_in_words(const Misfit& misfit) {
  const bool any = std::isinf(misfit.unnoticed);
  const auto size = [&](double factor) {
    std::ostringstream text;
    text << std::setprecision(2) << factor * misfit.unnoticed;
    return text.str();
  };
  switch (misfit.cause) {
    case MisfitCause::kDelay:
      return any ? "any delay between images and poses"
                 : "a delay between images and poses below " + size(1000) + " ms";
    case MisfitCause::kPixelSize:
      return any ? "any error of the pixel size"
                 : "an error of the pixel size below " + size(100) + " %";
    case MisfitCause::kCalibration:
      return "a probe calibration error " + (any ? "of any size" : "below " + size(1) + " mm") +
             ' ' + image_direction(misfit.unnoticed_along) +
             " (a needle with its own tracker would be wrong by as much)";
    case MisfitCause::kMotion:
      return any ? "any motion of the patient"
                 : "motion of the patient below " + size(1) + " mm RMS";
    case MisfitCause::kBend:
      break;
  }
  return any ? "any tissue deformation relative to the CT"
             : "tissue deformation below " + size(1) + " mm RMS relative to the CT";
}

}  // namespace

Witnesses witnesses_of(const LocalShape& shape, const PatchSet& patches, const Pose& pose,
                       std::span<const ImageMotion> motions) {
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
        {.patch = &patch,
         .motion = &motions[as_size(patch.frame)],
         .from_centre = r,
         .cube = {static_cast<int>(cell[0]), static_cast<int>(cell[1]), static_cast<int>(cell[2])},
         .gradient = shape.patch_gradients[i],
         .hessian = softer * shape.patch_hessians[i] * softer.transpose()});
    out.gradient += shape.patch_gradients[i];
    const ByPose by_pose = displacement_by_pose(r);
    out.pose_moves += by_pose.transpose() * by_pose;
  }
  return out;
}

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

bool Misfit::telling() const {
  if (deviations.size() != values.size()) return true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::abs(values[i]) > k95 * deviations[i]) return true;
  }
  return values.empty();
}

void set_intervals(const Eigen::Matrix<double, kErrorParameters, kErrorParameters>& covariance,
                   const ErrorSigmas& sigmas, std::vector<Misfit>& misfits) {
  constexpr double kUnshown = 0.9;
  const ErrorVector prior = sigmas.vector();
  for (Misfit& misfit : misfits) {
    // The values of a cause follow one another in ErrorVector.
    Index first = 0;
    if (misfit.cause == MisfitCause::kPixelSize) first = 1;
    if (misfit.cause == MisfitCause::kCalibration) first = 4;
    const auto count = static_cast<Index>(misfit.values.size());
    if (count == 0 || !(prior[first] > 0)) continue;
    misfit.deviations.clear();
    for (Index i = first; i < first + count; ++i) {
      misfit.deviations.push_back(square_root(covariance(i, i)));
    }
    double deviation = *std::max_element(misfit.deviations.begin(), misfit.deviations.end());
    double before = prior[first];
    if (misfit.cause == MisfitCause::kCalibration) {
      const Eigen::Matrix3d shifts = covariance.bottomRightCorner<3, 3>();
      const auto pairs = eigenpairs<3>(shifts);
      const Eigen::Vector3d along = pairs.vectors.col(2);
      misfit.unnoticed_along.assign(along.begin(), along.end());
      deviation = square_root(pairs.values[2]);
      before = prior[kErrorParameters - 1];
    }
    misfit.unnoticed =
        deviation < kUnshown * before ? k95 * deviation : std::numeric_limits<double>::infinity();
  }
}

std::vector<Misfit> find_misfits(const LocalShape& shape, const PatchSet& patches, const Pose& pose,
                                 std::span<const ImageMotion> motions,
                                 const ImageErrors& corrected) {
  if (shape.patch_hessians.empty() || !curvature_fault(shape.hessian).empty()) return {};
  const Witnesses witnesses = witnesses_of(shape, patches, pose, motions);
  const ErrorVector by = corrected.vector();
  std::vector<Misfit> out{
      fit_delay(witnesses, by),
      fit(MisfitCause::kPixelSize, PixelCause(witnesses), witnesses, {0, 1}, by.segment<2>(1)),
      fit_calibration(witnesses, by)};
  const double first_s = motions.front().time_s;
  const double last_s = motions.back().time_s;
  if (const int moments = moments_of(witnesses, last_s - first_s); moments > 0) {
    out.push_back(fit_motion(witnesses, first_s, last_s, moments));
  }
  out.push_back(fit_bend(witnesses));
  return out;
}

std::string in_words(const Misfit& misfit) {
  const std::vector<double>& values = misfit.values;
  std::ostringstream text;
  text.precision(2);
  switch (misfit.cause) {
    case MisfitCause::kDelay:
      text << "a delay between images and poses";
      if (values.size() == 1) {
        text << " (images " << std::fixed << std::setprecision(0) << 1000 * std::abs(values[0]);
        if (misfit.deviations.size() == 1) {
          text << " +- " << std::max(1.0, std::round(k95 * 1000 * misfit.deviations[0]));
        }
        text << " ms "
             << (values[0] > 0 ? "later than their poses: lower"
                               : "earlier than their poses: raise")
             << " --temporal-offset-ms)";
      }
      break;
    case MisfitCause::kPixelSize:
      text << "a wrong pixel size or speed of sound, or tissue deformed relative to the CT";
      if (values.size() == 2) {
        const auto size = [&](std::size_t i, const char* along) {
          text << std::showpos << 100 * values[i] << std::noshowpos;
          if (misfit.deviations.size() == 2) text << " +- " << k95 * 100 * misfit.deviations[i];
          text << " % in " << along;
        };
        text << " (";
        size(0, "depth, ");
        size(1, "width; recalibrate the probe)");
      }
      break;
    case MisfitCause::kCalibration:
      text << "a probe calibration error (recalibrate the probe)";
      break;
    case MisfitCause::kMotion:
      text << "motion of the patient during the sweep (sweep during a breath hold, or give "
              "--breath-period)";
      break;
    case MisfitCause::kBend:
      text << "tissue deformed relative to the CT (try --deformable)";
      break;
  }
  return text.str();
}

const Misfit* likeliest_of(const std::vector<Misfit>& misfits,
                           const std::array<double, kMisfitCauses>& limits_mm) {
  constexpr double kShare = 0.4;
  std::vector<const Misfit*> beyond;
  double most = 0;
  for (const Misfit& misfit : misfits) {
    if (!misfit.deviations.empty()) continue;
    if (misfit.excess_mm() <= limits_mm[static_cast<std::size_t>(misfit.cause)]) continue;
    beyond.push_back(&misfit);
    most = std::max(most, misfit.gain);
  }
  // Misfits are sorted, simplest first.
  const auto found = std::find_if(beyond.begin(), beyond.end(), [&](const Misfit* misfit) {
    return misfit->gain >= kShare * most;
  });
  if (found != beyond.end()) return *found;
  return beyond.empty() ? nullptr : beyond.back();
}

double telling_excess_mm(const std::vector<Misfit>& misfits) {
  double largest = 0;
  for (const Misfit& misfit : misfits) {
    if (!misfit.deviations.empty()) continue;
    const double excess_mm = misfit.excess_mm();
    if (std::isnan(excess_mm)) return excess_mm;
    const double share = excess_mm / telling_mm(misfit);
    largest = std::max(largest, excess_mm * std::clamp(2 * share - 1, 0.0, 1.0));
  }
  return largest;
}

std::string unnoticed_in_words(const std::vector<Misfit>& misfits) {
  std::ostringstream text;
  for (const Misfit& misfit : misfits) {
    text << (text.tellp() == 0 ? "this sweep cannot show " : ", ") << fault_in_words(misfit);
  }
  return text.str();
}

}  // namespace nav::registration
