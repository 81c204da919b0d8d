// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/line_medium.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tbb/parallel_for.h>

#include "sim/beam.hpp"

namespace nav::sim {
namespace {

constexpr std::size_t kApertureLines = 6;  // Number of lines to either side that are averaged.
constexpr double kPieceMm = 0.5;

bool is_gas(Tissue tissue) {
  return tissue == Tissue::kGas || tissue == Tissue::kLung || tissue == Tissue::kAir;
}

/// Assumed over true speed of sound along a line, and its gas, at true depths.
struct Walked {
  std::vector<float> slowness;
  std::optional<double> gas_mm;
  float gas_level = 0;
};

Walked walk(const Anatomy& patient, const ProbeModel& probe, const RestPath& path,
            std::size_t pieces) {
  Walked out;
  out.slowness.resize(pieces, 1.0F);
  bool contact = false;
  double loss_db = 0;
  for (std::size_t i = 0; i < pieces; ++i) {
    const double depth = (static_cast<double>(i) + 0.5) * kPieceMm;
    const Point<frames::Ct> p{path.at(depth)};
    if (!contact) contact = patient.skin_distance_mm(p) < 0;
    const bool gel = !contact && depth < most_coupling_mm(probe);
    const Tissue tissue = gel ? Tissue::kGel : patient.tissue(p);
    if (blocks_ultrasound(tissue)) {
      if (is_gas(tissue) && contact) {
        out.gas_mm = depth;
        out.gas_level = 0.5F * kInterfaceGain * amplitude_from_db(-2 * loss_db);
      }
      break;  // Behind bone and gas nothing is shown at its own depth.
    }
    out.slowness[i] = static_cast<float>(kAssumedSoundSpeed / sound_speed(tissue));
    const auto per_cm = static_cast<double>(tissue_acoustics(tissue).attenuation_db_per_cm_mhz);
    loss_db += per_cm * probe.frequency_mhz * kPieceMm / 10;
  }
  return out;
}

/// Depth as shown at the ends of the pieces of a line.
std::vector<double> shown_depths(std::span<const Walked> lines, std::size_t line,
                                 const ProbeModel& probe) {
  const std::size_t first = line - std::min(line, kApertureLines);
  const std::size_t last = std::min(line + kApertureLines, lines.size() - 1);
  std::vector<double> shown(lines[line].slowness.size() + 1, 0.0);
  for (std::size_t i = 0; i + 1 < shown.size(); ++i) {
    double sum = 0;
    for (std::size_t m = first; m <= last; ++m) sum += static_cast<double>(lines[m].slowness[i]);
    const double slowness = probe.layered_speed ? sum / static_cast<double>(last - first + 1) : 1.0;
    shown[i + 1] = shown[i] + probe.sound_speed * slowness * kPieceMm;
  }
  return shown;
}

/// Inverse of shown_depths() at every shown sample, in samples.
std::vector<float> sources(std::span<const double> shown, double sample_mm, std::size_t samples) {
  std::vector<float> source(samples);
  std::size_t piece = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const double depth = static_cast<double>(i) * sample_mm;
    while (piece + 2 < shown.size() && shown[piece + 1] < depth) ++piece;
    const double share = (depth - shown[piece]) / (shown[piece + 1] - shown[piece]);
    source[i] = static_cast<float>((static_cast<double>(piece) + share) * kPieceMm / sample_mm);
  }
  return source;
}

}  // namespace

std::vector<LineMedium> line_media(const Anatomy& patient, const ScanGeometry& geometry,
                                   const ProbeModel& probe, std::span<const RestPath> paths,
                                   std::size_t samples) {
  const auto pieces = static_cast<std::size_t>(
      std::ceil(static_cast<double>(geometry.samples()) * geometry.sample_mm() / kPieceMm));
  std::vector<Walked> walked(paths.size());
  tbb::parallel_for(std::size_t{0}, paths.size(),
                    [&](std::size_t l) { walked[l] = walk(patient, probe, paths[l], pieces); });
  std::vector<LineMedium> media(paths.size());
  tbb::parallel_for(std::size_t{0}, paths.size(), [&](std::size_t l) {
    const std::vector<double> shown = shown_depths(walked, l, probe);
    if (moves_echoes(probe)) media[l].source = sources(shown, geometry.sample_mm(), samples);
    if (!walked[l].gas_mm) return;
    media[l].gas_mm = shown[static_cast<std::size_t>(*walked[l].gas_mm / kPieceMm)];
    media[l].gas_level = walked[l].gas_level;
  });
  return media;
}

float haze_below_gas(const ProbeModel& probe, double below_mm) {
  constexpr double kFadesMm = 25;  // Depth over which the haze falls to 1/e.
  return amplitude_from_db(probe.gas_haze_db) * static_cast<float>(std::exp(-below_mm / kFadesMm));
}

}  // namespace nav::sim
