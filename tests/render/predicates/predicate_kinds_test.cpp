// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the predicate library: each kind against its description, and its bounds against its
// samples.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "render/predicates/program.hpp"
#include "render/predicates/registry.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PredicatePosition place_with_everything() {
  PredicatePosition place;
  place.grid.size = {20, 20, 20};
  place.grid.spacing_mm = {0.2, 0.2, 1};
  place.scan = ParallelScan{{{0, 0, 0}}, {{0.2, 2, -1}}};
  place.needle = Segment{{1, 1, 2}, {3, 2.5, 9}, 0.4};
  place.target = Segment{{2, 2, 5}, {2, 2, 5}, 1.5};
  return place;
}

PredicateSample sample_of(double a, double b = 0) {
  return {{a, b}, {0, 0}, 0, Eigen::Vector3d::Zero()};
}

bool holds(const PredicateKind& kind, const PredicateSample& sample, std::vector<double> p) {
  return kind.test(sample, place_with_everything(), p);
}

TEST(PredicateKindsTest, RangesAreClosedAtBothEnds) {
  for (const PredicateKind* kind :
       {&intensity_predicate(), &snr_predicate(), &vesselness_predicate(), &confidence_predicate(),
        &gradient_magnitude_predicate()}) {
    EXPECT_TRUE(holds(*kind, sample_of(0.25), {0.25, 0.75})) << kind->name();
    EXPECT_TRUE(holds(*kind, sample_of(0.75), {0.25, 0.75})) << kind->name();
    EXPECT_FALSE(holds(*kind, sample_of(std::nextafter(0.75, 1)), {0.25, 0.75})) << kind->name();
    EXPECT_FALSE(holds(*kind, sample_of(std::nextafter(0.25, 0)), {0.25, 0.75})) << kind->name();
    EXPECT_TRUE(holds(*kind, sample_of(0.5), {0.5, 0.5})) << kind->name() << ": one value";
    EXPECT_FALSE(holds(*kind, sample_of(kNaN), {0.25, 0.75})) << kind->name();
  }
}

TEST(PredicateKindsTest, TheQuantumWidensAnEndByHalf) {
  PredicateSample sample = sample_of(0.7501);
  sample.quantum[0] = 0.0002;
  EXPECT_TRUE(holds(snr_predicate(), sample, {0.25, 0.75}));
  sample.quantum[0] = 0.0001;
  EXPECT_FALSE(holds(snr_predicate(), sample, {0.25, 0.75}));
}

TEST(PredicateKindsTest, GradientAngleAgreesWithAtan2) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 20'000; ++i) {
    const double angle = M_PI * unit(random);
    const double size = std::exp(6 * unit(random) - 3);
    const double low = M_PI * unit(random);
    const double high = low + (M_PI - low) * unit(random);
    const double off = std::min(std::abs(angle - low), std::abs(angle - high));
    if (off < 1e-12) continue;  // Rounding decides these cases.
    const auto sample = sample_of(size * std::cos(angle), size * std::sin(angle));
    EXPECT_EQ(holds(gradient_angle_predicate(), sample, {low, high, 1e-6}),
              angle >= low && angle <= high)
        << angle << " in " << low << ", " << high;
  }
}

TEST(PredicateKindsTest, GradientAngleIsCorrectAtItsLimits) {
  const PredicateKind& kind = gradient_angle_predicate();
  const double more_than_one = std::nextafter(1.0, 2.0);  // A dot product that exceeds 1 by one
                                                          // ulp.
  EXPECT_FALSE(holds(kind, sample_of(0, 0), {0, M_PI, 1e-6})) << "no gradient, no angle";
  EXPECT_FALSE(holds(kind, sample_of(kNaN, 0), {0, M_PI, 1e-6}));
  EXPECT_TRUE(holds(kind, sample_of(more_than_one, 0), {0, 0, 1e-6})) << "parallel";
  EXPECT_FALSE(holds(kind, sample_of(-1, 0), {0, 0, 1e-6})) << "anti-parallel is not parallel";
  EXPECT_TRUE(holds(kind, sample_of(-1, 0), {M_PI, M_PI, 1e-6}));
  EXPECT_FALSE(holds(kind, sample_of(1, 0), {M_PI, M_PI, 1e-6}));
  EXPECT_TRUE(holds(kind, sample_of(0, 1), {M_PI / 2 - 1e-9, M_PI / 2 + 1e-9, 1e-6}));
  EXPECT_TRUE(holds(kind, sample_of(-1, 1e-17), {0, M_PI, 1e-6})) << "every angle";
}

TEST(PredicateKindsTest, LabelsIncludeBit31) {
  PredicateSample sample = sample_of(0);
  sample.labels = 0x80000000U;
  EXPECT_TRUE(holds(label_predicate(), sample, {2147483648.0}));
  EXPECT_TRUE(holds(label_predicate(), sample, {4294967295.0}));
  EXPECT_FALSE(holds(label_predicate(), sample, {2147483647.0}));
}

