// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/sheets.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "sim/anatomy/patient.hpp"
#include "sim/ultrasound.hpp"
#include "tests/support/trials.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kSpacingMm = 4;

Septa septa() { return {Vec(0.6, 0, 0.8), Vec(0.8, 0, -0.6), kSpacingMm, 4.5, 7}; }

float echo_of(const Acoustics& a) {
  return std::sqrt(a.sheet[0] * a.sheet[0] + a.sheet[1] * a.sheet[1] + a.sheet[2] * a.sheet[2]);
}

TEST(SheetsTest, WidthOfTheProfileIsTheThickness) {
  for (const double thickness : {0.2, 0.5}) {
    EXPECT_DOUBLE_EQ(sheet_profile(0.0, thickness), 1);
    EXPECT_NEAR(sheet_profile(0.5 * thickness, thickness), 0.5, 1e-3);
    EXPECT_NEAR(sheet_profile(-0.5 * thickness, thickness), 0.5, 1e-3);
    EXPECT_EQ(sheet_profile(0.93 * thickness, thickness), 0);
  }
}

/// Compares the gradient of a function of Vec3 of Dual with central differences of the function of
/// doubles.
template <class F>
void expect_gradient(const F& f, double least_slope) {
  Random random(3, 1);
  int sloped = 0;
  int corners = 0;
  for (int i = 0; i < 20000 && sloped < 1000; ++i) {
    const Vec p = random.offset(40);
    const Dual exact = f(seed(p));
    ASSERT_NEAR(exact.value, f(p), 1e-12);
    if (!(exact.gradient.norm() > least_slope)) continue;
    ++sloped;
    const auto differences = [&](double h) {
      Vec g;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec step = h * Vec::Unit(axis);
        g[axis] = (f(Vec(p + step)) - f(Vec(p - step))) / (2 * h);
      }
      return g;
    };
    const Vec fine = differences(1e-6);
    // At the middle between two septa, the nearest one changes.
    if ((fine - differences(4e-6)).norm() > 1e-3 * (1 + fine.norm())) {
      ++corners;
      continue;
    }
    EXPECT_LT((exact.gradient - fine).norm(), 1e-4 * (1 + fine.norm())) << p.transpose();
  }
  EXPECT_GT(sloped, 500);
  EXPECT_LT(corners, 20);
}

TEST(SheetsTest, GradientsAreTheDerivativesOfTheValues) {
  const Septa s = septa();
  expect_gradient([&](const auto& p) { return s.offset_mm(p); }, 0);
  expect_gradient([&](const auto& p) { return s.echo(p); }, 1e-3);
}

TEST(SheetsTest, SeptaAreThinInterruptedAndHaveTheirSpacing) {
  const Septa s = septa();
  constexpr double kStepMm = 0.01;
  constexpr double kWayMm = 400;
  int crossed = 0;
  int bright = 0;
  double run_mm = 0;
  for (double t = 0; t < kWayMm; t += kStepMm) {
    const Vec p(0.8 * t + 3, 11, -0.6 * t);
    const Vec next = p + kStepMm * Vec(0.8, 0, -0.6);
    const double off = s.offset_mm(p);
    if (off <= 0 && s.offset_mm(next) > 0) {
      ++crossed;
      bright += s.echo(p) > 0.5 ? 1 : 0;
    }
    run_mm = s.echo(p) > 0 ? run_mm + kStepMm : 0;
    EXPECT_LT(run_mm, 1.2);
    if (s.echo(p) > 0) {
      EXPECT_LT(std::abs(off), 0.5);
    }
  }
  EXPECT_NEAR(kWayMm / crossed, kSpacingMm, 0.1 * kSpacingMm);
  EXPECT_GT(bright, crossed / 2);
  EXPECT_LT(bright, crossed);
}

TEST(SheetsTest, SeptaAreVisibleOnlyInUltrasound) {
  const auto a = make_patient("shoulder", {2, Contrast::kNative})->anatomy;
  Random random(1, 2);
  int septa = 0;
  int as_muscle = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::AlignedBox3d box = a->region_mm();
    const Point<frames::Ct> p{box.center() + random.offset(0.5).cwiseProduct(box.sizes())};
    if (a->tissue(p) != Tissue::kMuscle || echo_of(a->acoustics(p)) < 1) continue;
    ++septa;
    as_muscle += a->hu(p) == tissue_hu(Tissue::kMuscle, Contrast::kNative) ? 1 : 0;
  }
  EXPECT_GT(septa, 100);
  EXPECT_GT(as_muscle, septa * 9 / 10);  // Except where the border of the muscle is blended.
}

