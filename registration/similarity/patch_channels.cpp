// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/patch_channels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nav/check.hpp"
#include "nav/index.hpp"

namespace nav::registration {
namespace {

// Largest movement of a typical solve on the next finer level.
constexpr double kRoomMm = 4;
// Rim of the channels that the kernel avoids, texels.
constexpr double kBoxRim = 0.01;

TexelPart hull(const TexelPart& p, const TexelPart& q) {
  TexelPart out{};
  for (std::size_t a = 0; a < 3; ++a) {
    out.first[a] = std::min(p.first[a], q.first[a]);
    out.size[a] = std::max(p.first[a] + p.size[a], q.first[a] + q.size[a]) - out.first[a];
  }
  return out;
}

std::size_t texels_in(const TexelPart& part) {
  return as_size(part.size[0]) * as_size(part.size[1]) * as_size(part.size[2]);
}

/// Approximate work for a box: its texels, plus the overhead of each row and each slice.
std::size_t work_for(const TexelPart& part) {
  constexpr int kRow = 32;
  constexpr int kRows = 8;
  return as_size(part.size[0] + kRow) * as_size(part.size[1] + kRows) *
         as_size(part.size[2] + kRows);
}

/// Largest distance of the samples from the centre along each axis, mm.
Eigen::Vector3d reach_of(const PlacedPatch& placed) {
  return 0.5 * (placed.side - 1) * (placed.step_a.cwiseAbs() + placed.step_b.cwiseAbs());
}

}  // namespace

Result<PatchChannels> PatchChannels::create(const Volume& ct, double sigma_mm, double texel_sigmas,
                                            std::size_t patches) {
  CtChannels whole;
  auto lattice = lattice_over(ct, box_of(ct.grid()), sigma_mm, texel_sigmas, whole);
  if (!lattice) return lattice.error();
  return PatchChannels(ct, *std::move(lattice), std::move(whole), patches);
}

/// Texels that the samples are interpolated from; absent if the patch is not finite, or farther
/// away than the kernel reads.
std::optional<TexelPart> PatchChannels::part_for(const PlacedPatch& placed,
                                                 double margin_mm) const {
  constexpr double kFarTexels = 2e9;
  const Eigen::Vector3d reach = reach_of(placed) + Eigen::Vector3d::Constant(margin_mm);
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

std::shared_ptr<PatchChannels::Box> PatchChannels::empty_box(const TexelPart& part) const {
  auto box = std::make_shared<Box>(Box{
      part, {.size = part.size, .spacing_mm = whole_.spacing_mm, .directions = whole_.directions}});
  const Eigen::Vector3d first(part.first[0], part.first[1], part.first[2]);
  box->channels.origin_ct_mm =
      whole_.origin_ct_mm + whole_.directions * first.cwiseProduct(whole_.spacing_mm);
  return box;
}

void PatchChannels::look_from(std::size_t index, const TexelPart& part,
                              std::shared_ptr<const Box> box) {
  constexpr double kAnywhere = std::numeric_limits<double>::infinity();
  View& view = views_[index];
  view.box = std::move(box);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const double spacing = whole_.spacing_mm[axis];
    const int end = part.first[a] + part.size[a];
    // Beyond the lattice the border values are used.
    view.low[axis] = part.first[a] == 0 ? -kAnywhere : spacing * (part.first[a] + kBoxRim);
    view.high[axis] = end == whole_.size[a] ? kAnywhere : spacing * (end - 1 - kBoxRim);
  }
}

bool PatchChannels::sees(std::size_t index, const PlacedPatch& placed) const {
  NAV_CHECK(index < views_.size(), index, views_.size());
  const View& view = views_[index];
  const Eigen::Vector3d reach = reach_of(placed);
  // Written so that NaN fails.
  return view.box != nullptr && ((placed.centre - reach).array() >= view.low.array()).all() &&
         ((placed.centre + reach).array() <= view.high.array()).all();
}

void PatchChannels::share(std::span<const IndexedPatch> patches) {
  std::vector<Group> groups;
  for (const auto& [index, placed] : patches) {
    if (sees(index, placed)) continue;
    const auto own = part_for(placed, kRoomMm);
    if (!own) continue;
    // Choose the group that grows least, or a new group if no growth is smaller than the patch's
    // own box.
    std::size_t least = work_for(*own);
    Group* best = nullptr;
    for (Group& group : groups) {
      const std::size_t more = work_for(hull(group.part, *own)) - work_for(group.part);
      if (more >= least) continue;
      least = more;
      best = &group;
    }
    if (best == nullptr) best = &groups.emplace_back(Group{*own, {}});
    best->part = hull(best->part, *own);
    best->members.push_back({index, *own});
  }
  std::vector<TexelOrder> orders;
  for (const Group& group : groups) {
    const std::shared_ptr<Box> box = empty_box(group.part);
    TexelArray& texels = box->channels.texels;
    texels.resize(texels_in(group.part));
    orders.push_back({group.part, runs_of(group), std::span(texels)});
    for (const Member& member : group.members) look_from(member.index, member.part, box);
  }
  fill_texels(ct_, lattice_, orders);
}

/// Returns for each row of a group's part the run that its patches need, from the first to the last
/// texel.
std::vector<TexelRun> PatchChannels::runs_of(const Group& group) const {
  const TexelPart& part = group.part;
  std::vector<TexelRun> runs(as_size(part.size[1]) * as_size(part.size[2]), {part.size[0], 0});
  for (const auto& [index, own] : group.members) {
    const int from = own.first[0] - part.first[0];
    const int to = from + own.size[0];
    for (int k = 0; k < own.size[2]; ++k) {
      const int slice = own.first[2] - part.first[2] + k;
      TexelRun* run = &runs[as_size(slice * part.size[1] + own.first[1] - part.first[1])];
      for (int j = 0; j < own.size[1]; ++j, ++run) {
        run->from = std::min(run->from, from);
        run->to = std::max(run->to, to);
      }
    }
  }
  return runs;
}

const CtChannels& PatchChannels::around(std::size_t index, PlacedPatch& placed) {
  if (!sees(index, placed)) {
    const auto part = part_for(placed, kRoomMm);
    if (!part) {  // Such a patch reads no texel.
      placed.centre.setConstant(std::numeric_limits<double>::quiet_NaN());
      return whole_;
    }
    const std::shared_ptr<Box> box = empty_box(*part);
    fill_texels(ct_, lattice_, *part, box->channels.texels);
    look_from(index, *part, box);
  }
  const Box& box = *views_[index].box;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    placed.centre[axis] -= box.part.first[a] * whole_.spacing_mm[axis];
  }
  return box.channels;
}

double PatchChannels::texels_for(const PlacedPatch& placed) const {
  const auto part = part_for(placed, kRoomMm);
  return part ? static_cast<double>(texels_in(*part)) : 0.0;
}

}  // namespace nav::registration
