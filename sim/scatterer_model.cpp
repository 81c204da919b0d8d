// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/scatterer_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <tbb/parallel_for.h>

#include "nav/matrices.hpp"
#include "sim/anatomy/dual.hpp"
#include "sim/beam.hpp"
#include "sim/motion/rest_path.hpp"
#include "sim/random.hpp"
#include "sim/speckle.hpp"

namespace nav::sim {
namespace {

using Complex = std::complex<float>;

constexpr double kCellMmTimesMhz = 2.4;   // One scatterer in each cell of this side.
constexpr double kPulseMmTimesMhz = 1.0;  // Standard deviation of the pulse.
constexpr double kSoundMmPerUs = 1.54;
constexpr double kRoughMm = 0.05;  // Of interfaces, standard deviation.
constexpr float kMirror = 1.1F;    // Echo of a full reflection, 1 is white.
constexpr double kSlab = 2.5;      // Half thickness, standard deviations of the beam.
constexpr int kTaps = 10;
constexpr int kPlanePieces = 8;  // Of a line, to find how moved tissue lies at rest.
constexpr int kAperture = 6;     // Lines to either side that share the way down.

/// A scatterer or mirror in beam coordinates.
struct Spike {
  std::uint32_t at;  ///< line * samples + sample below.
  float line_share, sample_share;
  Complex echo;
};

class Model {
 public:
  Model(const Anatomy& patient, const ScanGeometry& geometry, const ProbeModel& probe,
        std::uint64_t seed, const Transform<frames::Ct, frames::Image>& pose, const Warp* warp)
      : patient_(patient),
        geometry_(geometry),
        probe_(probe),
        seed_(hash_bits(seed, 0x706f696e7473, 0)),
        pose_(pose),
        warp_(warp),
        n_(static_cast<std::size_t>(geometry.samples())),
        lines_(static_cast<std::size_t>(probe.lines)),
        absorption_(seed ^ 0x61747465, 25.0),
        texture_(seed ^ 0x74657874, 9.0) {
    const Vec3d across = (pose * Direction<frames::Image>{Vec3d::UnitZ()}).v;
    paths_.reserve(lines_);
    for (int l = 0; l < probe.lines; ++l) {
      const ScanLine ray = geometry.line(l);
      paths_.emplace_back(
          warp, (pose * Point<frames::Image>{{ray.start.x(), ray.start.y(), 0}}).mm,
          (pose * Direction<frames::Image>{{ray.direction.x(), ray.direction.y(), 0}}).v, across,
          geometry.sample_mm() * static_cast<double>(n_ + 1));
    }
  }

  std::vector<Complex> echoes() {
    way_down();
    std::vector<Complex> raw(lines_ * n_);
    add_scatterers(raw);
    add_mirrors(raw);
    tbb::parallel_for(std::size_t{0}, lines_, [&](std::size_t l) { pulse(raw, l); });
    return beam(raw);
  }

 private:
  [[nodiscard]] double sigma_lateral(double along) const {
    return kFwhmToSigma * probe_.lateral_fwhm_mm * defocus(probe_, along, 1.5);
  }
  [[nodiscard]] double sigma_elevation(double along) const {
    return kFwhmToSigma * probe_.elevation_fwhm_mm * defocus(probe_, along, 1.0);
  }
  [[nodiscard]] double wave_number() const {
    return 2 * std::numbers::pi * probe_.frequency_mhz / kSoundMmPerUs;
  }
  [[nodiscard]] Complex phase(double along) const {
    const double angle = std::fmod(2 * wave_number() * along, 2 * std::numbers::pi);
    return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  }

  /// Tissue along the lines: amplitude that is left after the way there and back, mirrors.
  void way_down() {
    left_.assign(lines_ * n_, 0.0F);
    tissue_.assign(lines_ * n_, Tissue::kGel);
    std::vector<float> loss(lines_ * n_);
    tbb::parallel_for(std::size_t{0}, lines_, [&](std::size_t l) { walk(l, loss); });
    tbb::parallel_for(std::size_t{0}, lines_, [&](std::size_t l) {
      for (std::size_t i = 0; i < n_; ++i) {
        float sum = 0;
        int count = 0;
        for (int k = -kAperture; k <= kAperture; ++k) {
          const auto m = static_cast<std::ptrdiff_t>(l) + k;
          if (m < 0 || m >= static_cast<std::ptrdiff_t>(lines_)) continue;
          sum += std::pow(10.0F, -loss[static_cast<std::size_t>(m) * n_ + i] / 20.0F);
          ++count;
        }
        left_[l * n_ + i] = sum / static_cast<float>(count);
      }
    });
  }