TEST(SheetsTest, TheAbdomenHasNoSepta) {
  const auto a = make_patient("abdomen", {2, Contrast::kNative})->anatomy;
  Random random(1, 2);
  const Eigen::AlignedBox3d box = a->region_mm();
  for (int i = 0; i < test::trials(5000); ++i) {
    const Vec p = box.center() + random.offset(0.5).cwiseProduct(box.sizes());
    ASSERT_EQ(echo_of(a->acoustics({p})), 0);
  }
}

/// Far wall of the common carotid artery along a vertical line of an image, from the tissues of the
/// phantom.
struct FarWall {
  double lumen_mm = -1;  ///< Depth at which the blood ends.
  double outer_mm = -1;  ///< Depth at which the wall ends.
};
FarWall far_wall(const Anatomy& a, const Transform<frames::Ct, frames::Image>& pose, double x) {
  const auto at = [&](double depth) {
    return a.tissue(pose * Point<frames::Image>{Vec(x, depth, 0)});
  };
  constexpr double kStepMm = 0.005;
  FarWall wall;
  for (double d = 10; d < 40; d += kStepMm) {
    const bool inner = at(d) == Tissue::kArtery && at(d + kStepMm) == Tissue::kVesselWall;
    if (inner) wall.lumen_mm = d;
    const bool left = wall.lumen_mm > 0 && at(d) == Tissue::kVesselWall;
    if (left && at(d + kStepMm) != Tissue::kVesselWall) {
      wall.outer_mm = d;
      return wall;
    }
  }
  return wall;
}

/// Indices of the first two local maxima above \p least, and of the smallest value between them.
struct DoubleLine {
  std::size_t inner = 0, dark = 0, outer = 0;
};
DoubleLine double_line(const std::vector<double>& profile, double least) {
  std::vector<std::size_t> peaks;
  for (std::size_t i = 1; i + 1 < profile.size(); ++i) {
    const bool peak = profile[i] > profile[i - 1] && profile[i] >= profile[i + 1];
    if (peak && profile[i] > least) peaks.push_back(i);
  }
  if (peaks.size() < 2) return {};
  const auto from = profile.begin() + static_cast<std::ptrdiff_t>(peaks[0]);
  const auto to = profile.begin() + static_cast<std::ptrdiff_t>(peaks[1]);
  return {peaks[0], static_cast<std::size_t>(std::min_element(from, to) - profile.begin()),
          peaks[1]};
}

/// View along the right carotid artery. Positions with x < -6 mm lie below the bifurcation.
const StandardView& along_carotid(const Patient& neck) { return neck.views.at(1); }

TEST(CarotidWallTest, TheWallIsBrightDarkBrightAtPublishedDepths) {
  for (std::uint64_t seed = 1; seed <= test::trials(5U); ++seed) {
    const Patient neck = *make_patient("neck", {seed, Contrast::kNative});
    const auto& pose = along_carotid(neck).ct_from_image;
    const double x = -12;
    const FarWall wall = far_wall(*neck.anatomy, pose, x);
    ASSERT_GT(wall.outer_mm, wall.lumen_mm) << seed;
    // Intima and media of 0.6 to 0.8 mm and adventitia of 0.3 mm, at an angle of up to 20 degrees.
    EXPECT_GT(wall.outer_mm - wall.lumen_mm, 0.9) << seed;
    EXPECT_LT(wall.outer_mm - wall.lumen_mm, 1.25) << seed;
    constexpr double kStepMm = 0.01;
    std::vector<double> profile;
    for (double d = wall.lumen_mm - 0.3; d < wall.outer_mm; d += kStepMm) {
      const Acoustics a = neck.anatomy->acoustics(pose * Point<frames::Image>{Vec(x, d, 0)});
      profile.push_back(static_cast<double>(a.scatter + echo_of(a)));
    }
    const DoubleLine lines = double_line(profile, 0.6);
    ASSERT_GT(lines.outer, 0U) << seed;
    const auto depth = [&](std::size_t i) { return kStepMm * static_cast<double>(i) - 0.3; };
    EXPECT_NEAR(depth(lines.inner), 0.14, 0.05) << seed;
    EXPECT_NEAR(depth(lines.outer), wall.outer_mm - wall.lumen_mm - 0.16, 0.06) << seed;
    EXPECT_LT(profile[lines.dark], 0.4 * profile[lines.inner]) << seed;
    EXPECT_LT(profile[lines.dark], 0.2 * profile[lines.outer]) << seed;
  }
}

