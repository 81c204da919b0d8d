// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nav::render {
namespace {

constexpr double kMinHu = -32768;
constexpr double kMaxHu = 32767;
constexpr double kMaxExactRangeHu = 16000;  // Every OpenGL 4.1 device has 16384 texels in a row.
constexpr int kInexactEntries = 4096;

bool whole_numbers(const std::vector<TransferNode>& nodes) {
  return std::all_of(nodes.begin(), nodes.end(),
                     [](const TransferNode& node) { return node.hu == std::round(node.hu); });
}

}  // namespace

TransferTable TransferTable::at_whole_hu(const TransferFunction& transfer) {
  const double first = std::clamp(std::floor(transfer.nodes().front().hu), kMinHu, kMaxHu - 1);
  const double last = std::clamp(std::ceil(transfer.nodes().back().hu), first + 1, kMaxHu);
  return {transfer, first, 1, static_cast<int>(last - first) + 1};
}

TransferTable TransferTable::for_texture(const TransferFunction& transfer) {
  const double first = transfer.nodes().front().hu;
  const double range_hu = transfer.nodes().back().hu - first;
  if (whole_numbers(transfer.nodes()) && range_hu <= kMaxExactRangeHu) {
    return {transfer, first, 1, static_cast<int>(range_hu) + 1};
  }
  return {transfer, first, (kInexactEntries - 1) / range_hu, kInexactEntries};
}

TransferTable::TransferTable(const TransferFunction& transfer, double first_hu, double per_hu,
                             int size)
    : first_hu_(first_hu), per_hu_(per_hu) {
  rgbat_.reserve(4 * static_cast<std::size_t>(size));
  visible_before_.reserve(static_cast<std::size_t>(size) + 1);
  visible_before_.push_back(0);
  for (int i = 0; i < size; ++i) {
    const TransferSample sample = transfer.at(first_hu_ + i / per_hu_);
    for (int c = 0; c < 3; ++c) rgbat_.push_back(static_cast<float>(sample.rgb(c)));
    rgbat_.push_back(static_cast<float>(sample.tau_per_mm));
    visible_before_.push_back(visible_before_.back() + (rgbat_.back() > 0 ? 1 : 0));
  }
}

bool TransferTable::visible(double low_hu, double high_hu) const {
  const double last = size() - 1;
  const auto entry = [&](double hu) { return (hu - first_hu_) * per_hu_; };
  const double first = std::clamp(std::floor(entry(low_hu)) - 1, 0.0, last);
  const double end = std::clamp(std::ceil(entry(high_hu)) + 1, 0.0, last);
  return visible_before_[static_cast<std::size_t>(end) + 1] >
         visible_before_[static_cast<std::size_t>(first)];
}

double TransferTable::invisible_up_to_hu() const {
  // visible_before_[i + 1] > 0 first where entry i is visible; the one before is the last clear.
  const auto visible = std::upper_bound(visible_before_.begin(), visible_before_.end(), 0);
  if (visible == visible_before_.end()) return std::numeric_limits<double>::infinity();
  const auto clear = visible - visible_before_.begin() - 2;
  if (clear < 0) return -std::numeric_limits<double>::infinity();
  return first_hu_ + static_cast<double>(clear) / per_hu_;
}

bool same_tables(const TransferFunction& a, const TransferFunction& b) {
  return std::equal(a.nodes().begin(), a.nodes().end(), b.nodes().begin(), b.nodes().end(),
                    [](const TransferNode& x, const TransferNode& y) {
                      return x.hu == y.hu && x.rgb == y.rgb && x.opacity == y.opacity;
                    });
}

}  // namespace nav::render
