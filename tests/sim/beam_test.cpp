// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/beam.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "sim/scan_geometry.hpp"
#include "sim/smooth_patch.hpp"
#include "sim/ultrasound.hpp"
#include "tests/sim/block.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;

double shallow_plate(const Vec& p) { return std::abs(p.y() - 18) - 3; }  // Front surface at 15 mm.

/// Liver for both acoustic models, with a constant depth gain, no noise, and wide beams that many
/// lines sample.
class BeamTest : public testing::TestWithParam<AcousticModel> {
 protected:
  static ProbeModel probe() {
    ProbeModel p = linear_l14();
    p.model = GetParam();
    p.frequency_mhz = 6;
    p.lateral_fwhm_mm = 1.0;
    p.elevation_fwhm_mm = 3.0;
    p.lines = 128;
    p.tgc_db_per_cm_mhz =
        static_cast<double>(tissue_acoustics(Tissue::kLiver).attenuation_db_per_cm_mhz);
    p.tgc_error_db = 0;
    p.noise_level_db = -250;
    return p;
  }
  static ScanLineImage see(Tissue inside, Block::Shape shape, double shift_mm, const ProbeModel& p,
                           std::uint64_t seed, double elevation_mm = 0) {
    const UltrasoundSimulator simulator(std::make_shared<const Block>(inside, shape), p, seed);
    return simulator.envelope(
        {Eigen::Quaterniond::Identity(), Vec(shift_mm, 0, shift_mm + elevation_mm)}, 0);
  }
};

/// Correlation of the intensities of two images around a depth. The second image is shifted by some
/// lines.
class Correlation {
 public:
  explicit Correlation(double half_band_mm) : half_band_mm_(half_band_mm) {}
  void add(const ScanLineImage& a, const ScanLineImage& b, double depth_mm, int shift) {
    for (int l = 10; l + shift < a.lines - 10; ++l) {
      for (int s = 0; s < a.samples; ++s) {
        if (std::abs(s * a.sample_mm - depth_mm) > half_band_mm_) continue;
        const auto x = static_cast<double>(a.at(l, s) * a.at(l, s));
        const auto y = static_cast<double>(b.at(l + shift, s) * b.at(l + shift, s));
        ++n_, x_ += x, y_ += y, xx_ += x * x, yy_ += y * y, xy_ += x * y;
      }
    }
  }
  [[nodiscard]] double value() const {
    const double covariance = xy_ / n_ - x_ / n_ * y_ / n_;
    return covariance / std::sqrt((xx_ / n_ - x_ / n_ * x_ / n_) * (yy_ / n_ - y_ / n_ * y_ / n_));
  }

 private:
  double half_band_mm_;
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, yy_ = 0, xy_ = 0;
};

constexpr int kSeeds = 6;

TEST_P(BeamTest, SpeckleWidthIsTheBeamWidthIncludingDefocus) {
  const ProbeModel p = probe();
  const double spacing = p.width_mm / (p.lines - 1);
  // The ray model keeps scatterers constant within cells, so the width of a cell adds to the
  // speckle.
  const double cell =
      GetParam() == AcousticModel::kRays ? kSpeckleCellMmTimesMhz / p.frequency_mhz : 0;
  std::vector<ScanLineImage> images;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    images.push_back(
        see(Tissue::kLiver, nowhere, 50.0 * seed, p, static_cast<std::uint64_t>(seed)));
  }
  for (const double depth : {10.0, p.focus_mm, 45.0}) {
    const double sigma = kFwhmToSigma * p.lateral_fwhm_mm * defocus(p, depth, 1.5);
    const double width2 = sigma * sigma + cell * cell / 12;
    // Echoes of a Gaussian beam correlate as exp(-d^2 / 4 sigma^2), and intensities as its square.
    const int shift = static_cast<int>(std::lround(sigma / spacing));
    Correlation measured(3);
    for (const auto& image : images) measured.add(image, image, depth, shift);
    const double d = shift * spacing;
    const double found2 = d * d / (-2 * std::log(measured.value()));
    EXPECT_NEAR(std::sqrt(found2 / width2), 1, 0.15) << depth;
  }
}

TEST_P(BeamTest, ImagesDecorrelateInElevationWithTheSliceThickness) {
  const ProbeModel p = probe();
  for (const double depth : {10.0, p.focus_mm, 45.0}) {
    const double fwhm = p.elevation_fwhm_mm * defocus(p, depth, 1.0);
    // The ray model has three samples across the slice, half a width apart, with amplitudes 1, 2
    // and 1. After one step, two of them coincide. The scatterer model has a Gaussian.
    const double step = 0.5 * fwhm;
    const double sigma = kFwhmToSigma * fwhm;
    const double expected = GetParam() == AcousticModel::kRays
                                ? std::pow(4.0 / 6.0, 2)
                                : std::exp(-step * step / (2 * sigma * sigma));
    // Uses only a thin depth band, because the step is half the width only there.
    Correlation measured(1);
    for (int seed = 1; seed <= kSeeds; ++seed) {
      const auto of = static_cast<std::uint64_t>(seed);
      measured.add(see(Tissue::kLiver, nowhere, 50.0 * seed, p, of),
                   see(Tissue::kLiver, nowhere, 50.0 * seed, p, of, step), depth, 0);
    }
    EXPECT_NEAR(measured.value(), expected, 0.1) << depth;
  }
}

