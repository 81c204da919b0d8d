// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/persistence.hpp"

#include <cstdint>

namespace nav::sim {

void Persistence::apply(UltrasoundImage& frame) {
  if (!(share_ > 0)) return;
  const auto pixels = frame.pixels.pixels();
  if (shown_.size() != pixels.size()) {
    shown_.assign(pixels.begin(), pixels.end());
    return;
  }
  std::vector<std::uint8_t> mixed(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    shown_[i] = share_ * shown_[i] + (1 - share_) * static_cast<float>(pixels[i]);
    mixed[i] = static_cast<std::uint8_t>(shown_[i] + 0.5F);
  }
  frame.pixels = {frame.pixels.width(), frame.pixels.height(), std::move(mixed)};
}

}  // namespace nav::sim
