// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/phase_registration.hpp"

#include <algorithm>
#include <ceres/cost_function.h>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <sstream>

#include "nav/check.hpp"
#include "registration/cost_solver.hpp"
#include "registration/paired_gain.hpp"
#include "registration/pose_solver.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;
using Basis = Eigen::VectorXd;

constexpr double kMaxTravelMm = 60;  // Of any coefficient.

/// 1, cos, sin, cos 2, sin 2, … of the phase: as many as the series has columns.
Basis basis(double phase, Eigen::Index columns) {
  Basis out(columns);
  out[0] = 1;
  for (Eigen::Index i = 1; i < columns; i += 2) {
    const double angle = 2 * std::numbers::pi * static_cast<double>((i + 1) / 2) * phase;
    out[i] = std::cos(angle);
    out[i + 1] = std::sin(angle);
  }
  return out;
}

Vector6d twist_of(const Eigen::MatrixXd& series, const Basis& at) {
  Vector6d twist = series * at;
  twist.head<3>() /= kRotationScaleMm;
  return twist;
}

/// The patches of one picture, their share of all weights, its phase and which half it is of.
struct Picture {
  PatchSet patches;
  double weight;
  double phase;
  int half;
};

std::vector<Picture> pictures_of(const PatchSet& all, std::span<const double> phases,
                                 const std::vector<int>& halves) {
  std::set<int> frames;
  for (const Patch& p : all.patches) frames.insert(p.frame);
  std::vector<Picture> out;
  double total = 0;
  for (const int frame : frames) {
    const double phase = phases[static_cast<std::size_t>(frame)];
    if (std::isnan(phase)) continue;
    double weight = 0;
    for (const Patch& p : all.patches) weight += p.frame == frame ? p.weight : 0;
    if (!(weight > 0)) continue;
    total += weight;
    out.push_back({subset(all, [&](const Patch& p) { return p.frame == frame; }), weight, phase,
                   halves[static_cast<std::size_t>(frame)]});
  }
  for (Picture& picture : out) picture.weight /= total;
  return out;
}

/// Every picture is of one half: that of the even breaths, or that of the odd ones. A breath ends
/// where the phase falls back by more than noise of a belt would make it.
std::vector<int> halves_by_breath(std::span<const double> phases) {
  constexpr double kFallsBack = 0.3;
  std::vector<int> halves;
  int breath = 0;
  double before = 0;
  for (const double phase : phases) {
    if (!std::isnan(phase)) {
      if (phase < before - kFallsBack) ++breath;
      before = phase;
    }
    halves.push_back(breath % 2);
  }
  return halves;
}

using Chosen = std::vector<const Picture*>;

/// Longest part of the cycle between neighbouring phases; 1 for no pictures.
double longest_gap(const Chosen& pictures) {
  if (pictures.empty()) return 1;
  std::vector<double> phases;
  for (const Picture* p : pictures) phases.push_back(p->phase);
  std::sort(phases.begin(), phases.end());
  double gap = phases.front() + 1 - phases.back();
  for (std::size_t i = 1; i < phases.size(); ++i) gap = std::max(gap, phases[i] - phases[i - 1]);
  return gap;
}

enum class Part { kEven, kOdd, kAll };  ///< Which breaths.

Part other(Part half) { return half == Part::kEven ? Part::kOdd : Part::kEven; }

/// A level's pictures: of all breaths, and of the halves that judge each other.
struct Level {
  const CtChannels& ct;
  std::vector<Picture> pictures;

  [[nodiscard]] Chosen of(Part part) const {
    Chosen chosen;
    for (const Picture& picture : pictures) {
      if (part == Part::kAll || picture.half == static_cast<int>(part)) chosen.push_back(&picture);
    }
    return chosen;
  }
};

