// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "nav/index.hpp"
#include "render/rounding.hpp"
#include "render/spec/ray_spec_volume.hpp"

namespace nav::render {
namespace {

constexpr double kMinHu = -32768;
constexpr double kMaxHu = 32767;
/// Two values closer than this count as one: the mean over them is the value in the middle, HU.
constexpr double kSameHu = 1e-3;

/// The gradient magnitude above which nothing changes, HU/mm.
double last_gradient(const TransferFunction& transfer) {
  double last = 0;
  for (const TransferComponent& component : transfer.components()) {
    if (!component.gradient) continue;
    const GradientWindow& w = *component.gradient;
    for (const double edge : {w.zero_below, w.full_from, w.full_to, w.zero_above}) {
      if (std::isfinite(edge)) last = std::max(last, edge);
    }
  }
  return last;
}

}  // namespace

TransferTable::TransferTable(const TransferFunction& transfer) {
  const std::vector<double>& values = transfer.values();
  first_hu_ = std::clamp(std::floor(values.front()), kMinHu, kMaxHu - 1);
  const double last = std::clamp(std::ceil(values.back()), first_hu_ + 1, kMaxHu);
  size_ = static_cast<int>(last - first_hu_) + 1;
  if (transfer.uses_gradient()) {
    rows_ = kGradientRows;
    // A window that starts at 0 and never ends still needs a distance between rows.
    gradient_per_row_ = std::max(last_gradient(transfer), 1e-6) / (kGradientRows - 1);
  }
  const std::size_t entries = as_size(size_) * as_size(rows_);
  rgbat_.reserve(4 * entries);
  importance_.reserve(entries);
  for (int row = 0; row < rows_; ++row) add_row(transfer, row * gradient_per_row_);
  extend_importance();
  integrate();
  index_visible();
}

void TransferTable::add_row(const TransferFunction& transfer, double gradient_hu_per_mm) {
  for (int i = 0; i < size_; ++i) {
    const TransferSample sample = transfer.at(first_hu_ + i, gradient_hu_per_mm);
    for (int c = 0; c < 3; ++c) rgbat_.push_back(static_cast<float>(sample.rgb(c)));
    rgbat_.push_back(static_cast<float>(sample.tau_per_mm));
    const bool visible = rgbat_.back() > 0;
    importance_.push_back(visible ? static_cast<float>(sample.importance) : 0.0F);
    importance_matters_ = importance_matters_ || (visible && importance_.back() < 1);
  }
}

void TransferTable::extend_importance() {
  const auto size = static_cast<std::ptrdiff_t>(size_);
  for (std::ptrdiff_t row = 0; row < rows_; ++row) {
    float* importance = importance_.data() + row * size;
    std::ptrdiff_t last = -1;  // Last visible entry so far.
    for (std::ptrdiff_t i = 0; i <= size; ++i) {
      if (i < size && !(rgbat_[4 * static_cast<std::size_t>(row * size + i) + 3] > 0)) continue;
      // Between two visible entries each takes the nearer one; if there is only one, all take it.
      std::ptrdiff_t middle = (last + i) / 2 + 1;
      if (last < 0) middle = 0;
      if (i == size) middle = last < 0 ? 0 : size;
      for (std::ptrdiff_t j = last + 1; j < i; ++j) {
        if (j < middle) {
          importance[j] = importance[last];
        } else if (i < size) {
          importance[j] = importance[i];
        }
      }
      last = i;
    }
  }
}

Eigen::Vector4d TransferTable::entry(std::size_t i) const {
  return Eigen::Map<const Eigen::Vector4f>(rgbat_.data() + 4 * i).cast<double>();
}

Eigen::Vector4d TransferTable::premultiplied(std::size_t i) const {
  Eigen::Vector4d value = entry(i);
  value.head<3>() *= value[3];
  return value;
}

void TransferTable::integrate() {
  cumulative_.assign(as_size(size_), Eigen::Vector4d::Zero());
  for (std::size_t i = 1; i < cumulative_.size(); ++i) {
    cumulative_[i] = cumulative_[i - 1] + 0.5 * (premultiplied(i - 1) + premultiplied(i));
  }
  // Colours are at most 1, so extinction has the largest integral.
  quantum_ = std::max(cumulative_.back()[3], 1e-12) / kLargestIntegral;
  integrals_.reserve(4 * cumulative_.size());
  for (const Eigen::Vector4d& integral : cumulative_) {
    for (int c = 0; c < 4; ++c) {
      integrals_.push_back(rounded(integral[c] / quantum_));
    }
  }
}

void TransferTable::index_visible() {
  visible_before_.reserve(as_size(size_) + 1);
  visible_before_.assign(1, 0);
  std::vector<float> greatest;
  for (std::size_t i = 0; i < as_size(size_); ++i) {
    bool visible = false;
    float importance = 0;
    for (std::size_t row = 0; row < as_size(rows_); ++row) {
      const std::size_t at = row * as_size(size_) + i;
      visible = visible || rgbat_[4 * at + 3] > 0;
      importance = std::max(importance, importance_[at]);
    }
    visible_before_.push_back(visible_before_.back() + (visible ? 1 : 0));
    greatest.push_back(importance);
  }
  importance_levels_.push_back(std::move(greatest));
  for (std::size_t length = 2; length <= as_size(size_); length *= 2) {
    const std::vector<float>& below = importance_levels_.back();
    std::vector<float> level(below.size() - length / 2);
    for (std::size_t i = 0; i < level.size(); ++i) {
      level[i] = std::max(below[i], below[i + length / 2]);
    }
    importance_levels_.push_back(std::move(level));
  }
}

TransferSample TransferTable::at(double hu, double gradient_hu_per_mm) const {
  const double x = std::clamp(hu - first_hu_, 0.0, size_ - 1.0);
  const auto i = std::min(static_cast<std::size_t>(x), as_size(size_ - 2));
  const double w = x - static_cast<double>(i);
  const double y =
      rows_ > 1 ? std::clamp(gradient_hu_per_mm / gradient_per_row_, 0.0, rows_ - 1.0) : 0.0;
  const auto row_at = [&](std::size_t row) -> Eigen::Vector4d {
    const std::size_t start = row * as_size(size_) + i;
    return (1 - w) * entry(start) + w * entry(start + 1);
  };
  const auto row = std::min(static_cast<std::size_t>(y), as_size(std::max(rows_ - 2, 0)));
  Eigen::Vector4d value = row_at(row);
  if (rows_ > 1) {
    const double v = y - static_cast<double>(row);
    value = (1 - v) * value + v * row_at(row + 1);
  }
  const auto nearest = static_cast<std::size_t>(std::floor(y + 0.5)) * as_size(size_) +
                       static_cast<std::size_t>(std::floor(x + 0.5));
  return {value.head<3>(), value[3], importance_[nearest]};
}

Eigen::Vector4d TransferTable::integral_to(double hu) const {
  const double x = hu - first_hu_;
  const double last = size_ - 1.0;
  if (x <= 0) return x * premultiplied(0);
  if (x >= last) return cumulative_.back() + (x - last) * premultiplied(as_size(size_ - 1));
  const auto i = static_cast<std::size_t>(x);
  const double w = x - static_cast<double>(i);
  const Eigen::Vector4d here = premultiplied(i);
  return cumulative_[i] + w * here + 0.5 * w * w * (premultiplied(i + 1) - here);
}

Eigen::Vector4d TransferTable::premultiplied_at(double hu) const {
  const double x = std::clamp(hu - first_hu_, 0.0, size_ - 1.0);
  const auto i = std::min(static_cast<std::size_t>(x), as_size(size_ - 2));
  const Eigen::Vector4d here = premultiplied(i);
  return here + (x - static_cast<double>(i)) * (premultiplied(i + 1) - here);
}

TransferSample TransferTable::mean(double a_hu, double b_hu, double bow_hu) const {
  if (std::abs(b_hu - a_hu) < kSameHu) {
    TransferSample sample = at(0.5 * (a_hu + b_hu));
    sample.importance = 0;
    return sample;
  }
  Eigen::Vector4d mean = (integral_to(b_hu) - integral_to(a_hu)) / (b_hu - a_hu);
  if (bow_hu != 0) {
    const double share =
        std::clamp(bow_hu / (b_hu - a_hu), -spec::kMaxBowShare, spec::kMaxBowShare);
    mean += share * (premultiplied_at(b_hu) - premultiplied_at(a_hu));
  }
  if (!(mean[3] > 0)) return {Eigen::Vector3d::Zero(), 0, 0};
  return {(mean.head<3>() / mean[3]).cwiseMax(0).cwiseMin(1), mean[3], 0};
}

TransferTable::Entries TransferTable::entries_in(double low_hu, double high_hu) const {
  const double last = size_ - 1;
  return {static_cast<std::size_t>(std::clamp(std::floor(low_hu - first_hu_) - 1, 0.0, last)),
          static_cast<std::size_t>(std::clamp(std::ceil(high_hu - first_hu_) + 1, 0.0, last))};
}

bool TransferTable::visible(double low_hu, double high_hu) const {
  const Entries in = entries_in(low_hu, high_hu);
  return visible_before_[in.last + 1] > visible_before_[in.first];
}

double TransferTable::max_importance(double low_hu, double high_hu) const {
  const Entries in = entries_in(low_hu, high_hu);
  const std::size_t length = in.last - in.first + 1;
  const auto level = static_cast<std::size_t>(std::bit_width(length) - 1);
  const std::vector<float>& greatest = importance_levels_[level];
  return std::max(greatest[in.first], greatest[in.last + 1 - (std::size_t{1} << level)]);
}

double TransferTable::invisible_up_to_hu() const {
  // visible_before_[i + 1] > 0 first where entry i is visible; the entry before is the last
  // invisible one.
  const auto visible = std::upper_bound(visible_before_.begin(), visible_before_.end(), 0);
  if (visible == visible_before_.end()) return std::numeric_limits<double>::infinity();
  const auto clear = visible - visible_before_.begin() - 2;
  if (clear < 0) return -std::numeric_limits<double>::infinity();
  return first_hu_ + static_cast<double>(clear);
}

}  // namespace nav::render
