// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "nav/result.hpp"
#include "nav/sweep.hpp"

namespace nav::registration {

struct BoneDetectorOptions {
  double line_mm = 0.5;        ///< Distance of scan lines half way down, (0, 10].
  double near_field_mm = 2;    ///< No bone is sought closer to the transducer, >= 0.
  double shadow_mm = 8;        ///< Length of the shadow that is judged first, (1, 50].
  double least_shadow_mm = 4;  ///< Length of the shadow that the image must show, (1, shadow_mm].
  /// Greatest echo in the shadow, as a share of the echoes above the bone, (0, 1).
  double most_shadow_echo = 0.55;
  /// Bone that is narrower across the lines is not kept, mm, >= 0.
  double least_width_mm = 2;
  double least_confidence = 0.5;  ///< Echoes of less confidence are left out, [0, 1].
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const BoneDetectorOptions& options);

/// A place where a scan line meets bone.
struct BoneEcho {
  int line;               ///< Scan line, from the first column of the image.
  Eigen::Vector2d at_mm;  ///< Image frame, finer than a pixel.
  Eigen::Vector2d along;  ///< Direction of the line away from the transducer, unit, Image frame.
  double confidence;      ///< [0, 1], from ridge and shadow.
};

/// Echoes of bone in one image, at most one on each line, in the order of the lines.
using BoneSurface = std::vector<BoneEcho>;

/// Detects the surface of bone in the images of a sweep. Bone is a bright ridge along the lines'
/// depth, at one of three widths, whose line stays dark below it (Foroughi et al. 2007;
/// Hacihaliloglu et al. 2009 use local phase for the ridge). The shadow is an echo, less the noise
/// of the sweep at that depth (noise_floor.hpp), that is much weaker than those above the ridge; an
/// echo farther down counts against it as well. The surface of an image is the best path over its
/// lines (dynamic programming), which leaves out lines without bone. Other things that cast
/// shadows, gas above all, are not told from bone. Copies share the data; thread-safe,
/// deterministic.
class BoneDetector {
 public:
  /// Learns noise, texture and geometry of a sweep. Errors: kUsage (options), kMalformedData
  /// (impossible pixel grid or outline, images of different geometry).
  static Result<BoneDetector> create(const Sweep& sweep, const BoneDetectorOptions& options = {});

  [[nodiscard]] int lines() const;
  /// Precondition: an image of the sweep's geometry, otherwise a Bug.
  [[nodiscard]] BoneSurface detect(const UltrasoundImage& frame) const;

 private:
  struct Data;
  explicit BoneDetector(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

/// Bone in all images of a sweep.
struct BoneOfSweep {
  std::vector<BoneSurface> images;  ///< One for each image.
  int lines;                        ///< Scan lines of an image.
  /// Share of all lines that meet bone, [0, 1].
  [[nodiscard]] double share() const;
};

/// Detects bone in each image; a sector that the images show without saying so is found first
/// (image_outline.hpp). threads: 0 for all cores; the result does not depend on it. Errors: those
/// of BoneDetector::create().
Result<BoneOfSweep> bone_of_sweep(const Sweep& sweep, const BoneDetectorOptions& options = {},
                                  int threads = 0);

}  // namespace nav::registration
