// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "app/views/slice_view.hpp"

namespace nav::app {

/// Views of the window.
enum class ViewId {
  kScene,
  kUltrasound,
  kCt,
  kAxial,
  kCoronal,
  kSagittal,
  kNeedleFirst,
  kNeedleSecond,
  kBullsEye
};
inline constexpr std::size_t kViewCount = 9;
/// All views but the 3D view, in order.
inline constexpr std::array<ViewId, kViewCount - 1> kFlatViews{
    ViewId::kUltrasound, ViewId::kCt,          ViewId::kAxial,        ViewId::kCoronal,
    ViewId::kSagittal,   ViewId::kNeedleFirst, ViewId::kNeedleSecond, ViewId::kBullsEye};

constexpr std::size_t index_of(ViewId id) { return static_cast<std::size_t>(id); }

/// One value for each view.
template <class T>
struct PerView {
  std::array<T, kViewCount> all{};
  T& operator[](ViewId id) { return all.at(index_of(id)); }
  const T& operator[](ViewId id) const { return all.at(index_of(id)); }
};

/// The slice that a view shows; absent for other views.
constexpr std::optional<SliceKind> slice_of(ViewId id) {
  switch (id) {
    case ViewId::kAxial:
      return SliceKind::kAxial;
    case ViewId::kCoronal:
      return SliceKind::kCoronal;
    case ViewId::kSagittal:
      return SliceKind::kSagittal;
    case ViewId::kNeedleFirst:
      return SliceKind::kNeedleFirst;
    case ViewId::kNeedleSecond:
      return SliceKind::kNeedleSecond;
    default:
      return std::nullopt;
  }
}

/// True for the three slices along the patient's axes.
constexpr bool is_orthogonal(ViewId id) {
  return id == ViewId::kAxial || id == ViewId::kCoronal || id == ViewId::kSagittal;
}

}  // namespace nav::app
