// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "sim/ultrasound.hpp"
#include "tests/sim/block.hpp"
#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;

double plate(const Vec& p) { return std::abs(p.y() - 33) - 3; }  // Front surface at 30 mm.
double slab(const Vec& p) { return std::abs(p.y() - 15) - 5; }
double disc(const Vec& p) {
  return std::max(std::hypot(p.x(), p.z()) - 8, std::abs(p.y() - 12) - 2);
}

/// Runs with both acoustic models, without depth gain and noise.
class AcousticsTest : public testing::TestWithParam<AcousticModel> {
 protected:
  static ProbeModel probe() {
    ProbeModel p = linear_l14();
    p.model = GetParam();
    p.frequency_mhz = 6;
    p.lateral_fwhm_mm = 0.8;
    p.lines = 96;
    p.tgc_db_per_cm_mhz = 0;
    p.tgc_error_db = 0;
    p.noise_level_db = -250;
    return p;
  }
  static Transform<Ct, Image> pose(double tilt_rad, double shift_mm = 0) {
    const Eigen::AngleAxisd turn(tilt_rad, Vec::UnitZ());
    return {Eigen::Quaterniond(turn), Vec(shift_mm, 0, shift_mm)};
  }
  static ScanLineImage see(Tissue inside, Block::Shape shape, const Transform<Ct, Image>& from,
                           const ProbeModel& p, std::uint64_t seed = 1) {
    const UltrasoundSimulator simulator(std::make_shared<const Block>(inside, shape), p, seed);
    return simulator.envelope(from, 0);
  }
};

/// Mean amplitude over the lines and over the depths within \p half_mm of \p depth_mm.
double mean_at(const ScanLineImage& image, double depth_mm, double half_mm) {
  double sum = 0;
  int n = 0;
  for (int l = 10; l < image.lines - 10; ++l) {
    for (int s = 0; s < image.samples; ++s) {
      if (std::abs(s * image.sample_mm - depth_mm) > half_mm) continue;
      sum += static_cast<double>(image.at(l, s)), ++n;
    }
  }
  return sum / n;
}

/// Strength of the echo of the tilted plate: the mean over the lines of the peak amplitude around
/// the plate.
double plate_echo(const ScanLineImage& image, double tilt_rad) {
  const double width = linear_l14().width_mm;
  double sum = 0;
  int n = 0;
  for (int l = 10; l < image.lines - 10; ++l) {
    const double x = (static_cast<double>(l) / (image.lines - 1) - 0.5) * width;
    // Depth of the front surface along a tilted line: y = x sin + d cos = 30.
    const double depth = (30 - x * std::sin(tilt_rad)) / std::cos(tilt_rad);
    float peak = 0;
    for (int s = 0; s < image.samples; ++s) {
      if (std::abs(s * image.sample_mm - depth) < 1.5) peak = std::max(peak, image.at(l, s));
    }
    sum += static_cast<double>(peak), ++n;
  }
  return sum / n;
}

TEST_P(AcousticsTest, ShowsAPlateAtItsDepth) {
  ProbeModel p = probe();
  p.tgc_db_per_cm_mhz =
      static_cast<double>(tissue_acoustics(Tissue::kLiver).attenuation_db_per_cm_mhz);
  const ScanLineImage image = see(Tissue::kBone, plate, pose(0), p);
  for (int l = 10; l < image.lines - 10; l += 5) {
    int best = 40;  // Starts below the ringing of the face.
    for (int s = 40; s < image.samples; ++s) {
      if (image.at(l, s) > image.at(l, best)) best = s;
    }
    // Half of the blend of 0.8 mm, and one sample.
    EXPECT_NEAR(best * image.sample_mm, 30, 0.6) << l;
  }
}

TEST_P(AcousticsTest, EchoOfAPlateFallsWithTheAngleOfIncidence) {
  double before = 1e9;
  for (const double tilt : {0.0, 0.17, 0.35, 0.52}) {
    const double echo = plate_echo(see(Tissue::kBone, plate, pose(tilt), probe()), tilt);
    EXPECT_LT(echo, before) << tilt;
    before = echo;
  }
  const double square = plate_echo(see(Tissue::kBone, plate, pose(0), probe()), 0);
  const double fall_db = 20 * std::log10(before / square);
  EXPECT_LT(fall_db, -4);
  if (GetParam() == AcousticModel::kRays) {
    // Law of incidence: cos^6, plus a tenth that is scattered in all directions.
    const double law = 20 * std::log10((std::pow(std::cos(0.52), 6) + 0.1) / 1.1);
    EXPECT_NEAR(fall_db, law, 1.5);
  }
}

