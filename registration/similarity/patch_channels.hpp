// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "registration/similarity/ct_texels.hpp"
#include "registration/similarity/lc2_kernel.hpp"

namespace nav::registration {

/// A patch of some index, laid into the Grid of whole().
struct IndexedPatch {
  std::size_t index;
  PlacedPatch placed;
};

/// The channels of a whole CT where patches look, made when one first looks there: each patch has a
/// box, with room to move, of its own or one that it shares with neighbours. Fewer texels than the
/// CT has where patches are few; each is to the last bit that of make_ct_channels() over box_of()
/// the CT. Threads: patches of different indices may be asked for at once, one index by one thread.
class PatchChannels {
 public:
  /// patches: how many there are; ct must outlive it. Errors: those of make_ct_channels().
  static Result<PatchChannels> create(const Volume& ct, double sigma_mm, double texel_sigmas,
                                      std::size_t patches);

  /// Geometry of the whole, without texels.
  [[nodiscard]] const CtChannels& whole() const { return whole_; }
  /// Channels that hold all samples of a patch that was placed in the Grid of whole(); its centre
  /// is moved into theirs. Precondition: index below the number of patches.
  const CtChannels& around(std::size_t index, PlacedPatch& placed);
  /// Makes boxes for patches that do not lie in theirs, all in one pass over the CT: one for those
  /// near each other where it is smaller than theirs together. Of a shared box only what its
  /// patches may look at is set. While nobody else asks. Precondition: as around().
  void share(std::span<const IndexedPatch> patches);
  /// Whether all samples of a patch lie where its box is set. Precondition: as around().
  [[nodiscard]] bool sees(std::size_t index, const PlacedPatch& placed) const;
  /// How many texels a box for this patch has.
  [[nodiscard]] double texels_for(const PlacedPatch& placed) const;

 private:
  struct Box {
    TexelPart part;  ///< Of the whole lattice.
    CtChannels channels;
  };

  /// What a patch may look at of a box: between low and high, Grid of the whole, mm.
  struct View {
    Eigen::Vector3d low, high;
    std::shared_ptr<const Box> box;
  };
  struct Member {
    std::size_t index;
    TexelPart part;
  };
  /// Patches that share a box, and the part that holds theirs.
  struct Group {
    TexelPart part;
    std::vector<Member> members;
  };

  PatchChannels(const Volume& ct, TexelLattice lattice, CtChannels whole, std::size_t patches)
      : ct_(ct), lattice_(std::move(lattice)), whole_(std::move(whole)), views_(patches) {}
  void look_from(std::size_t index, const TexelPart& part, std::shared_ptr<const Box> box);
  [[nodiscard]] std::optional<TexelPart> part_for(const PlacedPatch& placed,
                                                  double margin_mm) const;
  [[nodiscard]] std::shared_ptr<Box> empty_box(const TexelPart& part) const;
  [[nodiscard]] std::vector<TexelRun> runs_of(const Group& group) const;

  const Volume& ct_;
  TexelLattice lattice_;
  CtChannels whole_;
  std::vector<View> views_;  // By index; without a box: none yet.
};

}  // namespace nav::registration
