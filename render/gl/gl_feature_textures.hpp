// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/gl/gl_textures.hpp"
#include "render/predicates/set.hpp"

namespace nav::render {

namespace gl {
struct SendLimit;
}

/// The features of predicates on the device, interleaved in textures of four components. So one
/// fetch reads as many as possible, and all textures are of one kind. The volume is the first
/// component. Sent features stay as long as the scene offers them: another predicate set that reads
/// the same features sends nothing. Internal to render/; needs the context current.
class GlFeatureTextures {
 public:
  static constexpr std::size_t kMostTextures = 3;
  static constexpr std::size_t kChannels = 4;  ///< Number of components of a texture.
  static constexpr std::size_t kMostFeatures = kMostTextures * kChannels - 1;

  /// Keeps features as tables of pairs of voxels, without the volume, if such tables can be large
  /// enough.
  void set_voxel_pairs(bool wanted) { wants_pairs_ = wanted; }
  /// True if the features of the last set are tables of pairs.
  [[nodiscard]] bool has_voxel_pairs() const { return pairs_; }
  /// Sends the features that the channels of a set need and the device lacks, as far as limit
  /// allows, and lowers limit. offered: the scene's features. Returns kUnsupportedData for more
  /// than kMostFeatures, and if the device's memory is too small.
  Result<void> update(const PredicateSet& set, const Features& offered, gl::SendLimit& limit);
  /// Bytes that the next update() sends without a limit.
  [[nodiscard]] std::size_t missing_bytes(const PredicateSet& set, const Features& offered) const;
  void release();

  /// Number of textures of the last set, at most kMostTextures.
  [[nodiscard]] std::size_t used() const { return used_.size(); }
  [[nodiscard]] unsigned texture(std::size_t i) {
    Group& group = groups_[used_[i]];
    return pairs_ ? group.pairs.texture.id() : group.texture.id();
  }
  /// Number of features in a texture, including the volume.
  [[nodiscard]] int members(std::size_t i) const {
    return static_cast<int>(groups_[used_[i]].members.size());
  }
  /// True if the first component of the first texture is the volume.
  [[nodiscard]] bool has_volume() const { return !pairs_ && !used_.empty() && used_.front() == 0; }
  /// True if some feature of the last set has undefined voxels.
  [[nodiscard]] bool has_undefined() const { return has_undefined_; }
  /// Texture of the bits of the features that are undefined at one of the eight voxels around a
  /// position, indexed by the lower voxel.
  [[nodiscard]] unsigned undefined_cells() { return undefined_.id(); }

  /// The slot of a channel of the last set: texture, counted as in used(), component, and its bit.
  struct Slot {
    std::size_t texture;
    int component;
    std::uint32_t undefined_bit;
  };
  [[nodiscard]] Slot slot(std::size_t channel) const;
  /// Number of times a texture was sent, for tests.
  [[nodiscard]] int uploads() const { return uploads_; }

 private:
  struct Group {
    GlTexture texture;
    GlTable pairs;  ///< Used instead of texture; member after member.
    std::vector<std::shared_ptr<const StoredVolume>> members;
    std::size_t sent = 0;  ///< Number of members that were sent.
    int slices = 0;        ///< Slices sent of the next member, or of the texture.
  };
  struct Place {
    std::size_t group;
    std::size_t component;
  };
  /// True if a placed feature is no longer offered.
  [[nodiscard]] bool is_stale(const PredicateSet& set, const Features& offered) const;
  [[nodiscard]] const Place* find(const StoredVolume* codes) const;
  Result<void> place(const PredicateSet& set);
  Result<void> send(Group& group, gl::SendLimit& limit);
  [[nodiscard]] bool send_pairs(Group& group, gl::SendLimit& limit) const;
  bool send_texture(Group& group, gl::SendLimit& limit) const;
  Result<void> send_undefined(const PredicateSet& set, gl::SendLimit& limit);
  /// The channels that have undefined voxels, unless they are marked already.
  [[nodiscard]] std::vector<const StoredVolume*> unmarked(const PredicateSet& set) const;

  std::array<Group, kMostTextures> groups_;
  std::vector<std::pair<const StoredVolume*, Place>> places_;
  std::vector<std::size_t> used_;
  std::vector<Place> channels_;  ///< Places of the last set's channels except the first.
  GlTexture undefined_;
  std::vector<const StoredVolume*> undefined_of_;  ///< Volumes whose bits are sent or being sent.
  int undefined_slices_ = 0;                       ///< Number of slices that were sent.
  bool has_undefined_ = false;
  bool wants_pairs_ = false;
  bool pairs_ = false;
  int uploads_ = 0;
};

}  // namespace nav::render