TEST(PredicateKindsTest, DistancesAreMeasuredFromTheSurface) {
  PredicateSample sample = sample_of(0);
  sample.position_mm = {2, 2, 8};  // 3 mm from the centre of the target, 1.5 mm from its surface.
  EXPECT_TRUE(holds(target_distance_predicate(), sample, {1.5, 1.5}));
  EXPECT_FALSE(holds(target_distance_predicate(), sample, {-1.5, 1.4}));
  sample.position_mm = {2, 2, 5};
  EXPECT_TRUE(holds(target_distance_predicate(), sample, {-1.5, -1.5}));
  sample.position_mm = {1, 1, 0};  // 2 mm before the tip of the needle.
  EXPECT_TRUE(holds(needle_distance_predicate(), sample, {1.6, 1.6 + 1e-12}));
}

TEST(PredicateKindsTest, NothingIsNearALostNeedle) {
  PredicatePosition place = place_with_everything();
  place.needle->a.setConstant(kNaN);
  place.needle->b = place.needle->a;
  const std::vector<double> anywhere{-1e4, 1e4};
  const PredicateKind& kind = needle_distance_predicate();
  EXPECT_FALSE(kind.test(sample_of(0), place, anywhere));
  EXPECT_EQ(kind.bounds({}, place, anywhere), Truth::kFalse);
  EXPECT_EQ(kind.form(place, anywhere).kind, PredicateForm::Kind::kNever);
}

TEST(PredicateKindsTest, DepthWorksForParallelLinesAndForAFan) {
  PredicatePosition place = place_with_everything();
  place.scan = ParallelScan{{{5, 1, 5}}, {{0, 10, 0}}};
  PredicateSample sample = sample_of(kNaN);
  sample.position_mm = {2, 4, 9};
  const std::vector<double> three{3, 3};
  EXPECT_TRUE(depth_predicate().test(sample, place, three));
  place.scan = FanScan{{{2, 4, 0}}, 6};
  EXPECT_TRUE(depth_predicate().test(sample, place, three));
  place.scan = VoxelScan{};
  EXPECT_FALSE(depth_predicate().test(sample, place, three)) << "from the feature, undefined here";
  sample.value[0] = 3;
  EXPECT_TRUE(depth_predicate().test(sample, place, three));
}

TEST(PredicateKindsTest, UnknownNamesListTheKnownOnes) {
  EXPECT_TRUE(test::rejects(find_predicate_kind("sharpness"), ErrorCode::kNotFound,
                            {"intensity", "vesselness", "target_distance", "\"sharpness\""}));
}

TEST(PredicateKindsTest, ParametersHaveUnitsAndInitialValuesInTheirRanges) {
  EXPECT_GE(predicate_kinds().size(), 10U);
  for (const PredicateKind* kind : predicate_kinds()) {
    std::vector<double> initial;
    for (const PredicateParameter& p : kind->parameters()) {
      EXPECT_FALSE(p.unit.empty()) << kind->name() << "." << p.name;
      EXPECT_TRUE(p.low <= p.initial && p.initial <= p.high) << kind->name() << "." << p.name;
      initial.push_back(p.initial);
    }
    EXPECT_TRUE(test::has_value(kind->check(initial))) << kind->name();
    EXPECT_LE(kind->needs(place_with_everything()).channels.size(), 2U) << kind->name();
    EXPECT_FALSE(kind->description().empty());
  }
}

/// A random valid value of a parameter, away from its far ends.
double random_value(std::mt19937& random, const PredicateParameter& p) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double low = std::max(p.low, -3.0);
  const double high = std::min(p.high, 12.0);
  return low + (high - low) * unit(random);
}

std::vector<double> random_parameters(std::mt19937& random, const PredicateKind& kind) {
  std::vector<double> out;
  for (const PredicateParameter& p : kind.parameters()) out.push_back(random_value(random, p));
  if (kind.name() == "label") return {static_cast<double>(1U << (random() % 4))};
  if (!kind.check(out)) std::swap(out[0], out[1]);
  if (out.size() > 2) out[2] = 0.01;
  return out;
}

struct RandomBrick {
  PredicateBounds bounds{};
  std::vector<std::uint32_t> labels;
};

RandomBrick random_brick(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  RandomBrick out;
  PredicateBounds& b = out.bounds;
  for (int i = 0; i < 2; ++i) {
    const double low = 6 * unit(random) - 3;
    b.value[i] = {low, low + std::pow(unit(random), 3) * 3};
    b.quantum[i] = random() % 2 == 0 ? 0 : std::pow(unit(random), 4);
    b.undefined[i] = random() % 4 == 0;
  }
  b.labels_all = ~0U;
  for (int i = 0; i < 3; ++i) {
    out.labels.push_back(random() % 16 & random());
    b.labels_any |= out.labels.back();
    b.labels_all &= out.labels.back();
  }
  for (int axis = 0; axis < 3; ++axis) {
    b.low_mm[axis] = 10 * unit(random) - 2;
    b.high_mm[axis] = b.low_mm[axis] + unit(random) * 2;
  }
  return out;
}

