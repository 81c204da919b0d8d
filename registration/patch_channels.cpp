// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/patch_channels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nav/check.hpp"
#include "nav/index.hpp"

namespace nav::registration {
namespace {

// A solve on the next finer level goes about so far.
constexpr double kRoomMm = 3;
// The kernel shuns the rim of the channels, texels.
constexpr double kBoxRim = 0.01;

TexelPart hull(const TexelPart& p, const TexelPart& q) {
  TexelPart out{};
  for (std::size_t a = 0; a < 3; ++a) {
    out.first[a] = std::min(p.first[a], q.first[a]);
    out.size[a] = std::max(p.first[a] + p.size[a], q.first[a] + q.size[a]) - out.first[a];
  }
  return out;
}

/// Whether all of a part lies in another.
bool holds(const TexelPart& outer, const TexelPart& inner) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (inner.first[a] < outer.first[a] ||
        inner.first[a] + inner.size[a] > outer.first[a] + outer.size[a]) {
      return false;
    }
  }
  return true;
}

}  // namespace

Result<PatchChannels> PatchChannels::create(const Volume& ct, double sigma_mm, double texel_sigmas,
                                            std::size_t patches) {
  CtChannels whole;
  auto lattice = lattice_over(ct, box_of(ct.grid()), sigma_mm, texel_sigmas, whole);
  if (!lattice) return lattice.error();
  return PatchChannels(ct, *std::move(lattice), std::move(whole), patches);
}

/// Texels that the samples are interpolated from; absent where the patch is not finite, or farther
/// away than the kernel looks.
std::optional<TexelPart> PatchChannels::part_for(const PlacedPatch& placed,
                                                 double margin_mm) const {
  constexpr double kFarTexels = 2e9;
  const Eigen::Vector3d reach =
      0.5 * (placed.side - 1) * (placed.step_a.cwiseAbs() + placed.step_b.cwiseAbs()) +
      Eigen::Vector3d::Constant(margin_mm);
  const Eigen::Vector3d low = (placed.centre - reach).cwiseQuotient(whole_.spacing_mm);
  const Eigen::Vector3d high = (placed.centre + reach).cwiseQuotient(whole_.spacing_mm);
  if (!(low.cwiseAbs().maxCoeff() < kFarTexels && high.cwiseAbs().maxCoeff() < kFarTexels)) {
    return {};
  }
  TexelPart part{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const int last = whole_.size[a] - 1;
    const int from = std::clamp(static_cast<int>(std::floor(low[axis] - kBoxRim)), 0, last - 1);
    const int to =
        std::clamp(static_cast<int>(std::floor(high[axis] + kBoxRim)) + 1, from + 1, last);
    part.first[a] = from;
    part.size[a] = to - from + 1;
  }
  return part;
}

std::shared_ptr<const PatchChannels::Box> PatchChannels::make(const TexelPart& part) const {
  auto box =
      std::make_shared<Box>(Box{part, {part.size, whole_.spacing_mm, {}, whole_.directions, {}}});
  const Eigen::Vector3d first(part.first[0], part.first[1], part.first[2]);
  box->channels.origin_ct_mm =
      whole_.origin_ct_mm + whole_.directions * first.cwiseProduct(whole_.spacing_mm);
  append_texels(ct_, lattice_, part, box->channels.texels);
  return box;
}

/// Texels that have to be smoothed for a part, those that the Gaussian reaches included.
double PatchChannels::work_for(const TexelPart& part) const {
  double texels = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    texels *= part.size[a] + 2.0 * static_cast<double>(lattice_.kernel[a].size());
  }
  return texels;
}

void PatchChannels::share(std::span<const IndexedPatch> patches) {
  struct Group {
    TexelPart part;
    double work;
    std::vector<std::size_t> indices;
  };
  std::vector<Group> groups;
  for (const auto& [index, placed] : patches) {
    NAV_CHECK(index < boxes_.size(), index, boxes_.size());
    const auto needed = part_for(placed, 0);
    if (!needed || (boxes_[index] && holds(boxes_[index]->part, *needed))) continue;
    const TexelPart own = part_for(placed, kRoomMm).value_or(*needed);
    // The group that takes it for the least; one of its own where none takes it for less.
    double least = work_for(own);
    Group* best = nullptr;
    for (Group& group : groups) {
      const double more = work_for(hull(group.part, own)) - group.work;
      if (more >= least) continue;
      least = more;
      best = &group;
    }
    if (best == nullptr) {
      groups.push_back({own, least, {index}});
      continue;
    }
    best->part = hull(best->part, own);
    best->work += least;
    best->indices.push_back(index);
  }
  for (const Group& group : groups) {
    const std::shared_ptr<const Box> box = make(group.part);
    for (const std::size_t index : group.indices) boxes_[index] = box;
  }
}

const CtChannels& PatchChannels::around(std::size_t index, PlacedPatch& placed) {
  NAV_CHECK(index < boxes_.size(), index, boxes_.size());
  std::shared_ptr<const Box>& box = boxes_[index];
  const auto needed = part_for(placed, 0);
  if (!needed) {  // No texel is looked at for such a patch.
    placed.centre.setConstant(std::numeric_limits<double>::quiet_NaN());
    return whole_;
  }
  if (!box || !holds(box->part, *needed)) {
    box = make(part_for(placed, kRoomMm).value_or(*needed));
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    placed.centre[axis] -= box->part.first[a] * whole_.spacing_mm[axis];
  }
  return box->channels;
}

double PatchChannels::texels_for(const PlacedPatch& placed) const {
  const auto part = part_for(placed, kRoomMm);
  return part ? 1.0 * part->size[0] * part->size[1] * part->size[2] : 0.0;
}

}  // namespace nav::registration
