// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/predicate_editor.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "render/predicates/registry.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

using Operator = PredicateExpression::Operator;

/// Eq. 2, with the tolerance that the window states.
constexpr double kSumError = 1e-9;

PredicateEditor edit_preset(const std::string& name) {
  return PredicateEditor(*preset_predicates(name));
}

double sum_of_importances(const PredicateModel& model) {
  double sum = 0;
  for (const auto& bar : model.histogram.bars()) sum += bar.importance;
  return sum;
}

features::Stroke dot(double x_mm) {
  return {.points = {{{x_mm, 0, 0}}}, .plane_normal = {Eigen::Vector3d::UnitZ()}};
}

TEST(PredicateEditorTest, AnyEditsLeaveAValidSetWithTheSumOneAndUndoLeadsBack) {
  std::mt19937 random(3);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  std::uniform_real_distribution<double> unit(0, 1);
  PredicateEditor editor = edit_preset("abdomen");
  for (int i = 0; i < 3000; ++i) {
    const std::size_t bars = editor.model().entries.size();
    const std::size_t bar = bars == 0 ? 0 : below(bars);
    const auto kind = bars == 0 ? 9 : below(12);
    if (kind < 3) editor.drag(bar, 1.4 * unit(random) - 0.2);
    if (kind == 3) editor.set_colour(bar, 720 * unit(random), unit(random));
    if (kind == 4) (void)editor.negate(bar);
    if (kind == 5) (void)editor.combine(Operator::kAnd, bar, below(bars));
    if (kind == 6) (void)editor.combine(Operator::kOr, bar, below(bars));
    if (kind == 7) editor.remove(bar);
    if (kind == 8) editor.undo();
    if (kind == 9) {
      (void)editor.add(predicate_kinds()[below(predicate_kinds().size())]->name());
    }
    if (kind == 10) editor.redo();
    if (kind == 11) {
      const auto all = editable_parameters(editor.model().entries[bar].expression);
      if (!all.empty()) (void)editor.set_parameter(bar, below(all.size()), 2 * unit(random));
    }
    const PredicateModel& model = editor.model();
    ASSERT_EQ(model.entries.size(), model.histogram.size());
    if (model.entries.empty()) continue;
    ASSERT_TRUE(validate(model).has_value()) << validate(model).error().message;
    ASSERT_NEAR(sum_of_importances(model), 1, kSumError);
    ASSERT_LT(*editor.selected(), model.entries.size());
  }
}

TEST(PredicateEditorTest, UndoGoesBackOneHundredStepsAndRedoForthAgain) {
  PredicateEditor editor = edit_preset("carotid-vessel");
  std::vector<PredicateModel> seen{editor.model()};
  for (int i = 1; i <= 150; ++i) {
    editor.drag(0, i / 200.0);
    seen.push_back(editor.model());
  }
  for (int i = 149; i >= 50; --i) {
    ASSERT_TRUE(editor.undo());
    ASSERT_EQ(editor.model(), seen[static_cast<std::size_t>(i)]) << i;
  }
  EXPECT_FALSE(editor.undo()) << "100 steps are kept";
  for (std::size_t i = 51; i <= 150; ++i) {
    ASSERT_TRUE(editor.redo());
    ASSERT_EQ(editor.model(), seen[i]) << i;
  }
  EXPECT_FALSE(editor.redo());
  ASSERT_TRUE(editor.undo());
  editor.set_colour(0, 200, 1);
  EXPECT_FALSE(editor.can_redo()) << "a new edit ends what could be redone";
}

TEST(PredicateEditorTest, ADragIsOneStep) {
  PredicateEditor editor = edit_preset("carotid-vessel");
  const PredicateModel before = editor.model();
  editor.begin();
  for (int i = 0; i < 40; ++i) editor.drag(1, i / 40.0);
  editor.end();
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(editor.model(), before);
  EXPECT_FALSE(editor.can_undo());
}

TEST(PredicateEditorTest, ASetCanBeEmptiedAndFilledToItsLimit) {
  PredicateEditor editor = edit_preset("thyroid");
  while (editor.selected()) editor.remove(*editor.selected());
  EXPECT_TRUE(editor.model().entries.empty());
  for (std::size_t i = 0; i < kMostPredicates; ++i) ASSERT_TRUE(editor.add("intensity"));
  EXPECT_NEAR(sum_of_importances(editor.model()), 1, kSumError);
  EXPECT_TRUE(validate(editor.model()).has_value());
  const auto full = editor.add("snr");
  ASSERT_FALSE(full.has_value());
  EXPECT_EQ(full.error().message,
            "predicates: expected at most 32 in a set, which is full; remove one first");
  EXPECT_EQ(editor.add("colour").error().code, ErrorCode::kNotFound);
}

