// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "render/features/confidence.hpp"
#include "render/features/gradient.hpp"
#include "render/features/scan_lines.hpp"
#include "render/features/snr.hpp"
#include "render/features/vesselness.hpp"

namespace nav::render::features {

struct GradientPartOptions {
  GradientPart part = GradientPart::kMagnitude;
  GradientOptions gradient{};
};
struct ScanDepthOptions {};

/// The kind of feature, with all its parameters besides the volume.
using DerivedOptions = std::variant<SnrOptions, VesselnessOptions, ConfidenceOptions,
                                    GradientPartOptions, ScanDepthOptions>;

struct DerivedRequest {
  ScalarVolume volume;
  DerivedOptions options;
  /// Needed by confidence, by gradients except their magnitude, and by depth along the scan line;
  /// ignored by the others.
  std::optional<ScanLines> lines;
};

/// True when a feature depends on the scan lines.
bool needs_scan_lines(const DerivedOptions& options);
/// Rejects options that are out of range or too wide for the volume's voxels, and scan lines that
/// are missing or of a different grid.
Result<void> validate(const DerivedRequest& request);
/// Digest of the volume and of everything that the feature depends on, including the version of its
/// definition. Equal keys mean equal values, also in other runs of the program.
std::string key_of(const DerivedRequest& request);

struct DerivedVolume {
  FeatureVolume volume;
  std::string note;  ///< Notes of the computation: iterations, estimated error.
};
/// Computes immediately, on the caller's thread and workers.
Result<DerivedVolume> compute(const DerivedRequest& request, const RunOptions& run);

struct DerivedLimits {
  std::size_t cache_bytes = std::size_t{2}
                            << 30;  ///< Limit of finished volumes; the newest always stays.
  std::size_t memory_limit = std::size_t{6} << 30;  ///< Limit of one computation, its result
                                                    ///< included, bytes.
  int threads = 0;                                  ///< 0 means all cores.
};

/// Features on demand. They are computed when requested, one after the other in the background, and
/// cached by content: a request with the same volume and parameters finds the feature again, and a
/// changed one is computed. Above the limit the least recently used ones are removed. Thread-safe.
class DerivedVolumes {
 public:
  using Compute = std::function<Result<DerivedVolume>(const DerivedRequest&, const RunOptions&)>;
  explicit DerivedVolumes(const DerivedLimits& limits = {}, Compute compute = features::compute);
  /// Stops the running computation and waits for it.
  ~DerivedVolumes();
  DerivedVolumes(const DerivedVolumes&) = delete;
  DerivedVolumes& operator=(const DerivedVolumes&) = delete;

  struct Job;
  /// The interest of one caller in a feature. When no ticket is left, the computation is stopped.
  /// Movable. Stays valid after the service ends.
  class Ticket {
   public:
    Ticket(Ticket&&) noexcept = default;
    Ticket& operator=(Ticket&& other) noexcept;
    ~Ticket();
    /// Progress, [0, 1]; 1 when finished, with any outcome.
    [[nodiscard]] double progress() const;
    /// The result; no value until finished. Throws what the computation threw.
    [[nodiscard]] std::optional<Result<DerivedVolume>> poll() const;
    /// Blocks until finished. Throws like poll().
    [[nodiscard]] Result<DerivedVolume> wait() const;
    /// Blocks at most for that time; true when finished.
    [[nodiscard]] bool wait_for(std::chrono::milliseconds most) const;
    /// Ends the interest. wait() then returns kCancelled unless another caller lets the computation
    /// finish.
    void cancel();

   private:
    friend class DerivedVolumes;
    explicit Ticket(std::shared_ptr<Job> job) : job_(std::move(job)) {}
    std::shared_ptr<Job> job_;
    bool interested_ = true;
  };

  /// Requests a feature. Never computes on the caller's thread, but the first request for a volume
  /// reads it once (for its digest). Rejects what validate() rejects.
  Result<Ticket> request(const DerivedRequest& request);

  struct Counts {
    std::size_t computed = 0;  ///< Number of computations started.
    std::size_t found = 0;     ///< Number of requests served by a finished or running computation.
    std::size_t cached_bytes = 0;  ///< Memory in use now.
  };
  [[nodiscard]] Counts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nav::render::features
