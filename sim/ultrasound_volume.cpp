// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/ultrasound_volume.hpp"

#include <algorithm>
#include <complex>
#include <span>
#include <sstream>
#include <tbb/parallel_for.h>

#include "nav/check.hpp"
#include "sim/beam.hpp"
#include "sim/speckle.hpp"
#include "sim/volume_lines.hpp"

namespace nav::sim {
namespace {

using Complex = std::complex<float>;

constexpr std::size_t kVolumeTaps = 9;  // Half of the beam, centre included.
constexpr std::uint64_t kVolumeNoiseStream = 0x757333;

/// Acoustic values of the tissue at a point.
struct Echo {
  float impedance;
  float loss_db_per_mm;  ///< Loss for one way.
  float scatter;
};

class Scanner {
 public:
  Scanner(const Anatomy& patient, const Transform<frames::Ct, frames::Image>& pose,
          const UltrasoundVolumeOptions& options)
      : patient_(patient),
        options_(options),
        lines_(pose, options),
        nx_(lines_.count(0)),
        ny_(lines_.count(1)),
        nz_(lines_.count(2)),
        speckle_(options.seed, kSpeckleCellMmTimesMhz / options.probe.frequency_mhz),
        texture_(options.seed ^ 0x74657874, 9.0),
        absorption_(options.seed ^ 0x61747465, 25.0) {}

  /// Grey values, lines of samples, [0, 255].
  std::vector<float> grey() const {
    std::vector<Complex> echo(nx_ * ny_ * nz_);
    {
      std::vector<Echo> tissue(nx_ * ny_ * nz_);
      each_line([&](std::size_t i, std::size_t k) { sample(i, k, row(tissue, i, k)); });
      const std::vector<float> mirror = mirror_gain();
      const auto pulse =
          axial_pulse(options_.probe.frequency_mhz, lines_.step_mm(), speckle_.cell_mm());
      each_line([&](std::size_t i, std::size_t k) {
        reflect(tissue, mirror, i, k, row(echo, i, k));
        blur_along(pulse, row(echo, i, k));
      });
    }
    blur_across(echo, 0, options_.probe.lateral_fwhm_mm, 1.5);
    blur_across(echo, 2, options_.probe.elevation_fwhm_mm, 1.0);
    return detect(echo);
  }
  [[nodiscard]] const VolumeLines& lines() const { return lines_; }

 private:
  template <class F>
  void each_line(const F& f) const {
    tbb::parallel_for(std::size_t{0}, nx_ * nz_, [&](std::size_t n) { f(n % nx_, n / nx_); });
  }
  template <class T>
  std::span<T> row(std::vector<T>& all, std::size_t i, std::size_t k) const {
    return std::span(all).subspan((k * nx_ + i) * ny_, ny_);
  }
  template <class T>
  std::span<const T> row(const std::vector<T>& all, std::size_t i, std::size_t k) const {
    return std::span(all).subspan((k * nx_ + i) * ny_, ny_);
  }

  void sample(std::size_t i, std::size_t k, std::span<Echo> out) const {
    Vec3d start, along;
    lines_.line(i, k, start, along);
    bool in_contact = false;
    for (std::size_t j = 0; j < ny_; ++j) {
      const double depth = lines_.step_mm() * static_cast<double>(j);
      const Point<frames::Ct> p{start + depth * along};
      if (!in_contact) in_contact = patient_.skin_distance_mm(p) < 0;
      const bool gel = !in_contact && depth < most_coupling_mm(options_.probe);
      const Acoustics a = gel ? tissue_acoustics(Tissue::kGel) : patient_.acoustics(p);
      out[j].impedance = a.impedance_mrayl;
      out[j].loss_db_per_mm = a.attenuation_db_per_cm_mhz * (1 + 0.12F * absorption_.at(p.mm)) *
                              static_cast<float>(options_.probe.frequency_mhz / 10.0);
      out[j].scatter =
          scatter_along(a, along.x(), along.y(), along.z()) * (1 + 0.14F * texture_.at(p.mm));
    }
  }

