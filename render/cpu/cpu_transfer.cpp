// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_transfer.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "render/rounding.hpp"

namespace nav::render {
namespace {

std::vector<Eigen::Vector4d> premultiplied(const TransferTable& table) {
  std::vector<Eigen::Vector4d> out(static_cast<std::size_t>(table.size()));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = Eigen::Map<const Eigen::Vector4f>(table.rgbat().data() + 4 * i).cast<double>();
    out[i].head<3>() *= out[i][3];
  }
  return out;
}

/// Entry for the values from value to value + change, in quanta.
IntegralEntry stretch(const Eigen::Vector4d& before, const Eigen::Vector4d& value,
                      const Eigen::Vector4d& change, double quantum) {
  IntegralEntry entry{};
  for (int c = 0; c < 4; ++c) {
    entry.before[c] = rounded(before[c] / quantum);
    entry.half[c] = static_cast<float>(0.5 * value[c] / quantum);
    entry.bend[c] = static_cast<float>(0.5 * change[c] / quantum);
  }
  return entry;
}

}  // namespace

std::vector<TableEntry> march_entries(const TransferTable& table) {
  const auto row = static_cast<std::size_t>(table.size());
  std::vector<TableEntry> entries(row * static_cast<std::size_t>(table.rows()));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const float* value = table.rgbat().data() + 4 * i;
    std::copy_n(value, 4, entries[i].value);
    const bool last = i % row == row - 1;
    for (std::size_t c = 0; c < 4; ++c) entries[i].to_next[c] = last ? 0 : value[c + 4] - value[c];
  }
  return entries;
}

MarchIntegrals march_integrals(const TransferTable& table, double low_hu, double high_hu) {
  const std::vector<Eigen::Vector4d> values = premultiplied(table);
  Eigen::Vector4d total = Eigen::Vector4d::Zero();
  for (std::size_t i = 1; i < values.size(); ++i) total += 0.5 * (values[i - 1] + values[i]);
  // Colour is at most 1, so extinction has the largest integral.
  const double held = values.front()[3] * std::max(table.first_hu() - low_hu, 0.0) +
                      values.back()[3] * std::max(high_hu - table.last_hu(), 0.0);
  const double quantum = std::max(held + total[3], 1e-12) / kLargestIntegral;
  MarchIntegrals out;
  out.quantum = static_cast<float>(quantum);
  out.entries.reserve(values.size() + 1);
  const Eigen::Vector4d none = Eigen::Vector4d::Zero();
  out.entries.push_back(stretch(none, values.front(), none, quantum));
  Eigen::Vector4d sum = none;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    out.entries.push_back(stretch(sum, values[i], values[i + 1] - values[i], quantum));
    sum += 0.5 * (values[i] + values[i + 1]);
  }
  out.entries.push_back(stretch(sum, values.back(), none, quantum));
  return out;
}

}  // namespace nav::render
