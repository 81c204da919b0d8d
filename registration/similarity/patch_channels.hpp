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

/// A patch with its index, placed in the Grid of whole().
struct IndexedPatch {
  std::size_t index;
  PlacedPatch placed;
};

/// The channels of a whole CT near the patches, computed when a patch first needs them. Each patch
/// has a box with room to move, of its own or shared with neighbours. If patches are few, these are
/// fewer texels than the whole CT has; each texel has the same bits as in make_ct_channels() over
/// box_of() the CT. Threads: patches of different indices may be requested at once, one index only
/// by one thread.
class PatchChannels {
 public:
  /// patches: number of patches; ct must outlive the result. Errors: those of make_ct_channels().
  static Result<PatchChannels> create(const Volume& ct, double sigma_mm, double texel_sigmas,
                                      std::size_t patches);

  /// Geometry of the whole CT, without texels.
  [[nodiscard]] const CtChannels& whole() const { return whole_; }
  /// Channels that hold all samples of a patch placed in the Grid of whole(); the patch centre is
  /// converted to their Grid. Precondition: index is below the number of patches.
  const CtChannels& around(std::size_t index, PlacedPatch& placed);
  /// Makes boxes for patches that lie outside theirs, all in one pass over the CT. Neighbouring
  /// patches share a box if it is smaller than their own boxes together. In a shared box only the
  /// texels that its patches may need are set. No other call may run at the same time.
  /// Precondition: as for around().
  void share(std::span<const IndexedPatch> patches);
  /// True if all samples of a patch lie in the valid part of its box. Precondition: as for
  /// around().
  [[nodiscard]] bool sees(std::size_t index, const PlacedPatch& placed) const;
  /// Number of texels of a box for this patch.
  [[nodiscard]] double texels_for(const PlacedPatch& placed) const;

 private:
  struct Box {
    TexelPart part;  ///< Part of the whole lattice.
    CtChannels channels;
  };

  /// The part of a box that a patch may read: between low and high, Grid of the whole CT, mm.
  struct View {
    Eigen::Vector3d low, high;
    std::shared_ptr<const Box> box;
  };
  struct Member {
    std::size_t index;
    TexelPart part;
  };
  /// Patches that share a box, and the part that contains all of theirs.
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
  std::vector<View> views_;  // One for each patch index; without a box until it is needed.
};

}  // namespace nav::registration
