// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/ultrasound.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "sim/session/simulated_session.hpp"
#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

using frames::Ct;
using frames::Image;
using Vec = Eigen::Vector3d;

const SimulatedSession& sweep() {
  static const SimulatedSession instance = [] {
    SimulatedSessionOptions options;
    options.seed = 3;
    options.path.kind = HandPathKind::kTilt;
    options.approach.emplace();
    return *SimulatedSession::create(options);
  }();
  return instance;
}
const AbdomenPhantom& imaged() {
  static const AbdomenPhantom phantom({3, Contrast::kPortal});
  return phantom;
}

/// Probe without errors of the depth gain and the electronics.
ProbeModel ideal_probe() {
  ProbeModel probe = convex_abdominal();
  probe.tgc_db_per_cm_mhz = tissue_acoustics(Tissue::kLiver).attenuation_db_per_cm_mhz;
  probe.tgc_error_db = 0;
  probe.noise_level_db = -250;
  return probe;
}

Transform<Ct, Image> frame_pose(int index) { return sweep().truth(index).ct_from_image; }

Point<Ct> on_line(const Transform<Ct, Image>& pose, const ProbeModel& probe, int line, double mm) {
  const double angle = (2.0 * line / (probe.lines - 1) - 1) * probe.half_angle_rad;
  const double r = probe.radius_mm + mm;
  return pose * Point<Image>{{r * std::sin(angle), r * std::cos(angle) - probe.radius_mm, 0}};
}

/// True if \p p and six points at a distance of \p mm around it lie in this tissue.
bool is_pure(const Point<Ct>& p, Tissue tissue, double mm) {
  if (imaged().tissue(p) != tissue) return false;
  for (int i = 0; i < 6; ++i) {
    if (imaged().tissue({p.mm + (i % 2 == 0 ? mm : -mm) * Vec::Unit(i / 2)}) != tissue) {
      return false;
    }
  }
  return true;
}

struct Patch {
  double mean = 0;
  double spread = 0;
};

/// Mean and standard deviation of the envelope in patches of pure liver.
std::vector<Patch> liver_patches(const ScanLineImage& image, const Transform<Ct, Image>& pose,
                                 const ProbeModel& probe) {
  constexpr int kLines = 14;
  constexpr int kSamples = 40;  // About 10 mm.
  std::vector<Patch> patches;
  for (int l = 8; l + kLines < image.lines - 8; l += kLines) {
    for (int s = 60; s + kSamples < image.samples; s += kSamples) {
      bool pure = true;
      for (int i = 0; i <= kLines && pure; i += 2) {
        for (int j = 0; j <= kSamples && pure; j += 5) {
          pure = is_pure(on_line(pose, probe, l + i, (s + j) * image.sample_mm), Tissue::kLiver, 5);
        }
      }
      if (!pure) continue;
      double sum = 0;
      double squares = 0;
      for (int i = 0; i < kLines; ++i) {
        for (int j = 0; j < kSamples; ++j) {
          const double a = image.at(l + i, s + j);
          sum += a;
          squares += a * a;
        }
      }
      const double n = kLines * kSamples;
      patches.push_back({sum / n, std::sqrt(squares / n - sum * sum / (n * n))});
    }
  }
  return patches;
}

TEST(UltrasoundTest, SpeckleInLiverIsFullyDeveloped) {
  const ProbeModel probe = ideal_probe();
  const UltrasoundSimulator simulator(imaged(), probe, 3);
  double ratio = 0;
  int count = 0;
  for (const int frame : {5, 20, 35, 50}) {
    const auto pose = frame_pose(frame);
    for (const Patch& p : liver_patches(simulator.envelope(pose, 0), pose, probe)) {
      ratio += p.mean / p.spread;
      ++count;
    }
  }
  ASSERT_GT(count, 20);
  // For a Rayleigh amplitude, mean / standard deviation = sqrt(pi / (4 - pi)) = 1.913.
  constexpr double kTolerance = 0.15;
  EXPECT_NEAR(ratio / count, std::sqrt(M_PI / (4 - M_PI)), kTolerance);
}

