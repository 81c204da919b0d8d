// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/ultrasound.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tbb/parallel_for.h>

#include "sim/beam.hpp"
#include "sim/line_medium.hpp"
#include "sim/motion/rest_path.hpp"
#include "sim/needle_echo.hpp"
#include "sim/scan_geometry.hpp"
#include "sim/scatterer_model.hpp"
#include "sim/speckle.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using Complex = std::complex<float>;

constexpr int kStride = 2;  // Number of echo samples per tissue sample.
constexpr int kSlices = 3;  // Number of samples across the slice thickness.
constexpr int kMaxLateralTaps = 8;
constexpr std::array<float, kSlices> kSliceAmplitude = {0.408248F, 0.816497F, 0.408248F};
constexpr std::uint64_t kImageNoiseStream = 0x7573;
constexpr std::uint64_t kClutterStream = 0x636c75;
constexpr std::uint64_t kGasStream = 0x676173;
constexpr std::uint64_t kLookStream = 0x6c6f6f6b;

struct TissueSample {
  float impedance = 0;
  float impedance_across = 0;  ///< Derivative along +z of the image, MRayl / mm.
  float loss_db_per_mm = 0;    ///< Loss for one way.
  std::array<float, kSlices> scatter{};
};

/// The probe whose images reach as deep as echoes have to be known.
ProbeModel deep_enough(ProbeModel probe) {
  probe.depth_mm *= heard_depth(probe);
  return probe;
}

std::vector<SpeckleField> speckle_of_looks(const ProbeModel& probe, std::uint64_t seed) {
  std::vector<SpeckleField> fields;
  for (int look = 0; look < probe.looks; ++look) {
    const auto k = static_cast<std::uint64_t>(look);
    fields.emplace_back(look == 0 ? seed : hash_bits(seed, kLookStream, k),
                        kSpeckleCellMmTimesMhz / probe.frequency_mhz);
  }
  return fields;
}

/// The echoes of a line at the depths at which they are shown. Magnitudes are interpolated, because
/// the phase of neighbouring samples may differ by more than a turn.
std::vector<Complex> as_shown(std::span<const Complex> heard, const LineMedium& medium) {
  std::vector<Complex> shown(medium.source.size());
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const auto sample = static_cast<std::size_t>(medium.source[i]);
    if (sample + 1 >= heard.size()) break;  // Deeper than what was simulated.
    const float share = medium.source[i] - static_cast<float>(sample);
    const Complex a = heard[sample], b = heard[sample + 1];
    const Complex nearest = share < 0.5F ? a : b;
    const float size = std::abs(nearest);
    if (size > 0) shown[i] = nearest * (((1 - share) * std::abs(a) + share * std::abs(b)) / size);
  }
  return shown;
}

}  // namespace

struct UltrasoundSimulator::Tables {
  Tables(std::shared_ptr<const Anatomy> p, const ProbeModel& m, std::uint64_t s);

  [[nodiscard]] RestPath path(const Transform<frames::Ct, frames::Image>& pose, const Warp* warp,
                              int line) const;
  void sample_tissue(const RestPath& path, std::span<TissueSample> out) const;
  void echoes(const SpeckleField& field, const RestPath& path, int line,
              std::span<const TissueSample> tissue, std::span<float> kept,
              std::span<Complex> out) const;
  void blur_along(std::span<Complex> line) const;
  [[nodiscard]] std::vector<RestPath> all_paths(const Transform<frames::Ct, frames::Image>& pose,
                                                const Warp* warp) const;
  [[nodiscard]] std::vector<TissueSample> all_tissue(std::span<const RestPath> paths) const;
  [[nodiscard]] std::vector<Complex> ray_echoes(const SpeckleField& field,
                                                std::span<const RestPath> paths,
                                                std::span<const TissueSample> tissue,
                                                const NeedleEcho& needle) const;
  void add_gas_haze(const LineMedium& medium, int line, std::uint64_t sequence,
                    std::span<Complex> shown) const;
  void add_reverberation(std::span<Complex> line) const;
  [[nodiscard]] std::vector<Complex> across(std::span<const Complex> echo, int line) const;
  [[nodiscard]] double elevation_mm(double along_mm) const;
  void detect(std::span<const Complex> sum, int line, std::uint64_t sequence, int look,
              std::span<float> out) const;