TEST_P(BeamTest, TheErrorOfTheDepthGainIsASineWithTheStatedPeak) {
  ProbeModel p = probe();
  const ScanLineImage even = see(Tissue::kLiver, nowhere, 0, p, 1);
  p.tgc_error_db = 3;
  const ScanLineImage off = see(Tissue::kLiver, nowhere, 0, p, 1);
  const auto error_db = [&](int sample) {
    return 20 * std::log10(static_cast<double>(off.at(60, sample) / even.at(60, sample)));
  };
  constexpr int kStep = 100;
  const double turn = 0.045 * kStep * even.sample_mm;  // Angular frequency in rad per mm from
                                                       // beam.cpp.
  for (int s = even.samples / 2 - 40; s < even.samples / 2 + 40; s += 20) {
    const double before = error_db(s - kStep), here = error_db(s), after = error_db(s + kStep);
    EXPECT_NEAR(before + after, 2 * std::cos(turn) * here, 0.02) << s;
    EXPECT_NEAR(std::hypot(here, (after - before) / (2 * std::sin(turn))), 3, 0.02) << s;
  }
}

TEST_P(BeamTest, ReverberationRepeatsAPlateAtTwiceAndThreeTimesItsDepth) {
  ProbeModel p = probe();
  p.tgc_db_per_cm_mhz = 0;  // Without depth gain, nothing is lost between the face and the plate.
  const double back = 0.5;
  p.reverberation = back;
  const ScanLineImage image = see(Tissue::kBone, shallow_plate, 0, p, 1);
  std::vector<double> mean(static_cast<std::size_t>(image.samples));
  for (int l = 20; l < image.lines - 20; ++l) {
    for (int s = 0; s < image.samples; ++s) {
      mean[static_cast<std::size_t>(s)] += static_cast<double>(image.at(l, s));
    }
  }
  const auto peak = [&](double depth_mm) {
    const auto from = mean.begin() + static_cast<std::ptrdiff_t>((depth_mm - 2) / image.sample_mm);
    const auto to = from + static_cast<std::ptrdiff_t>(4 / image.sample_mm);
    return std::max_element(from, to) - mean.begin();
  };
  const auto plate = peak(15);
  const auto strength = [&](std::ptrdiff_t at) { return mean[static_cast<std::size_t>(at)]; };
  // The peak of an echo with two or three times the length lies within this number of samples.
  EXPECT_NEAR(static_cast<double>(peak(30) - 2 * plate), 0, 2);
  EXPECT_NEAR(static_cast<double>(peak(45) - 3 * plate), 0, 3);
  EXPECT_NEAR(strength(2 * plate) / strength(plate), back, 0.03);
  EXPECT_NEAR(strength(3 * plate) / strength(plate), back * back, 0.03);
}

TEST_P(BeamTest, ImageDoesNotDependOnTheNumberOfThreads) {
  std::vector<std::vector<float>> images;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    images.push_back(see(Tissue::kBone, shallow_plate, 3, probe(), 2).amplitude);
  }
  EXPECT_EQ(images[0], images[1]);
  EXPECT_EQ(images[0], images[2]);
}

INSTANTIATE_TEST_SUITE_P(Models, BeamTest,
                         testing::Values(AcousticModel::kRays, AcousticModel::kScatterers),
                         [](const auto& tested) {
                           return tested.param == AcousticModel::kRays ? "rays" : "scatterers";
                         });

TEST(ScanGeometryTest, FloatBeamsAreWithinAHundredthOfALine) {
  for (const ProbeModel& probe : {convex_abdominal(), linear_l14(), sector_cranial()}) {
    const ScanGeometry geometry(probe);
    for (double x = -120; x <= 120; x += 7.3) {
      for (double y = 1; y <= probe.depth_mm; y += 3.1) {
        const Eigen::Vector2d exact = geometry.beam_of(Eigen::Vector2d(x, y));
        const Eigen::Vector2f fast =
            geometry.beam_of(Eigen::Vector2f(Eigen::Vector2d(x, y).cast<float>()));
        EXPECT_NEAR(static_cast<double>(fast.x()), exact.x(), 0.005);
        EXPECT_NEAR(static_cast<double>(fast.y()), exact.y(), 0.005);
      }
    }
  }
}

TEST(SmoothPatchTest, EqualsItsFieldInsideAndOutsideTheBox) {
  const SmoothField field(7, 9.0);
  const Eigen::AlignedBox3d box(Vec(-40, 5, -100), Vec(30, 60, -60));
  const SmoothPatch patch(field, box);
  for (int i = 0; i < 500; ++i) {
    const double t = i / 500.0;
    const Vec p =
        Vec(-60, -10, -120) + Vec(120 * t, 90 * std::fmod(7 * t, 1), 80 * std::fmod(13 * t, 1));
    EXPECT_NEAR(static_cast<double>(patch.at(p)), static_cast<double>(field.at(p)), 2e-6);
  }
}

TEST(PhasorTest, IsTheUnitComplexNumberAtItsAngle) {
  for (int i = 0; i <= 10000; ++i) {
    const double turns = i / 10000.0;
    const std::complex<float> found = unit_phasor(static_cast<float>(turns));
    const double angle = 2 * std::numbers::pi * static_cast<double>(static_cast<float>(turns));
    EXPECT_NEAR(found.real(), std::cos(angle), 5e-7) << turns;
    EXPECT_NEAR(found.imag(), std::sin(angle), 5e-7) << turns;
  }
}

}  // namespace
}  // namespace nav::sim
