// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl_transfer_table.hpp"

#include <algorithm>
#include <cmath>

namespace nav::render {
namespace {

constexpr double kMaxExactRangeHu = 16000;  // Every OpenGL 4.1 device has 16384 texels in a row.
constexpr int kInexactEntries = 4096;

bool whole_numbers(const std::vector<TransferNode>& nodes) {
  return std::all_of(nodes.begin(), nodes.end(),
                     [](const TransferNode& node) { return node.hu == std::round(node.hu); });
}

}  // namespace

TransferTable::TransferTable(const TransferFunction& transfer)
    : first_hu(transfer.nodes().front().hu) {
  const double range_hu = transfer.nodes().back().hu - first_hu;
  const bool exact = whole_numbers(transfer.nodes()) && range_hu <= kMaxExactRangeHu;
  const int count = exact ? static_cast<int>(range_hu) + 1 : kInexactEntries;
  per_hu = (count - 1) / range_hu;
  rgbat.reserve(4 * static_cast<std::size_t>(count));
  visible_before_.reserve(static_cast<std::size_t>(count) + 1);
  visible_before_.push_back(0);
  for (int i = 0; i < count; ++i) {
    const TransferSample sample = transfer.at(first_hu + i / per_hu);
    for (int c = 0; c < 3; ++c) rgbat.push_back(static_cast<float>(sample.rgb(c)));
    rgbat.push_back(static_cast<float>(sample.tau_per_mm));
    visible_before_.push_back(visible_before_.back() + (rgbat.back() > 0 ? 1 : 0));
  }
}

bool TransferTable::visible(double low_hu, double high_hu) const {
  const double last = entries() - 1;
  const auto entry = [&](double hu) { return (hu - first_hu) * per_hu; };
  const double first = std::clamp(std::floor(entry(low_hu)) - 1, 0.0, last);
  const double end = std::clamp(std::ceil(entry(high_hu)) + 1, 0.0, last);
  return visible_before_[static_cast<std::size_t>(end) + 1] >
         visible_before_[static_cast<std::size_t>(first)];
}

}  // namespace nav::render
