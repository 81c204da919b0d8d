// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/assembler.hpp"

#include <algorithm>
#include <utility>

namespace nav::app {
namespace {

constexpr std::size_t kMostFlats = 16;

std::uint64_t number_of(const FlatImages& flat) { return flat.moment->number; }

}  // namespace

void RefreshAssembler::add(FlatImages flat, Timestamp now) {
  flats_.push_back({std::move(flat), now});
  if (flats_.size() <= kMostFlats) return;
  flats_.pop_front();
  ++superseded_;
}

void RefreshAssembler::expect_scene(bool expected) {
  if (expected == with_scene_) return;
  with_scene_ = expected;
  scene_.reset();
  scene_number_ = 0;
}

void RefreshAssembler::add(ViewImage scene, Timestamp now) {
  if (!with_scene_) return;
  if (scene_) ++superseded_;
  scene_ = std::move(scene);
  scene_since_ = now;
}

/// Takes one of the waiting flat images; older ones are superseded.
FlatImages RefreshAssembler::take_flat(std::size_t index) {
  FlatImages taken = std::move(flats_[index].flat);
  superseded_ += index;
  flats_.erase(flats_.begin(), flats_.begin() + static_cast<std::ptrdiff_t>(index) + 1);
  flat_number_ = number_of(taken);
  return taken;
}

Assembled RefreshAssembler::next(Timestamp now) {
  Assembled shown;
  if (scene_) {
    const std::uint64_t wanted = scene_->moment->number;
    // The newest of that moment: the user may have moved its slices.
    const auto same = std::find_if(flats_.rbegin(), flats_.rend(), [&](const Waiting& waiting) {
      return number_of(waiting.flat) == wanted;
    });
    const bool comes = wanted > flat_number_ && same == flats_.rend() &&
                       (flats_.empty() || number_of(flats_.back().flat) < wanted);
    if (same != flats_.rend()) {
      shown.flat = take_flat(static_cast<std::size_t>(flats_.rend() - same) - 1);
    }
    // Its flat views will come; without them it would show another moment than they do.
    if (!comes || now - scene_since_ >= kMostWait) {
      scene_number_ = wanted;
      shown.scene = std::exchange(scene_, std::nullopt);
    }
  }
  if (!shown.flat && !flats_.empty()) {
    const bool agrees = number_of(flats_.back().flat) == scene_number_;
    if (agrees || !with_scene_ || now - flats_.front().since >= kMostWait) {
      shown.flat = take_flat(flats_.size() - 1);
    }
  }
  return shown;
}

}  // namespace nav::app
