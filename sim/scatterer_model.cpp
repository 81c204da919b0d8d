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
#include "sim/pulse_and_beam.hpp"
#include "sim/scatterer_cells.hpp"
#include "sim/way_down.hpp"

namespace nav::sim {
namespace {

using Complex = std::complex<float>;

constexpr double kCellMmTimesMhz = 2.4;  // Edge of the cells, each with one scatterer.
constexpr double kSoundMmPerUs = 1.54;
constexpr double kRoughMm = 0.05;  // Standard deviation of the roughness of interfaces.
constexpr float kMirror = 1.1F;    // Echo of a full reflection, 1 is white.
// Half thickness of the slab in standard deviations of the beam. Scatterers beyond it have 1 % of
// the power.
constexpr double kSlab = 1.8;
// Number of pieces of a line that are used to find the position of moved tissue at rest.
constexpr int kPlanePieces = 8;
constexpr double kSpreadPadMm = 2;
// Level below the electronic noise, dB, at which scatterers are skipped.
constexpr double kUnseenDb = 20;

/// A scatterer or mirror in beam coordinates.
struct Spike {
  std::uint32_t at;  ///< Index line * samples + sample of the next lower node.
  float line_share, sample_share;
  Complex echo;
};

/// Values that depend only on the depth.
struct Layer {
  float elevation_sigma_mm;
  float level;  ///< Echo of a scatterer of unit strength in liver.
};

class Model {
 public:
  Model(const Anatomy& patient, const ScanGeometry& geometry, const ProbeModel& probe,
        ScattererSeed seeds, const Transform<frames::Ct, frames::Image>& pose, const Warp* warp)
      : patient_(patient),
        geometry_(geometry),
        probe_(probe),
        cells_(hash_bits(seeds.patient, 0x706f696e7473, seeds.look),
               kCellMmTimesMhz / probe.frequency_mhz),
        seed_(hash_bits(seeds.patient, 0x706f696e7473, seeds.look)),
        pose_(pose),
        warp_(warp),
        n_(static_cast<std::size_t>(geometry.samples())),
        lines_(static_cast<std::size_t>(probe.lines)),
        paths_(lay_paths()),
        slab_(rest_slab()),
        box_(field_box()),
        texture_field_(seeds.patient ^ 0x74657874, 9.0),
        texture_(texture_field_, box_),
        absorption_field_(seeds.patient ^ 0x61747465, 25.0),
        absorption_(absorption_field_, box_),
        layers_(make_layers()),
        way_(way_down(patient, geometry, probe, paths_, absorption_)) {}

  LineEchoes echoes() && {
    std::vector<Complex> raw(lines_ * n_);
    add_scatterers(raw);
    add_mirrors(raw);
    return {pulse_and_beam(raw, geometry_, probe_), std::move(way_.left)};
  }

 private:
  std::vector<RestPath> lay_paths() const {
    const Vec3d across = (pose_ * Direction<frames::Image>{Vec3d::UnitZ()}).v;
    std::vector<RestPath> paths;
    paths.reserve(lines_);
    for (int l = 0; l < probe_.lines; ++l) {
      const ScanLine ray = geometry_.line(l);
      paths.emplace_back(
          warp_, (pose_ * Point<frames::Image>{{ray.start.x(), ray.start.y(), 0}}).mm,
          (pose_ * Direction<frames::Image>{{ray.direction.x(), ray.direction.y(), 0}}).v, across,
          geometry_.sample_mm() * static_cast<double>(n_ + 1));
    }
    return paths;
  }

  std::vector<Layer> make_layers() const {
    const float liver = amplitude_from_db(probe_.liver_level_db) / 0.886F;
    std::vector<Layer> layers(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      const double along = geometry_.sample_mm() * static_cast<double>(i);
      const double sigma = sigma_elevation(along);
      const double power = std::pow(std::numbers::pi, 1.5) * kPulseMmTimesMhz /
                           probe_.frequency_mhz * sigma_lateral(probe_, along) * sigma /
                           std::pow(cells_.cell_mm(), 3);
      layers[i] = {static_cast<float>(sigma), liver / static_cast<float>(std::sqrt(power))};
    }
    return layers;
  }