PredicateSample random_sample(std::mt19937& random, const RandomBrick& brick) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto within = [&](const Range& r) {
    const double x = unit(random);
    return x < 0.1 ? r.low : x > 0.9 ? r.high : r.low + x * (r.high - r.low);
  };
  PredicateSample s{};
  for (int i = 0; i < 2; ++i) {
    const bool undefined = brick.bounds.undefined[i] && random() % 3 == 0;
    s.value[i] = undefined ? kNaN : within(brick.bounds.value[i]);
    s.quantum[i] = brick.bounds.quantum[i];
  }
  s.labels = brick.labels[random() % brick.labels.size()];
  for (int a = 0; a < 3; ++a) {
    s.position_mm[a] = within({brick.bounds.low_mm[a], brick.bounds.high_mm[a]});
  }
  return s;
}

TEST(PredicateKindsTest, BoundsAreNeverWrong) {
  std::mt19937 random(5);
  const PredicatePosition place = place_with_everything();
  for (const PredicateKind* kind : predicate_kinds()) {
    int decided = 0;
    for (int i = 0; i < 1500; ++i) {
      const RandomBrick brick = random_brick(random);
      const auto p = random_parameters(random, *kind);
      const Truth truth = kind->bounds(brick.bounds, place, p);
      if (truth == Truth::kUnknown) continue;
      ++decided;
      for (int j = 0; j < 12; ++j) {
        const PredicateSample s = random_sample(random, brick);
        ASSERT_EQ(kind->test(s, place, p), truth == Truth::kTrue) << kind->name();
      }
    }
    EXPECT_GT(decided, 300) << kind->name() << ": bounds that know nothing are no bounds";
  }
}

TEST(PredicateKindsTest, BoundsNeverPromiseTruthForUndefinedVoxels) {
  RandomBrick brick;
  brick.bounds.value[0] = {0.5, 0.6};
  brick.bounds.undefined[0] = true;
  const auto place = place_with_everything();
  const std::vector<double> p{0, 1};
  EXPECT_EQ(snr_predicate().bounds(brick.bounds, place, p), Truth::kUnknown);
  brick.bounds.value[0] = {2, 3};
  EXPECT_EQ(snr_predicate().bounds(brick.bounds, place, p), Truth::kFalse);
}

/// A random tree of NOT, AND and OR over four leaves, in postfix order.
void random_tree(std::mt19937& random, int depth, std::vector<PredicateProgram::Token>& out) {
  using Op = PredicateProgram::Op;
  const auto kind = random() % (depth > 0 ? 5 : 2);
  if (kind < 2) {
    out.push_back({Op::kLeaf, static_cast<std::uint8_t>(random() % 4)});
    return;
  }
  random_tree(random, depth - 1, out);
  if (kind == 2) {
    out.push_back({Op::kNot, 0});
    return;
  }
  random_tree(random, depth - 1, out);
  out.push_back({kind == 3 ? Op::kAnd : Op::kOr, 0});
}

TEST(PredicateKindsTest, ThreeValuedTreesAreNeverWrong) {
  std::mt19937 random(9);
  int decided = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::vector<PredicateProgram> programs{{0, {}}};
    random_tree(random, 4, programs[0].tokens);
    Truth leaves[4];
    for (Truth& leaf : leaves) leaf = static_cast<Truth>(random() % 3);
    std::array<Truth, kMostPredicates> bound{};
    run_programs(
        programs, [&](int l) { return leaves[l]; }, not_of, and_of, or_of, bound);
    if (bound[0] == Truth::kUnknown) continue;
    ++decided;
    for (unsigned bits = 0; bits < 16; ++bits) {
      bool possible = true;
      for (unsigned l = 0; l < 4; ++l) {
        const bool value = ((bits >> l) & 1U) != 0;
        possible = possible && (leaves[l] == Truth::kUnknown || leaves[l] == truth_of(value));
      }
      if (!possible) continue;
      std::array<bool, kMostPredicates> exact{};
      run_programs(
          programs, [&](int l) { return ((bits >> l) & 1U) != 0; }, [](bool a) { return !a; },
          [](bool a, bool b) { return a && b; }, [](bool a, bool b) { return a || b; }, exact);
      ASSERT_EQ(exact[0], bound[0] == Truth::kTrue);
    }
  }
  EXPECT_GT(decided, 20'000);
}

}  // namespace
}  // namespace nav::render