  /// Echo of a full reflection at each depth. Echoes of a surface add up in phase over the beam's
  /// thickness, unlike those of scatterers. A single image has no neighbours in elevation and does
  /// not need this.
  [[nodiscard]] std::vector<float> mirror_gain() const {
    const std::vector<float> taps = beam(2, options_.probe.elevation_fwhm_mm, 1.0);
    std::vector<float> gain(ny_);
    for (std::size_t j = 0; j < ny_; ++j) {
      float in_phase = taps[j];
      for (std::size_t k = 1; k < kVolumeTaps; ++k) in_phase += 2 * taps[k * ny_ + j];
      gain[j] = kInterfaceGain / in_phase;
    }
    return gain;
  }

  /// Computes the echoes along a line before the beam's blur.
  void reflect(const std::vector<Echo>& tissue, const std::vector<float>& mirror, std::size_t i,
               std::size_t k, std::span<Complex> out) const {
    const auto own = row(tissue, i, k);
    const auto left = row(tissue, i > 0 ? i - 1 : i, k);
    const auto right = row(tissue, std::min(i + 1, nx_ - 1), k);
    const auto below = row(tissue, i, k > 0 ? k - 1 : k);
    const auto above = row(tissue, i, std::min(k + 1, nz_ - 1));
    Vec3d start, along;
    lines_.line(i, k, start, along);
    const Vec3d cells = speckle_.to_cells(start);
    const Vec3d way = speckle_.to_cells(along);
    const auto step = static_cast<float>(lines_.step_mm());
    const float level = amplitude_from_db(options_.probe.liver_level_db) / 0.886F;
    double loss_db = 0;
    float passed = 1;
    for (std::size_t j = 0; j < ny_; ++j) {
      const double depth = lines_.step_mm() * static_cast<double>(j);
      const Echo& a = own[j];
      const Echo& b = own[std::min(j + 1, ny_ - 1)];
      const float slope_along = (b.impedance - a.impedance) / step;
      const float slope_x = (right[j].impedance - left[j].impedance) /
                            static_cast<float>(2 * lines_.spacing_mm(0, depth));
      const float slope_z = (above[j].impedance - below[j].impedance) /
                            static_cast<float>(2 * lines_.spacing_mm(2, depth));
      const float slope =
          std::sqrt(slope_along * slope_along + slope_x * slope_x + slope_z * slope_z);
      Complex signal = a.scatter * speckle_.at(cells + depth * way);
      const float roughness = 1.0F + 0.5F * signal.real();
      signal *= level;
      const float sum = a.impedance + b.impedance;
      const float reflection = std::min(0.999F, std::abs(slope_along) * step / sum);
      if (slope > 0) {
        const float cosine = std::abs(slope_along) / slope;
        const float c2 = cosine * cosine;
        signal += mirror[j] * std::min(0.5F, slope * step / sum) * (c2 * c2 * c2 + kDiffuseShare) *
                  std::max(0.2F, roughness);
      }
      out[j] = signal * passed * amplitude_from_db(-2 * loss_db);
      loss_db += static_cast<double>(step * a.loss_db_per_mm);
      passed *= 1 - reflection * reflection;
    }
  }

  void blur_along(const std::vector<float>& pulse, std::span<Complex> line) const {
    const std::vector<Complex> in(line.begin(), line.end());
    const auto last = static_cast<int>(in.size()) - 1;
    for (int i = 0; i <= last; ++i) {
      Complex sum = pulse[0] * in[static_cast<std::size_t>(i)];
      for (int k = 1; k < static_cast<int>(pulse.size()); ++k) {
        sum += pulse[static_cast<std::size_t>(k)] *
               (in[static_cast<std::size_t>(std::max(i - k, 0))] +
                in[static_cast<std::size_t>(std::min(i + k, last))]);
      }
      line[static_cast<std::size_t>(i)] = sum;
    }
  }

  /// Half of the beam across the lines along an axis, tap by tap, for all depths.
  [[nodiscard]] std::vector<float> beam(std::size_t axis, double fwhm_mm, double spread) const {
    std::vector<float> taps(kVolumeTaps * ny_);
    std::array<float, kVolumeTaps> w{};
    for (std::size_t j = 0; j < ny_; ++j) {
      const double depth = lines_.step_mm() * static_cast<double>(j);
      const double sigma = kFwhmToSigma * fwhm_mm * defocus(options_.probe, depth, spread);
      beam_taps(sigma, lines_.spacing_mm(axis, depth), speckle_.cell_mm(), w);
      for (std::size_t k = 0; k < kVolumeTaps; ++k) taps[k * ny_ + j] = w[k];
    }
    return taps;
  }

