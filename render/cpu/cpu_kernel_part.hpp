// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel_classify.hpp"

/// What a march knows of a cell before it is blended. See cpu_kernel.hpp for V and for where this
/// may be included.
namespace nav::render {

template <class V>
struct CellColour {
  typename V::F rgb[3];
  typename V::F tau;
  typename V::F importance;  ///< Only where it matters.
};

/// How the cutaway treats a part; ray_spec.hpp, "Cutaway".
template <class V>
struct CellFade {
  bool any;               ///< Some lane lies in front of T2; else nothing else is set.
  typename V::M before;   ///< In front of T2.
  typename V::M varies;   ///< Of these, lanes that are a mean of midpoints.
  typename V::F visible;  ///< Mean of the visibilities at the ends; 1 in lanes not in front.
};

/// At which places of a cell its lanes are shaded.
template <class V>
struct CellShades {
  int places;                            ///< Most of any lane; 0: the cell is not shaded.
  typename V::M open[kMarchMostShades];  ///< Lanes that are shaded at a place.
  typename V::F per;                     ///< 1 over the places of a lane.
  typename V::F share;
};

/// A cell or the part of one between the events of the ray.
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
  // Where it shows:
  typename Integrals<V>::Sums sums;  ///< Only of pre-integrated cells.
  CellColour<V> colour;
  F opacity;
  F weight;              ///< In the pixel.
  CellShades<V> shades;  ///< Only with shading.
};

}  // namespace nav::render
