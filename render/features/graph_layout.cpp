// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/graph_layout.hpp"

#include <cmath>

#include "nav/index.hpp"

namespace nav::render::features {

std::size_t GraphLayout::cells_of(const std::array<int, 3>& size) {
  const std::size_t row = as_size(padded(size[0]) + kLanes);
  return row * (as_size(size[1]) + 2) * (as_size(size[2]) + 2) + 2 * kLanes;
}

GraphLayout::GraphLayout(const std::array<int, 3>& size)
    : size_(size), stride_(padded(size[0]) + kLanes), cells_(cells_of(size)) {
  const std::size_t plane = as_size(stride_) * as_size(size[1] + 2);
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    const auto& s = kEdgeSteps[e];
    offsets_[e] = s[0] + s[1] * stride_ + s[2] * static_cast<std::ptrdiff_t>(plane);
  }
}

FewRows::FewRows(const GraphLayout& layout)
    : rows_(as_size(layout.size()[1])),
      length_(as_size(layout.row_length())),
      slot_(rows_ * as_size(layout.size()[2])),
      values_(length_) {}

float* FewRows::writable(int j, int k) {
  auto& slot = slot_[number(j, k)];
  if (slot == 0) {
    slot = static_cast<std::int32_t>(values_.size() / length_);
    values_.resize(values_.size() + length_);
  }
  return &values_[as_size(slot) * length_];
}

double FewRows::norm() const {
  double squares = 0;
  for (const float v : values_) squares += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(squares);
}

}  // namespace nav::render::features