  [[nodiscard]] double sigma_elevation(double along) const {
    return kFwhmToSigma * probe_.elevation_fwhm_mm * defocus(probe_, along, 1.0);
  }
  [[nodiscard]] Complex phase(double along) const {
    // Whole turns are removed first, so that the remainder keeps its digits as a float.
    const double turns = 2 * probe_.frequency_mhz / kSoundMmPerUs * along;
    return unit_phasor(static_cast<float>(turns - std::floor(turns)));
  }
  /// Point of a line in the tissue at rest.
  [[nodiscard]] Point<frames::Ct> at(std::size_t line, double depth) const {
    return {paths_[line].at(depth)};
  }

  /// Slice of the image at rest: its plane, the largest deviation of the image's tissue from it,
  /// and the lattice axis that crosses it most directly.
  struct Slab {
    Vec3d point, normal;
    double bulge_mm;
    int thin;
    double half_mm;  ///< Half thickness at the widest position, with the bulge.
  };
  [[nodiscard]] Slab rest_slab() const {
    Slab slab{.point = pose_.translation_mm(),
              .normal = (pose_ * Direction<frames::Image>{Vec3d::UnitZ()}).v,
              .bulge_mm = 0,
              .thin = 0,
              .half_mm = kSlab * std::max(sigma_elevation(0), sigma_elevation(probe_.depth_mm))};
    if (warp_ != nullptr) fit_plane(slab);
    slab.normal.cwiseAbs().maxCoeff(&slab.thin);
    slab.half_mm += slab.bulge_mm;
    return slab;
  }
  void fit_plane(Slab& slab) const {
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(lines_) * (kPlanePieces + 1));
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const auto line = static_cast<std::size_t>(i / (kPlanePieces + 1));
      points.col(i) =
          at(line, probe_.depth_mm * static_cast<double>(i % (kPlanePieces + 1)) / kPlanePieces).mm;
    }
    slab.point = points.rowwise().mean();
    points.colwise() -= slab.point;
    slab.normal = eigenpairs<3>(points * points.transpose()).vectors.col(0);
    const double off = (slab.normal.transpose() * points).cwiseAbs().maxCoeff();
    // The factor allows for larger deviations between the points. Compressed tissue is thinner now
    // than at rest.
    slab.bulge_mm = 1.5 * off + 1.0;
  }

  /// Box of the whole field at rest, CT coordinates, with the thickness of the slab.
  [[nodiscard]] Eigen::AlignedBox3d field_box() const {
    Eigen::AlignedBox3d box;
    for (std::size_t l = 0; l < lines_; ++l) {
      const int pieces = warp_ == nullptr ? 1 : kPlanePieces;
      for (int i = 0; i <= pieces; ++i) box.extend(at(l, probe_.depth_mm * i / pieces).mm);
    }
    const double pad = slab_.half_mm + 2 * cells_.cell_mm() + kSpreadPadMm;
    box.min().array() -= pad;
    box.max().array() += pad;
    return box;
  }

  /// Adds the scatterers of the slab, row by row of the lattice that is fixed to the tissue.
  void add_scatterers(std::vector<Complex>& raw) const {
    const int u = (slab_.thin + 1) % 3;
    const int v = (slab_.thin + 2) % 3;
    const int first = cells_.index(box_.min()[u]);
    const int last = cells_.index(box_.max()[u]);
    std::vector<std::vector<Spike>> rows(static_cast<std::size_t>(last - first + 1));
    tbb::parallel_for(first, last + 1, [&](int a) {
      Eigen::Vector3i index;
      index[u] = a;
      for (int b = cells_.index(box_.min()[v]); b <= cells_.index(box_.max()[v]); ++b) {
        index[v] = b;
        add_row(index, rows[static_cast<std::size_t>(a - first)]);
      }
    });
    for (const auto& row : rows) add(row, raw);
  }

