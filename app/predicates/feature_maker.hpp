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

/// Computes derived features while the user waits. It shows progress, stops on Ctrl-C, and reuses
/// earlier features from the cache folder, if one is given. Main thread only.
class FeatureMaker {
 public:
  /// threads: 0 for all cores. cache: folder; empty for none.
  FeatureMaker(int threads, const std::filesystem::path& cache, Console& console);

  /// Computes a feature or reads it from the cache. name: for progress and messages. Rejects what
  /// render::features::compute() rejects; kCancelled after Ctrl-C. Nothing is cached in either
  /// case.
  Result<render::features::DerivedVolume> make(const std::string& name,
                                               const render::features::DerivedRequest& request);
  /// Returns kCancelled after Ctrl-C was pressed.
  [[nodiscard]] Result<void> check_interrupt(const std::string& name) const;

 private:
  Console& console_;
  Interrupt interrupt_;
  std::optional<FeatureCache> cache_;
  render::features::DerivedVolumes service_;
};

}  // namespace nav::app