TEST(UltrasoundTest, LiverAttenuatesByItsCoefficient) {
  ProbeModel probe = ideal_probe();
  probe.tgc_db_per_cm_mhz = 0;
  const UltrasoundSimulator simulator(imaged(), probe, 3);
  // Least squares of the mean level against depth, over patches of four frames.
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  int n = 0;
  for (const int frame : {5, 20, 35, 50}) {
    const auto pose = frame_pose(frame);
    const ScanLineImage image = simulator.envelope(pose, 0);
    for (int line = 20; line < image.lines - 20; line += 3) {
      bool shadow = false;
      for (int s = 0; s < 100; s += 4) {
        const auto p = on_line(pose, probe, line, s * image.sample_mm);
        shadow = shadow || blocks_ultrasound(imaged().tissue(p));
      }
      for (int s = 100; s + 20 < image.samples && !shadow; s += 20) {
        double mean = 0;
        bool pure = true;
        for (int j = 0; j < 20; j += 4) {
          pure = pure &&
                 is_pure(on_line(pose, probe, line, (s + j) * image.sample_mm), Tissue::kLiver, 4);
        }
        if (!pure) continue;
        for (int j = 0; j < 20; ++j) mean += image.at(line, s + j) / 20;
        const double depth_cm = (s + 10) * image.sample_mm / 10;
        const double db = 20 * std::log10(mean);
        sx += depth_cm, sy += db, sxx += depth_cm * depth_cm, sxy += depth_cm * db, ++n;
      }
    }
  }
  ASSERT_GT(n, 300);
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  const double expected =
      -2 * tissue_acoustics(Tissue::kLiver).attenuation_db_per_cm_mhz * probe.frequency_mhz;
  // The absorption varies by up to 12 % with the position.
  EXPECT_NEAR(slope, expected, 0.12 * std::abs(expected));
}

TEST(UltrasoundTest, SpeckleMovesWithTheTissue) {
  ProbeModel probe = linear_l14();
  const UltrasoundSimulator simulator(imaged(), probe, 3);
  // The probe face lies inside the liver, away from walls, so only speckle is visible.
  const Transform<Ct, Image> pose = frame_pose(20);
  const Vec origin = pose.translation_mm() + pose.rotation() * Vec(0, 35, 0);
  constexpr int kShift = 12;
  const double step = probe.width_mm / (probe.lines - 1);
  const Transform<Ct, Image> here(pose.rotation(), origin);
  const Transform<Ct, Image> beside(pose.rotation(),
                                    origin + pose.rotation() * Vec(kShift * step, 0, 0));
  const ScanLineImage a = simulator.envelope(here, 0);
  const ScanLineImage b = simulator.envelope(beside, 1);
  const auto correlation = [&](int shift) {
    double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
    int n = 0;
    for (int line = 20; line + kShift < a.lines - 20; ++line) {
      for (int s = 60; s < 300; ++s) {
        const double x = std::log(a.at(line + shift, s));
        const double y = std::log(b.at(line, s));
        sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y, ++n;
      }
    }
    return (n * sab - sa * sb) / std::sqrt((n * saa - sa * sa) * (n * sbb - sb * sb));
  };
  EXPECT_GT(correlation(kShift), 0.9);
  EXPECT_LT(correlation(0), 0.6);
}

TEST(UltrasoundTest, VesselsAreDarkerThanLiver) {
  const UltrasoundSimulator simulator(imaged(), convex_abdominal(), 3);
  double vessel = 0, liver = 0;
  int vessels = 0, livers = 0;
  for (const int frame : {5, 15, 25, 35, 45, 55}) {
    const auto pose = frame_pose(frame);
    const UltrasoundImage image = simulator.simulate(pose, Timestamp{}, 0);
    for (int row = 60; row < image.pixels.height(); row += 2) {
      for (int column = 0; column < image.pixels.width(); column += 2) {
        const auto p = image.grid.at(column, row);
        if (!image.outline->contains(p.mm.head<2>())) continue;
        const auto at = pose * p;
        if (is_pure(at, Tissue::kHepaticVein, 2.0) || is_pure(at, Tissue::kPortalVein, 2.0)) {
          vessel += image.pixels.at(column, row), ++vessels;
        } else if (is_pure(at, Tissue::kLiver, 4.0)) {
          liver += image.pixels.at(column, row), ++livers;
        }
      }
    }
  }
  ASSERT_GT(vessels, 60);
  ASSERT_GT(livers, 1000);
  EXPECT_NEAR(liver / livers, 105, 25);  // Mid-grey.
  EXPECT_LT(vessel / vessels, liver / livers - 40);
}

