// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nav/volume.hpp"
#include "render/transfer/transfer_function.hpp"
#include "render/undo_history.hpp"

namespace nav::render {

/// How often values occur in a volume, for the background of a transfer function.
struct ValueCounts {
  double low = 0;   ///< Left end of the first bin.
  double high = 1;  ///< Right end of the last bin, > low.
  std::vector<std::uint64_t> bins{};
};
/// Counts the values between the ends in equal bins. Looks at every n-th voxel of large volumes, so
/// that at most about 1 million are read; always the same ones. Precondition: low < high, bins > 0.
ValueCounts count_values(const StoredVolume& volume, double low, double high, int bins);

/// Edits the components of a transfer function: colour, opacity and importance, with undo and redo.
/// After every edit the function is valid. Toolkit-free; one thread. Components and nodes are
/// indices below the numbers that the function has; others are a Bug.
class TransferEditor {
 public:
  /// Opacity of 1 mm that an edit can give at most.
  static constexpr double kMostOpacity = 0.999;
  /// Least distance of two nodes, in values.
  static constexpr double kLeastGap = 0.5;

  explicit TransferEditor(TransferFunction function) : history_(std::move(function)) {}

  [[nodiscard]] const TransferFunction& function() const { return history_.value(); }
  [[nodiscard]] const std::vector<TransferComponent>& components() const {
    return function().components();
  }

  /// Moves a node. It stays between its neighbours; the opacity is clamped to [0, kMostOpacity].
  void move_node(std::size_t component, std::size_t node, double value, double opacity);
  /// Gives all nodes of a component a colour in [0, 1].
  void set_colour(std::size_t component, const Eigen::Vector3d& rgb);
  /// Scales the opacities of a component so that the greatest is this, [0, kMostOpacity]. A
  /// component that is invisible gets it at all its inner nodes, or at all if there are only two.
  void set_opacity(std::size_t component, double greatest);
  /// Gives all nodes of a component an importance in [0, 1] (Burns et al. 2007 §3.1).
  void set_importance(std::size_t component, double importance);

  /// All changes from begin() to end() are one step of undo: a drag of the mouse.
  void begin() { history_.begin(); }
  void end() { history_.end(); }
  bool undo() { return history_.undo(); }
  bool redo() { return history_.redo(); }
  [[nodiscard]] bool can_undo() const { return history_.can_undo(); }
  [[nodiscard]] bool can_redo() const { return history_.can_redo(); }

 private:
  void change(std::vector<TransferComponent> components);

  UndoHistory<TransferFunction> history_;
};

/// Greatest opacity of a component.
double greatest_opacity(const TransferComponent& component);
/// Colour and importance of its most opaque node.
const TransferNode& most_opaque(const TransferComponent& component);

}  // namespace nav::render
