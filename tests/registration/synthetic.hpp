// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "registration/image_registration.hpp"

/// A small analytic patient: smooth blobs of known HU. CT and ultrasound come from the same
/// formula, so the pose between them is known exactly.
namespace nav::test {

struct Blob {
  Eigen::Vector3d centre;
  double sigma_mm, hu;
};

/// Sum of Gaussians around the origin of Ct.
class BlobPatient {
 public:
  explicit BlobPatient(unsigned seed, int count = 60, double half_extent_mm = 75) {
    std::mt19937 random(seed);
    const auto uniform = [&](double a, double b) {
      return a + (b - a) * (static_cast<double>(random()) / 4294967296.0);
    };
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d centre(uniform(-half_extent_mm, half_extent_mm),
                                   uniform(-half_extent_mm, half_extent_mm),
                                   uniform(-half_extent_mm, half_extent_mm));
      blobs_.push_back({centre, uniform(4, 9), (i % 2 == 0 ? 1 : -1) * uniform(30, 60)});
    }
  }

  [[nodiscard]] double hu(const Eigen::Vector3d& p) const {
    double sum = 50;
    for (const Blob& blob : blobs_) {
      const double r2 = (p - blob.centre).squaredNorm() / (blob.sigma_mm * blob.sigma_mm);
      if (r2 < 30) sum += blob.hu * std::exp(-0.5 * r2);
    }
    return sum;
  }
  /// Derivative of hu() along a direction, HU/mm.
  [[nodiscard]] double slope(const Eigen::Vector3d& p, const Eigen::Vector3d& d) const {
    double sum = 0;
    for (const Blob& blob : blobs_) {
      const double s2 = blob.sigma_mm * blob.sigma_mm;
      const double r2 = (p - blob.centre).squaredNorm() / s2;
      if (r2 < 30) sum -= blob.hu * std::exp(-0.5 * r2) * (p - blob.centre).dot(d) / s2;
    }
    return sum;
  }

 private:
  std::vector<Blob> blobs_;
};

/// The slice z = 0 of a patient, repeated along z.
class PrismaticPatient {
 public:
  explicit PrismaticPatient(const BlobPatient& slice) : slice_(slice) {}
  [[nodiscard]] double hu(const Eigen::Vector3d& p) const { return slice_.hu({p.x(), p.y(), 0}); }
  [[nodiscard]] double slope(const Eigen::Vector3d& p, const Eigen::Vector3d& d) const {
    return slice_.slope({p.x(), p.y(), 0}, {d.x(), d.y(), 0});
  }

 private:
  BlobPatient slice_;
};

/// Returns a CT of the patient. \p offset_mm moves the patient and the grid together.
template <class Patient>
Volume blob_ct(const Patient& patient, const VoxelGrid& grid,
               const Eigen::Vector3d& offset_mm = Eigen::Vector3d::Zero()) {
  std::vector<std::int16_t> hu;
  hu.reserve(grid.voxel_count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d p = grid.at(Eigen::Vector3d(i, j, k)).mm;
        hu.push_back(static_cast<std::int16_t>(std::lround(patient.hu(p))));
      }
    }
  }
  VoxelGrid placed = grid;
  placed.origin_mm += offset_mm;
  return *Volume::create(placed, std::move(hu), "blob patient");
}

/// Grid of cubic voxels, centred on the origin.
inline VoxelGrid cubic_grid(double half_extent_mm = 80, double spacing_mm = 2.0) {
  VoxelGrid grid;
  const int n = static_cast<int>(2 * half_extent_mm / spacing_mm) + 1;
  grid.size = {n, n, n};
  grid.spacing_mm.setConstant(spacing_mm);
  grid.origin_mm.setConstant(-half_extent_mm);
  return grid;
}

struct SweepSpec {
  int frames = 24;
  double step_mm = 4;  ///< Distance between images along the sweep.
  int size_px = 110;   ///< Width and height of the images, with pixels of 1 mm.
  double gain = 0.7;   ///< Grey levels per HU.
  double offset = 60;  ///< Grey levels.
  double echo = 4.0;   ///< Grey levels per HU/mm along the beam.
  double noise = 4;    ///< Standard deviation in grey levels.
  unsigned seed = 5;
};

