// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer_function.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace nav::render {
namespace {

bool in_unit(double x) { return x >= 0 && x <= 1; }  // False for NaN.

double tau_of(const TransferNode& node) { return -std::log1p(-node.opacity); }

Result<void> check_node(const std::string& name, const std::vector<TransferNode>& nodes,
                        std::size_t i) {
  const TransferNode& node = nodes[i];
  const auto refuse = [&](const std::string& expected, auto found) {
    std::ostringstream text;
    text << "transfer function " << name << ": node " << i << ": expected " << expected
         << ", found " << found;
    return Error{ErrorCode::kMalformedData, text.str()};
  };
  if (!std::isfinite(node.hu)) return refuse("a finite value in HU", node.hu);
  if (i > 0 && !(node.hu > nodes[i - 1].hu)) {
    std::ostringstream expected;
    expected << "more than the " << nodes[i - 1].hu << " HU of the node before";
    return refuse(expected.str(), node.hu);
  }
  for (int c = 0; c < 3; ++c) {
    if (!in_unit(node.rgb[c])) return refuse("colours in [0, 1]", node.rgb[c]);
  }
  if (!(node.opacity >= 0 && node.opacity < 1)) {
    return refuse("an opacity of 1 mm in [0, 1)", node.opacity);
  }
  if (!in_unit(node.importance)) return refuse("an importance in [0, 1]", node.importance);
  return {};
}

}  // namespace

Result<TransferFunction> TransferFunction::create(std::string name,
                                                  std::vector<TransferNode> nodes) {
  if (nodes.size() < 2) {
    return Error{ErrorCode::kMalformedData, "transfer function " + name +
                                                ": expected at least two nodes, found " +
                                                std::to_string(nodes.size())};
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (const auto ok = check_node(name, nodes, i); !ok) return ok.error();
  }
  return TransferFunction(std::move(name), std::move(nodes));
}

TransferSample TransferFunction::at(double hu) const {
  const auto whole = [](const TransferNode& n) {
    return TransferSample{n.rgb, tau_of(n), n.importance};
  };
  const auto above = std::upper_bound(nodes_.begin(), nodes_.end(), hu,
                                      [](double x, const TransferNode& n) { return x < n.hu; });
  if (above == nodes_.begin()) return whole(nodes_.front());
  if (above == nodes_.end()) return whole(nodes_.back());
  const TransferNode& a = *(above - 1);
  const TransferNode& b = *above;
  const double w = (hu - a.hu) / (b.hu - a.hu);
  return {a.rgb + w * (b.rgb - a.rgb), tau_of(a) + w * (tau_of(b) - tau_of(a)),
          a.importance + w * (b.importance - a.importance)};
}

}  // namespace nav::render
