// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace nav::devices {

/// Faults of an emulated device's messages or images, by chance.
template <class Fault>
struct EmulatedFaultPlan {
  std::uint64_t seed = 1;
  double rate = 0;  ///< Part of the messages or images that have a fault, [0, 1].
  std::vector<Fault> kinds{};
};

/// Says which message or image has which fault: first those that were injected, then by the plan.
/// The same seed gives the same faults. Not thread-safe.
template <class Fault>
class EmulatedFaults {
 public:
  explicit EmulatedFaults(EmulatedFaultPlan<Fault> plan)
      : plan_(std::move(plan)), random_(plan_.seed) {}

  /// Gives that fault to the next \p times messages or images, >= 0.
  void inject(Fault fault, int times) {
    injected_.insert(injected_.end(), static_cast<std::size_t>(times), fault);
  }

  /// The fault of the next message or image; absent: none.
  std::optional<Fault> next() {
    if (!injected_.empty()) {
      const Fault first = injected_.front();
      injected_.pop_front();
      return first;
    }
    if (plan_.kinds.empty() || plan_.rate <= 0) return std::nullopt;
    if (std::uniform_real_distribution<double>(0, 1)(random_) >= plan_.rate) return std::nullopt;
    return plan_
        .kinds[std::uniform_int_distribution<std::size_t>(0, plan_.kinds.size() - 1)(random_)];
  }

 private:
  EmulatedFaultPlan<Fault> plan_;
  std::mt19937_64 random_;
  std::deque<Fault> injected_;
};

}  // namespace nav::devices