inline Transform<frames::Ct, frames::Reference> true_pose(
    const Eigen::Vector3d& ct_offset_mm = Eigen::Vector3d::Zero()) {
  const Eigen::AngleAxisd turn(0.4, Eigen::Vector3d(1, -2, 0.5).normalized());
  return {Eigen::Quaterniond(turn), ct_offset_mm + Eigen::Vector3d(12, -7, 5)};
}

/// Images of a linear probe that tilts by up to 0.1 rad over the sweep. They follow the formula
/// grey = offset + gain·HU + echo·|slope along the beam| + noise.
template <class Patient>
Sweep blob_sweep(const Patient& patient, const SweepSpec& spec,
                 const Eigen::Vector3d& ct_offset_mm = Eigen::Vector3d::Zero(),
                 const Eigen::Vector3d& reference_offset_mm = Eigen::Vector3d::Zero()) {
  std::mt19937 random(spec.seed);
  const auto uniform = [&] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
  const auto normal = [&] {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  };
  const auto reference_from_ct = true_pose(ct_offset_mm).inverse();
  std::vector<TrackedImage> frames;
  for (int f = 0; f < spec.frames; ++f) {
    const double along = spec.step_mm * (f - 0.5 * (spec.frames - 1));
    const double tilt = 0.1 * std::sin(2.0 * f / spec.frames * std::numbers::pi);
    const Transform<frames::Ct, frames::Image> ct_from_image(
        Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX())),
        ct_offset_mm + Eigen::Vector3d(0, -0.5 * spec.size_px, along));
    const PixelGrid grid = PixelGrid::centred(spec.size_px, 1.0, 1.0);
    const Eigen::Vector3d beam = ct_from_image.rotation() * Eigen::Vector3d::UnitY();
    std::vector<std::uint8_t> pixels;
    for (int row = 0; row < spec.size_px; ++row) {
      for (int column = 0; column < spec.size_px; ++column) {
        const Eigen::Vector3d p = (ct_from_image * grid.at(column, row)).mm - ct_offset_mm;
        const double grey = spec.offset + spec.gain * patient.hu(p) +
                            spec.echo * std::abs(patient.slope(p, beam)) + spec.noise * normal();
        pixels.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0))));
      }
    }
    UltrasoundImage frame;
    frame.acquired = Timestamp(from_seconds(0.1 * f));
    frame.received = frame.acquired;
    frame.sequence = static_cast<std::uint64_t>(f);
    frame.pixels = Image2d<std::uint8_t>(spec.size_px, spec.size_px, std::move(pixels));
    frame.grid = grid;
    auto pose = reference_from_ct * ct_from_image;
    const Transform<frames::Reference, frames::Image> moved(
        pose.rotation(), pose.translation_mm() + reference_offset_mm);
    frames.push_back({std::move(frame), moved, Duration{0}});
  }
  return *Sweep::create(std::move(frames), "synthetic");
}

/// Position of a point of the CT, and direction of the beam through it, at the time of the CT.
struct AtRest {
  Eigen::Vector3d p, beam;
};

/// Images of a patient whose tissue has moved since the CT.
struct MovedImages {
  Sweep sweep;
  std::vector<Eigen::Vector3d> places_ct_mm;  ///< Current positions, spread over the images.
};

/// Returns images of 90 mm, 100 ms apart. \p pose_of maps an image index to its pose in the CT. \p
/// rest maps (image index, current point of the CT, beam) to AtRest.
template <class PoseOf, class Rest>
MovedImages images_along(const BlobPatient& patient, int count, const PoseOf& pose_of,
                         const Rest& rest) {
  constexpr int kSide = 90;
  std::vector<TrackedImage> frames;
  std::vector<Eigen::Vector3d> places;
  std::mt19937 random(5);
  for (int f = 0; f < count; ++f) {
    const Transform<frames::Ct, frames::Image> pose = pose_of(f);
    UltrasoundImage frame;
    frame.acquired = frame.received = Timestamp(std::chrono::milliseconds(100 * f));
    frame.grid = PixelGrid::centred(kSide, 1, 1);
    const Eigen::Vector3d beam = pose.rotation() * Eigen::Vector3d::UnitY();
    std::vector<std::uint8_t> grey;
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const Eigen::Vector3d now = (pose * frame.grid.at(column, row)).mm;
        const AtRest was = rest(f, now, beam);
        const double value = 60 + 0.7 * patient.hu(was.p) +
                             4 * std::abs(patient.slope(was.p, was.beam)) +
                             4.0 * (static_cast<double>(random()) / 2147483648.0 - 1.0);
        grey.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))));
        if (row % 20 == 10 && column % 20 == 10) places.push_back(now);
      }
    }
    frame.pixels = Image2d<std::uint8_t>(kSide, kSide, std::move(grey));
    frames.push_back({std::move(frame), true_pose().inverse() * pose, Duration{0}});
  }
  return {*Sweep::create(std::move(frames), "synthetic"), std::move(places)};
}

