// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_classify.hpp"

/// Data of a cell in the march before it is blended. See cpu_kernel.hpp for V and for the files
/// that may include this.
namespace nav::render {

template <class V>
struct CellColour {
  typename V::F rgb[3];
  typename V::F tau;
  typename V::F importance;  ///< Set only if it matters.
};

/// Effect of the cutaway on a part; ray_spec.hpp, "Cutaway".
template <class V>
struct CellFade {
  bool any;               ///< Some lane lies in front of T2; otherwise no other member is set.
  typename V::M before;   ///< Lanes in front of T2.
  typename V::M varies;   ///< Lanes of these that are a mean of midpoints.
  typename V::F visible;  ///< Mean of the visibilities at the ends; 1 in lanes not in front.
};

/// Positions of a cell at which its lanes are shaded.
template <class V>
struct CellShades {
  int places;  ///< Greatest number of any lane; 0: the cell is not shaded.
  typename V::M open[kMarchMostShades];  ///< Lanes that are shaded at a position.
  typename V::F per;                     ///< 1 / number of positions of a lane.
  typename V::F share;
};

/// A cell, or its part between the events of the ray.
template <class V>
struct CellPart {
  using F = typename V::F;

  F cell;
  F t_a;  ///< In cells from the ray's base.
  F t_b;
  F v_a;  ///< HU.
  F v_b;
  F bow;  ///< HU; spec::bow_of().
  typename V::M active;
  CellFade<V> fade;  ///< Only with a cutaway.
  bool shows;
  // Valid only if it shows:
  typename Integrals<V>::Sums sums;  ///< Only for pre-integrated cells.
  CellColour<V> colour;
  F opacity;
  F weight;              ///< Weight in the pixel.
  CellShades<V> shades;  ///< Only with shading.
};

}  // namespace nav::render