/// E(series) = mean of the pictures' costs at the poses of their phases + stiffness.
class PhaseCost final : public ceres::CostFunction {
 public:
  /// Parameters are what is added to a series.
  PhaseCost(const CtChannels& ct, const Chosen& pictures, const Pose& start, const Vec& centre,
            const Eigen::MatrixXd& from, const PhaseOptions& options)
      : pictures_(pictures),
        start_(start),
        centre_(centre),
        from_(from),
        columns_(from.cols()),
        options_(options) {
    for (const Picture* p : pictures) {
      total_ += p->weight;
      costs_.emplace_back(ct, p->patches, options.ridge, options.threads);
    }
    set_num_residuals(static_cast<int>(6 * columns_) + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(6 * columns_));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::MatrixXd series =
        from_ + Eigen::Map<const Eigen::MatrixXd>(parameters[0], 6, columns_);
    if (!series.allFinite() || series.cwiseAbs().maxCoeff() > kMaxTravelMm) return false;
    const Eigen::Index n = 6 * columns_;
    const bool slopes = jacobians != nullptr && jacobians[0] != nullptr;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(n, n);
    double cost = add_stiffness(series, gradient, hessian);
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      cost += add(*pictures_[i], costs_[i], series, slopes, gradient, hessian);
    }
    if (!std::isfinite(cost) || !hessian.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd> r(residuals, n + 1);
    r.setZero();
    r[n] = std::sqrt(cost);
    if (!slopes) return true;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
        jacobians[0], n + 1, n);
    fill_residuals(cost, gradient, hessian, r, jacobian);
    return true;
  }

 private:
  double add_stiffness(const Eigen::MatrixXd& series, Eigen::VectorXd& gradient,
                       Eigen::MatrixXd& hessian) const {
    double cost = 0;
    for (Eigen::Index column = 1; column < columns_; ++column) {
      const double k = static_cast<double>((column + 1) / 2);
      const double weight = options_.stiffness * k * k * k * k;
      cost += weight * series.col(column).squaredNorm();
      gradient.segment<6>(6 * column) += weight * series.col(column);
      hessian.diagonal().segment<6>(6 * column).array() += weight;
    }
    return cost;
  }

  double add(const Picture& picture, const Lc2Cost& cost, const Eigen::MatrixXd& series,
             bool slopes, Eigen::VectorXd& gradient, Eigen::MatrixXd& hessian) const {
    const Basis b = basis(picture.phase, columns_);
    const Vector6d twist = twist_of(series, b);
    const Pose pose = moved(start_, centre_, twist);
    const double weight = picture.weight / total_;
    if (!slopes) return weight * cost.cost(pose).cost;
    const CostTerms terms = cost.terms(pose, centre_ + twist.tail<3>());
    Matrix6d chain = Matrix6d::Identity();
    chain.topLeftCorner<3, 3>() = left_jacobian(twist.head<3>()) / kRotationScaleMm;
    const Vector6d g = weight * (chain.transpose() * terms.gradient);
    const Matrix6d h = weight * (chain.transpose() * terms.hessian * chain);
    for (Eigen::Index i = 0; i < columns_; ++i) {
      gradient.segment<6>(6 * i) += b[i] * g;
      for (Eigen::Index j = 0; j < columns_; ++j) {
        hessian.block<6, 6>(6 * i, 6 * j) += b[i] * b[j] * h;
      }
    }
    return weight * terms.cost;
  }

  Chosen pictures_;
  std::vector<Lc2Cost> costs_;  // Of the pictures.
  Pose start_;
  Vec centre_;
  Eigen::MatrixXd from_;
  Eigen::Index columns_;
  const PhaseOptions& options_;
  double total_ = 0;
};

struct Fit {
  PhaseMotion motion;
  double cost;
  int iterations;
  bool finite;
};

/// What fits start from.
struct Start {
  Pose pose;
  Vec centre;
};

/// Coarse to fine. columns 1: the best common pose.
Fit fit(const std::vector<Level>& levels, Part part, const Start& start, Eigen::Index columns,
        const PhaseOptions& options) {
  Fit out{PhaseMotion(start.pose), 0, 0, true};
  Eigen::MatrixXd series = Eigen::MatrixXd::Zero(6, columns);
  for (const Level& level : levels) {
    Eigen::VectorXd delta(6 * columns);
    auto* cost = new PhaseCost(level.ct, level.of(part), start.pose, start.centre, series,
                               options);  // Ceres takes it.
    const CostSolution found = minimise(cost, delta, {options.max_iterations}, {});
    series += Eigen::Map<const Eigen::MatrixXd>(delta.data(), 6, columns);
    out.cost = found.final_cost;
    out.iterations += found.iterations;
    out.finite = out.finite && found.termination != Termination::kFailed;
  }
  out.motion = PhaseMotion(start.pose, start.centre, series);
  return out;
}

/// NaN where a patch has no finite similarity.
double cost_at(const CtChannels& ct, const Picture& picture, const PhaseMotion& motion,
               const PhaseOptions& options) {
  const CostTerms terms = Lc2Cost(ct, picture.patches, options.ridge, options.threads)
                              .cost(motion.ct_from_reference(picture.phase));
  return terms.non_finite > 0 ? std::numeric_limits<double>::quiet_NaN() : terms.cost;
}

