// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>

namespace nav::render {

/// Tells an engine whether the image that it draws is still wanted.
class Interrupt {
 public:
  /// The image is always wanted.
  Interrupt() = default;
  /// \p asked: true once the image is not wanted any more. Engines call it from all their threads,
  /// some thousand times per image.
  explicit Interrupt(std::function<bool()> asked) : asked_(std::move(asked)) {}

  [[nodiscard]] bool requested() const { return asked_ && asked_(); }
  /// False: it is never requested.
  [[nodiscard]] bool possible() const { return asked_ != nullptr; }

 private:
  std::function<bool()> asked_;
};

}  // namespace nav::render