  /// Adds the cells along the thin axis that are in the slab, if the image reaches them.
  void add_row(Eigen::Vector3i index, std::vector<Spike>& out) const {
    const double cell = cells_.cell_mm();
    const double across = std::abs(slab_.normal[slab_.thin]);
    Vec3d middle = cell * (index.cast<double>().array() + 0.5);
    middle[slab_.thin] = slab_.point[slab_.thin];
    middle[slab_.thin] -= slab_.normal.dot(middle - slab_.point) / slab_.normal[slab_.thin];
    // Distance within the image from the middle of the row to its ends. Tissue may be stretched.
    const double slope = std::sqrt(std::max(0.0, 1 - across * across)) / across;
    const double spread = (warp_ == nullptr ? 1.0 : 1.5) *
                          ((slab_.half_mm + cell) * slope + 2 * cell + slab_.bulge_mm);
    const Eigen::Vector2f beam = beam_of(image_of(middle));
    const double along = static_cast<double>(beam.y()) * geometry_.sample_mm();
    if (along < -spread || along > probe_.depth_mm + spread) return;
    const auto lines = static_cast<float>(spread / geometry_.line_spacing_mm(along - spread));
    if (beam.x() < -lines || beam.x() > static_cast<float>(lines_ - 1) + lines) return;
    const double sigma = std::max(sigma_elevation(along - spread), sigma_elevation(along + spread));
    const double reach = (std::min(slab_.half_mm, kSlab * sigma + slab_.bulge_mm) + cell) / across;
    const int first = cells_.index(middle[slab_.thin] - reach);
    const int last = cells_.index(middle[slab_.thin] + reach);
    const auto half_mm = static_cast<float>(kSlab * sigma);
    index[slab_.thin] = first;
    // Image position of the row's first corner; at rest the others follow by constant steps.
    const Vec3d corner = (image_from_ct_ * Point<frames::Ct>{cell * index.cast<double>()}).mm;
    for (int c = first; c <= last; ++c) {
      index[slab_.thin] = c;
      const std::uint64_t bits = cells_.bits(index);
      const Vec3d place = ScattererCells::place(bits);
      const Eigen::Vector3f at =
          warp_ == nullptr
              ? (corner + image_from_cells_ * (place + (c - first) * Vec3d::Unit(slab_.thin)))
                    .cast<float>()
              : image_of(cell * (index.cast<double>() + place));
      if (std::abs(at.z()) > half_mm) continue;
      add_scatterer(bits, cell * (index.cast<double>() + place), at, out);
    }
  }

  [[nodiscard]] Eigen::Vector3f image_of(const Vec3d& rest) const {
    const Vec3d now = warp_ == nullptr ? rest : warp_->apply(rest);
    return (image_from_ct_ * Point<frames::Ct>{now}).mm.cast<float>();
  }
  [[nodiscard]] Eigen::Vector2f beam_of(const Eigen::Vector3f& q) const {
    return geometry_.beam_of<float>(q.head<2>());
  }

  /// Adds a scatterer at \p p at rest, if the image shows it. \p q: its present position in the
  /// image, mm.
  void add_scatterer(std::uint64_t bits, const Vec3d& p, const Eigen::Vector3f& q,
                     std::vector<Spike>& out) const {
    const Eigen::Vector2f beam = beam_of(q);
    if (!(beam.x() >= 0 && beam.x() < static_cast<float>(lines_ - 1) && beam.y() >= 0 &&
          beam.y() < static_cast<float>(n_ - 1))) {
      return;
    }
    const auto line = static_cast<std::size_t>(beam.x());
    const auto sample = static_cast<std::size_t>(beam.y());
    const std::size_t here = line * n_ + sample;
    const Layer& layer = layers_[sample];
    const float off = q.z() / layer.elevation_sigma_mm;
    if (std::abs(off) > static_cast<float>(kSlab) || way_.left[here] < unseen_) return;
    const Acoustics a = patient_.acoustics({p});
    if (!(a.scatter > 0)) return;
    const double along = static_cast<double>(beam.y()) * geometry_.sample_mm();
    const float amplitude = static_cast<float>(ScattererCells::strength(bits)) *
                            std::exp(-0.5F * off * off) * echo_of(a, line, along) *
                            (1 + 0.14F * texture_.at(p));
    out.push_back({static_cast<std::uint32_t>(here), beam.x() - static_cast<float>(line),
                   beam.y() - static_cast<float>(sample),
                   amplitude * layer.level * way_.left[here] * phase(along)});
  }

