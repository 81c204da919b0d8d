// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_pack.hpp"
#include "render/cpu/cpu_kernel_part.hpp"

/// Shading of runs of pre-integrated cells. See cpu_kernel.hpp for V and for the files that may
/// include this.
namespace nav::render {

template <class V, MarchShade kShade>
struct RunShades {
  using F = typename V::F;
  using M = typename V::M;
  using Part = CellPart<V>;

  const MarchInputs& in;
  const Sampler<V>& sampler;
  MarchCounts& counts;

  /// Sets the spec::shades_of() positions of each lane's cell.
  void find_places(Part& part, M shaded) const {
    CellShades<V>& shades = part.shades;
    const F one = V::set(1.0F);
    const F weight = V::max(part.weight, V::set(0.0F));
    F wanted = V::mul(V::set(in.shades_per_root), V::sqrt(weight));
    wanted = V::min(V::floor(V::add(wanted, V::set(0.5F))),
                    V::set(static_cast<float>(kMarchMostShades)));
    shades.per = V::div(one, V::max(one, wanted));
    do {
      shades.open[shades.places++] = shaded;
      shaded = V::both(shaded, V::less(V::set(static_cast<float>(shades.places) + 0.5F), wanted));
    } while (V::any(shaded));
  }

  /// Shades the colours of the parts that show.
  void shade(Part* parts, int run) const {
    int lanes = 0;
    int all = 0;
    for (int i = 0; i < run; ++i) {
      if (!parts[i].shows) continue;
      const CellShades<V>& shades = parts[i].shades;
      for (int j = 0; j < shades.places; ++j) lanes += V::count(shades.open[j]);
      all += shades.places;
    }
    counts.gradients += static_cast<std::uint64_t>(lanes);
    if constexpr (V::kPacks) {
      if ((lanes + V::kLanes - 1) / V::kLanes < all) {
        shade_packed(parts, run);
        return;
      }
    }
    for (int i = 0; i < run; ++i) {
      if (!parts[i].shows) continue;
      mean_of_shades(parts[i], [&](int j, F* full) {
        const M open = parts[i].shades.open[j];
        const F* rgb = parts[i].colour.rgb;
        for (int c = 0; c < 3; ++c) full[c] = rgb[c];
        F gradient[3];
        sampler.gradient(place(parts[i], j), open, gradient);
        Shader<V, kShade>{sampler}.shade(gradient, parts[i].shades.share, full);
        for (int c = 0; c < 3; ++c) full[c] = V::mask(open, full[c]);
      });
    }
  }

 private:
  /// Position at which shade i is taken, in cells.
  static F place(const Part& part, int i) {
    return V::madd(part.shades.per, V::set(static_cast<float>(i) + 0.5F), part.cell);
  }

  /// Does the same with the same bytes, for cells in which few lanes are shaded.
  void shade_packed(Part* parts, int run) const {
    ShadePack<V, kShade> pack;
    for (int i = 0; i < run; ++i) {
      if (!parts[i].shows) continue;
      const CellShades<V>& shades = parts[i].shades;
      for (int j = 0; j < shades.places; ++j) {
        pack.add(place(parts[i], j), parts[i].colour.rgb, shades.share, shades.open[j]);
      }
    }
    pack.shade(sampler);
    for (int i = 0; i < run; ++i) {
      if (!parts[i].shows) continue;
      mean_of_shades(parts[i], [&](int j, F* full) { pack.take(parts[i].shades.open[j], full); });
    }
  }

  /// \p shade: fills in the shades of a position, with 0 in lanes that are not open there.
  template <class Shade>
  static void mean_of_shades(Part& part, const Shade& shade) {
    const CellShades<V>& shades = part.shades;
    if (shades.places == 0) return;
    F sum[3] = {V::set(0.0F), V::set(0.0F), V::set(0.0F)};
    for (int j = 0; j < shades.places; ++j) {
      F full[3];
      shade(j, full);
      for (int c = 0; c < 3; ++c) sum[c] = V::add(sum[c], full[c]);
    }
    CellColour<V>& colour = part.colour;
    for (int c = 0; c < 3; ++c) {
      colour.rgb[c] = V::select(shades.open[0], V::mul(sum[c], shades.per), colour.rgb[c]);
    }
  }
};

}  // namespace nav::render