  /// Applies the beam across the lines along an axis (0: across, 2: along), in place.
  void blur_across(std::vector<Complex>& echo, std::size_t axis, double fwhm_mm,
                   double spread) const {
    const std::vector<float> taps = beam(axis, fwhm_mm, spread);
    const std::size_t count = axis == 0 ? nx_ : nz_;
    const std::size_t stride = axis == 0 ? ny_ : nx_ * ny_;
    tbb::parallel_for(std::size_t{0}, axis == 0 ? nz_ : nx_, [&](std::size_t n) {
      const std::size_t base = n * (axis == 0 ? nx_ * ny_ : ny_);
      std::vector<Complex> in(count * ny_);
      for (std::size_t c = 0; c < count; ++c) {
        std::copy_n(echo.data() + base + c * stride, ny_, in.data() + c * ny_);
      }
      const auto last = static_cast<int>(count) - 1;
      constexpr int kMost = static_cast<int>(kVolumeTaps) - 1;
      for (int c = 0; c <= last; ++c) {
        Complex* out = echo.data() + base + static_cast<std::size_t>(c) * stride;
        std::fill_n(out, ny_, Complex(0));
        for (int k = -kMost; k <= kMost; ++k) {
          const auto from = static_cast<std::size_t>(std::clamp(c + k, 0, last));
          const Complex* source = in.data() + from * ny_;
          const float* weight = taps.data() + static_cast<std::size_t>(std::abs(k)) * ny_;
          for (std::size_t j = 0; j < ny_; ++j) out[j] += weight[j] * source[j];
        }
      }
    });
  }

  /// Applies noise, depth gain, envelope and log compression.
  std::vector<float> detect(const std::vector<Complex>& echo) const {
    const ProbeModel& probe = options_.probe;
    const auto gain = depth_gain(probe, options_.seed, lines_.step_mm(), ny_);
    const SpeckleField noise(hash_bits(options_.seed, kVolumeNoiseStream, 0), 1.0);
    const float noise_level = amplitude_from_db(probe.noise_level_db);
    std::vector<float> grey(echo.size());
    each_line([&](std::size_t i, std::size_t k) {
      const auto in = row(echo, i, k);
      const auto out = row(grey, i, k);
      for (std::size_t j = 0; j < ny_; ++j) {
        const Vec3d cell =
            Vec3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const Complex electronic = noise_level * noise.at(cell + Vec3d::Constant(0.5));
        const double along = lines_.step_mm() * static_cast<double>(j);
        const float v = std::sqrt(std::norm(in[j] + electronic)) * gain[j] + ringing(probe, along);
        const float db = 20.0F * std::log10(std::max(v, 1e-9F));
        out[j] = std::clamp(255.0F * (1.0F + db / static_cast<float>(probe.dynamic_range_db)), 0.0F,
                            255.0F);
      }
    });
    return grey;
  }

