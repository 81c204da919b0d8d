// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/bone_scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "nav/check.hpp"
#include "sim/anatomy/ct_patient.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/random.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/shapes.hpp"
#include "sim/ultrasound.hpp"

namespace nav::bench {
namespace {

using Spot = Eigen::Vector3d;
using ImageView = Transform<frames::Ct, frames::Image>;

constexpr double kLimbMm = 42;
constexpr double kChestMm = 115;
constexpr double kCortexMm = 2.2;
constexpr double kBoneImagesPerSecond = 15;
constexpr double kTraceStepMm = 0.25;

/// Bones and soft tissue made by code about the z axis; the probe comes from -y.
class MadeBody {
 public:
  MadeBody(BoneSite site, std::uint64_t seed) : site_(site), random_(seed, 0x626f6e65) {
    for (double& one : form_) one = random_.uniform(-1, 1);
    for (auto& blob : blobs_) {
      blob = {random_.uniform(-50, 50), random_.uniform(-50, 50), random_.uniform(-90, 90),
              random_.uniform(4, 9), random_.uniform(-35, 35)};
    }
  }
  [[nodiscard]] bool chest() const { return site_ == BoneSite::kRibs; }
  /// Middle of the body's section: the limb's axis, or that of the chest.
  [[nodiscard]] Spot middle() const { return chest() ? Spot(0, kChestMm - 5, 0) : Spot(0, 0, 0); }
  [[nodiscard]] double radius_mm() const { return chest() ? kChestMm : kLimbMm; }
  /// Distance to the bone's surface, mm, negative inside.
  [[nodiscard]] double bone_mm(const Spot& p) const {
    switch (site_) {
      case BoneSite::kRibs:
        return ribs(p);
      case BoneSite::kNoBone:
        return 1e3;
      default:
        return long_bone(p);
    }
  }
  [[nodiscard]] double hu(const Spot& p) const {
    const double skin = (p - middle()).head<2>().norm() - radius_mm();
    double soft = 45;
    for (const auto& [x, y, z, size, height] : blobs_) {
      const double r2 = (p - Spot(x, y, z)).squaredNorm() / (size * size);
      if (r2 < 25) soft += height * std::exp(-0.5 * r2);
    }
    soft += blend(-skin, 5) * -140 * (1 - blend(-skin, 2));
    if (chest() && skin < -32) soft = -850;
    const double bone = bone_mm(p);
    const double cortex = 1250 + (90 - 1250) * blend(-bone, kCortexMm);
    const double inside = soft + (cortex - soft) * blend(-bone, 0);
    return inside + (-1000 - inside) * blend(skin, 0);
  }

 private:
  /// 0 below the edge, 1 above, over a millimetre.
  static double blend(double x, double edge) { return std::clamp(x - edge + 0.5, 0.0, 1.0); }

  /// Bowed, twisted, not quite triangular shaft; condyles of unlike size, and the next bone.
  [[nodiscard]] double long_bone(const Spot& p) const {
    const double bow = 3 * form_[0] * std::cos(0.02 * p.z()) - 2;
    const double aside = 3 * form_[1] * std::sin(0.015 * p.z() + form_[2]);
    const Eigen::Vector2d q(p.x() - aside, p.y() - bow);
    const double a = std::atan2(q.y(), q.x()) - 0.004 * p.z();
    const double radius = 9.5 + form_[3] + (1.1 + 0.4 * form_[4]) * std::cos(3 * a + form_[5]) +
                          0.8 * std::cos(2 * a + form_[6]);
    double d = q.norm() - radius;
    if (site_ == BoneSite::kShaft) return d;
    d = std::max(d, p.z() - 35);
    using sim::shapes::Ellipsoid;
    const Ellipsoid inner{{-9 + form_[7], -2 + form_[8], 34}, {11 + form_[9], 14, 14 + form_[10]}};
    const Ellipsoid outer{{9.5 + form_[11], 1, 36 + form_[12]}, {9, 12 + form_[13], 11}};
    const Ellipsoid knob{{13, -6 + 2 * form_[14], 12 + 3 * form_[15]}, {5, 6, 9}};
    d = sim::shapes::smooth_union(d, inner(p), 5);
    d = sim::shapes::smooth_union(d, outer(p), 4);
    d = sim::shapes::smooth_union(d, knob(p), 4);
    const Ellipsoid next{{1 + form_[16], 1 + form_[17], 66}, {17 + form_[18], 15, 13}};
    return std::min(d, next(p));
  }