class SheetImageTest : public testing::TestWithParam<AcousticModel> {
 protected:
  static ScanLineImage see(const Patient& patient, const StandardView& view) {
    ProbeModel probe = view.probe;
    probe.model = GetParam();
    return UltrasoundSimulator(patient.anatomy, probe, 1).envelope(view.ct_from_image, 0);
  }
  static double x_of(const ScanLineImage& image, const ProbeModel& probe, int line) {
    return (static_cast<double>(line) / (image.lines - 1) - 0.5) * probe.width_mm;
  }
};

TEST_P(SheetImageTest, TheFarWallOfTheCarotidIsADoubleLine) {
  const Patient neck = *make_patient("neck", {1, Contrast::kNative});
  const StandardView& view = along_carotid(neck);
  const ScanLineImage image = see(neck, view);
  // Mean over the lines, aligned at the far wall.
  std::vector<double> profile(40);
  const auto zero = static_cast<int>(0.5 / image.sample_mm);
  double thick_mm = 0;
  int lines = 0;
  for (int l = 0; l < image.lines; ++l) {
    const double x = x_of(image, view.probe, l);
    if (x > -6) break;
    const FarWall wall = far_wall(*neck.anatomy, view.ct_from_image, x);
    ASSERT_GT(wall.outer_mm, 0) << x;
    const int first = static_cast<int>(std::lround(wall.lumen_mm / image.sample_mm)) - zero;
    for (std::size_t i = 0; i < profile.size(); ++i) {
      profile[i] += static_cast<double>(image.at(l, first + static_cast<int>(i)));
    }
    thick_mm += wall.outer_mm - wall.lumen_mm;
    ++lines;
  }
  thick_mm /= lines;
  for (double& v : profile) v /= lines;
  const DoubleLine found = double_line(profile, 2 * profile[0]);
  ASSERT_GT(found.outer, 0U);
  const auto depth = [&](std::size_t i) {
    return image.sample_mm * (static_cast<double>(i) - static_cast<double>(zero));
  };
  EXPECT_NEAR(depth(found.inner), 0.1, 0.2);
  EXPECT_NEAR(depth(found.outer), thick_mm - 0.1, 0.2);
  EXPECT_LT(profile[found.dark], 0.8 * profile[found.inner]);
  EXPECT_LT(profile[found.dark], 0.6 * profile[found.outer]);
}

TEST_P(SheetImageTest, SeptaInMuscleAreBright) {
  const Patient shoulder = *make_patient("shoulder", {1, Contrast::kNative});
  const StandardView& view = shoulder.views.at(0);
  const ScanLineImage image = see(shoulder, view);
  const Eigen::Vector3f beam =
      (view.ct_from_image * Direction<frames::Image>{Vec::UnitY()}).v.cast<float>();
  double on = 0, off = 0;
  int n_on = 0, n_off = 0;
  for (int l = 0; l < image.lines; ++l) {
    const double x = x_of(image, view.probe, l);
    for (int s = 0; s < image.samples; ++s) {
      const auto p = view.ct_from_image * Point<frames::Image>{Vec(x, s * image.sample_mm, 0)};
      if (shoulder.anatomy->tissue(p) != Tissue::kMuscle) continue;
      const Acoustics a = shoulder.anatomy->acoustics(p);
      const float met = std::abs(beam.dot(Eigen::Vector3f(a.sheet.data())));
      (met > 2 ? on : off) += static_cast<double>(image.at(l, s));
      (met > 2 ? n_on : n_off) += 1;
    }
  }
  ASSERT_GT(n_on, 100);
  EXPECT_GT(on / n_on, 2 * off / n_off);
}

INSTANTIATE_TEST_SUITE_P(Models, SheetImageTest,
                         testing::Values(AcousticModel::kRays, AcousticModel::kScatterers),
                         [](const auto& tested) {
                           return tested.param == AcousticModel::kRays ? "rays" : "scatterers";
                         });

}  // namespace
}  // namespace nav::sim