TEST(UltrasoundTest, ARibCastsAShadow) {
  // The view crosses the right chest wall. Lines that meet bone early must be black behind it.
  const ProbeModel probe = convex_abdominal();
  const UltrasoundSimulator simulator(imaged(), probe, 3);
  const Vec skin = imaged().skin_point(3.3, 30).mm;
  const Vec into = Vec(-skin.x(), -skin.y(), 0).normalized();
  Eigen::Matrix3d axes;
  axes.col(0) = Vec::UnitZ();
  axes.col(1) = into;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Transform<Ct, Image> pose(Eigen::Quaterniond(axes), skin + 8 * into);
  const ScanLineImage image = simulator.envelope(pose, 0);
  double shadow = 0, open = 0;
  int shadows = 0, opens = 0;
  for (int line = 0; line < image.lines; ++line) {
    bool bone = false;
    bool free = true;
    for (int s = 0; s * image.sample_mm < 60; s += 2) {
      const Tissue t = imaged().tissue(on_line(pose, probe, line, s * image.sample_mm));
      // Marrow marks a line through the middle of the rib, because the beam is wider than the edge
      // of the rib.
      if (s * image.sample_mm < 25) bone = bone || t == Tissue::kMarrow;
      free = free && !blocks_ultrasound(t);
    }
    for (int s = 160; s < 220; ++s) {
      if (bone) shadow += image.at(line, s), ++shadows;
      if (free) open += image.at(line, s), ++opens;
    }
  }
  ASSERT_GT(shadows, 300);
  ASSERT_GT(opens, 300);
  EXPECT_LT(20 * std::log10((shadow / shadows) / (open / opens)), -20);
}

TEST(UltrasoundTest, PixelsOutsideTheSectorAreBlack) {
  const UltrasoundSimulator simulator(imaged(), convex_abdominal(), 3);
  const UltrasoundImage image = simulator.simulate(frame_pose(10), Timestamp{}, 0);
  ASSERT_TRUE(image.outline.has_value());
  int inside = 0;
  for (int row = 0; row < image.pixels.height(); ++row) {
    for (int column = 0; column < image.pixels.width(); ++column) {
      if (image.outline->contains(image.grid.at(column, row).mm.head<2>())) {
        ++inside;
      } else {
        ASSERT_EQ(image.pixels.at(column, row), 0) << column << ' ' << row;
      }
    }
  }
  EXPECT_GT(inside, image.pixels.width() * image.pixels.height() / 3);
}

TEST(UltrasoundTest, TheNeedleIsVisibleOnlyInItsPlane) {
  const UltrasoundSimulator simulator(imaged(), convex_abdominal(), 3);
  const int last = sweep().frame_count() - 1;
  const auto pose = frame_pose(last);
  const auto needle = sweep().truth(last).needle->ct_from_needle;
  const auto with = simulator.simulate(pose, Timestamp{}, 7, needle);
  const auto without = simulator.simulate(pose, Timestamp{}, 7);
  const Point<Image> shaft = pose.inverse() * (needle * Point<frames::Needle>{Vec(0, 0, -4)});
  const Eigen::Vector2d at = with.grid.pixel_of(shaft);
  double near = 0, near_without = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int column = static_cast<int>(std::lround(at.x())) + dx;
      const int row = static_cast<int>(std::lround(at.y())) + dy;
      near += with.pixels.at(column, row) / 9.0;
      near_without += without.pixels.at(column, row) / 9.0;
    }
  }
  EXPECT_GT(near, near_without + 30);
  const Transform<Ct, Image> aside(pose.rotation(),
                                   pose.translation_mm() + pose.rotation() * Vec(0, 0, 20));
  const auto away = simulator.simulate(aside, Timestamp{}, 7, needle);
  const auto away_without = simulator.simulate(aside, Timestamp{}, 7);
  EXPECT_TRUE(std::ranges::equal(away.pixels.pixels(), away_without.pixels.pixels()));
}

TEST(UltrasoundTest, OneAndTwoThreadsGiveEqualBytes) {
  const auto draw = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const UltrasoundSimulator simulator(imaged(), convex_abdominal(), 3);
    return simulator.simulate(frame_pose(12), Timestamp{}, 4);
  };
  EXPECT_TRUE(std::ranges::equal(draw(1).pixels.pixels(), draw(2).pixels.pixels()));
}

TEST(UltrasoundTest, RejectsInvalidProbes) {
  ProbeModel probe = convex_abdominal();
  probe.depth_mm = -1;
  EXPECT_TRUE(test::rejects(validate(probe), ErrorCode::kUsage, {"depth_mm", "-1"}));
  EXPECT_THROW(UltrasoundSimulator(imaged(), probe, 1), Bug);
  EXPECT_TRUE(test::has_value(validate(linear_l14())));
}

}  // namespace
}  // namespace nav::sim