/// Half of the pictures judge what the other half was fitted to.
struct CrossCheck {
  double rigid = 0, moving = 0;
  PairedGain gain;
  bool finite = true;

  void judge(const CtChannels& ct, const Chosen& judges, const Fit& still, const Fit& breathing,
             const PhaseOptions& options) {
    finite = finite && still.finite && breathing.finite;
    for (const Picture* picture : judges) {
      const double a = cost_at(ct, *picture, still.motion, options);
      const double b = cost_at(ct, *picture, breathing.motion, options);
      rigid += a;
      moving += b;
      gain.add(a - b);
    }
  }
};

/// Says whether the pictures that were left out support the motion.
void choose(const CrossCheck& check, const PhaseOptions& options, PhaseResult& result) {
  result.held_out_rigid = check.rigid / check.gain.count;
  result.held_out_moving = check.moving / check.gain.count;
  result.gain_sigmas = check.gain.sigmas();
  const double share = check.gain.sum / std::max(check.rigid, 1e-12);
  result.supported =
      result.gain_sigmas >= options.min_gain_sigmas && share >= options.min_gain_share;
  std::ostringstream text;
  text.precision(3);
  text << (result.supported ? "moves with the breath" : "rigid") << ": breaths that were left out "
       << "gained " << 100 * share << " % and " << result.gain_sigmas
       << " standard errors by a motion with the breath";
  if (!result.supported) {
    text << ", expected " << 100 * options.min_gain_share << " % and " << options.min_gain_sigmas;
  }
  result.reason = text.str();
}

Result<void> check_phases(const PatchSet& patches, std::span<const double> phases) {
  for (std::size_t i = 0; i < phases.size(); ++i) {
    if (std::isnan(phases[i]) || (phases[i] >= 0 && phases[i] < 1)) continue;
    return Error{ErrorCode::kUsage, "phase of picture " + std::to_string(i) +
                                        ": expected [0, 1) or NaN, found " +
                                        std::to_string(phases[i])};
  }
  for (const Patch& p : patches.patches) {
    if (static_cast<std::size_t>(p.frame) < phases.size()) continue;
    return Error{ErrorCode::kUsage, "phases: expected one for each picture, found " +
                                        std::to_string(phases.size()) + " and a patch of picture " +
                                        std::to_string(p.frame)};
  }
  return {};
}

Result<void> check_pictures(const Level& level, const PhaseOptions& options) {
  if (static_cast<int>(level.pictures.size()) < options.min_pictures) {
    return Error{ErrorCode::kRefused, "registration by phase: expected at least " +
                                          std::to_string(options.min_pictures) +
                                          " pictures with patches and a phase, found " +
                                          std::to_string(level.pictures.size())};
  }
  const auto refuse = [](const std::string& expected, double gap) {
    return Error{ErrorCode::kRefused, "registration by phase: expected " + expected +
                                          ", found none in " +
                                          std::to_string(std::lround(100 * gap)) + " % of it"};
  };
  if (const double gap = longest_gap(level.of(Part::kAll)); gap > options.max_gap) {
    return refuse("pictures of the whole breath", gap);
  }
  for (const Part half : {Part::kEven, Part::kOdd}) {
    if (const double gap = longest_gap(level.of(half)); gap > options.max_gap) {
      return refuse("two breaths, as one judges the other, and pictures of the whole of each", gap);
    }
  }
  return {};
}

Vec centre_of(const std::vector<Picture>& pictures, const Pose& pose) {
  Vec sum = Vec::Zero();
  for (const Picture& picture : pictures) {
    for (const Patch& p : picture.patches.patches) {
      sum += picture.weight * p.weight * (pose * Point<frames::Reference>{p.centre_mm}).mm;
    }
  }
  return sum;
}

}  // namespace

PhaseMotion::PhaseMotion(const Pose& mean, const Vec& centre_ct_mm)
    : PhaseMotion(mean, centre_ct_mm, Eigen::MatrixXd::Zero(6, 1)) {}

PhaseMotion::PhaseMotion(const Pose& mean, const Vec& centre_ct_mm, Eigen::MatrixXd series)
    : mean_(mean), centre_(centre_ct_mm), series_(std::move(series)) {
  NAV_CHECK(series_.rows() == 6 && series_.cols() % 2 == 1, series_.rows(), series_.cols());
}

Pose PhaseMotion::ct_from_reference(double phase) const {
  return moved(mean_, centre_, twist_of(series_, basis(phase, series_.cols())));
}

