// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "registration/ct_texels.hpp"
#include "registration/lc2_kernel.hpp"

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
  /// Makes boxes for patches that do not lie in theirs, one for those near each other where that is
  /// less work than one for each: most of it is the rim that the Gaussian reaches into. While
  /// nobody else asks. Precondition: as around().
  void share(std::span<const IndexedPatch> patches);
  /// How many texels a box for this patch has.
  [[nodiscard]] double texels_for(const PlacedPatch& placed) const;

 private:
  struct Box {
    TexelPart part;  ///< Of the whole lattice.
    CtChannels channels;
  };

  PatchChannels(const Volume& ct, TexelLattice lattice, CtChannels whole, std::size_t patches)
      : ct_(ct), lattice_(std::move(lattice)), whole_(std::move(whole)), boxes_(patches) {}
  [[nodiscard]] std::optional<TexelPart> part_for(const PlacedPatch& placed,
                                                  double margin_mm) const;
  [[nodiscard]] std::shared_ptr<const Box> make(const TexelPart& part) const;
  [[nodiscard]] double work_for(const TexelPart& part) const;

  const Volume& ct_;
  TexelLattice lattice_;
  CtChannels whole_;
  std::vector<std::shared_ptr<const Box>> boxes_;  // By index; null: none yet.
};

}  // namespace nav::registration
