// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery_appearances.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "app/appearance/preset_folder.hpp"
#include "render/transfer/transfer_presets.hpp"
#include "sim/tissue.hpp"

namespace nav::bench {
namespace {

constexpr double kEveryValue = std::numeric_limits<double>::infinity();

/// A preset for a volume, with other importances of some of its components.
Result<render::TransferFunction> preset(
    const std::string& name, const Volume& volume,
    const std::vector<std::pair<std::string, double>>& importances) {
  auto read = app::read_preset(name);
  if (!read) return read.error();
  const auto laid = app::appearance_for(*std::move(read), volume);
  if (!laid) return laid.error();
  std::vector<render::ImportanceRule> rules;
  for (const auto& [component, importance] : importances) {
    rules.push_back({-kEveryValue, kEveryValue, importance, component});
  }
  return render::with_importance(laid->transfer, rules);
}

}  // namespace

Result<render::TransferFunction> abdomen_appearance(const Volume& ct,
                                                    const AbdomenImportance& importance) {
  return preset("ct-portal", ct,
                {{"skin", importance.skin},
                 {"flesh", importance.flesh},
                 {"organs", importance.organs},
                 {"vessels", importance.vessels},
                 {"bone", importance.bone}});
}

Result<render::TransferFunction> plain_ct_appearance(const Volume& ct) {
  return preset("ct-native", ct, {});
}

Result<render::TransferFunction> angiography_appearance(const Volume& ct) {
  return preset("cta-emphasis", ct, {});
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

/// Intensity without contrast agent and without suppression: fat is brightest.
double plain_mr_value(sim::Tissue tissue) {
  switch (tissue) {
    using enum sim::Tissue;
    case kFat:
    case kPeritonealFat:
    case kRenalSinus:
    case kMarrow:
      return 900;
    case kHepaticVein:
    case kPortalVein:
    case kAorta:
    case kVenaCava:
      return 260;
    case kKidneyCortex:
    case kKidneyMedulla:
      return 380;
    default:
      return mr_value(tissue);
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

Result<std::shared_ptr<const Volume>> simulated_mr(const sim::AbdomenPhantom& phantom, MrFat fat) {
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
          const sim::Tissue tissue = phantom.tissue({p + 0.5 * kSpacingMm * off});
          sum += fat == MrFat::kBright ? plain_mr_value(tissue) : mr_value(tissue);
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

Result<render::TransferFunction> mr_appearance(const Volume& mr, double vessels) {
  return preset("mr-fat-suppressed", mr, {{"vessels", vessels}});
}

}  // namespace nav::bench