PhaseMotion PhaseMotion::after(const Transform<frames::Ct, frames::Ct>& step) const {
  const Eigen::Matrix3d turn = step.rotation().toRotationMatrix();
  Eigen::MatrixXd series = series_;
  series.topRows<3>() = turn * series_.topRows<3>();
  series.bottomRows<3>() = turn * series_.bottomRows<3>();
  return {step * mean_, (step * Point<frames::Ct>{centre_}).mm, std::move(series)};
}

double PhaseMotion::amplitude_mm(const Point<frames::Ct>& at_mean) const {
  constexpr int kPhases = 32;
  const Point<frames::Reference> p = mean_.inverse() * at_mean;
  double longest = 0;
  for (int i = 0; i < kPhases; ++i) {
    const Vec a = (ct_from_reference(static_cast<double>(i) / kPhases) * p).mm;
    for (int j = 0; j < i; ++j) {
      const Vec b = (ct_from_reference(static_cast<double>(j) / kPhases) * p).mm;
      longest = std::max(longest, (a - b).norm());
    }
  }
  return longest;
}

Result<void> validate(const PhaseOptions& o) {
  const auto refuse = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("registration by phase: expected ") + what};
  };
  if (o.harmonics < 1 || o.harmonics > 4) return refuse("1 to 4 harmonics");
  if (!(o.stiffness > 0 && std::isfinite(o.stiffness))) return refuse("stiffness > 0");
  if (o.max_iterations < 1 || o.max_iterations > 200) return refuse("1 to 200 iterations");
  if (!(o.ridge > 0 && std::isfinite(o.ridge))) return refuse("ridge > 0");
  if (o.threads < 1 || o.threads > 64) return refuse("1 to 64 threads");
  if (o.min_pictures < 8) return refuse("min_pictures >= 8");
  if (!(o.max_gap > 0 && o.max_gap < 1)) return refuse("max_gap in (0, 1)");
  if (!(o.min_gain_sigmas > 0)) return refuse("min_gain_sigmas > 0");
  if (!(o.min_gain_share >= 0 && o.min_gain_share < 1)) return refuse("min_gain_share in [0, 1)");
  return {};
}

Result<PhaseResult> refine_by_phase(const CtChannels& ct, const PatchSet& patches,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options) {
  const std::array<PhaseLevel, 1> level = {PhaseLevel{ct, patches}};
  return refine_by_phase(level, phases, ct_from_reference, options);
}

Result<PhaseResult> refine_by_phase(std::span<const PhaseLevel> given,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options) {
  NAV_CHECK(!given.empty(), given.size());
  if (const auto ok = validate(options); !ok) return ok.error();
  std::vector<int> halves = halves_by_breath(phases);
  std::vector<Level> levels;
  for (const PhaseLevel& one : given) {
    if (const auto ok = check_phases(one.patches, phases); !ok) return ok.error();
    levels.push_back({one.ct, pictures_of(one.patches, phases, halves)});
    if (const auto ok = check_pictures(levels.back(), options); !ok) return ok.error();
  }
  const Level& finest = levels.back();
  const Start start{ct_from_reference, centre_of(finest.pictures, ct_from_reference)};
  const Eigen::Index columns = 1 + 2 * options.harmonics;
  const Fit still = fit(levels, Part::kAll, start, 1, options);
  CrossCheck check;
  check.finite = still.finite && std::isfinite(still.cost);
  std::array<PhaseMotion, 2> unseen = {still.motion, still.motion};
  for (const Part judged : {Part::kEven, Part::kOdd}) {
    if (!check.finite) break;
    const Fit breathing = fit(levels, other(judged), start, columns, options);
    check.judge(finest.ct, finest.of(judged), fit(levels, other(judged), start, 1, options),
                breathing, options);
    unseen[static_cast<std::size_t>(judged)] = breathing.motion;
  }
  const Error not_finite{ErrorCode::kNumerical,
                         "registration by phase: expected a finite similarity of every picture"};
  if (!check.finite || !std::isfinite(check.rigid) || !std::isfinite(check.moving)) {
    return not_finite;
  }
  PhaseResult result{still.motion,
                     false,
                     "",
                     still.cost,
                     still.cost,
                     0,
                     0,
                     0,
                     static_cast<int>(finest.pictures.size()),
                     still.iterations,
                     unseen,
                     std::move(halves)};
  choose(check, options, result);
  if (!result.supported) return result;
  const Fit whole = fit(levels, Part::kAll, start, columns, options);
  if (!whole.finite) return not_finite;
  result.motion = whole.motion;
  result.final_cost = whole.cost;
  result.iterations = whole.iterations;
  return result;
}

}  // namespace nav::registration