  const Anatomy& patient_;
  const UltrasoundVolumeOptions& options_;
  VolumeLines lines_;
  std::size_t nx_, ny_, nz_;
  SpeckleField speckle_;
  SmoothField texture_;
  SmoothField absorption_;
};

/// Trilinear value between scan lines; 0 outside of them.
float between(const std::vector<float>& grey, const std::array<int, 3>& size, const Vec3d& at) {
  std::array<std::size_t, 3> low{};
  std::array<float, 3> share{};
  for (int a = 0; a < 3; ++a) {
    const auto n = static_cast<std::size_t>(a);
    constexpr double kRounding = 1e-6;
    if (!(at[a] >= -kRounding && at[a] <= size[n] - 1 + kRounding)) return 0;
    low[n] = static_cast<std::size_t>(std::clamp(static_cast<int>(at[a]), 0, size[n] - 2));
    share[n] = static_cast<float>(at[a] - static_cast<double>(low[n]));
  }
  const auto nx = static_cast<std::size_t>(size[0]);
  const auto ny = static_cast<std::size_t>(size[1]);
  float sum = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    float weight = 1;
    std::array<std::size_t, 3> c = low;
    for (std::size_t a = 0; a < 3; ++a) {
      const bool high = ((corner >> a) & 1) != 0;
      weight *= high ? share[a] : 1 - share[a];
      c[a] += high ? 1 : 0;
    }
    sum += weight * grey[(c[2] * nx + c[0]) * ny + c[1]];
  }
  return sum;
}

std::vector<std::int16_t> convert(const std::vector<float>& grey, const VolumeLines& lines,
                                  const std::array<int, 3>& size) {
  const std::size_t nx = lines.count(0), ny = lines.count(1), nz = lines.count(2);
  std::vector<std::int16_t> voxels(grey.size());
  tbb::parallel_for(std::size_t{0}, nz, [&](std::size_t k) {
    for (std::size_t j = 0; j < ny; ++j) {
      for (std::size_t i = 0; i < nx; ++i) {
        float value = 0;
        if (lines.parallel()) {
          value = grey[(k * nx + i) * ny + j];
        } else {
          const Vec3d voxel(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
          value = between(grey, size, lines.beam_index(voxel));
        }
        voxels[(k * ny + j) * nx + i] = static_cast<std::int16_t>(value + 0.5F);
      }
    }
  });
  return voxels;
}

}  // namespace

Result<void> validate(const UltrasoundVolumeOptions& options) {
  if (const auto ok = validate(options.probe); !ok) return ok;
  struct Range {
    const char* name;
    double value, low, high;
  };
  const Range ranges[] = {
      {"size across", static_cast<double>(options.size[0]), 8, 512},
      {"size deep", static_cast<double>(options.size[1]), 8, 512},
      {"size along", static_cast<double>(options.size[2]), 8, 512},
      {"width_mm", options.width_mm, 1, 500},
      {"depth_mm", options.depth_mm, 1, 500},
      {"thickness_mm", options.thickness_mm, 1, 500},
      {"apex_mm", options.apex_mm, 0, 1000},
  };
  for (const Range& r : ranges) {
    if (r.value >= r.low && r.value <= r.high) continue;
    std::ostringstream text;
    text << "simulated ultrasound volume: expected " << r.name << " in [" << r.low << ", " << r.high
         << "], found " << r.value;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return {};
}

Result<UltrasoundVolume> scan_ultrasound_volume(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& ct_from_image,
    const UltrasoundVolumeOptions& options) {
  if (const auto ok = validate(options); !ok) return ok.error();
  const Scanner scanner(patient, ct_from_image, options);
  auto volume = StoredVolume::create(scanner.lines().voxels(),
                                     convert(scanner.grey(), scanner.lines(), options.size),
                                     "ultrasound of " + patient.name());
  if (!volume) return volume.error();
  return UltrasoundVolume{*std::move(volume), ct_from_image * Point<frames::Image>{Vec3d::Zero()},
                          ct_from_image * Direction<frames::Image>{Vec3d::UnitY()},
                          options.apex_mm};
}

std::vector<std::uint32_t> label_bits(const Anatomy& patient, const VoxelGrid& grid,
                                      const std::vector<std::vector<Tissue>>& groups) {
  NAV_CHECK(groups.size() <= 32, groups.size());
  std::array<std::uint32_t, static_cast<std::size_t>(Tissue::kCount)> bits{};
  for (std::size_t n = 0; n < groups.size(); ++n) {
    for (const Tissue t : groups[n]) bits[static_cast<std::size_t>(t)] |= std::uint32_t{1} << n;
  }
  std::vector<std::uint32_t> labels(grid.voxel_count());
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const auto ny = static_cast<std::size_t>(grid.size[1]);
  tbb::parallel_for(std::size_t{0}, labels.size() / nx, [&](std::size_t row) {
    for (std::size_t i = 0; i < nx; ++i) {
      const Vec3d index(static_cast<double>(i), static_cast<double>(row % ny),
                        static_cast<double>(row / ny));
      labels[row * nx + i] = bits[static_cast<std::size_t>(patient.tissue(grid.at(index)))];
    }
  });
  return labels;
}

}  // namespace nav::sim
