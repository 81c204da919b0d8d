// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/predicate_thread.hpp"

#include <chrono>
#include <exception>

#include "app/predicates/predicate_scribbles.hpp"
#include "nav/threads.hpp"

namespace nav::app {
namespace {

std::vector<bool> counting_bars(const render::PredicateModel& model) {
  std::vector<bool> counts;
  for (const auto& bar : model.histogram.bars()) counts.push_back(bar.importance > 0);
  return counts;
}

std::string words_of_scribble(const ScribbleOutcome& outcome) {
  const std::string text = std::to_string(outcome.shown) + " voxels to show, " +
                           std::to_string(outcome.hidden) + " to hide";
  return outcome.decisive ? text : text + ": they do not distinguish the predicates";
}

}  // namespace

PredicateThread::PredicateThread(int threads, std::function<void(Done)> done)
    : threads_(threads), done_(std::move(done)) {}

void PredicateThread::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void PredicateThread::stop() {
  thread_.request_stop();
  orders_.close();
  if (thread_.joinable()) thread_.join();
}

void PredicateThread::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const auto order = orders_.wait(std::chrono::seconds(1));
    if (!order) continue;
    try {
      done_(prepared(*order, stop));
    } catch (const std::exception& failure) {
      done_({.revision = order->revision,
             .failure = std::string("the predicate set failed: ") + failure.what()});
    }
  }
}

PredicateThread::Done PredicateThread::prepared(const Order& order, const std::stop_token& stop) {
  if (given_ != order.source) {
    given_ = order.source;
    source_ = *given_;
    kept_.reset();
  }
  Done done{.revision = order.revision};
  render::PredicateModel model = order.model;
  auto volume = volume_of(model, stop);
  if (volume && !order.strokes.empty() && !model.entries.empty()) {
    // Engines draw the set that the strokes lead to.
    const auto outcome = scribble(render::predicate_scene(*volume, volume->predicates.model, 1, 1),
                                  order.strokes, order.share);
    if (!outcome) {
      done.failure = outcome.error().message;
    } else {
      done.words = words_of_scribble(*outcome);
      done.scribbled = outcome->histogram;
      model.histogram = outcome->histogram;
      volume = volume_of(model, stop);
    }
  }
  if (!volume) {
    done.failure = volume.error().message;
  } else {
    done.volume = std::make_shared<const render::PredicateVolume>(*std::move(volume));
  }
  return done;
}

Result<render::PredicateVolume> PredicateThread::volume_of(const render::PredicateModel& model,
                                                           const std::stop_token& stop) {
  const std::vector<bool> counts = counting_bars(model);
  if (!kept_ || kept_->entries != model.entries || kept_->counts != counts) {
    constexpr std::chrono::milliseconds kBetweenLooks(20);
    render::features::DerivedLimits limits;
    limits.threads = usable_threads(threads_);
    render::features::DerivedVolumes service(limits);
    auto made =
        prepare_model(*source_, model,
                      [&](const std::string& name, const render::features::DerivedRequest& request)
                          -> Result<render::features::DerivedVolume> {
                        auto ticket = service.request(request);
                        if (!ticket) return ticket.error();
                        while (!ticket->wait_for(kBetweenLooks)) {
                          if (stop.stop_requested())
                            return Error{ErrorCode::kCancelled, name + ": cancelled"};
                        }
                        return ticket->wait();
                      });
    if (!made) return made.error();
    kept_ = Kept{model.entries, counts, *std::move(made)};
  }
  render::PredicateVolume volume = kept_->volume;
  // The entries as they were resolved, with the bars of now. An empty set keeps its own.
  if (!model.entries.empty()) volume.predicates.model.histogram = model.histogram;
  return volume;
}

}  // namespace nav::app
