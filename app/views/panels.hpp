// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/predicates/predicate_legend.hpp"
#include "app/views/overlay.hpp"
#include "render/canvas.hpp"
#include "render/scene.hpp"
#include "render/slices/slice.hpp"
#include "session/guidance_error.hpp"
#include "session/navigator.hpp"
#include "session/needle_size.hpp"

namespace nav::app {

/// Data that the flat panels and the status bar of a refresh show.
struct PanelContext {
  const session::Epoch& epoch;
  const StoredVolume& ct;
  const std::optional<NeedlePlan>& plan;
  render::HuWindow window{};
  const std::string& banner;
  render::Camera camera{};  ///< Camera of the 3D view, for its orientation letters.
  std::string note{};       ///< Engine's note about the 3D view ("down-sampled …"); may be empty.
  std::string warning = {};      ///< Warning about registration or placement; may be empty.
  bool needle_expected = false;  ///< True: show the needle's state even without a plan.
  double needle_length_mm = session::NeedleSize{}.length_mm;
  std::vector<LegendEntry> legend = {};  ///< Colours of the 3D view.
  /// Name of the volume's kind in panels: "CT", or "MR" for values that are not in HU.
  std::string modality = "CT";
  /// Name and settings of the appearance of the 3D view; may be empty.
  std::string appearance = {};
  bool simulated = false;  ///< The patient is simulated; the 3D view says so in words.
  session::GuidanceError guidance_error = {};   ///< Intervals of the numbers of the needle.
  std::optional<render::GreyWindow> grey = {};  ///< Grey window of a projection in the 3D view.
};

/// Colour of a state: green (valid), amber (degraded), grey (stale) or red (lost).
Rgba8 colour_of(SafetyState state);

/// Text such as "L 60  W 400" for a grey window.
std::string words_of_window(double level, double width);

/// Text with the numbers of a needle: "tip to target 12.3 mm …". Behind "+/-" is the half width of
/// the interval that holds the true number with 95 %, for the errors that are known; the text says
/// so. Numbers without a known error have none.
std::string guidance_words(const NeedleGuidance& guidance,
                           const session::GuidanceError& error = {});

/// Letters (R, L, A, P, S, I) of a direction in the patient, the strongest first. Components of at
/// most a third of the length are left out. "RA" means right and, less, anterior.
/// direction_ct: in Ct (LPS), of any length > 0.
std::string patient_direction(const Eigen::Vector3d& direction_ct);

/// Letters for the edges of a view: patient_direction() of its axes.
struct ViewLetters {
  std::string left, right, up, down;
};
ViewLetters view_letters(const render::Camera& camera);

/// Width and height, pixels.
struct PixelSize {
  int width, height;
  bool operator==(const PixelSize&) const = default;
};
/// True when a 3D view of that size, in pixels, is large enough for the flat panels and their text.
/// compose_panels() leaves them out otherwise.
bool has_panels(int width, int height);

/// Puts the live ultrasound and the CT along the same plane beside the 3D view, and states and
/// numbers below. A stale ultrasound image is not drawn; its panel says so. The result is wider
/// than the view by 2/3 of the view's height, and higher by the status bar (60 pixels, and a tenth
/// of the height of views above 600 pixels). Text grows with views above 600 pixels.
Image2d<Rgba8> compose_panels(const Image2d<Rgba8>& view_3d, const PanelContext& context);

}  // namespace nav::app
