// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "registration/ct_texels.hpp"
#include "registration/lc2_kernel.hpp"

namespace nav::registration {

/// The channels of a whole CT where patches look, made when one first looks there: each patch has a
/// box of its own, with room to move. Fewer texels than the CT has where patches are few; each is
/// to the last bit that of make_ct_channels() over box_of() the CT. Threads: patches of different
/// indices may be asked for at once, one index by one thread.
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
  [[nodiscard]] Box make(const TexelPart& part) const;

  const Volume& ct_;
  TexelLattice lattice_;
  CtChannels whole_;
  std::vector<std::optional<Box>> boxes_;
};

}  // namespace nav::registration
