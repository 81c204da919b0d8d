// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_editor.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"

namespace nav::render {

ValueCounts count_values(const StoredVolume& volume, double low, double high, int bins) {
  NAV_CHECK(low < high && bins > 0, low, high, bins);
  constexpr std::size_t kMostRead = std::size_t{1} << 19;
  ValueCounts counts{low, high, std::vector<std::uint64_t>(static_cast<std::size_t>(bins))};
  const auto values = volume.values();
  const std::size_t every = std::max<std::size_t>(1, values.size() / kMostRead);
  const double scale = bins / (high - low);
  for (std::size_t i = 0; i < values.size(); i += every) {
    const double bin = std::floor((values[i] - low) * scale);
    if (bin >= 0 && bin < bins) ++counts.bins[static_cast<std::size_t>(bin)];
  }
  return counts;
}

const TransferNode& most_opaque(const TransferComponent& component) {
  return *std::ranges::max_element(component.nodes, {}, &TransferNode::opacity);
}

double greatest_opacity(const TransferComponent& component) {
  return most_opaque(component).opacity;
}

void TransferEditor::change(std::vector<TransferComponent> components) {
  auto next = TransferFunction::blend(function().name(), std::move(components));
  NAV_CHECK(next.has_value(), next.error().message);
  history_.change(*std::move(next));
}

void TransferEditor::move_node(std::size_t component, std::size_t node, double value,
                               double opacity) {
  auto all = components();
  NAV_CHECK(component < all.size() && node < all[component].nodes.size(), component, node);
  auto& nodes = all[component].nodes;
  // Between the neighbours, which may be nearer to each other than two gaps.
  double low = node > 0 ? nodes[node - 1].hu + kLeastGap : value;
  double high = node + 1 < nodes.size() ? nodes[node + 1].hu - kLeastGap : value;
  if (node > 0 && node + 1 < nodes.size() && low > high) low = high = nodes[node].hu;
  if (std::isfinite(value)) {
    nodes[node].hu =
        node == 0 ? std::min(value, high) : std::clamp(value, low, std::max(low, high));
  }
  if (std::isfinite(opacity)) nodes[node].opacity = std::clamp(opacity, 0.0, kMostOpacity);
  change(std::move(all));
}

void TransferEditor::set_colour(std::size_t component, const Eigen::Vector3d& rgb) {
  auto all = components();
  NAV_CHECK(component < all.size(), component, all.size());
  for (TransferNode& node : all[component].nodes) node.rgb = rgb.cwiseMax(0.0).cwiseMin(1.0);
  change(std::move(all));
}

void TransferEditor::set_opacity(std::size_t component, double greatest) {
  auto all = components();
  NAV_CHECK(component < all.size() && std::isfinite(greatest), component, all.size(), greatest);
  const double to = std::clamp(greatest, 0.0, kMostOpacity);
  const double from = greatest_opacity(all[component]);
  auto& nodes = all[component].nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const bool inner = nodes.size() == 2 || (i > 0 && i + 1 < nodes.size());
    nodes[i].opacity =
        from > 0 ? std::min(nodes[i].opacity / from * to, kMostOpacity) : (inner ? to : 0);
  }
  change(std::move(all));
}

void TransferEditor::set_importance(std::size_t component, double importance) {
  auto all = components();
  NAV_CHECK(component < all.size() && std::isfinite(importance), component, all.size(), importance);
  for (TransferNode& node : all[component].nodes)
    node.importance = std::clamp(importance, 0.0, 1.0);
  change(std::move(all));
}

}  // namespace nav::render