  /// Three sloping ribs; their front ends lie at different angles.
  [[nodiscard]] double ribs(const Spot& p) const {
    const Spot q = p - middle();
    const double r = std::hypot(q.x(), q.y());
    const double angle = std::atan2(q.x(), -q.y());  // 0 towards the probe.
    double least = 1e3;
    for (int i = -1; i <= 1; ++i) {
      const double shape = form_[static_cast<std::size_t>(i + 1)];
      const double height = 27 * i + 2 * shape + 45 * angle + 30 * angle * angle;
      const double depth = r - (kChestMm - 18 - 1.5 * shape);
      const double wide = 6.5 + form_[static_cast<std::size_t>(i + 4)];
      const double tube = (std::hypot((q.z() - height) / wide, depth / 4.0) - 1) * 4.0;
      const double end =
          r * (angle - 0.13 - 0.05 * i - 0.02 * form_[static_cast<std::size_t>(i + 7)]);
      least = std::min(least, sim::shapes::smooth_intersection(tube, end, 3));
    }
    return least;
  }

  struct Blob {
    double x, y, z, size, height;
  };
  BoneSite site_;
  sim::Random random_;
  std::array<double, 24> form_{};
  std::array<Blob, 60> blobs_{};
};

Result<Volume> ct_of(const MadeBody& body) {
  VoxelGrid grid;
  const double wide = body.chest() ? 75 : 50;
  const double deep = body.chest() ? 70 : 50;
  grid.spacing_mm = {1, 1, 1};
  const double front = body.chest() ? -12 : -deep;
  grid.origin_mm = {-wide, front, -75};
  grid.size = {static_cast<int>(2 * wide) + 1, static_cast<int>(deep - front) + 1, 161};
  std::vector<std::int16_t> hu;
  hu.reserve(grid.voxel_count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        hu.push_back(static_cast<std::int16_t>(
            std::lround(body.hu(grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm))));
      }
    }
  }
  return Volume::create(grid, std::move(hu), "simulated bone");
}

/// The hand: along the axis, about the body's middle, turning the face as it goes.
std::vector<ImageView> hand_over(const MadeBody& body, BoneSite site, std::uint64_t seed,
                                 int images) {
  sim::Random random(seed, 0x68616e64);
  const double phase = random.uniform(0, 6.28);
  const double from = site == BoneSite::kShaft ? -50 : body.chest() ? -38 : -30;
  const double to = site == BoneSite::kShaft ? 25 : body.chest() ? 42 : 66;
  const double swing = body.chest() ? 0.16 : 0.45;
  std::vector<ImageView> out;
  for (int i = 0; i < images; ++i) {
    const double s = static_cast<double>(i) / (images - 1);
    const double angle = swing * std::sin(5.5 * s + phase) + (body.chest() ? 0.12 : 0);
    const Spot outward(std::sin(angle), -std::cos(angle), 0);
    const Spot face = body.middle() + (body.radius_mm() - (body.chest() ? 2.2 : 4.6)) * outward +
                      Spot(0, 0, from + (to - from) * s);
    const double turn = (body.chest() ? 0.5 : 0.25) * std::sin(4 * s + 1 + phase);
    const double tilt = 0.15 * std::sin(7 * s + phase);
    Eigen::Matrix3d axes;
    axes.col(1) = (-outward + Spot(0, 0, tilt)).normalized();
    const Spot along(std::cos(angle), std::sin(angle), 0);
    const Spot wanted = std::cos(turn) * along + std::sin(turn) * Spot::UnitZ();
    axes.col(0) = (wanted - wanted.dot(axes.col(1)) * axes.col(1)).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    out.emplace_back(Eigen::Quaterniond(axes).normalized(), face);
  }
  return out;
}

CtPose seeded_truth(std::uint64_t seed) {
  sim::Random random(seed, 0x7472757468);
  const Spot turn = random.offset(1.2);
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())),
          random.offset(120)};
}

