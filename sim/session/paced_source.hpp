// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "nav/source.hpp"

namespace nav::sim {

/// Delivers a virtual source in real time: each item arrives at its time of reception. The caller
/// decides how to wait: it sleeps on a live clock, or advances a virtual one. Source is PoseSource
/// or FrameSource. Not thread-safe.
template <class Source, class Item>
class PacedSource final : public Source {
 public:
  /// \p wait: returns when the session clock has reached a time, or at once if it already has.
  PacedSource(std::unique_ptr<Source> source, std::function<void(Timestamp)> wait)
      : source_(std::move(source)), wait_(std::move(wait)) {}

  Result<Item> next(Deadline deadline) override {
    if (!held_) {
      auto item = source_->next(Timestamp::max());
      if (!item) return item.error();
      held_ = std::move(*item);
    }
    if (held_->received > deadline) {
      wait_(deadline);
      return Error{ErrorCode::kTimeout, "paced source: nothing more by the deadline"};
    }
    wait_(held_->received);
    Result<Item> item(std::move(*held_));
    held_.reset();
    return item;
  }
  void stop() noexcept override { source_->stop(); }

 private:
  std::unique_ptr<Source> source_;
  std::function<void(Timestamp)> wait_;
  std::optional<Item> held_;
};

using PacedPoseSource = PacedSource<PoseSource, RawPose>;

}  // namespace nav::sim