  [[nodiscard]] std::size_t samples() const { return static_cast<std::size_t>(geometry.samples()); }
  [[nodiscard]] std::size_t tissue_samples() const { return samples() / kStride + 2; }

  std::shared_ptr<const Anatomy> patient;
  ProbeModel probe;
  ProbeModel heard;  ///< The probe, as deep as echoes have to be known.
  std::uint64_t seed;
  ScanGeometry geometry;              ///< Geometry of the echoes that are known.
  ScanGeometry shown;                 ///< Geometry of the image.
  std::vector<SpeckleField> speckle;  ///< One pattern for each of probe.looks.
  SmoothField texture;
  SmoothField absorption;
  std::vector<float> axial;    ///< Half of the symmetric pulse, centre first.
  std::vector<float> lateral;  ///< Taps 0..kMaxLateralTaps, each for all samples.
  std::vector<float> gain;     ///< Depth gain of each sample.
};

UltrasoundSimulator::Tables::Tables(std::shared_ptr<const Anatomy> p, const ProbeModel& m,
                                    std::uint64_t s)
    : patient(std::move(p)),
      probe(m),
      heard(deep_enough(m)),
      seed(s),
      geometry(heard),
      shown(m),
      speckle(speckle_of_looks(m, s)),
      texture(s ^ 0x74657874, 9.0),
      absorption(s ^ 0x61747465, 25.0) {
  const double step = geometry.sample_mm();
  axial = axial_pulse(m.frequency_mhz, step, speckle.front().cell_mm());
  gain = depth_gain(m, s, step, samples());
  lateral.assign(static_cast<std::size_t>(kMaxLateralTaps + 1) * samples(), 0.0F);
  std::array<float, kMaxLateralTaps + 1> taps{};
  for (std::size_t i = 0; i < samples(); ++i) {
    const double along = static_cast<double>(i) * step;
    const double sigma = kFwhmToSigma * m.lateral_fwhm_mm * defocus(m, along, 1.5);
    beam_taps(sigma, geometry.line_spacing_mm(along), speckle.front().cell_mm(), taps);
    for (std::size_t k = 0; k < taps.size(); ++k) lateral[k * samples() + i] = taps[k];
  }
}

double UltrasoundSimulator::Tables::elevation_mm(double along_mm) const {
  return elevation_half_mm(probe, along_mm);
}

RestPath UltrasoundSimulator::Tables::path(const Transform<frames::Ct, frames::Image>& pose,
                                           const Warp* warp, int line) const {
  const ScanLine ray = geometry.line(line);
  return {warp, (pose * Point<frames::Image>{{ray.start.x(), ray.start.y(), 0}}).mm,
          (pose * Direction<frames::Image>{{ray.direction.x(), ray.direction.y(), 0}}).v,
          (pose * Direction<frames::Image>{Vec::UnitZ()}).v,
          geometry.sample_mm() * static_cast<double>(samples() + 2 * kStride)};
}

