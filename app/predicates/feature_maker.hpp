// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "app/interrupt.hpp"
#include "app/predicates/feature_cache.hpp"
#include "render/features/service.hpp"

namespace nav::app {

/// Derives features for a user who waits: in the background of a progress line, stopped by Ctrl-C,
/// from a folder of earlier ones where one was given. Main thread only.
class FeatureMaker {
 public:
  /// threads: 0: all cores. cache: empty: none.
  FeatureMaker(int threads, const std::filesystem::path& cache, Console& console);

  /// Refuses as render::features::compute(); kCancelled after Ctrl-C. Nothing is kept of either.
  Result<render::features::DerivedVolume> make(const std::string& name,
                                               const render::features::DerivedRequest& request);
  /// kCancelled once Ctrl-C was pressed.
  [[nodiscard]] Result<void> check_interrupt(const std::string& name) const;

 private:
  Console& console_;
  Interrupt interrupt_;
  std::optional<FeatureCache> cache_;
  render::features::DerivedVolumes service_;
};

}  // namespace nav::app
