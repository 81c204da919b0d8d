// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/hopeless.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bench/registration/altered_sweep.hpp"
#include "nav/check.hpp"
#include "sim/random.hpp"

namespace nav::bench {
namespace {

constexpr double kScale = 1.2;
constexpr double kEchoMm = 25;
constexpr double kOverlap = 0.125;

using Pixels = std::vector<std::uint8_t>;

Sweep mirrored(const Sweep& sweep) {
  return with_pixels(sweep, [](Pixels& pixels, const UltrasoundImage& frame) {
    const auto width = static_cast<std::ptrdiff_t>(frame.pixels.width());
    for (auto row = pixels.begin(); row != pixels.end(); row += width) {
      std::reverse(row, row + width);
    }
  });
}

Sweep shadowed(const Sweep& sweep, std::uint64_t seed) {
  std::uint64_t image = 0;
  return with_pixels(sweep, [&](Pixels& pixels, const UltrasoundImage& frame) {
    const int width = frame.pixels.width();
    ++image;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto at = static_cast<int>(i);
      const Eigen::Vector2d p = frame.grid.at(at % width, at / width).mm.head<2>();
      const double depth = frame.outline
                               ? (p - frame.outline->apex_mm).norm() - frame.outline->radius_min_mm
                               : p.y();
      if (depth < kEchoMm || pixels[i] == 0) continue;
      pixels[i] = static_cast<std::uint8_t>(sim::hash_bits(seed, image, i) % 12);
    }
  });
}

Sweep saturated(const Sweep& sweep) {
  return with_pixels(sweep, [](Pixels& pixels, const UltrasoundImage&) {
    for (std::uint8_t& pixel : pixels) {
      pixel = static_cast<std::uint8_t>(std::min(255, 12 * static_cast<int>(pixel)));
    }
  });
}

/// The CT up to the plane across its z axis below which an eighth of the targets lies.
std::shared_ptr<const Volume> cut_short(const Volume& ct, const RecordedSweep& recorded) {
  std::vector<double> heights;
  for (const auto& target : recorded.targets) heights.push_back(target.mm.z());
  std::sort(heights.begin(), heights.end());
  const double top =
      heights[static_cast<std::size_t>(kOverlap * static_cast<double>(heights.size()))];
  VoxelGrid grid = ct.grid();
  const double last = grid.index_of({{0, 0, top}}).z();
  grid.size[2] = std::clamp(static_cast<int>(last), 2, grid.size[2]);
  const auto hu = ct.hu().first(grid.voxel_count());
  return std::make_shared<const Volume>(
      *Volume::create(grid, {hu.begin(), hu.end()}, ct.name() + ", cut short"));
}

CtPose turned(const Patient& patient, const RecordedSweep& recorded, std::uint64_t seed) {
  sim::Random random(seed, 0x7475726e);
  const Eigen::Vector3d centre = (patient.truth * recorded.sweep.centroid()).mm;
  const Eigen::Quaterniond half(Eigen::AngleAxisd(std::numbers::pi, random.direction()));
  return {(half * patient.truth.rotation()).normalized(),
          centre + half * (patient.truth.translation_mm() - centre)};
}

}  // namespace

const char* to_string(Hopeless kind) {
  constexpr std::array<const char*, kHopelessKinds> kNames{
      "wrong patient", "mirrored",     "wrong scale", "all shadow",
      "saturated",     "tiny overlap", "turned"};
  return kNames[static_cast<std::size_t>(kind)];
}

HopelessCase make_hopeless(Hopeless kind, const Patient& patient, const Patient& other,
                           const RecordedSweep& recorded, std::uint64_t seed) {
  const CtPose near = start_at(kHopelessStartMm, patient.truth, recorded, seed);
  switch (kind) {
    case Hopeless::kWrongPatient:
      return {other.ct, recorded.sweep, near, false};
    case Hopeless::kMirrored:
      return {patient.ct, mirrored(recorded.sweep), near, false};
    case Hopeless::kWrongScale:
      return {patient.ct, enlarged(recorded.sweep, kScale), near, true};
    case Hopeless::kAllShadow:
      return {patient.ct, shadowed(recorded.sweep, seed), near, true};
    case Hopeless::kSaturated:
      return {patient.ct, saturated(recorded.sweep), near, true};
    case Hopeless::kTinyOverlap:
      return {cut_short(*patient.ct, recorded), recorded.sweep, near, true};
    case Hopeless::kTurned:
      return {patient.ct, recorded.sweep, turned(patient, recorded, seed), true};
  }
  NAV_CHECK(false, static_cast<int>(kind));
  return {patient.ct, recorded.sweep, near, false};
}

}  // namespace nav::bench
