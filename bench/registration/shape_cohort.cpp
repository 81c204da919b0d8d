// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/shape_cohort.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <sstream>

#include "nav/stopwatch.hpp"
#include "registration/twist.hpp"

namespace nav::bench {
namespace {

using registration::decide;
using BonePose = Transform<frames::Ct, frames::Reference>;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kWrongPoseMm = 3;
constexpr int kMeshU = 72;
constexpr int kMeshV = 110;

class BoneRandom {
 public:
  explicit BoneRandom(std::uint64_t seed) : engine_(seed * 2654435761U + 77) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  /// Approximately normal, with bounded tails; the same on every platform.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform(0, 1);
    return sum;
  }
  Eigen::Vector3d direction() {
    Eigen::Vector3d d(normal(), normal(), normal());
    return d.normalized();
  }
  std::uint64_t next() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

double bump(double x, double width) { return std::exp(-0.5 * x * x / (width * width)); }

/// Smooth errors of a segmentation: waves of 25 to 60 mm, along the surface's normals.
class SegmentationError {
 public:
  SegmentationError(double sigma_mm, std::uint64_t seed) {
    BoneRandom random(seed);
    for (Wave& wave : waves_) {
      wave.k = random.direction() * kTurn / random.uniform(25, 60);
      wave.phase = random.uniform(0, kTurn);
      wave.size = sigma_mm * std::sqrt(2.0 / kWaves);
    }
  }
  [[nodiscard]] double at(const Eigen::Vector3d& p) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += wave.size * std::sin(wave.k.dot(p) + wave.phase);
    return sum;
  }

 private:
  static constexpr int kWaves = 6;
  struct Wave {
    Eigen::Vector3d k;
    double phase, size;
  };
  std::array<Wave, kWaves> waves_{};
};

/// Part that a pointer reaches: a rectangle of the surface's parameters.
struct Reach {
  double u0, u1, v0, v1;
};

Reach reach_of(BoneKind kind, BoneCase bone_case, BoneRandom& random) {
  const double side = random.uniform(0, 1);
  switch (kind) {
    case BoneKind::kLongBone: {
      const double wide = random.uniform(0.35, 0.6);
      if (bone_case == BoneCase::kRightShaft) return {side, side + wide, 0.3, 0.7};
      const double which = random.uniform(0, 1);
      if (which < 0.4) return {side, side + wide, 0.02, 0.98};
      if (which < 0.7) return {side, side + wide, 0.01, random.uniform(0.35, 0.6)};
      return {side, side + wide, random.uniform(0.4, 0.65), 0.99};
    }
    case BoneKind::kRib: {
      const double wide = random.uniform(0.4, 0.6);
      if (bone_case == BoneCase::kRightShaft) return {side, side + wide, 0.35, 0.65};
      return {side, side + wide, random.uniform(0, 0.3), random.uniform(0.8, 1)};
    }
    default: {
      const double wide = random.uniform(0.4, 0.7);
      if (bone_case == BoneCase::kRightShaft) return {side, side + 0.12, 0.45, 0.6};
      return {side, side + wide, random.uniform(0.05, 0.2), random.uniform(0.75, 0.95)};
    }
  }
}

/// A rotation and shift of a few centimetres, and up to 15 degrees.
BonePose displaced(const BonePose& pose, const Eigen::Vector3d& centre, BoneRandom& random) {
  registration::Vector6d twist;
  twist << random.direction() * random.uniform(0, 0.26), random.direction() * random.uniform(0, 20);
  return registration::moved(pose, centre, twist);
}

bool is_undetermined(const registration::ShapeRegistration& result) {
  if (!result.evidence) return true;
  const auto& turned = result.evidence->rivals.turned;
  const registration::ShapeLimits limits;
  const double least = limits.min_evidence;
  const auto& strain = result.evidence->strain;
  if (strain.scale_sigma > limits.max_scale_sigma &&
      strain.moved_sigma_mm > limits.max_moved_sigma_mm) {
    return true;
  }
  return std::any_of(turned.begin(), turned.end(),
                     [&](const auto& one) { return std::abs(one.evidence) < least; });
}

}  // namespace

