// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <memory>
#include <type_traits>
#include <utility>

#include "sim/anatomy/dual.hpp"

namespace nav::sim {

/// Function of space with its value and exact gradient, made from one callable that accepts
/// positions of double and of Dual (a shape, or a lambda of `const auto&`). Immutable; copies share
/// the callable; as thread-safe as the callable. CT coordinates, mm.
class Field {
 public:
  template <class F>
  requires(!std::same_as<std::remove_cvref_t<F>, Field>) Field(F function)
      : node_(std::make_shared<const Of<F>>(std::move(function))) {}  // NOLINT

  double operator()(const Vec3d& p) const { return node_->value(p); }
  Dual operator()(const Vec3Dual& p) const { return node_->dual(p); }

 private:
  struct Node {
    virtual ~Node() = default;
    [[nodiscard]] virtual double value(const Vec3d& p) const = 0;
    [[nodiscard]] virtual Dual dual(const Vec3Dual& p) const = 0;
  };
  template <class F>
  struct Of final : Node {
    explicit Of(F f) : function(std::move(f)) {}
    [[nodiscard]] double value(const Vec3d& p) const override { return function(p); }
    [[nodiscard]] Dual dual(const Vec3Dual& p) const override { return function(p); }
    F function;
  };
  std::shared_ptr<const Node> node_;
};

}  // namespace nav::sim