  [[nodiscard]] float echo_of(const Acoustics& a, std::size_t line, double along) const {
    const Vec3d way = paths_[line].direction(along);
    return scatter_along(a, way.x(), way.y(), way.z());
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

  /// Adds a rough mirror at every tissue boundary along a line.
  void add_mirrors(std::vector<Complex>& raw) const {
    tbb::parallel_for(std::size_t{0}, lines_, [&](std::size_t l) {
      for (std::size_t i = 1; i + 1 < n_; ++i) {
        if (way_.tissue[l * n_ + i - 1] != way_.tissue[l * n_ + i]) add_mirror(l, i, raw);
      }
    });
  }

  /// Adds the mirror between samples i - 1 and i of a line.
  void add_mirror(std::size_t l, std::size_t i, std::vector<Complex>& raw) const {
    const Tissue before = way_.tissue[l * n_ + i - 1];
    const double depth = boundary(l, static_cast<double>(i - 1), before);
    const Vec3d p = at(l, depth).mm;
    const double rough = kRoughMm * normal_at(seed_, 0x726f756768, hash_bits(seed_, l, i));
    // The amplitude is scaled by the beam width in lines, so that it does not depend on the line
    // spacing: the beam adds up its lines.
    const double lateral = std::sqrt(2 * std::numbers::pi) * sigma_lateral(probe_, depth) /
                           geometry_.line_spacing_mm(depth);
    const auto r =
        static_cast<float>(reflection(before, way_.tissue[l * n_ + i]) / std::max(1.0, lateral));
    const double sample = depth / geometry_.sample_mm();
    const std::size_t s = std::min(static_cast<std::size_t>(sample), n_ - 2);
    const auto share = static_cast<float>(sample - static_cast<double>(s));
    const Complex echo = kMirror * r * way_.left[l * n_ + s] *
                         (1 + 0.4F * texture_field_.at(3 * p)) * phase(depth + rough);
    raw[l * n_ + s] += (1 - share) * echo;
    raw[l * n_ + s + 1] += share * echo;
  }

  /// Depth of the tissue boundary within a step, by bisection.
  [[nodiscard]] double boundary(std::size_t line, double index, Tissue before) const {
    double low = index * geometry_.sample_mm();
    double high = low + geometry_.sample_mm();
    if (before == Tissue::kGel) return high;  // Contact begins at the skin under the gel.
    for (int i = 0; i < 5; ++i) {
      const double middle = 0.5 * (low + high);
      (patient_.tissue(at(line, middle)) == before ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  const Anatomy& patient_;
  const ScanGeometry& geometry_;
  const ProbeModel& probe_;
  ScattererCells cells_;
  std::uint64_t seed_;
  Transform<frames::Ct, frames::Image> pose_;
  const Warp* warp_;
  Transform<frames::Image, frames::Ct> image_from_ct_ = pose_.inverse();
  Eigen::Matrix3d image_from_cells_ =
      cells_.cell_mm() * image_from_ct_.rotation().toRotationMatrix();
  std::size_t n_, lines_;
  std::vector<RestPath> paths_;
  Slab slab_;
  Eigen::AlignedBox3d box_;
  SmoothField texture_field_;
  SmoothPatch texture_;
  SmoothField absorption_field_;
  SmoothPatch absorption_;
  std::vector<Layer> layers_;
  WayDown way_;
  float unseen_ = amplitude_from_db(probe_.noise_level_db - probe_.liver_level_db - kUnseenDb);
};

}  // namespace

LineEchoes scatterer_echoes(const Anatomy& patient, const ScanGeometry& geometry,
                            const ProbeModel& probe, ScattererSeed seed,
                            const Transform<frames::Ct, frames::Image>& ct_from_image,
                            const Warp* warp) {
  return Model(patient, geometry, probe, seed, ct_from_image, warp).echoes();
}

}  // namespace nav::sim
