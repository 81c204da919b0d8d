// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>

#include "nav/index.hpp"
#include "render/gl/gl_feature_textures.hpp"
#include "render/gl/gl_upload.hpp"

namespace nav::render {
namespace {

/// Interleaves a slice of the codes of up to four volumes, voxel by voxel. Undefined codes and
/// missing volumes become 0. as_they_are: keeps the codes of the first volume, because it is no
/// feature.
void interleave(const std::vector<std::shared_ptr<const StoredVolume>>& members, bool as_they_are,
                int k, std::int16_t* to) {
  static_assert(GlFeatureTextures::kChannels == 4);
  const auto& size = members[0]->grid().size;
  const std::size_t row = as_size(size[0]);
  const std::vector<std::int16_t> missing(row);
  const auto defined = [](std::int16_t v) -> int { return v == FeatureVolume::kUndefined ? 0 : v; };
  for (int j = 0; j < size[1]; ++j) {
    const std::size_t first = (as_size(k) * as_size(size[1]) + as_size(j)) * row;
    std::array<const std::int16_t*, 4> from{};
    for (std::size_t c = 0; c < from.size(); ++c) {
      from[c] = c < members.size() ? members[c]->values().data() + first : missing.data();
    }
    for (std::size_t i = 0; i < row; ++i, to += 4) {
      to[0] = static_cast<std::int16_t>(as_they_are ? from[0][i] : defined(from[0][i]));
      to[1] = static_cast<std::int16_t>(defined(from[1][i]));
      to[2] = static_cast<std::int16_t>(defined(from[2][i]));
      to[3] = static_cast<std::int16_t>(defined(from[3][i]));
    }
  }
}

/// A volume that has undefined voxels, and its bit.
struct Holes {
  const StoredVolume* codes;
  std::uint16_t bit;
};

/// Writes for each cell of a slice the bits of the volumes that are undefined at one of its
/// corners.
void mark_undefined(const std::vector<Holes>& holes, int k, std::uint16_t* cells) {
  const auto& n = holes[0].codes->grid().size;
  const auto row = as_size(n[0]);
  const auto slice = row * as_size(n[1]);
  std::fill_n(cells, slice, std::uint16_t{0});
  std::vector<std::uint8_t> here(row + 1);  // 1: undefined in one of the four rows.
  for (const Holes& of : holes) {
    const std::int16_t* voxels = of.codes->values().data();
    for (int j = 0; j < n[1]; ++j) {
      const std::size_t first = as_size(k) * slice + as_size(j) * row;
      const std::size_t up = j + 1 < n[1] ? row : 0;
      const std::size_t behind = k + 1 < n[2] ? slice : 0;
      const std::int16_t* const rows[4] = {voxels + first, voxels + first + up,
                                           voxels + first + behind, voxels + first + up + behind};
      for (std::size_t i = 0; i < row; ++i) {
        const auto empty = [&](int r) { return rows[r][i] == FeatureVolume::kUndefined ? 1 : 0; };
        here[i] = static_cast<std::uint8_t>(empty(0) | empty(1) | empty(2) | empty(3));
      }
      std::uint16_t* to = cells + as_size(j) * row;
      for (std::size_t i = 0; i < row; ++i) {
        const int open = here[i] | here[i + 1];
        to[i] = static_cast<std::uint16_t>(to[i] | (open * of.bit));
      }
    }
  }
}

Result<void> accepted(const std::string& what) {
  if (glGetError() == GL_NO_ERROR) return {};
  return Error{
      ErrorCode::kUnsupportedData,
      what + ": the memory of this OpenGL device is full; the CPU engine draws such scenes"};
}

}  // namespace

const GlFeatureTextures::Place* GlFeatureTextures::find(const StoredVolume* codes) const {
  const auto found = std::find_if(places_.begin(), places_.end(),
                                  [&](const auto& place) { return place.first == codes; });
  return found == places_.end() ? nullptr : &found->second;
}

bool GlFeatureTextures::is_stale(const PredicateSet& set, const Features& offered) const {
  const auto& first = groups_[0].members;
  const bool with_volume = !first.empty() && !pairs_;
  if (with_volume && first[0] != set.channels()[0].codes) return true;
  return std::any_of(places_.begin(), places_.end(), [&](const auto& place) {
    return std::none_of(offered.volumes.begin(), offered.volumes.end(), [&](const auto& named) {
      return named.second.codes().get() == place.first;
    });
  });
}

std::size_t GlFeatureTextures::missing_bytes(const PredicateSet& set,
                                             const Features& offered) const {
  const auto& size = set.channels()[0].codes->grid().size;
  const std::size_t slice = as_size(size[0]) * as_size(size[1]);
  const bool pairs = wants_pairs_ && gl::has_room_for_pairs(size, kChannels);
  const bool stale = pairs != pairs_ || is_stale(set, offered);
  const std::size_t texel = pairs ? sizeof(std::uint32_t) : kChannels * sizeof(std::int16_t);
  std::size_t slices = 0;
  for (std::size_t c = 1; c < set.channels().size(); ++c) {
    const Place* at = stale ? nullptr : find(set.channels()[c].codes.get());
    const Group* group = at != nullptr ? &groups_[at->group] : nullptr;
    const bool there = group != nullptr && at->component < group->sent;
    const bool begun = group != nullptr && at->component == group->sent;
    if (!there) slices += as_size(size[2] - (begun ? group->slices : 0));
  }
  std::size_t bytes = slices * slice * texel;
  if (stale || !unmarked(set).empty()) {
    bytes += slice * as_size(size[2]) * sizeof(std::uint16_t);
  }
  return bytes;
}

Result<void> GlFeatureTextures::update(const PredicateSet& set, const Features& offered,
                                       gl::SendLimit& limit) {
  const bool pairs =
      wants_pairs_ && gl::has_room_for_pairs(set.channels()[0].codes->grid().size, kChannels);
  const bool stale = pairs != pairs_ || is_stale(set, offered);
  const auto missing = [&] {
    return std::count_if(set.channels().begin() + 1, set.channels().end(),
                         [&](const auto& channel) { return !find(channel.codes.get()); });
  };
  if (stale || places_.size() + as_size(static_cast<int>(missing())) > kMostFeatures) release();
  pairs_ = pairs;
  if (auto ok = place(set); !ok) return ok;
  used_.clear();
  channels_.clear();
  for (std::size_t c = 1; c < set.channels().size(); ++c) {
    channels_.push_back(*find(set.channels()[c].codes.get()));
    const std::size_t group = channels_.back().group;
    if (std::find(used_.begin(), used_.end(), group) == used_.end()) used_.push_back(group);
  }
  std::sort(used_.begin(), used_.end());
  for (const std::size_t g : used_) {
    if (groups_[g].sent == groups_[g].members.size() || limit.bytes == 0) continue;
    if (auto ok = send(groups_[g], limit); !ok) return ok;
  }
  return send_undefined(set, limit);
}

Result<void> GlFeatureTextures::place(const PredicateSet& set) {
  for (std::size_t c = 1; c < set.channels().size(); ++c) {
    const auto& codes = set.channels()[c].codes;
    if (find(codes.get()) != nullptr) continue;
    const std::size_t at = places_.size() + (pairs_ ? 0 : 1);  // After the volume.
    if (places_.size() == kMostFeatures) {
      return Error{ErrorCode::kUnsupportedData,
                   "predicates: expected at most " + std::to_string(kMostFeatures) +
                       " features on the GL engine, found more; the CPU engine draws such scenes"};
    }
    if (at == 1 && !pairs_) groups_[0].members = {set.channels()[0].codes};
    Group& group = groups_[at / kChannels];
    group.members.push_back(codes);
    if (!pairs_) group.sent = group.slices = 0;
    places_.push_back({codes.get(), {at / kChannels, at % kChannels}});
  }
  return {};
}

bool GlFeatureTextures::send_pairs(Group& group, gl::SendLimit& limit) const {
  const auto& size = group.members[0]->grid().size;
  // Room for all members that may follow: unwritten parts take no memory yet.
  if (group.sent == 0 && group.slices == 0 && !gl::start_pairs(group.pairs, size, kChannels)) {
    return false;
  }
  const std::size_t slice = sizeof(std::uint32_t) * as_size(size[0]) * as_size(size[1]);
  while (group.sent < group.members.size()) {
    const int count = limit.take(size[2] - group.slices, slice);
    if (count == 0) return true;
    const gl::SliceRange slices{group.slices, group.slices + count};
    const bool filled = gl::fill_pairs(
        group.pairs, group.sent, *group.members[group.sent], slices,
        [](std::int16_t v) { return v == FeatureVolume::kUndefined ? std::int16_t{0} : v; });
    if (!filled) return false;
    group.slices = slices.end % size[2];
    if (group.slices == 0) ++group.sent;
  }
  return true;
}

bool GlFeatureTextures::send_texture(Group& group, gl::SendLimit& limit) const {
  const bool with_volume = &group == &groups_[0];
  const auto& size = group.members[0]->grid().size;
  const std::size_t slice = kChannels * sizeof(std::int16_t) * as_size(size[0]) * as_size(size[1]);
  const int count = limit.take(size[2] - group.slices, slice);
  if (count == 0) return true;
  const gl::SliceRange slices{group.slices, group.slices + count};
  glBindTexture(GL_TEXTURE_3D, group.texture.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_LINEAR);
  // Also for a single feature: drivers compile again for other kinds of textures.
  gl::send_slices<std::int16_t>(
      GL_RGBA16_SNORM, GL_RGBA, GL_SHORT, size, slices, kChannels,
      [&](int k, std::int16_t* to) { interleave(group.members, with_volume, k, to); });
  group.slices = slices.end % size[2];
  if (group.slices == 0) group.sent = group.members.size();
  return true;
}

Result<void> GlFeatureTextures::send(Group& group, gl::SendLimit& limit) {
  const bool sent = pairs_ ? send_pairs(group, limit) : send_texture(group, limit);
  ++uploads_;
  auto ok = accepted("features of predicates");
  if (!ok || !sent) group.sent = group.slices = 0;
  return ok;
}

std::vector<const StoredVolume*> GlFeatureTextures::unmarked(const PredicateSet& set) const {
  std::vector<const StoredVolume*> holes;
  for (std::size_t c = 1; c < set.channels().size(); ++c) {
    if (set.channels()[c].has_undefined) holes.push_back(set.channels()[c].codes.get());
  }
  if (holes.empty()) return holes;
  const bool known = std::all_of(holes.begin(), holes.end(), [&](const StoredVolume* codes) {
    return std::find(undefined_of_.begin(), undefined_of_.end(), codes) != undefined_of_.end();
  });
  const bool whole = undefined_slices_ == set.channels()[0].codes->grid().size[2];
  return known && whole ? std::vector<const StoredVolume*>() : holes;
}

Result<void> GlFeatureTextures::send_undefined(const PredicateSet& set, gl::SendLimit& limit) {
  has_undefined_ = std::any_of(set.channels().begin() + 1, set.channels().end(),
                               [](const auto& channel) { return channel.has_undefined; });
  std::vector<const StoredVolume*> holes = unmarked(set);
  if (holes.empty()) return {};
  if (holes != undefined_of_) undefined_slices_ = 0;
  const auto& size = set.channels()[0].codes->grid().size;
  const std::size_t slice = sizeof(std::uint16_t) * as_size(size[0]) * as_size(size[1]);
  const int count = limit.take(size[2] - undefined_slices_, slice);
  if (count == 0) return {};
  std::vector<Holes> marked;
  for (const StoredVolume* codes : holes) {
    const Place place = *find(codes);
    marked.push_back(
        {codes, static_cast<std::uint16_t>(1U << (place.group * kChannels + place.component))});
  }
  const gl::SliceRange slices{undefined_slices_, undefined_slices_ + count};
  glBindTexture(GL_TEXTURE_3D, undefined_.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_NEAREST);
  gl::send_slices<std::uint16_t>(GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, size, slices, 1,
                                 [&](int k, std::uint16_t* to) { mark_undefined(marked, k, to); });
  ++uploads_;
  undefined_slices_ = 0;
  undefined_of_.clear();
  if (auto ok = accepted("undefined voxels of predicates"); !ok) return ok;
  undefined_slices_ = slices.end;
  undefined_of_ = std::move(holes);
  return {};
}

GlFeatureTextures::Slot GlFeatureTextures::slot(std::size_t channel) const {
  const Place& at = channels_[channel - 1];
  const auto used = std::find(used_.begin(), used_.end(), at.group);
  return {static_cast<std::size_t>(used - used_.begin()), static_cast<int>(at.component),
          1U << (at.group * kChannels + at.component)};
}

void GlFeatureTextures::release() {
  for (Group& group : groups_) {
    group.texture.release();
    group.pairs.release();
    group.members.clear();
    group.sent = 0;
    group.slices = 0;
  }
  undefined_.release();
  undefined_slices_ = 0;
  places_.clear();
  undefined_of_.clear();
  used_.clear();
  channels_.clear();
}

}  // namespace nav::render
