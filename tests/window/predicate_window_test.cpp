// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The panels of the real window, driven by scripts, in this process.
#include <QMouseEvent>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "app/options/settings.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "app/window/key_filter.hpp"
#include "app/window/main_window.hpp"
#include "app/window/script_player.hpp"
#include "app/window/window_controls.hpp"
#include "tests/window/application.hpp"

namespace nav::app {
namespace {

using test::application;

SessionConfig phantom() {
  SessionConfig config;
  config.predicates.alone = true;
  config.predicates.phantom = "carotid";
  config.predicates.phantom_side = 40;
  return config;
}

SessionConfig simulated() {
  SessionConfig config;
  config.source.kind = SessionConfig::SourceKind::kSimulated;
  config.appearance.preset = "ct-liver";
  return config;
}

class ScriptedWindowTest : public ::testing::Test {
 protected:
  explicit ScriptedWindowTest(const SessionConfig& config) {
    application();
    window_ = std::make_unique<MainWindow>(
        MainWindow::Options{.loop = {.config = config, .engine = "cpu"}}, clock_, console_,
        report_);
    filter_ = std::make_unique<KeyFilter>(*window_);
    application().installEventFilter(filter_.get());
    window_->resize(1280, 800);
    window_->show();
    window_->start();
  }
  ~ScriptedWindowTest() override {
    application().removeEventFilter(filter_.get());
    window_->stop();
  }
  /// Plays the lines of a script; its failure, or empty.
  std::string play(const std::string& text) {
    auto lines = parse_script(text);
    if (!lines) return lines.error().message;
    std::optional<std::string> ended;
    ScriptPlayer player(
        *std::move(lines), {}, *window_, clock_, report_,
        [&](std::optional<Error> failure) { ended = failure ? failure->message : std::string(); });
    const Timestamp end = clock_.now() + std::chrono::seconds(240);
    while (!ended && clock_.now() < end) {
      QCoreApplication::processEvents(QEventLoop::AllEvents, 20);
    }
    return ended.value_or("the script did not end");
  }
  [[nodiscard]] std::string value(const char* name) const {
    return window_->value(QLatin1String(name)).value_or(QStringLiteral("nothing")).toStdString();
  }