void UltrasoundSimulator::Tables::sample_tissue(const RestPath& path,
                                                std::span<TissueSample> out) const {
  const double step = kStride * geometry.sample_mm();
  bool in_contact = false;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double depth = static_cast<double>(i) * step;
    const Vec centre = path.at(depth);
    const Vec along = path.direction(depth);
    const double half = elevation_mm(depth);
    TissueSample& s = out[i];
    if (!in_contact) in_contact = patient->skin_distance_mm({centre}) < 0;
    std::array<Acoustics, kSlices> slices;
    for (int k = 0; k < kSlices; ++k) {
      const auto n = static_cast<std::size_t>(k);
      const bool gel = !in_contact && depth < most_coupling_mm(probe);
      slices[n] = gel ? tissue_acoustics(Tissue::kGel)
                      : patient->acoustics({path.at(depth, (k - 1) * half)});
      s.scatter[n] = kSliceAmplitude[n] * scatter_along(slices[n], along.x(), along.y(), along.z());
    }
    s.impedance = 0.25F * (slices[0].impedance_mrayl + 2 * slices[1].impedance_mrayl +
                           slices[2].impedance_mrayl);
    s.impedance_across =
        (slices[2].impedance_mrayl - slices[0].impedance_mrayl) / static_cast<float>(2 * half);
    const float attenuation =
        0.25F * (slices[0].attenuation_db_per_cm_mhz + 2 * slices[1].attenuation_db_per_cm_mhz +
                 slices[2].attenuation_db_per_cm_mhz);
    s.loss_db_per_mm = attenuation * (1 + 0.12F * absorption.at(centre)) *
                       static_cast<float>(probe.frequency_mhz / 10.0);
    const float vary = 1 + 0.14F * texture.at(centre);
    for (float& value : s.scatter) value *= vary;
  }
}

/// \p tissue: all lines, one after another. \p kept: receives the remaining amplitude of an echo
/// from each sample; may be empty.
void UltrasoundSimulator::Tables::echoes(const SpeckleField& field, const RestPath& path, int line,
                                         std::span<const TissueSample> tissue,
                                         std::span<float> kept, std::span<Complex> out) const {
  const std::size_t stride = tissue_samples();
  const auto row = [&](int l) {
    return tissue.subspan(static_cast<std::size_t>(std::clamp(l, 0, probe.lines - 1)) * stride,
                          stride);
  };
  const auto own = row(line);
  const auto left = row(line - 1);
  const auto right = row(line + 1);
  const auto step = static_cast<float>(geometry.sample_mm());
  const RestPath cells = path.mapped(field.cells_from_mm());
  const float level = amplitude_from_db(probe.liver_level_db) / 0.886F;  // Rayleigh mean / rms.
  double loss_db = 0;
  float passed = 1;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t n = i / kStride;
    const float share = static_cast<float>(i % kStride) / kStride;
    const TissueSample& a = own[n];
    const TissueSample& b = own[n + 1];
    const double depth = static_cast<double>(i) * geometry.sample_mm();
    const float slope_along = (b.impedance - a.impedance) / (kStride * step);
    const float slope_side = (right[n].impedance - left[n].impedance) /
                             static_cast<float>(2 * geometry.line_spacing_mm(depth));
    const float slope = std::sqrt(slope_along * slope_along + slope_side * slope_side +
                                  a.impedance_across * a.impedance_across);
    Complex signal = 0;
    const double half = elevation_mm(depth);
    for (int k = 0; k < kSlices; ++k) {
      const auto s = static_cast<std::size_t>(k);
      const float scatter = a.scatter[s] + share * (b.scatter[s] - a.scatter[s]);
      signal += scatter * field.at(cells.at(depth, (k - 1) * half));
    }
    const float roughness = 1.0F + 0.5F * signal.real();
    signal *= level;
    const float reflection =
        std::min(0.999F, std::abs(slope_along) * step / (a.impedance + b.impedance));
    if (slope > 0) {
      const float directed = facing_interface(slope_along / slope);
      signal += kInterfaceGain * std::min(0.5F, slope * step / (a.impedance + b.impedance)) *
                directed * std::max(0.2F, roughness);
    }
    const float fading = std::exp(static_cast<float>(-2 * std::numbers::ln10 / 20 * loss_db));
    out[i] = signal * passed * fading;
    if (!kept.empty()) kept[i] = passed * fading;
    loss_db += step * (a.loss_db_per_mm + share * (b.loss_db_per_mm - a.loss_db_per_mm));
    passed *= 1 - reflection * reflection;
  }
}

