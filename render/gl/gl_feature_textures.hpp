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

/// The features of predicates on the device, interleaved in textures of four components, so that
/// one fetch reads what it can and all textures are of one kind; the volume is the first component.
/// What has been sent stays as long as the scene offers it: another set that reads the same
/// features sends nothing. Internal to render/; needs the context current.
class GlFeatureTextures {
 public:
  static constexpr std::size_t kMostTextures = 3;
  static constexpr std::size_t kChannels = 4;  ///< Of a texture.
  static constexpr std::size_t kMostFeatures = kMostTextures * kChannels - 1;

  /// Features are tables of pairs of voxels, without the volume, where such tables are large
  /// enough.
  void set_voxel_pairs(bool wanted) { wants_pairs_ = wanted; }
  /// What the last set's are.
  [[nodiscard]] bool has_voxel_pairs() const { return pairs_; }
  /// Sends what the channels of a set need and what is not there, as far as a limit allows, which
  /// is lowered. offered: the scene's features. kUnsupportedData for more than kMostFeatures and
  /// for what the device's memory does not hold.
  Result<void> update(const PredicateSet& set, const Features& offered, gl::SendLimit& limit);
  /// Bytes that the next update() sends where nothing limits it.
  [[nodiscard]] std::size_t missing_bytes(const PredicateSet& set, const Features& offered) const;
  void release();

  /// Textures of the last set, at most kMostTextures.
  [[nodiscard]] std::size_t used() const { return used_.size(); }
  [[nodiscard]] unsigned texture(std::size_t i) {
    Group& group = groups_[used_[i]];
    return pairs_ ? group.pairs.texture.id() : group.texture.id();
  }
  /// Features in it, and the volume.
  [[nodiscard]] int members(std::size_t i) const {
    return static_cast<int>(groups_[used_[i]].members.size());
  }
  /// The first component of the first texture is the volume.
  [[nodiscard]] bool has_volume() const { return !pairs_ && !used_.empty() && used_.front() == 0; }
  /// Some feature of the last set has voxels without a value.
  [[nodiscard]] bool has_undefined() const { return has_undefined_; }
  /// Bits of the features without a value at one of the eight voxels around a place, by the voxel
  /// below it.
  [[nodiscard]] unsigned undefined_cells() { return undefined_.id(); }

  /// Where a channel of the last set is: texture, counted as in used(), component; and its bit.
  struct Slot {
    std::size_t texture;
    int component;
    std::uint32_t undefined_bit;
  };
  [[nodiscard]] Slot slot(std::size_t channel) const;
  /// How often a texture was sent, for tests.
  [[nodiscard]] int uploads() const { return uploads_; }

 private:
  struct Group {
    GlTexture texture;
    GlTable pairs;  ///< Instead, member after member.
    std::vector<std::shared_ptr<const Volume>> members;
    std::size_t sent = 0;  ///< Members that are there.
    int slices = 0;        ///< Of the next one, or of the texture.
  };
  struct Place {
    std::size_t group;
    std::size_t component;
  };
  /// Whether something that is placed has gone.
  [[nodiscard]] bool is_stale(const PredicateSet& set, const Features& offered) const;
  [[nodiscard]] const Place* find(const Volume* codes) const;
  Result<void> place(const PredicateSet& set);
  Result<void> send(Group& group, gl::SendLimit& limit);
  [[nodiscard]] bool send_pairs(Group& group, gl::SendLimit& limit) const;
  bool send_texture(Group& group, gl::SendLimit& limit) const;
  Result<void> send_undefined(const PredicateSet& set, gl::SendLimit& limit);
  /// The channels with voxels without a value, unless they are marked already.
  [[nodiscard]] std::vector<const Volume*> unmarked(const PredicateSet& set) const;

  std::array<Group, kMostTextures> groups_;
  std::vector<std::pair<const Volume*, Place>> places_;
  std::vector<std::size_t> used_;
  std::vector<Place> channels_;  ///< Of the last set's channels but the first.
  GlTexture undefined_;
  std::vector<const Volume*> undefined_of_;  ///< Whose bits are there, or are being sent.
  int undefined_slices_ = 0;                 ///< Of them there.
  bool has_undefined_ = false;
  bool wants_pairs_ = false;
  bool pairs_ = false;
  int uploads_ = 0;
};

}  // namespace nav::render