/// Returns images step_mm apart. Each is rotated a little.
template <class Rest>
MovedImages moved_images(const BlobPatient& patient, int count, double step_mm, const Rest& rest) {
  const auto pose_of = [&](int f) {
    return Transform<frames::Ct, frames::Image>(
        Eigen::Quaterniond(Eigen::AngleAxisd(0.15 * std::sin(0.5 * f), Eigen::Vector3d::UnitX())),
        Eigen::Vector3d(0, -45, step_mm * (f - 0.5 * (count - 1))));
  };
  return images_along(patient, count, pose_of, rest);
}

/// RMS distance between two poses over the corners of a 100 mm cube around the patient of the CT.
inline double cube_error_mm(const Transform<frames::Ct, frames::Reference>& found,
                            const Transform<frames::Ct, frames::Reference>& truth,
                            const Eigen::Vector3d& ct_offset_mm = Eigen::Vector3d::Zero()) {
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p((corner & 1) != 0 ? 50 : -50, (corner & 2) != 0 ? 50 : -50,
                            (corner & 4) != 0 ? 50 : -50);
    const Point<frames::Reference> q = truth.inverse() * Point<frames::Ct>{ct_offset_mm + p};
    sum += ((found * q).mm - (truth * q).mm).squaredNorm() / 8;
  }
  return std::sqrt(sum);
}

/// Returns the truth with an error of \p mm and \p rad about \p centre_ct_mm.
inline Transform<frames::Ct, frames::Reference> off_by(
    const Transform<frames::Ct, frames::Reference>& truth, double mm, double rad, unsigned seed,
    const Eigen::Vector3d& centre_ct_mm = Eigen::Vector3d::Zero()) {
  std::mt19937 random(seed);
  const auto direction = [&] {
    Eigen::Vector3d v;
    do {
      for (int axis = 0; axis < 3; ++axis) {
        v[axis] = static_cast<double>(random()) / 2147483648.0 - 1.0;
      }
    } while (v.norm() > 1 || v.norm() < 0.1);
    return Eigen::Vector3d(v.normalized());
  };
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(rad, direction()));
  const Eigen::Vector3d shift = mm * direction();
  return {(turn * truth.rotation()).normalized(),
          centre_ct_mm + turn * (truth.translation_mm() - centre_ct_mm) + shift};
}

/// Three small levels for the CT of blobs, on one thread. \p starts: searched in addition to the
/// plain solve.
inline registration::ImageRegistrationOptions small_options(int starts = 0) {
  registration::ImageRegistrationOptions options;
  options.levels = {{5.0, 7, 150, 9.0}, {3.0, 9, 250, 6.0}, {1.6, 11, 400, 4.0}};
  options.starts = starts;
  options.ridge = 0.005;  // This CT has only rounding noise (0.3 HU).
  // Images of blobs have one speed of sound, and nothing presses the blobs.
  options.speed_from_ct = false;
  options.pressed_sigma_mm = 0;
  options.threads = 1;
  return options;
}

/// Oblique, left-handed grid with 80 voxels per side. It exercises every change of axes.
inline VoxelGrid oblique_grid() {
  VoxelGrid grid;
  grid.size = {80, 80, 80};
  grid.spacing_mm.setConstant(2.0);
  grid.directions = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 1, 0).normalized()) *
                    Eigen::Vector3d(1, 1, -1).asDiagonal();
  grid.origin_mm = -grid.directions * Eigen::Vector3d::Constant(79);
  return grid;
}

/// A patient of blobs, its CT, and a sweep over it.
struct BlobScene {
  BlobPatient patient{11};
  Volume ct = blob_ct(patient, cubic_grid());
  Sweep sweep = blob_sweep(patient, {});
};
inline const BlobScene& blob_scene() {
  static const BlobScene instance;
  return instance;
}

}  // namespace nav::test
