// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/predicates/predicate_legend.hpp"
#include "render/canvas.hpp"
#include "render/scene.hpp"
#include "render/slices/slice.hpp"
#include "session/navigator.hpp"
#include "session/needle_size.hpp"

namespace nav::app {

/// What the flat parts of a refresh show.
struct PanelContext {
  const session::Epoch& epoch;
  const Volume& ct;
  const std::optional<NeedlePlan>& plan;
  render::HuWindow window;
  const std::string& banner;
  render::Camera camera;  ///< Of the 3D view, for its orientation letters.
  std::string note;  ///< What the engine says of the 3D view ("down-sampled …"); may be empty.
  std::string warning = {};      ///< Of the registration or placement; may be empty.
  bool needle_expected = false;  ///< Its state is shown, as that of a planned one.
  double needle_length_mm = session::NeedleSize{}.length_mm;
  std::vector<LegendEntry> legend = {};         ///< Of predicates in the 3D view.
  std::optional<render::GreyWindow> grey = {};  ///< Of a projection in the 3D view.
};

/// Of words that warn of nothing.
inline constexpr Rgba8 kWords = render::rgb8(0xd8dee4);

/// Green, amber, grey, red.
Rgba8 colour_of(SafetyState state);

/// "L 60  W 400", as on every picture of a CT.
std::string words_of_window(double level, double width);

/// "tip to target 12.3 mm …": the numbers of a needle.
std::string guidance_words(const NeedleGuidance& guidance);

/// Where a direction of the CT (LPS) points in the patient: letters of R, L, A, P, S, I, the
/// strongest first, those above a third of the whole; "RA" is right and, less, anterior.
std::string patient_direction(const Eigen::Vector3d& direction_ct);

/// Where the edges of a view lie: patient_direction() of its axes.
struct ViewLetters {
  std::string left, right, up, down;
};
ViewLetters view_letters(const render::Camera& camera);

/// Whether compose_panels() draws the flat panels beside a 3D view of a size in pixels: words need
/// room.
bool has_panels(int width, int height);

/// Puts the live ultrasound and the CT along the same plane beside the 3D view, and state and
/// numbers below. A stale picture is not drawn: its panel says so. The picture is 3/2 as wide as
/// the view's height more than the view, and one status bar higher.
Image2d<Rgba8> compose_panels(const Image2d<Rgba8>& view_3d, const PanelContext& context);

}  // namespace nav::app