const char* to_string(BoneKind kind) {
  constexpr std::array kNames = {"long bone", "rib",    "vertebra",
                                 "skull cap", "pelvis", "half pelvis"};
  return kNames[static_cast<std::size_t>(kind)];
}

const char* to_string(BoneCase bone_case) {
  constexpr std::array kNames = {"right",       "right, part alone", "other side",   "turned",
                                 "other level", "other patient",     "scaled by 5 %"};
  return kNames[static_cast<std::size_t>(bone_case)];
}

BoneModel::BoneModel(BoneKind kind, std::uint64_t seed) : kind_(kind) {
  BoneRandom random(seed);
  for (double& one : form_) one = random.uniform(-1, 1);
}

BoneModel BoneModel::neighbour(std::uint64_t seed) const {
  BoneModel out = *this;
  BoneRandom random(seed);
  for (double& one : out.form_) one += random.uniform(-0.25, 0.25);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double change = random.uniform(0.03, 0.08);
    out.scale_[i] *= 1 + (seed % 2 == 0 ? change : -change);
  }
  return out;
}

BoneModel BoneModel::scaled(double factor) const {
  BoneModel out = *this;
  out.scale_ *= factor;
  return out;
}

BoneModel BoneModel::mirrored() const {
  BoneModel out = *this;
  out.scale_.x() *= -1;
  return out;
}

bool BoneModel::has_sides() const {
  return kind_ == BoneKind::kLongBone || kind_ == BoneKind::kRib || kind_ == BoneKind::kHemipelvis;
}

/// Long bone or rib: a tube of varying, not quite elliptic section about a bent line.
Eigen::Vector3d BoneModel::tube(double u, double v) const {
  const double a = kTurn * u;
  const bool rib = kind_ == BoneKind::kRib;
  const double s = 2 * v - 1;  // Along the bone, -1 to 1.
  double radius = rib ? 5.5 + form(0) : 11 + 3 * form(0);
  // Section: flat, triangular, twisted along the bone.
  const double twist = (0.5 + 0.4 * form(1)) * s;
  radius *= 1 + (rib ? 0.3 : 0.12) * std::cos(2 * (a - twist)) +
            (0.07 + 0.03 * form(2)) * std::cos(3 * (a - 2 * twist) + form(3));
  // Ends, each with its condyles; ridges and tubercles.
  const double low = bump(s + 1, 0.16);
  const double high = bump(s - 1, 0.13);
  const double size = rib ? 3 : 13;
  radius += size * low *
            (0.8 + 0.2 * form(4) + 0.35 * std::cos(a - 1 - form(5)) +
             0.3 * std::cos(2 * a + 2 * form(6)));
  radius += size * high *
            (0.65 + 0.2 * form(7) + 0.3 * std::cos(a + 2 + form(8)) +
             0.35 * std::cos(2 * a + 1 + 2 * form(9)) + 0.15 * std::cos(3 * a + form(10)));
  for (std::size_t i = 0; i < 3; ++i) {
    const double where = -0.6 + 0.6 * static_cast<double>(i) + 0.25 * form(11 + i);
    const double angle = a - kTurn * 0.5 * form(14 + i);
    radius += (rib ? 0.9 : 2.2) * bump(s - where, 0.1) * (1 + std::cos(angle)) * 0.5 *
              (1 + 0.4 * form(17 + i));
  }
  // Close the tube at both ends.
  const double cap = std::sqrt(std::max(1 - std::pow(std::abs(s), 40), 0.0));
  radius *= cap;
  const double x = radius * std::cos(a);
  const double y = radius * std::sin(a);
  // The line itself differs from one person to the next.
  double aside = 0;
  double along = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double waves = 1.3 * static_cast<double>(i + 1);
    aside += 2.5 * form(30 + i) / static_cast<double>(i + 1) * std::sin(waves * s + form(33 + i));
    along += 2.5 * form(36 + i) / static_cast<double>(i + 1) * std::cos(waves * s + form(39 + i));
  }
  if (rib) {
    const double bend = 85 + 15 * form(20);
    const double angle = (1.0 + 0.12 * form(21)) * s * (1 + 0.15 * s);
    const double r = bend * (1 + 0.12 * s) + x + aside;
    return {r * std::cos(angle) - bend, r * std::sin(angle),
            y + along + (18 + 6 * form(22)) * s * std::abs(s) + 9 * s};
  }
  const double half = 150 + 45 * form(20);
  const double bow = (9 + 5 * form(21)) * (1 - s * s);
  return {x + bow + aside, y + along + 4 * form(22) * std::sin(2 * s + 1), half * s};
}

