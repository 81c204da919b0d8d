// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_sample.hpp"

/// spec::phong() and spec::gooch() in lanes. See cpu_kernel.hpp for V and for the files that may
/// include this.
namespace nav::render {

template <class V, MarchShade kShade>
struct Shader {
  using F = typename V::F;

  const Sampler<V>& sampler;

  static F clamp01(F x) { return V::max(V::set(0.0F), V::min(V::set(1.0F), x)); }

  /// cosine^shininess. Integer exponents need few products and no slow logarithm. Cosines so small
  /// that the products would underflow are raised to a value whose power is still negligible
  /// compared with 1.
  static F shine(const MarchInputs& in, F cosine) {
    if (in.whole_shininess < 0) return V::power(cosine, in.shininess);
    F square = V::max(cosine, V::set(in.least_cosine));
    F product = V::set(1.0F);
    for (int left = in.whole_shininess; left > 0; left >>= 1) {
      if ((left & 1) != 0) product = V::mul(product, square);
      square = V::mul(square, square);
    }
    return product;
  }

  static void phong(const MarchInputs& in, const F* rgb, F cosine, F* full) {
    const F lit = V::madd(cosine, V::set(in.diffuse), V::set(in.ambient));
    const F gloss = V::mul(V::set(in.specular), shine(in, cosine));
    for (int c = 0; c < 3; ++c) full[c] = clamp01(V::madd(rgb[c], lit, gloss));
  }

  static void gooch(const MarchInputs& in, const F* rgb, F cosine, F towards, F* full) {
    constexpr float kBlueOfCool = 0.4F;    // spec::kGoochBlue
    constexpr float kYellowOfWarm = 0.4F;  // spec::kGoochYellow
    const F half = V::set(0.5F);
    const F warmth = clamp01(V::madd(towards, half, half));
    const F edge = V::sub(V::set(1.0F), cosine);
    const F square = V::mul(edge, edge);
    const F dark = V::sub(V::set(1.0F), V::mul(V::set(in.silhouette), V::mul(square, square)));
    for (int c = 0; c < 3; ++c) {
      const F cool = V::madd(rgb[c], V::set(in.cool_share), V::set(c == 2 ? kBlueOfCool : 0.0F));
      const F warm = V::madd(rgb[c], V::set(in.warm_share), V::set(c == 2 ? 0.0F : kYellowOfWarm));
      full[c] = clamp01(V::mul(dark, Sampler<V>::lerp(cool, warm, warmth)));
    }
  }

  /// Shades colours with a gradient as spec::shade_sample() does.
  void shade(const F* g, F share, F* rgb) const {
    const MarchInputs& in = sampler.in;
    const F norm = Sampler<V>::length(g);
    // A zero gradient has weight 0, so the quotient only has to be finite.
    const F per_norm = V::div(V::set(1.0F), V::max(norm, V::set(1e-20F)));
    const F dot = sampler.along_ray(g);
    const F cosine = V::min(V::set(1.0F), V::mul(V::abs(dot), per_norm));
    const F weight =
        V::mul(share, V::min(V::set(1.0F), V::mul(norm, V::set(in.per_full_gradient))));
    F full[3];
    if constexpr (kShade == MarchShade::kGooch) {
      F lit = V::mul(g[0], V::set(in.light[0]));
      lit = V::madd(g[1], V::set(in.light[1]), V::madd(g[2], V::set(in.light[2]), lit));
      lit = V::mul(lit, per_norm);
      const F turned = V::select(V::less(V::set(0.0F), dot), V::sub(V::set(0.0F), lit), lit);
      gooch(in, rgb, cosine, turned, full);
    } else {
      phong(in, rgb, cosine, full);
    }
    for (int c = 0; c < 3; ++c) rgb[c] = Sampler<V>::lerp(rgb[c], full[c], weight);
  }
};

}  // namespace nav::render
