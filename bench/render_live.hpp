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

/// What a live session asks of the CPU engine: cutaway, new images, edits, interaction, skipping.
namespace nav::bench {

/// One picture three ways: CT alone; with the plane; with the plane and the cutaway about it. And
/// the CT alone at a coarser step, which tells what a sample costs beside what rays do without.
struct CutawayCost {
  double ct_ms = 0;  ///< Process time.
  double coarse_ct_ms = 0;
  double plane_ms = 0;
  double cutaway_ms = 0;
  std::uint64_t ct_samples = 0;
  std::uint64_t coarse_ct_samples = 0;
  std::uint64_t plane_samples = 0;
  std::uint64_t cutaway_samples = 0;
  /// (cutaway - ct) / cutaway: what both cost of a frame, all told; negative: they save.
  [[nodiscard]] double net_fraction() const { return 1 - ct_ms / cutaway_ms; }
  /// The same if the samples that they save were still taken, at what one more sample of the CT
  /// alone costs: the price of their own work.
  [[nodiscard]] double own_fraction() const {
    return own_fraction((ct_ms - coarse_ct_ms) / samples_over(coarse_ct_samples));
  }
  /// An upper bound of it: at what a sample costs with its share of all else that a frame does, as
  /// if rays and empty space went away with the samples.
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
/// Precondition of the scene: a plane and a cutaway.
Result<CutawayCost> measure_cutaway(const render::Scene& scene, const Repeats& repeats);

/// A new ultrasound image at the same pose and camera.
struct ImageUpdate {
  double cpu_ms = 0;  ///< Process time of the whole picture, median.
  double wall_ms = 0;
  std::uint64_t samples = 0;  ///< Most volume samples of any update.
  bool identical = true;      ///< To an engine that never saw the picture before.
};
Result<ImageUpdate> measure_image_update(const render::Scene& scene, int updates);

/// Volume samples with skipping and without, at the scene's quality: of a picture among others,
/// when all is known that is skipped by.
struct SkipRatio {
  std::string scene;
  std::uint64_t first = 0;  ///< With skipping, of the first picture with this transfer function.
  std::uint64_t on = 0;
  std::uint64_t off = 0;
  std::uint64_t brute = 0;  ///< Without early termination either: all that the rays' parts hold.
  bool identical = false;   ///< Byte for byte.
  [[nodiscard]] double ratio() const {
    return static_cast<double>(off) / static_cast<double>(on > 0 ? on : 1);
  }
  [[nodiscard]] double brute_ratio() const {
    return static_cast<double>(brute) / static_cast<double>(on > 0 ? on : 1);
  }
};
Result<SkipRatio> measure_skipping(const NamedScene& named);

/// Beside that, what could be skipped at best, and the time.
struct SkipBound {
  SkipRatio found;
  SkipOracle oracle;
  double on_ms = 0;  ///< Process time of a picture, least of all repeats.
  double off_ms = 0;
};
/// Precondition of the scene: that of skip_oracle().
Result<SkipBound> measure_skip_bound(const NamedScene& named, int repeats);

/// Time of a picture where nothing is empty: with skipping over without, less 1.
Result<double> full_volume_overhead(const render::Scene& scene, const Repeats& repeats);

/// An edited transfer function on a cubic patient of n voxels a side.
struct EditCost {
  int side = 0;
  double prepare_ms = 0;  ///< Wall time to classify anew and rebuild tables, median.
  double frame_ms = 0;    ///< Process time of the first picture after it, median.
};
Result<EditCost> measure_edit(const render::Scene& scene, int edits);

/// The camera moves: frames of 800 x 600 at the fastest step and pixel error that keep rms <= 1e-2,
/// and the same as render::ProgressiveRenderer draws it.
struct Interaction {
  std::string scene;
  int side = 0;
  double step = 0;         ///< Voxels; the finest candidate when none keeps to 1e-2.
  double pixel_error = 0;  ///< Of the quality.
  double rms = 0;          ///< Against the reference, unlike the comparison not rounded to 8 bits.
  double dense_step = 0;   ///< The coarsest with a ray for every pixel.
  double dense_wall_ms = 0;
  double cpu_ms = 0;
  double wall_ms = 0;
  double progressive_wall_ms = 0;  ///< Median of the pictures on the way.
  double refined_ms = 0;           ///< From the last movement to the whole picture, wall.
};
Result<Interaction> measure_interaction(const NamedScene& named, const Repeats& repeats);

}  // namespace nav::bench
