// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/arrangement.hpp"

#include <algorithm>
#include <utility>

namespace nav::app {
namespace {

constexpr int kGap = 6;

struct Columns {
  QRect left, right;
};

/// Divides an area into two columns; share: of the left one.
Columns columns_of(const QRect& area, double share) {
  const int left = std::max(1, static_cast<int>(share * (area.width() - kGap)));
  const int right = std::max(1, area.width() - left - kGap);
  return {QRect(area.left(), area.top(), left, area.height()),
          QRect(area.left() + left + kGap, area.top(), right, area.height())};
}

struct Rows {
  QRect upper, lower;
};

Rows halves_of(const QRect& area) {
  const int upper = std::max(1, (area.height() - kGap) / 2);
  return {QRect(area.left(), area.top(), area.width(), upper),
          QRect(area.left(), area.top() + upper + kGap, area.width(),
                std::max(1, area.height() - upper - kGap))};
}

}  // namespace

namespace {

/// The layout guidance with the panel of a tool below ultrasound and CT.
Arrangement guidance_with_tool(const QRect& area, int tool_width, int numerals_height) {
  const int right =
      std::clamp(static_cast<int>(0.36 * area.width()), 1, std::max(1, area.width() - 1));
  const int left = std::max(1, area.width() - std::max(right, tool_width) - kGap);
  const QRect main(area.left(), area.top(), left, area.height());
  const QRect side(area.left() + left + kGap, area.top(), std::max(1, area.width() - left - kGap),
                   area.height());
  const int tool = std::clamp(static_cast<int>(0.46 * side.height()),
                              std::min(kToolHeight, std::max(1, side.height() - 200)),
                              std::max(1, side.height()));
  const int views = std::max(1, side.height() - tool - kGap);
  const Rows images = halves_of(QRect(side.left(), side.top(), side.width(), views));
  Arrangement made;
  const int height = std::max(1, area.height() - numerals_height - kGap);
  made.views[ViewId::kScene] = QRect(main.left(), main.top(), main.width(), height);
  made.numerals = QRect(main.left(), main.top() + height + kGap, main.width(), numerals_height);
  made.views[ViewId::kUltrasound] = images.upper;
  made.views[ViewId::kCt] = images.lower;
  made.panel = QRect(side.left(), side.top() + views + kGap, side.width(), tool);
  return made;
}

}  // namespace

Arrangement arrange_views(WindowLayout layout, ViewId single, const QRect& area,
                          std::optional<int> tool_width, int numerals_height) {
  if (tool_width && layout == WindowLayout::kGuidance) {
    return guidance_with_tool(area, *tool_width, numerals_height);
  }
  if (tool_width) {
    const int left = std::max(1, area.width() - *tool_width - kGap);
    Arrangement made =
        arrange_views(layout, single, QRect(area.left(), area.top(), left, area.height()),
                      std::nullopt, numerals_height);
    // The numbers keep the whole width below the views.
    if (made.panel) made.numerals.setWidth(left);
    made.panel = QRect(area.left() + left + kGap, area.top(),
                       std::max(1, area.width() - left - kGap), area.height());
    return made;
  }
  Arrangement made;
  const int height = std::max(1, area.height() - numerals_height - kGap);
  const QRect views(area.left(), area.top(), std::max(1, area.width()), height);
  const QRect below(area.left(), area.top() + height + kGap, views.width(), numerals_height);
  if (layout == WindowLayout::kSingle) {
    made.views[single] = views;
    made.numerals = below;
    return made;
  }
  constexpr double kGuidanceShare = 0.64;
  const double share = layout == WindowLayout::kGuidance ? kGuidanceShare : 0.5;
  const Columns columns = columns_of(views, share);
  const Rows right = halves_of(columns.right);
  // The numbers keep the width that they need.
  const Columns foot = columns_of(below, kGuidanceShare);
  made.numerals = foot.left;
  made.panel = foot.right;
  if (layout == WindowLayout::kGuidance) {
    made.views[ViewId::kScene] = columns.left;
    made.views[ViewId::kUltrasound] = right.upper;
    made.views[ViewId::kCt] = right.lower;
    return made;
  }
  const Rows left = halves_of(columns.left);
  if (layout == WindowLayout::kSlices) {
    made.views[ViewId::kAxial] = left.upper;
    made.views[ViewId::kScene] = right.upper;
    made.views[ViewId::kCoronal] = left.lower;
    made.views[ViewId::kSagittal] = right.lower;
    return made;
  }
  made.views[ViewId::kBullsEye] = left.upper;
  made.views[ViewId::kNeedleFirst] = right.upper;
  made.views[ViewId::kUltrasound] = left.lower;
  made.views[ViewId::kNeedleSecond] = right.lower;
  return made;
}

Arrangement arrange_second(const PerView<bool>& views, const QRect& area, int numerals_height) {
  constexpr double kSceneShare = 0.6;
  Arrangement made;
  const int height = std::max(1, area.height() - numerals_height - kGap);
  made.numerals = QRect(area.left(), area.top() + height + kGap, area.width(), numerals_height);
  QRect rest(area.left(), area.top(), area.width(), height);
  const int others = static_cast<int>(std::ranges::count(views.all, true)) -
                     static_cast<int>(views[ViewId::kScene]);
  if (views[ViewId::kScene]) {
    const Columns columns = columns_of(rest, kSceneShare);
    made.views[ViewId::kScene] = others > 0 ? columns.left : rest;
    rest = columns.right;
  }
  if (others == 0) return made;
  constexpr int kMostInAColumn = 2;
  const bool beside = !views[ViewId::kScene] && others > 1;
  const int across = beside || others > kMostInAColumn ? 2 : 1;
  const int down = (others + across - 1) / across;
  const auto part = [](int whole, int count, int i) {
    const int size = std::max(1, (whole - (count - 1) * kGap) / count);
    return std::pair(i * (size + kGap), size);
  };
  int at = 0;
  for (const ViewId id : kFlatViews) {
    if (!views[id]) continue;
    const auto [x, width] = part(rest.width(), across, at % across);
    const auto [y, tall] = part(rest.height(), down, at / across);
    made.views[id] = QRect(rest.left() + x, rest.top() + y, width, tall);
    ++at;
  }
  return made;
}

}  // namespace nav::app