void UltrasoundSimulator::Tables::blur_along(std::span<Complex> line) const {
  const std::vector<Complex> in(line.begin(), line.end());
  const auto last = static_cast<int>(in.size()) - 1;
  for (int i = 0; i <= last; ++i) {
    Complex sum = axial[0] * in[static_cast<std::size_t>(i)];
    for (int k = 1; k < static_cast<int>(axial.size()); ++k) {
      sum += axial[static_cast<std::size_t>(k)] *
             (in[static_cast<std::size_t>(std::max(i - k, 0))] +
              in[static_cast<std::size_t>(std::min(i + k, last))]);
    }
    line[static_cast<std::size_t>(i)] = sum;
  }
}

/// Adds reverberations of the face: an echo is reflected there again and returns at twice and three
/// times its depth, after the losses of the longer way.
void UltrasoundSimulator::Tables::add_reverberation(std::span<Complex> line) const {
  const std::vector<Complex> in(line.begin(), line.end());
  const auto back = static_cast<float>(probe.reverberation);
  for (std::size_t i = 0; i < in.size(); ++i) {
    const double depth = static_cast<double>(i) * geometry.sample_mm();
    const double loss = probe.tgc_db_per_cm_mhz * probe.frequency_mhz * depth / 10.0;
    line[i] += back * amplitude_from_db(-loss) * in[i / 2] +
               back * back * amplitude_from_db(-4.0 / 3.0 * loss) * in[i / 3];
  }
}

/// Applies the lateral beam to one line. \p echo: all lines.
std::vector<Complex> UltrasoundSimulator::Tables::across(std::span<const Complex> echo,
                                                         int line) const {
  std::vector<Complex> sum(samples());
  for (int k = -kMaxLateralTaps; k <= kMaxLateralTaps; ++k) {
    const auto from = static_cast<std::size_t>(std::clamp(line + k, 0, probe.lines - 1));
    const Complex* in = echo.data() + from * samples();
    const float* w = lateral.data() + static_cast<std::size_t>(std::abs(k)) * samples();
    for (std::size_t i = 0; i < samples(); ++i) sum[i] += w[i] * in[i];
  }
  return sum;
}

/// Adds what multiple reflections in gas return below it, before depth gain.
void UltrasoundSimulator::Tables::add_gas_haze(const LineMedium& medium, int line,
                                               std::uint64_t sequence,
                                               std::span<Complex> shown_line) const {
  if (!medium.gas_mm || probe.gas_haze_db <= -299) return;
  constexpr double kCells = 3;  // Lines and samples that a speckle of the haze extends over.
  const SpeckleField haze(hash_bits(seed, kGasStream, sequence), 1.0);
  for (std::size_t i = 0; i < shown_line.size(); ++i) {
    const double below = static_cast<double>(i) * shown.sample_mm() - *medium.gas_mm;
    if (below <= 0) continue;
    shown_line[i] += medium.gas_level * haze_below_gas(probe, below) *
                     haze.at({line / kCells, static_cast<double>(i) / kCells, 0.5});
  }
}

/// Computes depth gain, electronic noise, clutter and envelope of one line.
void UltrasoundSimulator::Tables::detect(std::span<const Complex> sum, int line,
                                         std::uint64_t sequence, int look,
                                         std::span<float> out) const {
  const std::uint64_t own =
      look == 0 ? seed : hash_bits(seed, kLookStream + 1, static_cast<std::uint64_t>(look));
  const SpeckleField noise(hash_bits(own, kImageNoiseStream, sequence), 1.0);
  const float noise_level = amplitude_from_db(probe.noise_level_db);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Complex electronic =
        noise_level * noise.at({static_cast<double>(line) + 0.5, static_cast<double>(i) + 0.5, 0});
    const double along = static_cast<double>(i) * geometry.sample_mm();
    out[i] = std::sqrt(std::norm(sum[i] + electronic)) * gain[i] + ringing(probe, along);
  }
  if (probe.clutter_level_db > -299) {
    const SpeckleField haze(hash_bits(seed, kClutterStream, sequence), 2.0);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double along = static_cast<double>(i) * geometry.sample_mm();
      const Complex here = haze.at({static_cast<double>(line), static_cast<double>(i), 0});
      out[i] += amplitude_from_db(probe.clutter_level_db) * std::abs(here) *
                static_cast<float>(std::exp(-along / probe.clutter_mm));
    }
  }
}

