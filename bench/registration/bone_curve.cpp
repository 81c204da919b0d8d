// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/bone_curve.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "bench/measure.hpp"
#include "registration/bone/bone_registration.hpp"
#include "registration/bone/ct_bone.hpp"
#include "registration/bone/scan_lines.hpp"
#include "registration/similarity/image_outline.hpp"
#include "registration/twist.hpp"
#include "sim/random.hpp"

namespace nav::bench {
namespace {

constexpr double kFoundMm = 2;
constexpr double kWrongBoneMm = 3;
constexpr double kMirroredStartMm = 5;
constexpr double kMirroredStartRad = 0.05;

double share_of(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(share * last))];
}

void count_echoes(const BoneScene& scene, const registration::BoneOfSweep& bone,
                  BoneFinding& finding) {
  const Sweep outlined = registration::with_outline(scene.sweep);
  const registration::ScanLines scan(outlined, registration::BoneDetectorOptions{}.line_mm);
  const double limit_mm = scan.step_mm() * (scan.depths() - 1);
  for (std::size_t i = 0; i < bone.images.size(); ++i) {
    std::vector<double> depths(static_cast<std::size_t>(scan.lines()), -1);
    for (const auto& one : bone.images[i]) {
      depths[static_cast<std::size_t>(one.line)] = (one.at_mm - scan.at_mm(one.line, 0)).norm();
    }
    for (int line = 0; line < scan.lines(); ++line) {
      const auto truth = true_bone_mm(*scene.anatomy, scene.views[i], scan.at_mm(line, 0),
                                      scan.along(line), limit_mm);
      const double depth = depths[static_cast<std::size_t>(line)];
      finding.with_bone += truth ? 1 : 0;
      if (depth < 0) continue;
      if (!truth) {
        ++finding.without_bone;
      } else if (std::abs(depth - *truth) > kFoundMm) {
        ++finding.far;
      } else {
        ++finding.found;
        finding.depth_errors_mm.push_back(depth - *truth);
      }
    }
  }
}

CtPose start_from(const CtPose& truth, const Eigen::Vector3d& centre, double mm, double rad,
                  std::uint64_t seed) {
  sim::Random random(seed, 0x7374617274);
  registration::Vector6d twist;
  twist << rad * random.offset(1).normalized(), mm * random.offset(1).normalized();
  return registration::moved(truth, centre, twist);
}

Result<void> register_scene(const BoneScene& scene, const registration::BoneOfSweep& bone,
                            const BoneCurveOptions& options, std::uint64_t seed,
                            BoneFinding& finding) {
  const auto points = registration::bone_points(bone, scene.sweep, 0.6);
  const auto threshold = registration::bone_threshold_hu(scene.ct);
  if (points.empty() || !threshold) return {};
  const std::pair<Eigen::Vector3d, Eigen::Vector3d> all{Eigen::Vector3d::Constant(-1e6),
                                                        Eigen::Vector3d::Constant(1e6)};
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& one : points) {
    centre += (scene.truth * one.at).mm / static_cast<double>(points.size());
  }
  for (const bool mirrored : {false, true}) {
    const Volume ct = mirrored ? scene.mirrored_ct() : scene.ct;
    const auto surface = registration::bone_surface(ct, *threshold, all);
    if (!surface) return surface.error();
    const CtPose start =
        mirrored ? start_from(scene.truth, centre, kMirroredStartMm, kMirroredStartRad, seed)
                 : start_from(scene.truth, centre, options.start_mm, options.start_rad, seed);
    ++(mirrored ? finding.mirrored : finding.runs);
    const auto result = registration::register_bone(bone, scene.sweep, *surface, start);
    if (!result) {
      finding.undetermined += mirrored ? 0 : 1;
      continue;
    }
    const bool accepted =
        registration::decide(*result, {}, result->shape.uncertainty.centre_ct).accepted;
    if (mirrored) {
      finding.mirrored_accepted += accepted ? 1 : 0;
      continue;
    }
    double squares = 0;
    for (const auto& one : points) {
      squares +=
          ((result->shape.ct_from_reference * one.at).mm - (scene.truth * one.at).mm).squaredNorm();
    }
    const double error_mm = std::sqrt(squares / static_cast<double>(points.size()));
    finding.accepted += accepted ? 1 : 0;
    finding.wrong_accepted += accepted && error_mm > kWrongBoneMm ? 1 : 0;
    if (result->shape.sliding.empty()) {
      finding.errors_mm.push_back(error_mm);
    } else {
      ++finding.undetermined;
    }
  }
  return {};
}

}  // namespace

Result<std::vector<BoneFinding>> measure_bones(const BoneCurveOptions& options,
                                               const std::function<void(double)>& progress) {
  std::vector<BoneFinding> out;
  const double all = static_cast<double>(options.levels.size()) * kBoneSites;
  for (const ErrorLevel level : options.levels) {
    for (int s = 0; s < kBoneSites; ++s) {
      BoneFinding finding{.site = static_cast<BoneSite>(s), .level = level};
      for (int i = 0; i < options.sweeps; ++i) {
        const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(i);
        const auto scene = make_bone_scene(finding.site, seed, level, options.images);
        if (!scene) return scene.error();
        const double before_s = process_time_s();
        const auto bone = registration::bone_of_sweep(scene->sweep, {}, 1);
        if (!bone) return bone.error();
        finding.detect_ms += 1e3 * (process_time_s() - before_s) /
                             static_cast<double>(scene->views.size()) / options.sweeps;
        count_echoes(*scene, *bone, finding);
        if (finding.site == BoneSite::kNoBone) continue;
        if (auto ok = register_scene(*scene, *bone, options, seed, finding); !ok) return ok.error();
      }
      out.push_back(std::move(finding));
      progress(static_cast<double>(out.size()) / all);
    }
  }
  return out;
}

std::string to_text(const std::vector<BoneFinding>& findings) {
  std::ostringstream text;
  text << "bone in simulated sweeps: lines with bone, share found within 2 mm, echoes far from "
          "bone and on lines without it,\ndepth error median and p95 of its size (mm), ms an "
          "image; registrations, determined ones' error median (mm), accepted, wrong,\n"
          "undetermined, mirrored accepted\n";
  text << std::fixed;
  for (const BoneFinding& one : findings) {
    std::vector<double> sizes;
    for (const double e : one.depth_errors_mm) sizes.push_back(std::abs(e));
    text << std::left << std::setw(11) << to_string(one.site) << std::setw(7)
         << to_string(one.level) << std::right << std::setprecision(2) << std::setw(7)
         << one.with_bone << std::setw(6)
         << static_cast<double>(one.found) / std::max(one.with_bone, 1) << std::setw(6) << one.far
         << std::setw(6) << one.without_bone << std::setw(7) << share_of(one.depth_errors_mm, 0.5)
         << std::setw(6) << share_of(sizes, 0.95) << std::setw(6) << one.detect_ms << " |"
         << std::setw(4) << one.runs << std::setw(7) << share_of(one.errors_mm, 0.5) << std::setw(4)
         << one.accepted << std::setw(4) << one.wrong_accepted << std::setw(4) << one.undetermined
         << std::setw(4) << one.mirrored_accepted << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