  MonotonicClock clock_;
  Console console_{false};
  WindowReport report_;
  std::unique_ptr<MainWindow> window_;
  std::unique_ptr<KeyFilter> filter_;
};

class PredicateWindowTest : public ScriptedWindowTest {
 protected:
  PredicateWindowTest() : ScriptedWindowTest(phantom()) {}
};

class PanelWindowTest : public ScriptedWindowTest {
 protected:
  PanelWindowTest() : ScriptedWindowTest(simulated()) {}
};

TEST_F(PanelWindowTest, ComponentsOfTheTransferFunctionAreEdited) {
  ASSERT_EQ(play("wait view.view3d shown 60\nkey T\nexpect panel transfer\n"
                 "choose transfer-component bone\nset transfer-importance 0.25\n"
                 "set transfer-opacity 0.5\nexpect transfer.bone 0.250/0.25\n"
                 "set transfer-hue 0.333\nset transfer-saturation 1\nset transfer-brightness 1\n"),
            "");
  ASSERT_TRUE(window_->loop().edits());
  const auto& function = *window_->loop().edits()->transfer;
  const auto bone = std::ranges::find(function.components(), std::string("bone"),
                                      &render::TransferComponent::name);
  ASSERT_NE(bone, function.components().end());
  for (const auto& node : bone->nodes) {
    EXPECT_LT((node.rgb - Eigen::Vector3d(0, 1, 0)).norm(), 0.02) << node.rgb.transpose();
    EXPECT_EQ(node.importance, 0.25);
  }
  EXPECT_TRUE(window_->loop().newest()->counts);
  EXPECT_EQ(play("key Ctrl+Z\nkey Ctrl+Shift+Z\n"
                 "expect transfer.bone 0.250/0.25\nclick transfer-reset\nkey T\n"
                 "expect panel step\n"),
            "");
  EXPECT_FALSE(window_->loop().edits()->transfer) << "the session's own";
}

TEST_F(PanelWindowTest, TheCutawayIsEditedAndItsAnglesKeepTheirOrder) {
  ASSERT_EQ(play("wait view.view3d shown 60\nkey C\nexpect cutaway.on yes\n"
                 "set cutaway-theta1 0.75\nexpect cutaway.theta1 64.0\n"
                 "expect cutaway.theta2 64.0\nset cutaway-overlay 0.3\n"
                 "expect cutaway.overlay 30.0\nclick cutaway-endless\n"
                 "expect cutaway.overlay inf\nset cutaway-emphasis 0.5\n"
                 "choose cutaway-style gooch\nexpect cutaway.style gooch\nkey Ctrl+Z\n"
                 "expect cutaway.style phong\nexpect cutaway.emphasis 0.50\n"
                 "click cutaway-on\nexpect cutaway.on no\n"),
            "");
  render::Scene scene = *window_->loop().newest()->scene;
  ASSERT_TRUE(scene.cutaway);
  apply_edits_to(*window_->loop().edits(), scene);
  EXPECT_FALSE(scene.cutaway);
  EXPECT_EQ(play("click cutaway-on\n"), "");
  scene = *window_->loop().newest()->scene;
  apply_edits_to(*window_->loop().edits(), scene);
  ASSERT_TRUE(scene.cutaway);
  EXPECT_NEAR(scene.cutaway->theta1_rad, 64 * M_PI / 180, 1e-9);
  EXPECT_TRUE(std::isinf(scene.cutaway->overlay_mm));
  EXPECT_EQ(scene.shading.emphasis, 0.5);
  EXPECT_TRUE(render::validate(scene).has_value());
}

TEST_F(PanelWindowTest, WithoutA3dUltrasoundThePanelSaysSo) {
  ASSERT_EQ(play("wait view.view3d shown 60\nkey P\nexpect predicates none\n"
                 "expect histogram.count 0\n"),
            "");
  EXPECT_TRUE(window_->predicates().page().words().contains(QLatin1String("No 3D ultrasound")));
  EXPECT_EQ(play("drag histogram.vessel 0.5\n"), "line 1: drag: 'histogram' is disabled");
}

TEST_F(PanelWindowTest, NoButtonOfTheRailLiesOverAnother) {
  for (const QSize size : {QSize(1280, 800), QSize(1280, 500), QSize(800, 300)}) {
    window_->resize(size);
    QCoreApplication::processEvents();
    const auto buttons = window_->rail().findChildren<QPushButton*>();
    ASSERT_GE(buttons.size(), 9);
    for (const QPushButton* a : buttons) {
      if (a->isHidden()) continue;
      EXPECT_GE(a->height(), 44) << a->objectName().toStdString();
      for (const QPushButton* b : buttons) {
        if (a == b || b->isHidden()) continue;
        EXPECT_FALSE(a->geometry().intersects(b->geometry()))
            << a->objectName().toStdString() << ", " << b->objectName().toStdString();
      }
    }
  }
}

TEST_F(PredicateWindowTest, ADraggedBarChangesTheSetTheSumStaysOneAndThe3dViewFollows) {
  ASSERT_EQ(play("wait view.view3d shown 60\nexpect layout slices\nexpect panel predicates\n"
                 "expect histogram.count 3\nwait scene full 60\n"),
            "");
  auto* scene = window_->findChild<SceneWidget*>(QStringLiteral("view3d"));
  const QImage before = scene->view_image()->image;
  EXPECT_EQ(play("drag histogram.vessel 0.1\nexpect histogram.vessel 0.100\n"
                 "expect histogram.sum 1\nwait predicates ready 20\nwait scene full 60\n"),
            "");
  const QImage after = scene->view_image()->image;
  EXPECT_NE(before.copy(0, 0, 200, 200), after.copy(0, 0, 200, 200));
  EXPECT_EQ(play("key Ctrl+Z\nexpect histogram.vessel 0.700\nkey Ctrl+Shift+Z\n"
                 "expect histogram.vessel 0.100\nexpect histogram.sum 1\n"),
            "");
}

TEST_F(PredicateWindowTest, ColoursParametersAndCombinationsAreEdited) {
  ASSERT_EQ(play("wait view.view3d shown 60\nset predicate-hue 0.5\nset predicate-saturation 1\n"
                 "set parameter3 9\nset parameter5 0.4\nwait predicates ready 60\n"),
            "");
  const render::PredicateModel& model = window_->predicates().editor().model();
  EXPECT_NEAR(model.histogram.bars()[0].hue_deg, 180, 1);
  EXPECT_EQ(model.histogram.bars()[0].saturation, 1);
  EXPECT_EQ(render::editable_parameters(model.entries[0].expression)[2].value, 9);
  EXPECT_EQ(model.entries[0].floor, 0.4);
  EXPECT_EQ(play("choose predicate-add snr\nwait predicates ready 60\nexpect histogram.count 4\n"
                 "click predicate-not\nclick predicate-and\nclick histogram.tissue\n"
                 "wait predicates ready 60\nexpect histogram.count 5\n"
                 "expect histogram.selected snr-and-tissue\nclick predicate-or\nkey Escape\n"
                 "click histogram.skin\nexpect histogram.count 5\nexpect histogram.selected skin\n"
                 "click predicate-remove\nexpect histogram.count 4\nexpect histogram.sum 1\n"
                 "choose predicate-preset shoulder-muscle\nwait predicates ready 60\n"
                 "expect histogram.count 3\nexpect predicates ready\n"),
            "");
  // An inverted range is rejected with a sentence, and the number goes back.
  EXPECT_EQ(play("click histogram.fibres\nset parameter1 50\n"), "");
  EXPECT_NE(window_->predicates().page().words(), QString());
  EXPECT_EQ(render::editable_parameters(model.entries[0].expression)[0].value, 2);
}

TEST_F(PredicateWindowTest, DigitsInANumberFieldEditTheNumberAndOtherKeysKeepTheirMeaning) {
  ASSERT_EQ(play("wait view.view3d shown 60\n"), "");
  auto* number = window_->findChild<QDoubleSpinBox*>(QStringLiteral("parameter1"));
  ASSERT_NE(number, nullptr);
  const auto press = [&](int key, const char* text) {
    QKeyEvent event(QEvent::KeyPress, key, Qt::NoModifier, QLatin1String(text));
    QApplication::sendEvent(number, &event);
  };
  press(Qt::Key_1, "1");
  EXPECT_EQ(value("layout"), "slices");
  press(Qt::Key_Space, " ");
  EXPECT_EQ(value("frozen"), "yes");
  press(Qt::Key_T, "t");
  EXPECT_EQ(value("panel"), "transfer");
}

TEST_F(PredicateWindowTest, ASetOfNoneAndAFullSetWork) {
  ASSERT_EQ(play("wait view.view3d shown 60\nclick predicate-remove\nclick predicate-remove\n"
                 "click predicate-remove\nexpect histogram.count 0\nwait predicates ready 60\n"
                 "wait scene full 60\nexpect view.view3d shown\n"),
            "");
  std::string fill;
  for (std::size_t i = 0; i < render::kMostPredicates; ++i) {
    fill += "choose predicate-add intensity\n";
  }
  EXPECT_EQ(play(fill + "expect histogram.count 32\nexpect histogram.sum 1\n"
                        "wait predicates ready 60\ndrag histogram.intensity-32 0.5\n"
                        "expect histogram.intensity-32 0.500\nexpect histogram.sum 1\n"
                        "choose predicate-add intensity\nexpect histogram.count 32\n"
                        "wait predicates ready 60\n"),
            "");
  EXPECT_TRUE(window_->predicates().page().words().contains(QLatin1String("at most 32")));
}

TEST_F(PredicateWindowTest, APredicateThatCannotBeEvaluatedIsNamedAndTheViewStays) {
  ASSERT_EQ(play("wait view.view3d shown 60\nchoose predicate-add needle_distance\n"
                 "wait predicates failed 60\nexpect view.view3d shown\n"),
            "");
  EXPECT_TRUE(window_->predicates().page().words().contains(QLatin1String("needle")));
  EXPECT_EQ(play("key Ctrl+Z\nwait predicates ready 60\n"), "");
}

TEST_F(PredicateWindowTest, ScribblesChangeTheHistogramAndUndoTakesThemBack) {
  ASSERT_EQ(play("wait view.axial shown 60\nexpect histogram.strokes 0\n"
                 "stroke axial hide -8,-8 8,-8\nwait predicates ready 60\n"
                 "expect histogram.strokes 1\nexpect histogram.sum 1\n"),
            "");
  const auto importances = [&] {
    std::vector<double> all;
    for (const auto& bar : window_->predicates().editor().model().histogram.bars()) {
      all.push_back(bar.importance);
    }
    return all;
  };
  const std::vector<double> hidden = importances();
  // The effect of the same stroke by the code of the command line.
  const auto& editor = window_->predicates().editor();
  const auto& source = *window_->loop().newest()->predicates;
  render::PredicateVolume volume = source.volume;
  volume.predicates.model = editor.before_strokes();
  const auto outcome = scribble(render::predicate_scene(volume, volume.predicates.model, 1, 1),
                                editor.strokes(), 0.25);
  ASSERT_TRUE(outcome.has_value());
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    EXPECT_NEAR(hidden[i], outcome->histogram.bars()[i].importance, 1e-12);
  }
  EXPECT_NE(hidden[0], 0.7);
  EXPECT_EQ(play("stroke sagittal show 0,0\nwait predicates ready 60\nexpect histogram.strokes 2\n"
                 "key Ctrl+Z\nwait predicates ready 60\nexpect histogram.strokes 1\n"),
            "");
  EXPECT_EQ(importances(), hidden);
  // Two presses within 150 ms count once.
  EXPECT_EQ(
      play("pause 0.2\nkey Ctrl+Z\nexpect histogram.strokes 0\nexpect histogram.vessel 0.700\n"),
      "");
  // Erased strokes have no effect.
  EXPECT_EQ(play("set scribble-radius 3\nstroke axial show 0,0 5,0\nwait predicates ready 60\n"
                 "stroke axial erase 0,0 5,0\nwait predicates ready 60\n"
                 "expect histogram.vessel 0.700\nclick scribble-clear\n"
                 "expect histogram.strokes 0\nkey Escape\n"),
            "");
  EXPECT_FALSE(window_->predicates().page().brush()) << "Escape ends the brush";
}

TEST_F(PredicateWindowTest, AStrokeOutsideTheVolumeIsNamed) {
  ASSERT_EQ(play("wait view.axial shown 60\nwheel axial -12 ctrl\npause 0.5\n"
                 "stroke axial show 60,60 61,61\nwait predicates failed 60\n"),
            "");
  EXPECT_TRUE(window_->predicates().page().words().contains(QLatin1String("under the stroke")));
  EXPECT_EQ(value("histogram.vessel"), "0.700");
}

TEST_F(PredicateWindowTest, TheButtonsOfTheSidesAndADoubleClickMoveTheCamera) {
  ASSERT_EQ(play("wait view.view3d shown 60\nwait scene full 60\nclick view-anterior\n"
                 "expect camera.letters R/S\nclick view-feet\nexpect camera.letters R/A\n"
                 "click view-left\nexpect camera.letters A/S\nwait scene full 60\n"),
            "");
  const std::string before = value("camera.looks-at");
  EXPECT_EQ(play("doubleclick view3d 20 10\npause 1\nwait scene full 60\n"), "");
  EXPECT_NE(value("camera.looks-at"), before);
  EXPECT_EQ(value("camera.letters"), "A/S");
}

TEST_F(PredicateWindowTest, NoTextIsCutAndEveryControlHasAName) {
  ASSERT_EQ(play("wait view.view3d shown 60\n"), "");
  for (const char* layout : {"1", "2"}) {
    ASSERT_EQ(play(std::string("key ") + layout + "\npause 0.1\n"), "");
    for (const auto& control : controls_of(*window_)) {
      const QWidget* widget =
          window_->findChild<QWidget*>(QString::fromStdString(control["name"].get<std::string>()));
      if (!widget->isVisible()) continue;
      EXPECT_FALSE(control["clipped"].get<bool>()) << control["name"];
      if (control["kind"] != "button") continue;
      EXPECT_NE(control["accessible_name"], "") << control["name"];
      EXPECT_GE(control["height_px"].get<int>(), kSmallControl) << control["name"];
    }
  }
}

TEST_F(PredicateWindowTest, AnyEventsLeaveTheSumOneAndNoCrash) {
  ASSERT_EQ(play("wait view.view3d shown 60\n"), "");
  std::mt19937 random(5);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  auto* bars = window_->findChild<QWidget*>("histogram");
  const std::vector<QWidget*> targets{bars,
                                      window_->findChild<QWidget*>("axial"),
                                      window_->findChild<QWidget*>("predicate-add"),
                                      window_->findChild<QWidget*>("predicate-not"),
                                      window_->findChild<QWidget*>("predicate-and"),
                                      window_->findChild<QWidget*>("predicate-remove"),
                                      window_->findChild<QWidget*>("predicate-hue"),
                                      window_->findChild<QWidget*>("scribble-show"),
                                      window_->findChild<QWidget*>("predicate-undo")};
  for (int i = 0; i < 600; ++i) {
    QWidget* to = targets[static_cast<std::size_t>(below(static_cast<int>(targets.size())))];
    const QPointF at(below(std::max(1, to->width())), below(std::max(1, to->height())));
    constexpr std::array kTypes{QEvent::MouseButtonPress, QEvent::MouseMove,
                                QEvent::MouseButtonRelease};
    if (auto* list = qobject_cast<QComboBox*>(to)) {
      emit list->activated(below(list->count()));
    } else {
      QMouseEvent event(kTypes[static_cast<std::size_t>(below(3))], at, to->mapToGlobal(at),
                        Qt::LeftButton, Qt::LeftButton, Qt::NoModifier);
      QApplication::sendEvent(to, &event);
    }
    if (i % 5 == 0) QCoreApplication::processEvents();
    const auto& model = window_->predicates().editor().model();
    double sum = 0;
    for (const auto& bar : model.histogram.bars()) sum += bar.importance;
    if (model.entries.empty()) continue;
    ASSERT_NEAR(sum, 1, 1e-9) << i;
  }
  EXPECT_EQ(report_.epochs_disagree(), 0U);
}

}  // namespace
}  // namespace nav::app