TEST(PredicateEditorTest, NotTwiceIsAsBeforeAndAndOrAddABar) {
  PredicateEditor editor = edit_preset("carotid-vessel");
  const PredicateModel before = editor.model();
  ASSERT_TRUE(editor.negate(1));
  EXPECT_EQ(editor.model().entries[1].expression.op, Operator::kNot);
  ASSERT_TRUE(editor.negate(1));
  EXPECT_EQ(editor.model(), before);
  ASSERT_TRUE(editor.combine(Operator::kAnd, 0, 2));
  ASSERT_EQ(editor.model().entries.size(), 4U);
  const PredicateEntry& both = editor.model().entries[3];
  EXPECT_EQ(both.name, "vessel and skin");
  EXPECT_EQ(both.expression,
            PredicateExpression::all({before.entries[0].expression, before.entries[2].expression}));
  EXPECT_EQ(editor.selected(), 3U);
  editor.remove(0);
  EXPECT_EQ(editor.model().entries[2].expression, both.expression) << "it does not refer to a bar";
}

TEST(PredicateEditorTest, ABarThatOthersReferToLeavesItsExpression) {
  PredicateModel model = *preset_predicates("carotid-vessel");
  model.entries[1].expression = PredicateExpression::negation(PredicateExpression::entry("vessel"));
  PredicateEditor editor(model);
  editor.remove(0);
  EXPECT_EQ(editor.model().entries[0].expression,
            PredicateExpression::negation(model.entries[0].expression));
}

TEST(PredicateEditorTest, ParametersKeepTheirRangesAndOrder) {
  PredicateEditor editor = edit_preset("carotid-vessel");
  // vesselness in [0.3, 1] and depth in [5, 10000].
  const auto all = editable_parameters(editor.model().entries[0].expression);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[0].kind, "vesselness");
  EXPECT_EQ(all[2].kind, "depth");
  EXPECT_EQ(all[2].value, 5);
  ASSERT_TRUE(editor.set_parameter(0, 2, 8));
  EXPECT_EQ(editable_parameters(editor.model().entries[0].expression)[2].value, 8);
  const PredicateModel before = editor.model();
  EXPECT_EQ(editor.set_parameter(0, 0, 2).error().code, ErrorCode::kUsage) << "inverted range";
  EXPECT_EQ(editor.set_parameter(0, 2, NAN).error().code, ErrorCode::kUsage);
  EXPECT_EQ(editor.set_floor(0, 1.5).error().code, ErrorCode::kUsage);
  EXPECT_EQ(editor.model(), before);
  // Connected parts have a volume.
  const auto connected = editable_parameters(edit_preset("abdomen").model().entries[0].expression);
  EXPECT_EQ(connected.front().parameter.name, "least_mm3");
  EXPECT_EQ(connected.front().value, 150);
}

TEST(PredicateEditorTest, StrokesStartFromTheHistogramBeforeThemAndEndWithAnotherEdit) {
  PredicateEditor editor = edit_preset("carotid-vessel");
  const PredicateModel before = editor.model();
  editor.add_stroke(dot(1));
  PredicateHistogram shown = before.histogram;
  shown.drag(0, 0.9);
  EXPECT_FALSE(editor.finish_scribble(editor.revision() - 1, shown)) << "it is out of date";
  ASSERT_TRUE(editor.finish_scribble(editor.revision(), shown));
  EXPECT_NEAR(editor.model().histogram.bars()[0].importance, 0.9, kSumError);
  editor.add_stroke(dot(2));
  EXPECT_EQ(editor.strokes().size(), 2U);
  EXPECT_EQ(editor.before_strokes(), before) << "all strokes count from there";
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(editor.strokes().size(), 1U);
  EXPECT_EQ(editor.model().histogram.bars(), shown.bars())
      << "the step of the first stroke has its effect";
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(editor.model(), before);
  ASSERT_TRUE(editor.redo());
  editor.drag(1, 0.5);
  EXPECT_TRUE(editor.strokes().empty());
  EXPECT_EQ(editor.before_strokes(), editor.model());
}

}  // namespace
}  // namespace nav::render
