// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "bench/scene_set.hpp"
#include "bench/skip_oracle.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

/// Tasks of the CPU engine in a live session: cutaway, new images, edits, interaction, skipping.
namespace nav::bench {

/// One image in three versions: CT alone; with the plane; with the plane and the cutaway about it.
/// The CT alone at a coarser step tells the cost of a sample apart from the rest of a ray.
struct CutawayCost {
  double ct_ms = 0;  ///< Process time.
  double coarse_ct_ms = 0;
  double plane_ms = 0;
  double cutaway_ms = 0;
  std::uint64_t ct_samples = 0;
  std::uint64_t coarse_ct_samples = 0;
  std::uint64_t plane_samples = 0;
  std::uint64_t cutaway_samples = 0;
  /// (cutaway - ct) / cutaway: net fraction of an image that both cost; negative: they save time.
  [[nodiscard]] double net_fraction() const { return 1 - ct_ms / cutaway_ms; }
  /// The fraction if the samples that they save were still taken, at the cost of one more sample of
  /// the CT alone: the cost of their own work.
  [[nodiscard]] double own_fraction() const {
    return own_fraction((ct_ms - coarse_ct_ms) / samples_over(coarse_ct_samples));
  }
  /// An upper bound of own_fraction(), with the average cost of a sample, which includes its share
  /// of all other work of an image, as if rays and empty space went away with the samples.
  [[nodiscard]] double own_fraction_at_most() const {
    return own_fraction(ct_ms / samples_over(0));
  }

 private:
  [[nodiscard]] double samples_over(std::uint64_t fewer) const {
    return static_cast<double>(ct_samples) - static_cast<double>(fewer);
  }
  [[nodiscard]] double own_fraction(double sample_ms) const {
    return (cutaway_ms + sample_ms * samples_over(cutaway_samples) - ct_ms) / cutaway_ms;
  }
};
/// Precondition: the scene has a plane and a cutaway.
Result<CutawayCost> measure_cutaway(const render::Scene& scene, const Repeats& repeats);

/// A new ultrasound image at the same pose and camera.
struct ImageUpdate {
  double cpu_ms = 0;  ///< Process time of the whole image, median.
  double wall_ms = 0;
  std::uint64_t samples = 0;  ///< Largest number of volume samples of any update.
  /// Identical to the image of an engine that never saw the previous ultrasound image.
  bool identical = true;
};
Result<ImageUpdate> measure_image_update(const render::Scene& scene, int updates);

/// Volume samples with and without skipping, at the scene's quality, for an image after the first
/// one, when all data for skipping is known.
struct SkipRatio {
  std::string scene;
  std::uint64_t first = 0;  ///< With skipping, first image with this transfer function.
  std::uint64_t on = 0;
  std::uint64_t off = 0;
  std::uint64_t brute = 0;  ///< Without early termination too: all samples of the rays' parts.
  bool identical = false;   ///< Byte for byte.
  [[nodiscard]] double ratio() const {
    return static_cast<double>(off) / static_cast<double>(on > 0 ? on : 1);
  }
  [[nodiscard]] double brute_ratio() const {
    return static_cast<double>(brute) / static_cast<double>(on > 0 ? on : 1);
  }
};
Result<SkipRatio> measure_skipping(const NamedScene& named);

/// Skipping compared with its best possible result, with times.
struct SkipBound {
  SkipRatio found;
  SkipOracle oracle;
  double on_ms = 0;  ///< Process time of an image, smallest of all repeats.
  double off_ms = 0;
};
/// Precondition: that of skip_oracle().
Result<SkipBound> measure_skip_bound(const NamedScene& named, int repeats);

/// Relative overhead of skipping in an image where nothing is empty: time with skipping over time
/// without, minus 1.
Result<double> full_volume_overhead(const render::Scene& scene, const Repeats& repeats);

/// Cost of an edited transfer function on a cubic patient of n voxels a side.
struct EditCost {
  int side = 0;
  double prepare_ms = 0;  ///< Wall time to classify again and rebuild tables, median.
  double frame_ms = 0;    ///< Process time of the first image after it, median.
};
Result<EditCost> measure_edit(const render::Scene& scene, int edits);

/// A moving camera: images of 800 x 600 at the fastest step and pixel error that keep rms <= 1e-2,
/// and the same with render::ProgressiveRenderer.
struct Interaction {
  std::string scene;
  int side = 0;
  double step = 0;         ///< Voxels; the finest candidate if none keeps to 1e-2.
  double pixel_error = 0;  ///< Pixel error of the quality.
  double rms = 0;  ///< Against the reference; not rounded to 8 bits, unlike in the comparison.
  double dense_step = 0;  ///< The coarsest step with a ray for every pixel.
  double dense_wall_ms = 0;
  double cpu_ms = 0;
  double wall_ms = 0;
  double progressive_wall_ms = 0;  ///< Median of the images during the movement.
  double refined_ms = 0;           ///< From the last movement to the complete image, wall time.
};
Result<Interaction> measure_interaction(const NamedScene& named, const Repeats& repeats);

}  // namespace nav::bench
