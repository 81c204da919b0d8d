// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/feature_maker.hpp"

#include <chrono>

#include "nav/threads.hpp"

namespace nav::app {
namespace {

using render::features::DerivedLimits;
using render::features::DerivedRequest;
using render::features::DerivedVolume;

DerivedLimits limits_of(int threads) {
  DerivedLimits limits;
  limits.threads = usable_threads(threads);
  limits.cache_bytes = 0;  // The callers keep the results.
  return limits;
}

}  // namespace

FeatureMaker::FeatureMaker(int threads, const std::filesystem::path& cache, Console& console)
    : console_(console), service_(limits_of(threads)) {
  if (!cache.empty()) cache_.emplace(cache);
}

Result<void> FeatureMaker::check_interrupt(const std::string& name) const {
  if (interrupt_.asked()) return render::features::cancelled(name);
  return {};
}

Result<DerivedVolume> FeatureMaker::make(const std::string& name, const DerivedRequest& request) {
  if (const auto ok = validate(request); !ok) return ok.error();
  if (const auto ok = check_interrupt(name); !ok) return ok.error();
  console_.begin(name);
  if (cache_) {
    if (auto found = cache_->find(request, console_)) {
      console_.end((found->note.empty() ? "" : found->note + ", ") + "from the cache");
      return *std::move(found);
    }
  }
  auto ticket = service_.request(request);
  if (!ticket) return ticket.error();
  constexpr std::chrono::milliseconds kBetweenChecks(50);
  while (!ticket->wait_for(kBetweenChecks)) {
    console_.progress(ticket->progress());
    if (interrupt_.asked()) ticket->cancel();
  }
  auto made = ticket->wait();
  if (!made) {
    console_.end(made.error().code == ErrorCode::kCancelled ? "cancelled" : "rejected");
    if (made.error().code == ErrorCode::kCancelled) return render::features::cancelled(name);
    return made;
  }
  if (cache_) cache_->keep(request, *made, console_);
  console_.end(made->note.empty() ? "done" : made->note);
  if (const auto ok = check_interrupt(name); !ok)
    return ok.error();  // Ctrl-C may come at the very end.
  return made;
}

}  // namespace nav::app