TEST_P(AcousticsTest, LiverAttenuatesByItsCoefficientAtEachFrequency) {
  for (const double mhz : {4.0, 7.0}) {
    ProbeModel p = probe();
    p.frequency_mhz = mhz;
    const double near_mm = 12, far_mm = 42;
    double slope = 0;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const ScanLineImage image =
          see(Tissue::kLiver, nowhere, pose(0, 40.0 * static_cast<double>(seed)), p, seed);
      const double db = 20 * std::log10(mean_at(image, far_mm, 4) / mean_at(image, near_mm, 4));
      slope += db / (2 * (far_mm - near_mm) / 10 * mhz) / 3;  // One way, dB / (cm MHz).
    }
    const auto expected =
        -static_cast<double>(tissue_acoustics(Tissue::kLiver).attenuation_db_per_cm_mhz);
    // Absorption varies by up to 12 % with the position.
    EXPECT_NEAR(slope, expected, 0.12 * std::abs(expected)) << mhz;
  }
}

TEST_P(AcousticsTest, SpeckleIsRayleighDistributedBeforeCompression) {
  ProbeModel p = probe();
  p.tgc_db_per_cm_mhz =
      static_cast<double>(tissue_acoustics(Tissue::kLiver).attenuation_db_per_cm_mhz);
  double ratio = 0;
  int n = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const ScanLineImage image =
        see(Tissue::kLiver, nowhere, pose(0, 30.0 * static_cast<double>(seed)), p, seed);
    for (double depth = 15; depth < 40; depth += 6) {  // Depth bands, because the level drifts with
                                                       // depth.
      double sum = 0, squares = 0;
      int count = 0;
      for (int l = 10; l < image.lines - 10; ++l) {
        for (int s = 0; s < image.samples; ++s) {
          if (std::abs(s * image.sample_mm - depth) > 2.5) continue;
          const auto v = static_cast<double>(image.at(l, s));
          sum += v, squares += v * v, ++count;
        }
      }
      const double mean = sum / count;
      ratio += mean / std::sqrt(squares / count - mean * mean);
      ++n;
    }
  }
  // sqrt(pi / (4 - pi)) = 1.913. The texture of the tissue broadens the distribution a little.
  EXPECT_NEAR(ratio / n, std::sqrt(M_PI / (4 - M_PI)), 0.16);
}

TEST_P(AcousticsTest, BothModelsAgreeOnTheLevelOfLiver) {
  ProbeModel p = probe();
  p.tgc_db_per_cm_mhz =
      static_cast<double>(tissue_acoustics(Tissue::kLiver).attenuation_db_per_cm_mhz);
  const double db =
      20 * std::log10(mean_at(see(Tissue::kLiver, nowhere, pose(0), p), p.focus_mm, 8));
  EXPECT_NEAR(db, p.liver_level_db, 4);
}

TEST_P(AcousticsTest, ADiscOfBoneCastsAShadowOfItsWidth) {
  const ScanLineImage image = see(Tissue::kBone, disc, pose(0), probe());
  const double width = linear_l14().width_mm;
  double dark = 0, open = 0;
  int darks = 0, opens = 0;
  for (int l = 4; l < image.lines - 4; ++l) {
    const double x = std::abs((static_cast<double>(l) / (image.lines - 1) - 0.5) * width);
    for (int s = 0; s < image.samples; ++s) {
      const double depth = s * image.sample_mm;
      if (depth < 22 || depth > 38) continue;
      // The edges of the shadow are as soft as the beam and the aperture are wide.
      if (x < 8 - 4) dark += static_cast<double>(image.at(l, s)), ++darks;
      if (x > 8 + 4) open += static_cast<double>(image.at(l, s)), ++opens;
    }
  }
  EXPECT_LT(20 * std::log10(dark / darks / (open / opens)), -20);
}

/// Echo in dB of a needle that lies across the beams, 30 mm deep, in liver that is too dark to see.
double needle_db(Tissue in_front, ProbeModel p) {
  p.liver_level_db = -120;
  const NeedleShaft needle({{Vec(-40, 30, 0)}, {Vec(40, 30, 0)}});
  const UltrasoundSimulator simulator(std::make_shared<const Block>(in_front, slab), p, 1);
  const auto image = simulator.envelope({Eigen::Quaterniond::Identity(), Vec::Zero()}, 0, needle);
  return 20 * std::log10(plate_echo(image, 0));
}

