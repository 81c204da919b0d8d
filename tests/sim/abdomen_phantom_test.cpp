// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/abdomen_phantom.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "sim/random.hpp"
#include "tests/support/trials.hpp"

namespace nav::sim {
namespace {

using frames::Ct;
using Vec = Eigen::Vector3d;

constexpr double kRoundingHu = 1e-6;

const AbdomenPhantom& phantom() {
  static const AbdomenPhantom instance({3, Contrast::kPortal});
  return instance;
}

Vec random_point(Random& random) {
  return {random.uniform(-160, 160), random.uniform(-120, 120), random.uniform(-125, 125)};
}

/// Returns the tissue if it fills a sphere of \p radius_mm around the point, and kCount if several
/// tissues meet there.
Tissue pure_tissue(const AbdomenPhantom& p, const Vec& at, double radius_mm) {
  const Tissue centre = p.tissue({at});
  for (int i = 0; i < 14; ++i) {
    const Vec d = i < 6
                      ? Vec(Vec::Unit(i / 2) * (i % 2 == 0 ? 1.0 : -1.0))
                      : Vec(Vec((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)
                                .normalized());
    if (p.tissue({at + radius_mm * d}) != centre) return Tissue::kCount;
  }
  return centre;
}

TEST(AbdomenPhantomTest, HasTextbookValuesInsideEachTissue) {
  Random random(1, 1);
  std::set<Tissue> seen;
  for (int i = 0; i < 60000; ++i) {
    const Vec p = random_point(random);
    const Tissue tissue = pure_tissue(phantom(), p, 1.5);
    // A lung recess that is thinner than the blend darkens the diaphragm around it without being
    // lung.
    if (tissue == Tissue::kCount || tissue == Tissue::kDiaphragm) continue;
    seen.insert(tissue);
    ASSERT_NEAR(phantom().hu({p}), tissue_hu(tissue, Contrast::kPortal), 1.0)
        << to_string(tissue) << " at " << p.transpose();
  }
  for (const Tissue t : {Tissue::kAir, Tissue::kFat, Tissue::kMuscle, Tissue::kLiver, Tissue::kLung,
                         Tissue::kAorta, Tissue::kVenaCava, Tissue::kLesion, Tissue::kKidneyCortex,
                         Tissue::kSpleen, Tissue::kMarrow, Tissue::kBile, Tissue::kGas}) {
    EXPECT_TRUE(seen.contains(t)) << to_string(t);
  }
  EXPECT_NEAR(phantom().hu({Vec(0, -119, 0)}), -1000, kRoundingHu);
  EXPECT_NEAR(tissue_hu(Tissue::kLiver, Contrast::kPortal), 110, 10);
  EXPECT_GT(tissue_hu(Tissue::kBone, Contrast::kPortal), 400);
  EXPECT_GT(tissue_hu(Tissue::kAorta, Contrast::kArterial),
            tissue_hu(Tissue::kAorta, Contrast::kNative) + 200);
}

TEST(AbdomenPhantomTest, LiverIsOnTheRightAndSpleenOnTheLeft) {
  Random random(2, 1);
  double liver_x = 0;
  double spleen_x = 0;
  int liver = 0;
  int spleen = 0;
  for (int i = 0; i < 40000; ++i) {
    const Vec p = random_point(random);
    const Tissue t = phantom().tissue({p});
    if (t == Tissue::kLiver) liver_x += p.x(), ++liver;
    if (t == Tissue::kSpleen) spleen_x += p.x(), ++spleen;
  }
  ASSERT_GT(liver, 500);
  ASSERT_GT(spleen, 50);
  EXPECT_LT(liver_x / liver, -30);
  EXPECT_GT(spleen_x / spleen, 60);
}

TEST(AbdomenPhantomTest, GridAgreesWithTheSearchOfEveryOrgan) {
  for (const std::uint64_t seed : {3U, 4U}) {
    const AbdomenPhantom p({seed, Contrast::kPortal});
    Random random(seed, 2);
    for (int i = 0; i < test::trials(15000); ++i) {
      const Vec at = random_point(random);
      ASSERT_EQ(p.tissue({at}), p.tissue_exhaustive({at})) << at.transpose();
    }
  }
}

TEST(AbdomenPhantomTest, HuAtTheSkinIsTheMeanOfAirAndSkin) {
  // Air blends into skin over 1 mm. The surface itself has the mean of both.
  const double half = 0.5 * (-1000 + tissue_hu(Tissue::kSkin, Contrast::kPortal));
  for (const double angle : {3.0, 3.6, 4.3, 5.0}) {
    const Point<Ct> p = phantom().skin_point(angle, 5);
    EXPECT_NEAR(phantom().skin_distance_mm(p), 0, 1e-9);
    EXPECT_NEAR(phantom().hu(p), half, 1.0);
  }
}

TEST(AbdomenPhantomTest, ValuesAreContinuous) {
  // No step is steeper than air to bone over the 1 mm blend, times the slope of a first-order
  // distance (below 2).
  constexpr double kStepMm = 0.01;
  constexpr double kLimitHu = 2.0 * 2000.0 * kStepMm;
  Random random(5, 1);
  for (int i = 0; i < test::trials(20000); ++i) {
    const Vec p = random_point(random);
    const Vec q = p + kStepMm * random.direction();
    ASSERT_LT(std::abs(phantom().hu({p}) - phantom().hu({q})), kLimitHu) << p.transpose();
  }
}

TEST(AbdomenPhantomTest, PlanAvoidsOrgansThatANeedleMustNotTouch) {
  for (std::uint64_t seed = 1; seed <= test::trials(12U); ++seed) {
    const AbdomenPhantom p({seed, Contrast::kPortal});
    const NeedlePlan plan = p.plan();
    ASSERT_TRUE(validate(plan).has_value());
    EXPECT_NEAR(p.skin_distance_mm(plan.entry_ct), 0, 1e-6);
    EXPECT_EQ(p.tissue(plan.target_ct), Tissue::kLesion);
    const Vec path = plan.target_ct.mm - plan.entry_ct.mm;
    for (double t = 0; t <= 1; t += 0.004) {
      const Vec at = plan.entry_ct.mm + t * path;
      const Tissue tissue = p.tissue({at + 0.01 * path.normalized()});
      const bool free = tissue == Tissue::kSkin || tissue == Tissue::kFat ||
                        tissue == Tissue::kMuscle || tissue == Tissue::kPeritonealFat ||
                        tissue == Tissue::kDiaphragm || tissue == Tissue::kLiver ||
                        tissue == Tissue::kLesion || tissue == Tissue::kHepaticVein ||
                        tissue == Tissue::kPortalVein || tissue == Tissue::kPortalWall;
      ASSERT_TRUE(free) << "seed " << seed << ": " << to_string(tissue) << " at " << t;
      for (const VesselSegment& v : p.vessels()) {
        if (v.radius_mm <= 2) continue;
        const Vec along = v.to.mm - v.from.mm;
        const double s = std::clamp((at - v.from.mm).dot(along) / along.squaredNorm(), 0.0, 1.0);
        ASSERT_GT((at - v.from.mm - s * along).norm(), v.radius_mm + 2) << "seed " << seed;
      }
    }
  }
}

TEST(AbdomenPhantomTest, VesselsBranchInsideTheLiverByMurraysLaw) {
  const auto& vessels = phantom().vessels();
  ASSERT_GT(vessels.size(), 60U);
  std::vector<double> cubes(vessels.size(), 0.0);
  for (const VesselSegment& v : vessels) {
    EXPECT_GE(v.radius_mm, 1.3);
    EXPECT_EQ(phantom().tissue({0.5 * (v.from.mm + v.to.mm)}), v.tissue);
    if (v.parent < 0) continue;
    const VesselSegment& parent = vessels[static_cast<std::size_t>(v.parent)];
    EXPECT_EQ(parent.to.mm, v.from.mm);
    EXPECT_LT(phantom().liver_distance_mm(v.to), -3);
    cubes[static_cast<std::size_t>(v.parent)] += std::pow(v.radius_mm, 3);
  }
  for (std::size_t i = 0; i < vessels.size(); ++i) {
    if (vessels[i].parent < 0) continue;  // The trunks do not follow Murray's law.
    EXPECT_LE(cubes[i], std::pow(vessels[i].radius_mm, 3) * (1 + 1e-9));
  }
}

TEST(AbdomenPhantomTest, LandmarksAndTargetsLieInTheirOrgans) {
  const auto landmarks = phantom().landmarks();
  EXPECT_GE(landmarks.size(), 6U);
  std::set<std::string> names;
  for (const NamedPoint& p : landmarks) {
    names.insert(p.name);
    if (p.name.find("bifurcation") == std::string::npos) continue;
    const Tissue t = phantom().tissue(p.position_ct);
    EXPECT_TRUE(t == Tissue::kPortalVein || t == Tissue::kHepaticVein) << p.name;
  }
  EXPECT_EQ(names.size(), landmarks.size());
  const auto targets = phantom().targets();
  EXPECT_GE(targets.size(), 100U);
  for (const auto& t : targets) EXPECT_LT(phantom().liver_distance_mm(t), -5);
}

TEST(AbdomenPhantomTest, TheSeedDeterminesThePatient) {
  const AbdomenPhantom same({3, Contrast::kPortal});
  const AbdomenPhantom other({4, Contrast::kPortal});
  EXPECT_EQ(same.plan().target_ct.mm, phantom().plan().target_ct.mm);
  EXPECT_GT((other.plan().target_ct.mm - phantom().plan().target_ct.mm).norm(), 1);
  Random random(7, 1);
  int differ = 0;
  constexpr int kPoints = 5000;
  for (int i = 0; i < kPoints; ++i) {
    const Vec p = random_point(random);
    EXPECT_EQ(same.hu({p}), phantom().hu({p}));
    differ += other.tissue({p}) != phantom().tissue({p}) ? 1 : 0;
  }
  EXPECT_GT(differ, kPoints / 50);
}

}  // namespace
}  // namespace nav::sim
