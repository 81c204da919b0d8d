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

/// Which feature, with everything that it depends on besides the volume.
using DerivedOptions = std::variant<SnrOptions, VesselnessOptions, ConfidenceOptions,
                                    GradientPartOptions, ScanDepthOptions>;

struct DerivedRequest {
  ScalarVolume volume;
  DerivedOptions options;
  /// Needed by confidence, gradients but for their magnitude, and depth along the scan line;
  /// ignored by the others.
  std::optional<ScanLines> lines;
};

/// Whether a feature depends on where the scan lines run.
bool needs_scan_lines(const DerivedOptions& options);
/// Refuses options out of range or too wide for the volume's voxels, missing scan lines and those
/// of another grid.
Result<void> validate(const DerivedRequest& request);
/// Digest of the volume and of all that the feature depends on, the version of its definition
/// included: the same key is the same values, in other runs of the program too.
std::string key_of(const DerivedRequest& request);

struct DerivedVolume {
  FeatureVolume volume;
  std::string note;  ///< What the computation says of itself: iterations, estimated error.
};
/// Computes at once, on the caller's thread and workers.
Result<DerivedVolume> compute(const DerivedRequest& request, const RunOptions& run);

struct DerivedLimits {
  std::size_t cache_bytes = std::size_t{2}
                            << 30;  ///< Of finished volumes; the newest always stays.
  std::size_t memory_limit = std::size_t{6} << 30;  ///< Of one computation, its result included.
  int threads = 0;                                  ///< 0: all cores.
};

/// Features on demand: computed when asked for, one after the other in the background, and kept by
/// content: the same volume and parameters are found again, whichever of them changed is computed
/// anew; beyond the bound the least recently used go. Thread-safe.
class DerivedVolumes {
 public:
  using Compute = std::function<Result<DerivedVolume>(const DerivedRequest&, const RunOptions&)>;
  explicit DerivedVolumes(const DerivedLimits& limits = {}, Compute compute = features::compute);
  /// Stops what runs and waits for it.
  ~DerivedVolumes();
  DerivedVolumes(const DerivedVolumes&) = delete;
  DerivedVolumes& operator=(const DerivedVolumes&) = delete;

  struct Job;
  /// One asker's interest in a feature; without any left, its computation is stopped. Movable.
  /// Valid beyond the service.
  class Ticket {
   public:
    Ticket(Ticket&&) noexcept = default;
    Ticket& operator=(Ticket&& other) noexcept;
    ~Ticket();
    /// [0, 1]; 1 when finished, however it ended.
    [[nodiscard]] double progress() const;
    /// Absent until finished. What the computation threw is thrown here.
    [[nodiscard]] std::optional<Result<DerivedVolume>> poll() const;
    /// Blocks. Throws as poll().
    [[nodiscard]] Result<DerivedVolume> wait() const;
    /// Blocks no longer than that; true when finished.
    [[nodiscard]] bool wait_for(std::chrono::milliseconds most) const;
    /// Gives up the interest; wait() then says kCancelled unless somebody else lets it finish.
    void cancel();

   private:
    friend class DerivedVolumes;
    explicit Ticket(std::shared_ptr<Job> job) : job_(std::move(job)) {}
    std::shared_ptr<Job> job_;
    bool interested_ = true;
  };

  /// Never computes on the caller's thread, but the first request for a volume reads it once (for
  /// its digest). Refuses as validate().
  Result<Ticket> request(const DerivedRequest& request);

  struct Counts {
    std::size_t computed = 0;      ///< Computations begun.
    std::size_t found = 0;         ///< Requests met by a finished or running one.
    std::size_t cached_bytes = 0;  ///< Held now.
  };
  [[nodiscard]] Counts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace nav::render::features
