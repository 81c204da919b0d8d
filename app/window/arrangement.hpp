// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QRect>
#include <optional>

#include "app/window/view_id.hpp"

namespace nav::app {

/// Arrangements of the views, by keys 1 to 4.
enum class WindowLayout { kGuidance, kSlices, kNeedle, kSingle };

/// Rectangles of the views in a part of the window.
struct Arrangement {
  PerView<std::optional<QRect>> views{};  ///< Absent: not on the screen.
  QRect numerals{};                       ///< On the screen in every layout.
  std::optional<QRect> panel{};           ///< Absent: not on the screen.
};

/// Space that the panel of a tool needs, pixels; a larger window gives more.
inline constexpr int kToolWidth = 372;
inline constexpr int kToolHeight = 400;
inline constexpr int kNumeralsHeight = 150;

/// Places the views of a layout. single: the view that fills the area in the layout single. All
/// rectangles have at least one pixel and lie apart from each other where the area is large enough.
/// tool_width: width that the open panel of a tool needs; absent: none is open. It stands below the
/// ultrasound in the layout guidance, at the right in others, and is kToolHeight high at least.
/// numerals_height: height of the numbers, pixels.
Arrangement arrange_views(WindowLayout layout, ViewId single, const QRect& area,
                          std::optional<int> tool_width = std::nullopt,
                          int numerals_height = kNumeralsHeight);

/// Places views on a screen of their own, with the numbers below: the 3D view at the left beside
/// others, which are in one column, or in two if they are more than two. views: at least one.
Arrangement arrange_second(const PerView<bool>& views, const QRect& area,
                           int numerals_height = kNumeralsHeight);

}  // namespace nav::app