  /// Two-way loss in dB and tissue along a line.
  void walk(std::size_t l, std::vector<float>& loss) {
    const double step = geometry_.sample_mm();
    double sum = 0;
    bool contact = false;
    for (std::size_t i = 0; i < n_; ++i) {
      const double depth = step * static_cast<double>(i);
      const Point<frames::Ct> p = at(l, depth);
      if (!contact) contact = patient_.skin_distance_mm(p) < 0;
      const bool gel = !contact && depth < kMaxCouplingMm;
      const Tissue t = gel ? Tissue::kGel : patient_.tissue(p);
      const auto a = static_cast<double>(tissue_acoustics(t).attenuation_db_per_cm_mhz);
      tissue_[l * n_ + i] = t;
      loss[l * n_ + i] = static_cast<float>(sum);
      sum += 2 * a * (1 + 0.12 * static_cast<double>(absorption_.at(p.mm))) * step *
             probe_.frequency_mhz / 10.0;
      if (i > 0 && t != tissue_[l * n_ + i - 1]) {
        const double r = reflection(tissue_[l * n_ + i - 1], t);
        sum -= 10 * std::log10(std::max(1e-6, 1 - r * r)) * 2;
      }
    }
  }
  [[nodiscard]] static double reflection(Tissue before, Tissue after) {
    const auto z1 = static_cast<double>(tissue_acoustics(before).impedance_mrayl);
    const auto z2 = static_cast<double>(tissue_acoustics(after).impedance_mrayl);
    return (z2 - z1) / (z2 + z1);
  }
  /// What a line meets, where it lies at rest.
  [[nodiscard]] Point<frames::Ct> at(std::size_t line, double depth) const {
    return {paths_[line].at(depth)};
  }

  /// Scatterers of the slab about the plane, row by row of the lattice that is fixed to the tissue.
  void add_scatterers(std::vector<Complex>& raw) const {
    const double cell = kCellMmTimesMhz / probe_.frequency_mhz;
    const RestPlane slab = rest_plane();
    const Vec3d& normal = slab.normal;
    int thin = 0;  // The lattice axis that crosses the slab most directly.
    normal.cwiseAbs().maxCoeff(&thin);
    const int u = (thin + 1) % 3;
    const int v = (thin + 2) % 3;
    const Eigen::AlignedBox3d box = field_box(cell);
    const double half =
        slab.bulge_mm + kSlab * std::max(sigma_elevation(0), sigma_elevation(probe_.depth_mm));
    const double plane = normal.dot(slab.point);
    const int first = static_cast<int>(std::floor(box.min()[u] / cell));
    const int last = static_cast<int>(std::floor(box.max()[u] / cell));
    std::vector<std::vector<Spike>> rows(static_cast<std::size_t>(last - first + 1));
    tbb::parallel_for(first, last + 1, [&](int a) {
      auto& out = rows[static_cast<std::size_t>(a - first)];
      for (int b = static_cast<int>(std::floor(box.min()[v] / cell)); b * cell <= box.max()[v];
           ++b) {
        const double rest = plane - normal[u] * (a + 0.5) * cell - normal[v] * (b + 0.5) * cell;
        const double middle = rest / normal[thin];
        const double reach = (half + cell) / std::abs(normal[thin]);
        for (int c = static_cast<int>(std::floor((middle - reach) / cell));
             c * cell <= middle + reach; ++c) {
          Eigen::Vector3i index;
          index[u] = a, index[v] = b, index[thin] = c;
          scatterer(index, cell, out);
        }
      }
    });
    for (const auto& row : rows) add(row, raw);
  }

  /// Box of the whole field, CT coordinates.
  [[nodiscard]] Eigen::AlignedBox3d field_box(double pad) const {
    Eigen::AlignedBox3d box;
    for (std::size_t l = 0; l < lines_; ++l) {
      const int pieces = warp_ == nullptr ? 1 : kPlanePieces;
      for (int i = 0; i <= pieces; ++i) box.extend(at(l, probe_.depth_mm * i / pieces).mm);
    }
    box.min().array() -= pad;
    box.max().array() += pad;
    return box;
  }

