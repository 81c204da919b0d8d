// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/register_bone.hpp"

#include <sstream>

#include "app/verbs/register/register_shape.hpp"
#include "io/surface_file.hpp"
#include "registration/bone/ct_bone.hpp"

namespace nav::app {
namespace {

constexpr double kBonePieceMm = 1.5;
// Bone of the CT farther than this from the echoes at the start is out of reach.
constexpr double kReachMm = 80;

Result<registration::Shape> bone_of_ct(const Volume& ct, const std::vector<Eigen::Vector3d>& echoes,
                                       std::optional<double>& threshold_hu) {
  threshold_hu = registration::bone_threshold_hu(ct);
  if (!threshold_hu) {
    return Error{ErrorCode::kRefused, ct.name() + ": expected bone in the CT, found none"};
  }
  Eigen::Vector3d low = echoes.front();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3d& p : echoes) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return registration::bone_surface(ct, *threshold_hu,
                                    {low.array() - kReachMm, high.array() + kReachMm});
}

}  // namespace

Result<BoneOutcome> register_bone_of(const Sweep& sweep, const Volume& ct,
                                     const std::filesystem::path& surface,
                                     const Transform<frames::Ct, frames::Reference>& start,
                                     int threads, const std::function<bool()>& keep_going) {
  const auto bone = registration::bone_of_sweep(sweep, {}, threads);
  if (!bone) return bone.error();
  const registration::BoneRegistrationOptions options;
  std::vector<Eigen::Vector3d> echoes;
  for (const auto& one : registration::bone_points(*bone, sweep, options.least_confidence)) {
    echoes.push_back((start * one.at).mm);
  }
  if (echoes.empty() || bone->share() < kEnoughBone) {
    std::ostringstream text;
    text.precision(2);
    text << "bone: expected it on at least " << 100 * kEnoughBone
         << " % of the scan lines, found it on " << 100 * bone->share()
         << " %: show more bone, or register by tissue";
    return Error{ErrorCode::kRefused, text.str()};
  }
  std::optional<double> threshold_hu;
  Result<registration::Shape> shape = [&]() -> Result<registration::Shape> {
    if (surface.empty()) return bone_of_ct(ct, echoes, threshold_hu);
    const auto mesh = io::read_surface(surface);
    if (!mesh) return mesh.error();
    return registration::outward_shape(*mesh, kBonePieceMm);
  }();
  if (!shape) return shape.error();
  auto result = registration::register_bone(*bone, sweep, *shape, start, options, keep_going);
  if (!result) return result.error();
  return BoneOutcome{std::move(*result), threshold_hu};
}

io::Json json_of(const BoneOutcome& outcome, const registration::Decision& decision,
                 const Point<frames::Ct>& target) {
  io::Json json = json_of(outcome.result.shape, decision, target);
  json["bone"] = {
      {"echoes", outcome.result.echoes},
      {"line_share", outcome.result.share},
      {"threshold_hu", outcome.threshold_hu ? io::Json(*outcome.threshold_hu) : io::Json(nullptr)},
      {"from_whole_surface_mm", json_number(outcome.result.from_whole_mm)}};
  return json;
}

}  // namespace nav::app