/// Images of a family of patients along a path of the hand; with the scan of the part shown.
Result<BoneScene> family_scene(BoneSite site, std::uint64_t seed, ErrorLevel level, int images) {
  sim::SimulatedSessionOptions options;
  options.family = site == BoneSite::kSpine ? "spine" : "shoulder";
  options.seed = seed;
  options.standard_view = true;
  options.path.kind = sim::HandPathKind::kTilt;
  options.path.length_mm = site == BoneSite::kSpine ? 80 : 50;
  options.frame_rate_hz = kBoneImagesPerSecond;
  options.duration_s = images / kBoneImagesPerSecond;
  const auto patient = sim::make_patient(options.family, {seed, *options.contrast});
  if (!patient) return patient.error();
  options.probe = patient->views.front().probe;
  const LevelErrors errors = errors_of(level);
  sim::set_image_errors(errors, options.probe);
  options.path.unevenness = errors.unevenness;
  options.pressure_mm = errors.pressure_mm;
  const auto session = sim::SimulatedSession::create(options, *patient);
  if (!session) return session.error();
  sim::CtOptions scan;
  scan.seed = seed;
  scan.spacing_mm = {1, 1, 1};
  scan.region = sim::region_of(*patient->anatomy);
  auto ct = sim::scan_ct(*patient->anatomy, scan);
  if (!ct) return ct.error();
  const CtPose truth = session->ct_from_reference();
  sim::Random random(seed, 0x747261636b);
  std::vector<TrackedImage> frames;
  std::vector<ImageView> views;
  const auto stream = session->frames();
  for (int i = 0; i < session->frame_count(); ++i) {
    auto frame = stream->next(Timestamp::max());
    if (!frame) return frame.error();
    views.push_back(session->truth(i).ct_from_image);
    frames.push_back({std::move(*frame),
                      measured(truth.inverse() * views.back(), random, errors.tracker_mm,
                               kTrackerRad / kTrackerMm * errors.tracker_mm),
                      Duration{0}});
  }
  auto sweep = Sweep::create(std::move(frames), "simulated");
  if (!sweep) return sweep.error();
  return BoneScene{.ct = std::move(*ct),
                   .anatomy = patient->anatomy,
                   .sweep = std::move(*sweep),
                   .truth = truth,
                   .views = std::move(views)};
}

}  // namespace

const char* to_string(BoneSite site) {
  constexpr std::array kNames = {"spine", "shoulder", "long bone", "shaft", "ribs", "no bone"};
  return kNames[static_cast<std::size_t>(site)];
}

Volume BoneScene::mirrored_ct() const {
  VoxelGrid grid = ct.grid();
  std::vector<std::int16_t> hu(ct.hu().begin(), ct.hu().end());
  const auto row = static_cast<std::ptrdiff_t>(grid.size[0]);
  for (auto at = hu.begin(); at != hu.end(); at += row) std::reverse(at, at + row);
  auto out = Volume::create(grid, std::move(hu), ct.name() + ", mirrored");
  NAV_CHECK(out.has_value());
  return *out;
}

Result<BoneScene> make_bone_scene(BoneSite site, std::uint64_t seed, ErrorLevel level, int images) {
  if (site == BoneSite::kSpine || site == BoneSite::kShoulder) {
    return family_scene(site, seed, level, images);
  }
  const MadeBody body(site, seed);
  auto ct = ct_of(body);
  if (!ct) return ct.error();
  auto anatomy = sim::make_ct_patient(*ct, {.smooth_mm = 0.4, .seed = seed, .about = {}});
  if (!anatomy) return anatomy.error();
  sim::ProbeModel probe = sim::linear_l14();
  const LevelErrors errors = errors_of(level);
  sim::set_image_errors(errors, probe);
  const sim::UltrasoundSimulator scanner(*anatomy, probe, seed);
  std::vector<ImageView> views = hand_over(body, site, seed, images);
  const CtPose truth = seeded_truth(seed);
  sim::Random random(seed, 0x747261636b);
  std::vector<TrackedImage> frames;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Timestamp time(from_seconds(static_cast<double>(i) / kBoneImagesPerSecond));
    frames.push_back({scanner.simulate(views[i], time, i),
                      measured(truth.inverse() * views[i], random, errors.tracker_mm,
                               kTrackerRad / kTrackerMm * errors.tracker_mm),
                      Duration{0}});
  }
  auto sweep = Sweep::create(std::move(frames), "simulated");
  if (!sweep) return sweep.error();
  return BoneScene{.ct = std::move(*ct),
                   .anatomy = std::move(*anatomy),
                   .sweep = std::move(*sweep),
                   .truth = truth,
                   .views = std::move(views)};
}

std::optional<double> true_bone_mm(const sim::Anatomy& anatomy, const ImageView& view,
                                   const Eigen::Vector2d& start_mm, const Eigen::Vector2d& along,
                                   double limit_mm) {
  const auto bone = [&](double mm) {
    const Eigen::Vector2d p = start_mm + mm * along;
    return anatomy.tissue(view * Point<frames::Image>{{p.x(), p.y(), 0}}) == sim::Tissue::kBone;
  };
  for (double mm = 0; mm <= limit_mm; mm += kTraceStepMm) {
    if (!bone(mm)) continue;
    double low = std::max(mm - kTraceStepMm, 0.0);
    double high = mm;
    for (int i = 0; i < 6; ++i) {
      const double middle = 0.5 * (low + high);
      (bone(middle) ? high : low) = middle;
    }
    return high;
  }
  return {};
}

}  // namespace nav::bench
