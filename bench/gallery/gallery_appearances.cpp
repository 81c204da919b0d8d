// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery_appearances.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "sim/tissue.hpp"

namespace nav::bench {
namespace {

using Rgb = Eigen::Vector3d;

const Rgb kSkinRgb(0.78, 0.58, 0.44);
const Rgb kFleshRgb(0.72, 0.25, 0.20);
const Rgb kOrganRgb(0.90, 0.74, 0.38);
const Rgb kVesselRgb(0.22, 0.42, 0.90);
const Rgb kBoneRgb(0.97, 0.94, 0.87);

/// A trapezoid over values: opaque from full to full_to, clear outside from and to.
render::TransferComponent trapezoid(const std::string& name, std::array<double, 4> hu,
                                    const Rgb& rgb, double opacity, double importance) {
  return {name,
          {{hu[0], rgb, 0, importance},
           {hu[1], rgb, opacity, importance},
           {hu[2], rgb, opacity, importance},
           {hu[3], rgb, 0, importance}},
          {}};
}

render::TransferFunction made(const std::string& name,
                              std::vector<render::TransferComponent> components) {
  auto transfer = render::TransferFunction::blend(name, std::move(components));
  NAV_CHECK(transfer.has_value(), name);
  return *transfer;
}

render::TransferComponent bone_above(double hu, double importance) {
  return {"bone",
          {{hu, kBoneRgb, 0, importance},
           {hu + 160, kBoneRgb, 0.35, importance},
           {hu + 600, Rgb(1, 0.98, 0.95), 0.8, importance}},
          {}};
}

}  // namespace

render::TransferFunction abdomen_appearance(const AbdomenImportance& importance) {
  // Rims of bones pass through the values of vessels on 300 HU/mm and more; rims of vessels in the
  // liver are below 60 HU/mm.
  auto vessels = trapezoid("vessels", {142, 160, 186, 194}, kVesselRgb, 0.45, importance.vessels);
  vessels.gradient = render::GradientWindow{0, 0, 60, 110};
  return made("abdomen",
              {trapezoid("skin", {-180, -130, -60, -20}, kSkinRgb, 0.10, importance.skin),
               trapezoid("flesh", {-10, 40, 75, 90}, kFleshRgb, 0.08, importance.flesh),
               trapezoid("organs", {84, 100, 130, 150}, kOrganRgb, 0.10, importance.organs),
               std::move(vessels), bone_above(230, importance.bone)});
}

render::TransferFunction plain_ct_appearance(const AbdomenImportance& importance) {
  return made("plain CT",
              {trapezoid("skin", {-180, -130, -60, -20}, kSkinRgb, 0.10, importance.skin),
               trapezoid("flesh", {-10, 30, 80, 120}, kFleshRgb, 0.08, importance.flesh),
               bone_above(150, importance.bone)});
}

render::TransferFunction angiography_appearance() {
  const Rgb red(0.86, 0.16, 0.12);
  // Blood of the aorta lies at 350 to 510 HU in this scan, that of the veins below 200; rims of
  // bones reach the same values on steeper slopes, metal lies above.
  auto vessels = trapezoid("vessels", {270, 350, 520, 620}, red, 0.30, 1);
  vessels.gradient = render::GradientWindow{0, 0, 70, 140};
  return made(
      "angiography",
      {trapezoid("skin", {-220, -160, -60, -20}, kSkinRgb, 0.004, 0.02),
       std::move(vessels),
       {"bone",
        {{220, kBoneRgb, 0, 0.08}, {330, kBoneRgb, 0.05, 0.08}, {900, kBoneRgb, 0.35, 0.08}},
        {}}});
}

namespace {

/// Intensity of a tissue in contrast-enhanced, fat-suppressed T1; made up to order as such images
/// do: enhanced blood and kidneys brightest, then spleen, liver, muscle; bone and air dark.
double mr_value(sim::Tissue tissue) {
  switch (tissue) {
    using enum sim::Tissue;
    case kHepaticVein:
    case kPortalVein:
    case kAorta:
    case kVenaCava:
      return 950;
    case kKidneyCortex:
    case kKidneyMedulla:
      return 820;
    case kSpleen:
      return 620;
    case kLiver:
      return 520;
    case kLesion:
      return 380;
    case kSkin:
      return 360;
    case kBowelWall:
    case kPortalWall:
    case kGallbladderWall:
      return 400;
    case kMuscle:
    case kDiaphragm:
    case kDisc:
      return 300;
    case kBile:
    case kSpinalCanal:
    case kBowelContent:
      return 200;
    case kMarrow:
    case kFat:
    case kPeritonealFat:
    case kRenalSinus:
      return 130;
    case kBone:
    case kCartilage:
      return 60;
    default:
      return 0;
  }
}

/// Two independent uniform numbers in (0, 1) of a voxel, to two normal ones by Box and Muller.
std::array<double, 2> normal_pair(std::uint64_t voxel) {
  const auto uniform = [&](std::uint64_t salt) {
    std::uint64_t h = (voxel * 2 + salt + 1) * 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    return (static_cast<double>((h ^ (h >> 31)) >> 11) + 0.5) / 9007199254740992.0;
  };
  const double radius = std::sqrt(-2 * std::log(uniform(0)));
  const double angle = 2 * M_PI * uniform(1);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace

Result<std::shared_ptr<const Volume>> simulated_mr(const sim::AbdomenPhantom& phantom) {
  constexpr double kSpacingMm = 1.6;
  constexpr double kNoise = 22;
  VoxelGrid grid;
  grid.size = {188, 150, 138};
  grid.spacing_mm.setConstant(kSpacingMm);
  grid.origin_mm = Eigen::Vector3d(-150, -120, -110);
  std::vector<std::int16_t> values;
  values.reserve(grid.voxel_count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d p = grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm;
        double sum = 0;  // Partial volume: eight points of the voxel.
        for (int corner = 0; corner < 8; ++corner) {
          const Eigen::Vector3d off((corner & 1) - 0.5, (corner >> 1 & 1) - 0.5,
                                    (corner >> 2 & 1) - 0.5);
          sum += mr_value(phantom.tissue({p + 0.5 * kSpacingMm * off}));
        }
        const double gain = 1 + 0.15 * std::cos(p.x() / 110) * std::sin(p.y() / 90);
        const auto noise = normal_pair(values.size());
        const double rician = std::hypot(gain * sum / 8 + kNoise * noise[0], kNoise * noise[1]);
        values.push_back(static_cast<std::int16_t>(std::lround(rician)));
      }
    }
  }
  auto volume = Volume::create(grid, std::move(values), "simulated MR");
  if (!volume) return volume.error();
  return std::make_shared<const Volume>(std::move(*volume));
}

render::TransferFunction mr_appearance(double vessels) {
  return made("MR", {trapezoid("surface", {70, 110, 160, 220}, kSkinRgb, 0.06, 0.1),
                     trapezoid("flesh", {230, 280, 380, 430}, kFleshRgb, 0.05, 0.05),
                     trapezoid("organs", {440, 490, 640, 720}, kOrganRgb, 0.08, 0.4),
                     trapezoid("vessels", {720, 820, 1200, 2000}, kVesselRgb, 0.40, vessels)});
}

}  // namespace nav::bench
