// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/anatomy.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "sim/anatomy/patient.hpp"
#include "sim/random.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kSameHu = 1e-6;

/// Runs with each family of the registry.
class AnatomyTest : public testing::TestWithParam<std::string> {
 protected:
  static Patient patient(std::uint64_t seed = 2, Contrast contrast = Contrast::kArterial) {
    return *make_patient(GetParam(), {seed, contrast});
  }
  static Vec random_point(const Anatomy& a, Random& random) {
    const Eigen::AlignedBox3d box = a.region_mm();
    const Vec share(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
    return box.min() + box.sizes().cwiseProduct(share);
  }
};

Vec central_difference(const Anatomy& a, const Vec& p, double h) {
  Vec g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec step = h * Vec::Unit(axis);
    g[axis] = (a.hu({p + step}) - a.hu({p - step})) / (2 * h);
  }
  return g;
}

TEST_P(AnatomyTest, GradientIsTheDerivativeOfTheValue) {
  const auto a = patient().anatomy;
  Random random(5, 1);
  int sloped = 0;
  int corners = 0;
  for (int i = 0; i < 60000 && sloped < 800; ++i) {
    const Vec p = random_point(*a, random);
    const ValueAndGradient exact = a->hu_with_gradient({p});
    ASSERT_NEAR(exact.value, a->hu({p}), kSameHu) << p.transpose();
    const Vec g = exact.gradient_per_mm.v;
    ASSERT_TRUE(g.allFinite()) << p.transpose();
    const Vec fine = central_difference(*a, p, 1e-6);
    const Vec coarse = central_difference(*a, p, 4e-6);
    if (g.norm() + fine.norm() < 1e-6) continue;
    ++sloped;
    // There is no gradient if a corner lies within the step: the edge of a blend or a crease
    // between shapes.
    const double scale = 1 + fine.norm();
    if ((fine - coarse).norm() > 1e-4 * scale) {
      ++corners;
      continue;
    }
    // The rounding of values near 1000 over 2e-6 mm is about 1e-7 per mm.
    EXPECT_LT((g - fine).norm(), 2e-4 * scale)
        << p.transpose() << ": " << g.transpose() << " or " << fine.transpose();
  }
  EXPECT_GT(sloped, 300);
  EXPECT_LT(corners, sloped / 50);
}

TEST_P(AnatomyTest, LandmarksAndTargetsLieInsideThePatient) {
  const auto a = patient().anatomy;
  const auto landmarks = a->landmarks();
  EXPECT_GE(landmarks.size(), 5U);
  std::set<std::string> names;
  for (const NamedPoint& p : landmarks) {
    names.insert(p.name);
    EXPECT_LT(a->skin_distance_mm(p.position_ct), 0) << p.name;
    EXPECT_NE(a->tissue(p.position_ct), Tissue::kAir) << p.name;
  }
  EXPECT_EQ(names.size(), landmarks.size());
  const auto targets = a->targets();
  EXPECT_GE(targets.size(), 100U);
  for (const auto& t : targets) {
    EXPECT_LT(a->skin_distance_mm(t), 0);
    EXPECT_TRUE(a->region_mm().contains(t.mm));
  }
}

TEST_P(AnatomyTest, SkinSeparatesAirFromTissue) {
  const auto a = patient().anatomy;
  Random random(9, 1);
  for (int i = 0; i < 4000; ++i) {
    const Vec p = random_point(*a, random);
    const double depth = -a->skin_distance_mm({p});
    if (depth < -1) {
      ASSERT_EQ(a->tissue({p}), Tissue::kAir) << p.transpose();
    }
    if (depth > 0.2) {
      ASSERT_NE(a->tissue({p}), Tissue::kAir) << p.transpose();
    }
  }
}

TEST_P(AnatomyTest, TheSeedDeterminesThePatient) {
  const auto a = patient(2).anatomy;
  const auto same = patient(2).anatomy;
  const auto other = patient(3).anatomy;
  Random random(4, 1);
  int differ = 0;
  constexpr int kPoints = 3000;
  for (int i = 0; i < kPoints; ++i) {
    const Vec p = random_point(*a, random);
    ASSERT_EQ(a->hu({p}), same->hu({p}));
    ASSERT_EQ(a->acoustics({p}).scatter, same->acoustics({p}).scatter);
    differ += a->tissue({p}) != other->tissue({p}) ? 1 : 0;
  }
  EXPECT_GT(differ, kPoints / 200);
}

TEST_P(AnatomyTest, StandardViewsPointIntoThePatient) {
  const Patient p = patient();
  ASSERT_FALSE(p.views.empty());
  for (const StandardView& view : p.views) {
    EXPECT_TRUE(test::has_value(validate(view.probe)));
    const Point<frames::Ct> deep = view.ct_from_image * Point<frames::Image>{Vec(0, 10, 0)};
    EXPECT_LT(p.anatomy->skin_distance_mm(deep), -5) << view.name;
  }
}

std::vector<std::string> family_names() {
  std::vector<std::string> names;
  for (const PatientFamily& f : patient_families()) names.push_back(f.name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(Families, AnatomyTest, testing::ValuesIn(family_names()),
                         [](const auto& tested) { return tested.param; });

TEST(PatientFamilyTest, RejectsUnknownNamesAndListsTheKnownOnes) {
  EXPECT_TRUE(
      test::rejects(make_patient("elbow"), ErrorCode::kUsage, {"elbow", "neck", "abdomen"}));
  EXPECT_TRUE(test::rejects(make_patient(""), ErrorCode::kUsage, {"neck"}));
}

TEST(NeckTest, TheCarotidDividesIntoTwoLumens) {
  for (std::uint64_t seed = 1; seed <= test::trials(6U); ++seed) {
    const auto a = make_patient("neck", {seed, Contrast::kArterial})->anatomy;
    for (const NamedPoint& p : a->landmarks()) {
      if (p.name.find("carotid bifurcation") == std::string::npos) continue;
      // Number of separate intervals of arterial blood along the line through both branches, in one
      // slice.
      const auto lumens = [&](double z) {
        std::set<int> parts;
        int part = 0;
        bool before = false;
        for (double t = -14; t <= 14; t += 0.1) {
          const Vec side = p.position_ct.mm.x() < 0 ? Vec(-0.876, 0.482, 0) : Vec(0.876, 0.482, 0);
          const bool blood =
              a->tissue({p.position_ct.mm + t * side + Vec(0, 0, z)}) == Tissue::kArtery;
          part += blood && !before ? 1 : 0;
          if (blood) parts.insert(part);
          before = blood;
        }
        return parts.size();
      };
      EXPECT_EQ(lumens(6), 2U) << "seed " << seed << ' ' << p.name;
      EXPECT_LE(lumens(-22), 1U) << "seed " << seed << ' ' << p.name;
      EXPECT_EQ(a->tissue(p.position_ct), Tissue::kVesselWall);
    }
  }
}

}  // namespace
}  // namespace nav::sim