  /// The picture's plane at rest and how far the tissue of the picture lies off it.
  struct RestPlane {
    Vec3d point, normal;
    double bulge_mm;
  };
  [[nodiscard]] RestPlane rest_plane() const {
    const Vec3d upright = (pose_ * Direction<frames::Image>{Vec3d::UnitZ()}).v;
    if (warp_ == nullptr) return {pose_.translation_mm(), upright, 0};
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(lines_) * (kPlanePieces + 1));
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const auto line = static_cast<std::size_t>(i / (kPlanePieces + 1));
      points.col(i) =
          at(line, probe_.depth_mm * static_cast<double>(i % (kPlanePieces + 1)) / kPlanePieces).mm;
    }
    const Vec3d mean = points.rowwise().mean();
    points.colwise() -= mean;
    const Vec3d normal = eigenpairs<3>(points * points.transpose()).vectors.col(0);
    const double off = (normal.transpose() * points).cwiseAbs().maxCoeff();
    // Between the points it may be a little more; squeezed tissue is thinner now than at rest.
    return {mean, normal, 1.5 * off + 1.0};
  }

  /// The scatterer of a cell: a place and a strength out of its hash.
  void scatterer(const Eigen::Vector3i& index, double cell, std::vector<Spike>& out) const {
    const auto part = [](int i) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(i));
    };
    const std::uint64_t bits = hash_bits(seed_ ^ (part(index.x()) * 0x8da6b343d8163841ULL) ^
                                         (part(index.y()) * 0xd8163841cb1ab31fULL) ^
                                         (part(index.z()) * 0xcb1ab31f8da6b343ULL));
    const std::uint64_t more = hash_bits(bits);
    const auto share = [](std::uint64_t word, int shift) {
      return static_cast<double>((word >> shift) & 0xffff) / 65536.0;
    };
    const Vec3d jitter(share(bits, 0), share(bits, 16), share(bits, 32));
    const Vec3d p = cell * (index.cast<double>() + jitter);
    const Vec3d now = warp_ == nullptr ? p : warp_->apply(p);
    const Vec3d q = (inverse_ * Point<frames::Ct>{now}).mm;
    const Eigen::Vector2d beam = geometry_.beam_of(q.head<2>());
    if (!(beam.x() >= 0 && beam.x() < static_cast<double>(lines_ - 1) && beam.y() >= 0 &&
          beam.y() < static_cast<double>(n_ - 1))) {
      return;
    }
    const double along = beam.y() * geometry_.sample_mm();
    const double sigma = sigma_elevation(along);
    const double off = q.z() / sigma;
    if (std::abs(off) > kSlab) return;
    const Acoustics a = patient_.acoustics({p});
    const Vec3d way = paths_[static_cast<std::size_t>(beam.x() + 0.5)].direction(along);
    // Sum of four uniform numbers: nearly normal; unit variance.
    const double strength =
        (share(more, 0) + share(more, 16) + share(more, 32) + share(more, 48) - 2.0) *
        std::sqrt(3.0);
    const auto amplitude = static_cast<float>(strength * std::exp(-0.5 * off * off)) * a.scatter *
                           fibre_echo(a, way.x(), way.y(), way.z()) * (1 + 0.14F * texture_.at(p));
    const double power = std::pow(std::numbers::pi, 1.5) * kPulseMmTimesMhz / probe_.frequency_mhz *
                         sigma_lateral(along) * sigma / (cell * cell * cell);
    const float level = amplitude_from_db(probe_.liver_level_db) / 0.886F;
    spike(beam, amplitude * level / static_cast<float>(std::sqrt(power)) * phase(along), out);
  }

  void spike(const Eigen::Vector2d& beam, Complex echo, std::vector<Spike>& out) const {
    const auto l = static_cast<std::size_t>(beam.x());
    const auto s = static_cast<std::size_t>(beam.y());
    out.push_back({static_cast<std::uint32_t>(l * n_ + s),
                   static_cast<float>(beam.x() - static_cast<double>(l)),
                   static_cast<float>(beam.y() - static_cast<double>(s)),
                   echo * left_[l * n_ + s]});
  }

  void add(const std::vector<Spike>& spikes, std::vector<Complex>& raw) const {
    for (const Spike& s : spikes) {
      const float far = s.line_share, deep = s.sample_share;
      raw[s.at] += (1 - far) * (1 - deep) * s.echo;
      raw[s.at + 1] += (1 - far) * deep * s.echo;
      raw[s.at + n_] += far * (1 - deep) * s.echo;
      raw[s.at + n_ + 1] += far * deep * s.echo;
    }
  }

  /// A rough mirror wherever the tissue changes along a line.
  void add_mirrors(std::vector<Complex>& raw) const {
    tbb::parallel_for(std::size_t{0}, lines_, [&](std::size_t l) {
      for (std::size_t i = 1; i + 1 < n_; ++i) {
        const Tissue before = tissue_[l * n_ + i - 1];
        const Tissue after = tissue_[l * n_ + i];
        if (before == after) continue;
        const double depth = boundary(l, static_cast<double>(i - 1), before);
        const Vec3d p = at(l, depth).mm;
        const auto key = hash_bits(seed_, l, i);
        const double rough = kRoughMm * normal_at(seed_, 0x726f756768, key);
        // Per sample, so that it does not depend on how finely a line is sampled; the beam adds
        // its lines up.
        const double spacing = geometry_.line_spacing_mm(depth);
        const double lateral = std::sqrt(2 * std::numbers::pi) * sigma_lateral(depth) / spacing;
        const auto r = static_cast<float>(reflection(before, after) / std::max(1.0, lateral));
        const std::size_t s =
            std::min(static_cast<std::size_t>(depth / geometry_.sample_mm()), n_ - 2);
        const auto share =
            static_cast<float>(depth / geometry_.sample_mm() - static_cast<double>(s));
        const Complex echo = kMirror * r * left_[l * n_ + s] * (1 + 0.4F * texture_.at(3 * p)) *
                             phase(depth + rough);
        raw[l * n_ + s] += (1 - share) * echo;
        raw[l * n_ + s + 1] += share * echo;
      }
    });
  }
  /// Depth where the tissue changes within a step, by bisection.
  [[nodiscard]] double boundary(std::size_t line, double index, Tissue before) const {
    double low = index * geometry_.sample_mm();
    double high = low + geometry_.sample_mm();
    if (before == Tissue::kGel) return high;  // The skin under the gel is where contact begins.
    for (int i = 0; i < 5; ++i) {
      const double middle = 0.5 * (low + high);
      (patient_.tissue(at(line, middle)) == before ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  /// Gaussian pulse along a line, peak 1.
  void pulse(std::vector<Complex>& raw, std::size_t l) const {
    const double sigma = kPulseMmTimesMhz / probe_.frequency_mhz / geometry_.sample_mm();
    const auto line = std::span(raw).subspan(l * n_, n_);
    const std::vector<Complex> in(line.begin(), line.end());
    const int reach = static_cast<int>(std::ceil(3 * sigma));
    const auto last = static_cast<int>(n_) - 1;
    for (int i = 0; i <= last; ++i) {
      Complex sum = 0;
      for (int k = std::max(-reach, -i); k <= std::min(reach, last - i); ++k) {
        sum += static_cast<float>(std::exp(-0.5 * k * k / (sigma * sigma))) *
               in[static_cast<std::size_t>(i + k)];
      }
      line[static_cast<std::size_t>(i)] = sum;
    }
  }

  /// Gaussian beam across the lines, peak 1.
  [[nodiscard]] std::vector<Complex> beam(const std::vector<Complex>& raw) const {
    std::vector<float> taps((kTaps + 1) * n_);
    for (std::size_t i = 0; i < n_; ++i) {
      const double along = geometry_.sample_mm() * static_cast<double>(i);
      const double sigma = sigma_lateral(along) / geometry_.line_spacing_mm(along);
      for (int k = 0; k <= kTaps; ++k) {
        taps[static_cast<std::size_t>(k) * n_ + i] =
            static_cast<float>(std::exp(-0.5 * k * k / (sigma * sigma)));
      }
    }
    std::vector<Complex> out(raw.size());
    tbb::parallel_for(std::size_t{0}, lines_, [&](std::size_t l) {
      for (int k = -kTaps; k <= kTaps; ++k) {
        const auto m = static_cast<std::ptrdiff_t>(l) + k;
        if (m < 0 || m >= static_cast<std::ptrdiff_t>(lines_)) continue;
        const Complex* in = raw.data() + static_cast<std::size_t>(m) * n_;
        const float* w = taps.data() + static_cast<std::size_t>(std::abs(k)) * n_;
        for (std::size_t i = 0; i < n_; ++i) out[l * n_ + i] += w[i] * in[i];
      }
    });
    return out;
  }

  const Anatomy& patient_;
  const ScanGeometry& geometry_;
  const ProbeModel& probe_;
  std::uint64_t seed_;
  Transform<frames::Ct, frames::Image> pose_;
  const Warp* warp_;
  Transform<frames::Image, frames::Ct> inverse_ = pose_.inverse();
  std::size_t n_, lines_;
  SmoothField absorption_, texture_;
  std::vector<RestPath> paths_;
  std::vector<float> left_;
  std::vector<Tissue> tissue_;
};

}  // namespace

std::vector<std::complex<float>> scatterer_echoes(
    const Anatomy& patient, const ScanGeometry& geometry, const ProbeModel& probe,
    std::uint64_t seed, const Transform<frames::Ct, frames::Image>& ct_from_image,
    const Warp* warp) {
  return Model(patient, geometry, probe, seed, ct_from_image, warp).echoes();
}

}  // namespace nav::sim