UltrasoundSimulator::UltrasoundSimulator(const AbdomenPhantom& phantom, const ProbeModel& probe,
                                         std::uint64_t seed)
    : UltrasoundSimulator(std::make_shared<const AbdomenPhantom>(phantom), probe, seed) {}
UltrasoundSimulator::UltrasoundSimulator(std::shared_ptr<const Anatomy> patient,
                                         const ProbeModel& probe, std::uint64_t seed) {
  NAV_CHECK(patient != nullptr);
  const auto ok = validate(probe);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
  tables_ = std::make_unique<const Tables>(std::move(patient), probe, seed);
}
UltrasoundSimulator::~UltrasoundSimulator() = default;
UltrasoundSimulator::UltrasoundSimulator(UltrasoundSimulator&&) noexcept = default;
UltrasoundSimulator& UltrasoundSimulator::operator=(UltrasoundSimulator&&) noexcept = default;

const ProbeModel& UltrasoundSimulator::probe() const { return tables_->probe; }
PixelGrid UltrasoundSimulator::grid() const { return tables_->shown.grid(); }
std::optional<SectorOutline> UltrasoundSimulator::outline() const {
  return tables_->shown.outline();
}

ScanLineImage UltrasoundSimulator::envelope(
    const Transform<frames::Ct, frames::Image>& ct_from_image, std::uint64_t sequence,
    const NeedleShaft& needle, const Warp* warp) const {
  const Tables& t = *tables_;
  const std::size_t n = t.samples();
  const auto shown = static_cast<std::size_t>(t.shown.samples());
  const bool rays = t.probe.model == AcousticModel::kRays;
  const NeedleEcho needle_echo(needle, ct_from_image, t.geometry, t.heard);
  std::vector<RestPath> paths;
  std::vector<TissueSample> tissue;
  std::vector<LineMedium> media;
  if (rays || needs_media(t.probe)) paths = t.all_paths(ct_from_image, warp);
  if (rays) tissue = t.all_tissue(paths);
  if (needs_media(t.probe)) {
    media = line_media(*t.patient, t.geometry, t.probe, paths, shown);
  }
  ScanLineImage image;
  image.lines = t.probe.lines;
  image.samples = t.shown.samples();
  image.sample_mm = t.geometry.sample_mm();
  image.amplitude.resize(static_cast<std::size_t>(image.lines) * shown);
  for (int look = 0; look < t.probe.looks; ++look) {
    const auto k = static_cast<std::size_t>(look);
    const LineEchoes heard =
        rays ? LineEchoes{t.ray_echoes(t.speckle[k], paths, tissue, needle_echo), {}}
             : scatterer_echoes(*t.patient, t.geometry, t.heard, {t.seed, k}, ct_from_image, warp);
    tbb::parallel_for(0, image.lines, [&](int line) {
      const std::size_t first = static_cast<std::size_t>(line) * n;
      std::vector<Complex> sum(n);
      if (rays) {
        sum = t.across(heard.echo, line);
      } else {
        std::copy_n(heard.echo.begin() + static_cast<std::ptrdiff_t>(first), n, sum.begin());
        needle_echo.add(line, std::span(heard.left).subspan(first, n), sum);
      }
      if (!media.empty()) {
        const LineMedium& medium = media[static_cast<std::size_t>(line)];
        if (!medium.source.empty()) sum = as_shown(sum, medium);
        t.add_gas_haze(medium, line, hash_bits(sequence, k, 0), sum);
      }
      if (t.probe.reverberation > 0) t.add_reverberation(sum);
      const auto out =
          std::span(image.amplitude).subspan(static_cast<std::size_t>(line) * shown, shown);
      if (t.probe.looks == 1) return t.detect(sum, line, sequence, look, out);
      std::vector<float> own(shown);
      t.detect(sum, line, sequence, look, own);
      for (std::size_t i = 0; i < shown; ++i) {
        out[i] += own[i] * own[i] / static_cast<float>(t.probe.looks);
      }
    });
  }
  if (t.probe.looks > 1) {
    for (float& power : image.amplitude) power = std::sqrt(power);
  }
  return image;
}

