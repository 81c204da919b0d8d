// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/predicates/predicate_volume.hpp"
#include "app/window/mailbox.hpp"
#include "render/features/scribbles.hpp"

namespace nav::app {

/// Prepares the predicate sets that the user edits, on a thread of its own: features that a set
/// newly reads, connected parts, floors, and the effect of scribbles. It takes the newest order
/// only. A set whose importances and colours alone have changed is ready at once.
class PredicateThread {
 public:
  struct Order {
    /// The volume; the thread keeps what it derives from it until another one is ordered.
    std::shared_ptr<const PredicateSource> source;
    render::PredicateModel model;                     ///< Valid or empty.
    std::vector<render::features::Stroke> strokes{};  ///< Not empty: Eq. 9 is applied to the model.
    double share = 0.25;                              ///< q of Eq. 9.
    std::uint64_t revision = 0;
  };
  struct Done {
    std::uint64_t revision = 0;
    std::shared_ptr<const render::PredicateVolume> volume{};  ///< Null: see failure.
    /// The histogram that the strokes lead to; absent without strokes.
    std::optional<render::PredicateHistogram> scribbled{};
    std::string words{};    ///< Sentence about the strokes; may be empty.
    std::string failure{};  ///< Cause why the set cannot be shown; empty: it can.
  };
  /// done is called on the thread. threads: of the features, 0 for all cores.
  PredicateThread(int threads, std::function<void(Done)> done);
  ~PredicateThread() { stop(); }

  void start();
  /// Ends a running computation and joins the thread. Idempotent.
  void stop();
  void prepare(Order order) { orders_.put(std::move(order)); }

 private:
  /// The last set that was prepared in full.
  struct Kept {
    std::vector<render::PredicateEntry> entries;
    std::vector<bool> counts;  ///< Importance above 0: it shapes intensities.
    render::PredicateVolume volume;
  };
  void run(const std::stop_token& stop);
  [[nodiscard]] Done prepared(const Order& order, const std::stop_token& stop);
  [[nodiscard]] Result<render::PredicateVolume> volume_of(const render::PredicateModel& model,
                                                          const std::stop_token& stop);

  int threads_;
  std::function<void(Done)> done_;
  Mailbox<Order> orders_;
  std::shared_ptr<const PredicateSource> given_;
  std::optional<PredicateSource> source_;  ///< Grows by the features that were computed.
  std::optional<Kept> kept_;
  std::jthread thread_;
};

}  // namespace nav::app
