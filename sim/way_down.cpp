// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/way_down.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tbb/parallel_for.h>

#include "sim/beam.hpp"

namespace nav::sim {
namespace {

constexpr std::size_t kAperture = 6;  // Number of lines to either side that are averaged.

class Walk {
 public:
  Walk(const Anatomy& patient, const ScanGeometry& geometry, const ProbeModel& probe,
       const SmoothPatch& absorption)
      : patient_(patient),
        absorption_(absorption),
        step_mm_(geometry.sample_mm()),
        mhz_(probe.frequency_mhz),
        coupling_mm_(most_coupling_mm(probe)) {}

  /// Computes the tissue and the remaining amplitude along one line.
  void operator()(const RestPath& path, std::span<Tissue> tissue, std::span<float> left) const {
    double loss_db = 0;
    bool contact = false;
    for (std::size_t i = 0; i < tissue.size(); ++i) {
      const double depth = step_mm_ * static_cast<double>(i);
      const Point<frames::Ct> p{path.at(depth)};
      if (!contact) contact = patient_.skin_distance_mm(p) < 0;
      const bool gel = !contact && depth < coupling_mm_;
      const Tissue t = gel ? Tissue::kGel : patient_.tissue(p);
      tissue[i] = t;
      left[i] = std::exp(static_cast<float>(-std::numbers::ln10 / 20 * loss_db));
      const auto a = static_cast<double>(tissue_acoustics(t).attenuation_db_per_cm_mhz);
      loss_db +=
          2 * a * (1 + 0.12 * static_cast<double>(absorption_.at(p.mm))) * step_mm_ * mhz_ / 10.0;
      if (i > 0 && t != tissue[i - 1]) {
        const double r = reflection(tissue[i - 1], t);
        loss_db -= 10 * std::log10(std::max(1e-6, 1 - r * r)) * 2;
      }
    }
  }

 private:
  const Anatomy& patient_;
  const SmoothPatch& absorption_;
  double step_mm_, mhz_, coupling_mm_;
};

/// Mean over the lines of the aperture, for each sample.
void average(std::span<const float> lines, std::size_t line, std::span<float> out) {
  const std::size_t n = out.size();
  const std::size_t count = lines.size() / n;
  const std::size_t first = line - std::min(line, kAperture);
  const std::size_t last = std::min(line + kAperture, count - 1);
  std::ranges::fill(out, 0.0F);
  for (std::size_t m = first; m <= last; ++m) {
    const float* in = lines.data() + m * n;
    for (std::size_t i = 0; i < n; ++i) out[i] += in[i];
  }
  for (float& v : out) v /= static_cast<float>(last - first + 1);
}

}  // namespace

double reflection(Tissue before, Tissue after) {
  const auto z1 = static_cast<double>(tissue_acoustics(before).impedance_mrayl);
  const auto z2 = static_cast<double>(tissue_acoustics(after).impedance_mrayl);
  return (z2 - z1) / (z2 + z1);
}

WayDown way_down(const Anatomy& patient, const ScanGeometry& geometry, const ProbeModel& probe,
                 std::span<const RestPath> paths, const SmoothPatch& absorption) {
  const auto n = static_cast<std::size_t>(geometry.samples());
  WayDown out{std::vector<Tissue>(paths.size() * n, Tissue::kGel),
              std::vector<float>(paths.size() * n)};
  std::vector<float> own(paths.size() * n);
  const Walk walk(patient, geometry, probe, absorption);
  tbb::parallel_for(std::size_t{0}, paths.size(), [&](std::size_t l) {
    walk(paths[l], std::span(out.tissue).subspan(l * n, n), std::span(own).subspan(l * n, n));
  });
  tbb::parallel_for(std::size_t{0}, paths.size(),
                    [&](std::size_t l) { average(own, l, std::span(out.left).subspan(l * n, n)); });
  return out;
}

}  // namespace nav::sim