/// The other bones: a radius over the sphere with processes; bones of the midline are symmetric in
/// x but for half a millimetre.
Eigen::Vector3d BoneModel::ball(double u, double v) const {
  const double longitude = kTurn * u;
  const double latitude = 0.5 * std::numbers::pi * (2 * v - 1) * 0.98;
  const Eigen::Vector3d d(std::cos(latitude) * std::cos(longitude),
                          std::cos(latitude) * std::sin(longitude), std::sin(latitude));
  Eigen::Vector3d axes(22 + 3 * form(0), 18 + 2 * form(1), 14 + 2 * form(2));
  double size = 1;
  double width = 0.3;
  int bumps = 7;
  double height = 14;
  if (kind_ == BoneKind::kSkullCap) {
    axes = {72 + 5 * form(0), 88 + 6 * form(1), 70 + 5 * form(2)};
    height = 5;
    width = 0.45;
    bumps = 6;
  } else if (kind_ != BoneKind::kVertebra) {
    axes = {75 + 6 * form(0), 48 + 5 * form(1), 60 + 5 * form(2)};
    height = 26;
    width = 0.33;
    bumps = 9;
  }
  const bool symmetric = !has_sides();
  double extra = 0;
  for (int i = 0; i < bumps; ++i) {
    const auto at = static_cast<std::size_t>(3 + 4 * i);
    // Fixed places of a kind, shifted from patient to patient.
    const double base = 1.9 * i + 0.7;
    const double lat = 0.9 * std::sin(2.3 * i + 0.4) + 0.15 * form(at);
    const double lon = base + 0.2 * form(at + 1);
    Eigen::Vector3d centre(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon),
                           std::sin(lat));
    const double tall = height * (i % 3 == 2 ? -0.5 : 1) * (0.75 + 0.3 * form(at + 2));
    const double w = width * (1 + 0.25 * form(at + 3));
    extra += tall * bump((d - centre).norm(), w);
    if (!symmetric) continue;
    centre.x() = -centre.x();
    extra += tall * bump((d - centre).norm(), w);
  }
  if (symmetric) extra += 0.5 * std::sin(3 * d.x() + 2 * d.y() + 3 * form(60));
  Eigen::Vector3d p = d.cwiseProduct(axes) * size;
  return p + extra * d;
}

Eigen::Vector3d BoneModel::at(double u, double v) const {
  const bool is_tube = kind_ == BoneKind::kLongBone || kind_ == BoneKind::kRib;
  return scale_.cwiseProduct(is_tube ? tube(u, v) : ball(u, v));
}