std::vector<RestPath> UltrasoundSimulator::Tables::all_paths(
    const Transform<frames::Ct, frames::Image>& pose, const Warp* warp) const {
  std::vector<RestPath> paths;
  paths.reserve(static_cast<std::size_t>(probe.lines));
  for (int line = 0; line < probe.lines; ++line) paths.push_back(path(pose, warp, line));
  return paths;
}

/// Tissue of all lines, one after another.
std::vector<TissueSample> UltrasoundSimulator::Tables::all_tissue(
    std::span<const RestPath> paths) const {
  const std::size_t m = tissue_samples();
  std::vector<TissueSample> tissue(paths.size() * m);
  tbb::parallel_for(std::size_t{0}, paths.size(), [&](std::size_t line) {
    sample_tissue(paths[line], std::span(tissue).subspan(line * m, m));
  });
  return tissue;
}

/// Echoes of all lines before the lateral beam.
std::vector<Complex> UltrasoundSimulator::Tables::ray_echoes(const SpeckleField& field,
                                                             std::span<const RestPath> paths,
                                                             std::span<const TissueSample> tissue,
                                                             const NeedleEcho& needle) const {
  const std::size_t n = samples();
  const auto at = [](int line) { return static_cast<std::size_t>(line); };
  std::vector<Complex> echo(at(probe.lines) * n);
  tbb::parallel_for(0, probe.lines, [&](int line) {
    const auto out = std::span(echo).subspan(at(line) * n, n);
    std::vector<float> kept(needle.empty() ? 0 : n);
    echoes(field, paths[at(line)], line, tissue, kept, out);
    if (!needle.empty()) needle.add(line, kept, out);
    blur_along(out);
  });
  return echo;
}

namespace {

/// Reverses the order of the lines.
void mirror(ScanLineImage& image) {
  const auto n = static_cast<std::ptrdiff_t>(image.samples);
  for (std::ptrdiff_t l = 0; l < image.lines / 2; ++l) {
    const auto first = image.amplitude.begin() + l * n;
    std::swap_ranges(first, first + n, image.amplitude.begin() + (image.lines - 1 - l) * n);
  }
}

}  // namespace

UltrasoundImage UltrasoundSimulator::simulate(
    const Transform<frames::Ct, frames::Image>& ct_from_image, Timestamp acquired,
    std::uint64_t sequence, const NeedleShaft& needle, const Warp* warp) const {
  ScanLineImage image = envelope(ct_from_image, sequence, needle, warp);
  const auto range = static_cast<float>(tables_->probe.dynamic_range_db);
  const auto gain = static_cast<float>(tables_->probe.gain_db);
  if (tables_->probe.marker_on_other_side) mirror(image);
  const auto n = static_cast<std::size_t>(image.samples);
  tbb::parallel_for(0, image.lines, [&](int line) {
    for (float& v : std::span(image.amplitude).subspan(static_cast<std::size_t>(line) * n, n)) {
      v = 255.0F * (1.0F + (20.0F * std::log10(std::max(v, 1e-9F)) + gain) / range);
      v = std::clamp(v, 0.0F, 255.0F);
    }
  });
  UltrasoundImage frame;
  frame.acquired = acquired;
  frame.received = acquired;
  frame.sequence = sequence;
  frame.pixels = tables_->shown.convert(image.amplitude);
  frame.grid = grid();
  frame.outline = outline();
  return frame;
}

}  // namespace nav::sim
