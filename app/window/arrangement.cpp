// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/arrangement.hpp"

#include <algorithm>

namespace nav::app {
namespace {

constexpr int kGap = 6;
constexpr int kNumeralsHeight = 150;

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

Arrangement arrange_views(WindowLayout layout, ViewId single, const QRect& area) {
  Arrangement made;
  const int height = std::max(1, area.height() - kNumeralsHeight - kGap);
  const QRect views(area.left(), area.top(), std::max(1, area.width()), height);
  const QRect below(area.left(), area.top() + height + kGap, views.width(), kNumeralsHeight);
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

}  // namespace nav::app