TriangleMesh BoneModel::mesh(double sigma_mm, std::uint64_t seed) const {
  TriangleMesh mesh;
  mesh.name = to_string(kind_);
  const SegmentationError error(sigma_mm, seed);
  // A skull cap is open below.
  const double from = kind_ == BoneKind::kSkullCap ? 0.35 : 0.0;
  for (int j = 0; j <= kMeshV; ++j) {
    for (int i = 0; i < kMeshU; ++i) {
      const double u = static_cast<double>(i) / kMeshU;
      const double v = from + (1 - from) * static_cast<double>(j) / kMeshV;
      const Eigen::Vector3d p = at(u, v);
      constexpr double kStep = 1e-4;
      const Eigen::Vector3d du = at(u + kStep, v) - p;
      const Eigen::Vector3d dv = p - at(u, v - kStep);
      const Eigen::Vector3d cross = du.cross(dv);
      const Eigen::Vector3d normal =
          cross.norm() > 1e-12 ? Eigen::Vector3d(cross.normalized()) : Eigen::Vector3d::Zero();
      mesh.points_mm.push_back(p + error.at(p) * normal);
    }
  }
  for (int j = 0; j < kMeshV; ++j) {
    for (int i = 0; i < kMeshU; ++i) {
      const int a = j * kMeshU + i;
      const int b = j * kMeshU + (i + 1) % kMeshU;
      const int c = a + kMeshU;
      const int d = b + kMeshU;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

Result<BoneTrial> run_bone(BoneKind kind, BoneCase bone_case, std::uint64_t bone_seed,
                           std::uint64_t run_seed) {
  BoneRandom random(run_seed * 7919 + bone_seed * 131 + static_cast<std::uint64_t>(bone_case));
  const BoneModel patient(kind, bone_seed);
  BoneModel given = patient;
  if (bone_case == BoneCase::kOtherSide) given = patient.mirrored();
  if (bone_case == BoneCase::kOtherLevel) given = patient.neighbour(random.next());
  if (bone_case == BoneCase::kOtherPatient) given = BoneModel(kind, bone_seed + 100003);
  if (bone_case == BoneCase::kScaled)
    given = patient.scaled(random.uniform(0, 1) < 0.5 ? 1.05 : 1 / 1.05);
  const double noise_mm = random.uniform(0.3, 0.9);
  const double segmentation_mm = random.uniform(0, 0.4);
  const int count = static_cast<int>(random.uniform(80, 600));
  const Reach reach = reach_of(kind, bone_case, random);
  registration::Vector6d anyhow;
  anyhow << random.direction() * random.uniform(0, 3), random.direction() * 100;
  const BonePose truth = registration::moved(
      {Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()}, Eigen::Vector3d::Zero(), anyhow);
  std::vector<Point<frames::Reference>> points;
  std::vector<Eigen::Vector3d> belong;
  const double low = kind == BoneKind::kSkullCap ? 0.42 : 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int i = 0; i < count; ++i) {
    const double u = random.uniform(reach.u0, reach.u1);
    const double v = std::max(random.uniform(reach.v0, reach.v1), low + random.uniform(0, 0.1));
    const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
    points.push_back(truth.inverse() * Point<frames::Ct>{patient.at(u, v) + noise_mm * noise});
    belong.push_back(given.at(u, v));
    centre += belong.back() / count;
  }
  // The pose that the user thinks of: the bone lies where it belongs.
  BonePose start = truth;
  if (bone_case == BoneCase::kTurned) {
    registration::Vector6d half = registration::Vector6d::Zero();
    const int axis = static_cast<int>(random.uniform(0, 2.999));
    half[axis] = std::numbers::pi;
    start = registration::moved(
        start, random.uniform(0, 1) < 0.5 ? Eigen::Vector3d::Zero() : centre, half);
  } else if (bone_case == BoneCase::kOtherSide) {
    // The mirrored mesh lies across its plane x = 0; the bone's own middle is a better guess.
    Eigen::Vector3d shift = centre - Eigen::Vector3d(-centre.x(), centre.y(), centre.z());
    registration::Vector6d move = registration::Vector6d::Zero();
    move.tail<3>() = shift * random.uniform(0, 1);
    start = registration::moved(start, centre, move);
  }
  start = displaced(start, centre, random);
  const auto shape = registration::surface_shape(given.mesh(segmentation_mm, random.next()), 3);
  if (!shape) return shape.error();
  const auto field = registration::ShapeField::create(*shape);
  if (!field) return field.error();
  const auto begin = std::chrono::steady_clock::now();
  auto result = registration::register_points(points, *field, start);
  if (!result) return result.error();
  BoneTrial trial{.kind = kind,
                  .bone_case = bone_case,
                  .seed = run_seed,
                  .error_mm = 0,
                  .accepted = false,
                  .undetermined = false,
                  .false_accept = false,
                  .reasons = "",
                  .seconds = seconds_since(begin),
                  .result = std::move(*result)};
  for (std::size_t i = 0; i < points.size(); ++i) {
    trial.error_mm += ((trial.result.ct_from_reference * points[i]).mm - belong[i]).squaredNorm();
  }
  trial.error_mm = std::sqrt(std::max(trial.error_mm / count - 3 * noise_mm * noise_mm, 0.0));
  const auto decision = decide(trial.result, {}, trial.result.uncertainty.centre_ct);
  trial.accepted = decision.accepted;
  for (const auto& one : decision.reasons)
    trial.reasons += (trial.reasons.empty() ? "" : "; ") + one;
  trial.undetermined = is_undetermined(trial.result);
  const bool other = bone_case == BoneCase::kOtherPatient;
  trial.false_accept = trial.accepted && (other || trial.error_mm > kWrongPoseMm);
  return trial;
}

Result<std::vector<BoneTrial>> run_bones(const BoneCohortOptions& options,
                                         const std::function<void(double)>& progress) {
  std::vector<BoneTrial> trials;
  for (int b = 0; b < options.bones; ++b) {
    const auto kind = static_cast<BoneKind>(b % kBoneKinds);
    const std::uint64_t bone_seed = options.first_seed * 1000 + static_cast<std::uint64_t>(b);
    for (int c = 0; c < kBoneCases; ++c) {
      const auto bone_case = static_cast<BoneCase>(c);
      if (bone_case == BoneCase::kOtherSide && !BoneModel(kind, bone_seed).has_sides()) continue;
      for (int r = 0; r < options.runs; ++r) {
        auto trial = run_bone(kind, bone_case, bone_seed,
                              options.first_seed * 100 + static_cast<std::uint64_t>(r));
        if (!trial) return trial.error();
        trials.push_back(std::move(*trial));
      }
    }
    progress(static_cast<double>(b + 1) / options.bones);
  }
  return trials;
}

std::vector<BoneCount> count_bones(const std::vector<BoneTrial>& trials) {
  std::map<std::pair<BoneCase, BoneKind>, BoneCount> counts;
  for (const BoneTrial& one : trials) {
    BoneCount& count = counts[{one.bone_case, one.kind}];
    count.bone_case = one.bone_case;
    count.kind = one.kind;
    ++count.runs;
    count.accepted += one.accepted ? 1 : 0;
    count.undetermined += one.undetermined ? 1 : 0;
    count.false_accepts += one.false_accept ? 1 : 0;
    count.seconds += one.seconds;
  }
  std::vector<BoneCount> out;
  for (const auto& [key, count] : counts) out.push_back(count);
  return out;
}

std::string to_text(const std::vector<BoneTrial>& trials) {
  BoneCount all{};
  std::ostringstream rows;
  rows << std::left << std::setw(20) << "case" << std::setw(13) << "bone" << std::right
       << std::setw(7) << "runs" << std::setw(10) << "accepted" << std::setw(14) << "undetermined"
       << std::setw(7) << "false" << '\n';
  for (const BoneCount& one : count_bones(trials)) {
    rows << std::left << std::setw(20) << to_string(one.bone_case) << std::setw(13)
         << to_string(one.kind) << std::right << std::setw(7) << one.runs << std::setw(10)
         << one.accepted << std::setw(14) << one.undetermined << std::setw(7) << one.false_accepts
         << '\n';
    all.runs += one.runs;
    all.accepted += one.accepted;
    all.false_accepts += one.false_accepts;
    all.seconds += one.seconds;
  }
  std::ostringstream text;
  text << "points on surfaces of bones made by code: " << all.runs << " runs, " << all.accepted
       << " accepted, " << all.false_accepts << " of them wrong, " << std::setprecision(2)
       << all.seconds / std::max(all.runs, 1) << " s each\n"
       << rows.str();
  return text.str();
}

}  // namespace nav::bench