TEST_P(AcousticsTest, TissueInFrontOfANeedleWeakensItsEcho) {
  const auto attenuation = [](Tissue t) {
    return static_cast<double>(tissue_acoustics(t).attenuation_db_per_cm_mhz);
  };
  const double in_liver = needle_db(Tissue::kLiver, probe());
  for (const Tissue in_front : {Tissue::kFluid, Tissue::kDisc, Tissue::kCartilage}) {
    // The echo passes 10 mm twice. The two surfaces reflect less than 0.1 dB.
    const double expected =
        -2 * (attenuation(in_front) - attenuation(Tissue::kLiver)) * probe().frequency_mhz * 1.0;
    // Absorption varies by up to 12 % with the position. The edges are 0.8 mm soft.
    EXPECT_NEAR(needle_db(in_front, probe()) - in_liver, expected, 0.12 * std::abs(expected) + 0.1)
        << to_string(in_front);
  }
  EXPECT_LT(needle_db(Tissue::kBone, probe()) - in_liver, -60);
}

TEST_P(AcousticsTest, EqualSeedsGiveEqualEchoes) {
  const auto a = see(Tissue::kBone, plate, pose(0.1), probe(), 5);
  const auto b = see(Tissue::kBone, plate, pose(0.1), probe(), 5);
  const auto c = see(Tissue::kBone, plate, pose(0.1), probe(), 6);
  EXPECT_EQ(a.amplitude, b.amplitude);
  EXPECT_NE(a.amplitude, c.amplitude);
}

INSTANTIATE_TEST_SUITE_P(Models, AcousticsTest,
                         testing::Values(AcousticModel::kRays, AcousticModel::kScatterers),
                         [](const auto& tested) {
                           return tested.param == AcousticModel::kRays ? "rays" : "scatterers";
                         });

TEST(ProbeSettingsTest, GainMarkerClutterAndReverberationChangeTheImage) {
  const auto block = std::make_shared<const Block>(Tissue::kBone, plate);
  const Transform<Ct, Image> pose(Eigen::Quaterniond::Identity(), Vec::Zero());
  const auto see = [&](const ProbeModel& p) {
    return UltrasoundSimulator(block, p, 1).simulate(pose, Timestamp{}, 0).pixels;
  };
  ProbeModel p = linear_l14();
  const auto plain = see(p);
  p.marker_on_other_side = true;
  const auto turned = see(p);
  int same = 0;
  for (int row = 40; row < 200; row += 10) {
    for (int c = 40; c < 260; c += 10) {
      same += std::abs(plain.at(c, row) - turned.at(p.columns - 1 - c, row)) <= 1 ? 1 : 0;
    }
  }
  EXPECT_EQ(same, 16 * 22);
  p.marker_on_other_side = false;
  p.gain_db = 6;  // 6 dB of a range of 60 dB: a tenth of 255.
  EXPECT_NEAR(see(p).at(150, 150) - plain.at(150, 150), 25.5, 1);
  p.gain_db = 0;
  p.reverberation = 0.5;
  const UltrasoundSimulator ringing(block, p, 1);
  p.reverberation = 0;
  const UltrasoundSimulator clean(block, p, 1);
  // The plate at 30 mm returns at 60 mm. Without reverberation the shadow of the bone is black
  // there.
  const auto at_double = [&](const ScanLineImage& image) {
    double sum = 0;
    for (int s = static_cast<int>(58 / image.sample_mm); s < image.samples; ++s) {
      sum += static_cast<double>(image.at(96, s));
    }
    return sum;
  };
  EXPECT_GT(at_double(ringing.envelope(pose, 0)), 2 * at_double(clean.envelope(pose, 0)));
  p.clutter_level_db = -20;
  EXPECT_GT(mean_at(UltrasoundSimulator(block, p, 1).envelope(pose, 0), 4, 2),
            mean_at(clean.envelope(pose, 0), 4, 2) * 1.2);
}

TEST(ProbeSettingsTest, ASectorStartsAtItsApex) {
  ProbeModel p = sector_cranial();
  const UltrasoundSimulator simulator(std::make_shared<const Block>(Tissue::kLiver, nowhere), p, 1);
  const auto image =
      simulator.simulate({Eigen::Quaterniond::Identity(), Vec::Zero()}, Timestamp{}, 0);
  ASSERT_TRUE(image.outline.has_value());
  EXPECT_EQ(image.outline->radius_min_mm, 0);
  EXPECT_EQ(image.pixels.at(2, 2), 0);
  EXPECT_GT(image.pixels.at(p.columns / 2, p.rows / 2), 30);
  p.lines = 0;
  EXPECT_TRUE(test::rejects(validate(p), ErrorCode::kUsage, {"lines", "0"}));
}

}  // namespace
}  // namespace nav::sim
