// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The real window with the simulated procedure, in this process.
#include "app/window/main_window.hpp"

#include <QMouseEvent>
#include <QPushButton>
#include <QWheelEvent>
#include <cstdlib>
#include <gtest/gtest.h>
#include <random>

#include "app/options/settings.hpp"
#include "app/window/key_filter.hpp"
#include "app/window/theme.hpp"
#include "app/window/window_controls.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"
#include "tests/window/application.hpp"

namespace nav::app {
namespace {

using test::application;

class MainWindowTest : public ::testing::Test {
 protected:
  MainWindowTest() {
    application();
    SessionConfig config;
    config.source.kind = SessionConfig::SourceKind::kSimulated;
    config.appearance.preset = "ct-liver";
    window_ = std::make_unique<MainWindow>(
        MainWindow::Options{.loop = {.config = config, .engine = "cpu"}}, clock_, console_,
        report_);
    filter_ = std::make_unique<KeyFilter>(*window_);
    application().installEventFilter(filter_.get());
    window_->resize(640, 480);
    window_->show();
    window_->start();
  }
  ~MainWindowTest() override {
    application().removeEventFilter(filter_.get());
    window_->stop();
  }
  /// Handles events until a thing has a value, at most a minute.
  bool reaches(const char* thing, const char* value) {
    return until([&] { return window_->value(QLatin1String(thing)) == QLatin1String(value); });
  }
  bool until(const std::function<bool()>& done) {
    const Timestamp end = clock_.now() + std::chrono::seconds(60);
    while (clock_.now() < end) {
      QCoreApplication::processEvents(QEventLoop::AllEvents, 20);
      if (done()) return true;
    }
    return false;
  }
  bool shows_numbers() {
    return until([&] { return window_->value("numeral.tip") != QLatin1String("withdrawn"); });
  }

  MonotonicClock clock_;
  Console console_{false};
  WindowReport report_;
  std::unique_ptr<MainWindow> window_;
  std::unique_ptr<KeyFilter> filter_;
};

TEST_F(MainWindowTest, CoversAStaleImageAndWithdrawsTheNumbers) {
  ASSERT_TRUE(reaches("view.ultrasound", "shown"));
  ASSERT_TRUE(shows_numbers());
  ASSERT_TRUE(window_->loop().fault("cover-marker", std::chrono::seconds(2)));
  EXPECT_TRUE(reaches("numeral.tip", "withdrawn"));
  EXPECT_TRUE(reaches("view.ultrasound", "covered"));
  EXPECT_TRUE(reaches("view.ctplane", "covered"));
  EXPECT_TRUE(reaches("view.ultrasound", "shown")) << "it comes back by itself";
  EXPECT_EQ(report_.epochs_disagree(), 0U);
  EXPECT_GT(report_.refreshes(), 10U);
}

TEST_F(MainWindowTest, CoversTheViewOfAnEngineThatHangs) {
  ASSERT_TRUE(reaches("view.view3d", "shown"));
  ASSERT_TRUE(shows_numbers());
  ASSERT_TRUE(window_->loop().fault("hang-engine", std::chrono::seconds(4)));
  EXPECT_TRUE(reaches("view.view3d", "covered"));
  EXPECT_TRUE(reaches("view.view3d", "shown"));
  ASSERT_TRUE(window_->loop().fault("hang-session", std::chrono::seconds(2)));
  EXPECT_TRUE(reaches("view.ultrasound", "covered"));
  EXPECT_TRUE(reaches("numeral.tip", "withdrawn"));
}

TEST_F(MainWindowTest, AFrozenWindowShowsNoLiveNumber) {
  ASSERT_TRUE(reaches("view.ultrasound", "shown"));
  ASSERT_TRUE(shows_numbers());
  QKeyEvent space(QEvent::KeyPress, Qt::Key_Space, Qt::NoModifier);
  QApplication::sendEvent(window_.get(), &space);
  EXPECT_EQ(window_->value("frozen"), QLatin1String("yes"));
  EXPECT_EQ(window_->value("numeral.tip"), QLatin1String("withdrawn"));
}

TEST_F(MainWindowTest, EachLayoutShowsItsViewsOfOneMoment) {
  ASSERT_TRUE(shows_numbers());
  const auto press = [&](int key) {
    QKeyEvent event(QEvent::KeyPress, key, Qt::NoModifier);
    QApplication::sendEvent(window_.get(), &event);
  };
  press(Qt::Key_2);
  for (const char* view : {"view.axial", "view.coronal", "view.sagittal", "view.view3d"}) {
    EXPECT_TRUE(reaches(view, "shown")) << view;
  }
  EXPECT_EQ(window_->value("view.ultrasound"), QLatin1String("hidden"));
  press(Qt::Key_3);
  for (const char* view : {"view.bullseye", "view.needle1", "view.needle2", "view.ultrasound"}) {
    EXPECT_TRUE(reaches(view, "shown")) << view;
  }
  EXPECT_EQ(window_->value("view.view3d"), QLatin1String("hidden"));
  ASSERT_TRUE(window_->loop().fault("cover-marker", std::chrono::seconds(2)));
  EXPECT_TRUE(reaches("view.bullseye", "covered"));
  EXPECT_TRUE(reaches("view.needle1", "covered"));
  press(Qt::Key_2);
  EXPECT_TRUE(reaches("view.axial", "shown")) << "the CT does not grow old";
  EXPECT_EQ(report_.epochs_disagree(), 0U);
}

TEST_F(MainWindowTest, SlicesFollowTheMouse) {
  ASSERT_TRUE(reaches("view.view3d", "shown"));
  QKeyEvent slices(QEvent::KeyPress, Qt::Key_2, Qt::NoModifier);
  QApplication::sendEvent(window_.get(), &slices);
  ASSERT_TRUE(reaches("view.axial", "shown"));
  auto* axial = window_->findChild<FlatWidget*>(QStringLiteral("axial"));
  const auto drag = [&](Qt::MouseButton button, QPointF from, QPointF to) {
    QMouseEvent down(QEvent::MouseButtonPress, from, axial->mapToGlobal(from), button, button,
                     Qt::NoModifier);
    QMouseEvent move(QEvent::MouseMove, to, axial->mapToGlobal(to), Qt::NoButton, button,
                     Qt::NoModifier);
    QMouseEvent up(QEvent::MouseButtonRelease, to, axial->mapToGlobal(to), button, Qt::NoButton,
                   Qt::NoModifier);
    for (QMouseEvent* event : {&down, &move, &up}) QApplication::sendEvent(axial, event);
  };
  const QPointF centre = QRectF(axial->rect()).center();
  const auto sagittal = window_->value("slice.sagittal");
  const auto height = window_->value("slice.axial");
  drag(Qt::LeftButton, centre, centre + QPointF(10, 0));
  EXPECT_NE(window_->value("slice.sagittal"), sagittal);
  EXPECT_EQ(window_->value("slice.axial"), height);
  const auto level = window_->value("slice.window");
  drag(Qt::RightButton, centre, centre + QPointF(30, 10));
  EXPECT_NE(window_->value("slice.window"), level);
  QWheelEvent notch(centre, axial->mapToGlobal(centre), QPoint(), QPoint(0, 120), Qt::NoButton,
                    Qt::NoModifier, Qt::NoScrollPhase, false);
  QApplication::sendEvent(axial, &notch);
  EXPECT_NE(window_->value("slice.axial"), height);
  QWheelEvent zoom(centre, axial->mapToGlobal(centre), QPoint(), QPoint(0, 120), Qt::NoButton,
                   Qt::ControlModifier, Qt::NoScrollPhase, false);
  QApplication::sendEvent(axial, &zoom);
  EXPECT_EQ(window_->value("slice.zoom-axial"), QLatin1String("1.15"));
  // The image on the screen obeys.
  const Eigen::Vector3d wanted = cursor_of(window_->loop().slices(), *window_->loop().newest()).mm;
  EXPECT_TRUE(
      until([&] { return axial->view_image() && axial->view_image()->cursor.mm == wanted; }));
  ASSERT_TRUE(window_->loop().fault("hang-views", std::chrono::seconds(3)));
  EXPECT_TRUE(reaches("view.axial", "covered")) << "the line of the plane in it is old";
  EXPECT_TRUE(reaches("view.axial", "shown"));
  // A double click enlarges, and again goes back.
  for (const char* layout : {"single", "slices"}) {
    const QPointF at = QRectF(axial->rect()).center();
    QMouseEvent twice(QEvent::MouseButtonDblClick, at, axial->mapToGlobal(at), Qt::LeftButton,
                      Qt::LeftButton, Qt::NoModifier);
    QApplication::sendEvent(axial, &twice);
    EXPECT_EQ(window_->value("layout"), QLatin1String(layout));
  }
}

TEST_F(MainWindowTest, SimulatedStandsInTheTitleAndInEveryView) {
  SessionConfig simulated;
  simulated.source.kind = SessionConfig::SourceKind::kSimulated;
  EXPECT_TRUE(session_title(simulated).contains(QLatin1String("SIMULATED")));
  ASSERT_TRUE(reaches("view.ultrasound", "shown"));
  for (const char* layout : {"1", "2", "3"}) {
    QKeyEvent key(QEvent::KeyPress, Qt::Key_0 + (layout[0] - '0'), Qt::NoModifier);
    QApplication::sendEvent(window_.get(), &key);
    QCoreApplication::processEvents();
    for (auto* view : window_->findChildren<QWidget*>()) {
      auto* shown = dynamic_cast<ViewWidget*>(view);
      if (shown == nullptr || !shown->isVisible()) continue;
      EXPECT_TRUE(until([&] { return shown->kind() == QLatin1String("SIMULATED"); }))
          << shown->objectName().toStdString();
      // The word is painted: pixels of its colour in the line of the title or below it.
      const QImage line = shown->grab(QRect(0, 0, shown->width(), 50)).toImage();
      int painted = 0;
      for (int y = 0; y < line.height(); ++y) {
        for (int x = 0; x < line.width(); ++x) {
          if (line.pixel(x, y) == theme::kWindowAccent) ++painted;
        }
      }
      EXPECT_GT(painted, 20) << shown->objectName().toStdString();
    }
  }
}

TEST_F(MainWindowTest, TheSecondScreenShowsTheViewsAndHasNoControls) {
  ASSERT_TRUE(reaches("view.ultrasound", "shown"));
  QKeyEvent key(QEvent::KeyPress, Qt::Key_D, Qt::ControlModifier);
  QApplication::sendEvent(window_.get(), &key);
  ASSERT_TRUE(reaches("second-screen", "shown"));
  auto* second = window_->findChild<QWidget*>(QStringLiteral("second-screen"));
  EXPECT_TRUE(second->findChildren<QWidget*>().isEmpty());
  const QImage image = second->grab().toImage();
  qint64 painted = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (image.pixel(x, y) != theme::kWindowBackground) ++painted;
    }
  }
  constexpr double kLeastShare = 0.3;  // Borders beside the views, and dark parts of them.
  EXPECT_GT(static_cast<double>(painted), kLeastShare * image.width() * image.height());
  if (const char* folder = std::getenv("SONDE_SHOTS")) {
    image.save(QString::fromUtf8(folder) + QStringLiteral("/second-screen.png"));
  }
}

TEST_F(MainWindowTest, TheSecondScreenShowsChosenViewsThatAreHiddenHere) {
  ASSERT_TRUE(reaches("view.ultrasound", "shown"));
  const auto press = [&](int code, Qt::KeyboardModifiers with) {
    QKeyEvent key(QEvent::KeyPress, code, with);
    QApplication::sendEvent(window_.get(), &key);
  };
  press(Qt::Key_D, Qt::ControlModifier);
  ASSERT_TRUE(reaches("second-screen", "shown"));
  const Timestamp opened = clock_.now();
  for (const char* name : {"second-view3d", "second-slices"}) {
    window_->findChild<QPushButton*>(QLatin1String(name))->click();
  }
  EXPECT_EQ(window_->value("second-views"), QLatin1String("view3d,slices"));
  const auto* axial = window_->findChild<FlatWidget*>(QStringLiteral("axial"));
  EXPECT_TRUE(until([&] { return axial->view_image().has_value(); }));
  EXPECT_EQ(window_->value("view.axial"), QLatin1String("hidden"));
  ASSERT_TRUE(window_->loop().fault("cover-marker", std::chrono::seconds(2)));
  EXPECT_TRUE(until([&] { return axial->judgement().about == "plane"; }));
  auto* second = window_->findChild<QWidget*>(QStringLiteral("second-screen"));
  const QImage image = second->grab().toImage();
  bool found = false;  // The frame of the axial slice is red, and no other view has its colour.
  for (int y = 0; y < image.height() && !found; ++y) {
    for (int x = 0; x < image.width() && !found; ++x) {
      found = image.pixel(x, y) == *slice_colour(ViewId::kAxial);
    }
  }
  EXPECT_TRUE(found);
  if (const char* folder = std::getenv("SONDE_SHOTS")) {
    image.save(QString::fromUtf8(folder) + QStringLiteral("/second-screen-chosen.png"));
  }
  // Two presses within 150 ms count once.
  ASSERT_TRUE(until([&] { return clock_.now() - opened > std::chrono::milliseconds(300); }));
  press(Qt::Key_D, Qt::ControlModifier);
  ASSERT_TRUE(reaches("second-screen", "hidden"));
  EXPECT_FALSE(axial->view_image()) << "nobody sees it";
  EXPECT_EQ(window_->session_now().window.second_views,
            (std::vector<std::string>{"view3d", "slices"}));
  EXPECT_EQ(report_.epochs_disagree(), 0U);
}

TEST_F(MainWindowTest, TheSizeOfTextsIsKeptForTheUser) {
  const test::TemporaryFolder folder;
  const auto with = [&](const UserSettings& user) {
    return std::make_unique<MainWindow>(
        MainWindow::Options{.loop = {.config = {}, .engine = "cpu", .has_session = false},
                            .user = user,
                            .settings_folder = folder.path()},
        clock_, console_, report_);
  };
  const auto press = [](MainWindow& window, int code) {
    QKeyEvent key(QEvent::KeyPress, code, Qt::ControlModifier);
    window.press(key);
  };
  auto first = with({});
  EXPECT_EQ(first->value("text-scale"), QLatin1String("1.00"));
  press(*first, Qt::Key_Plus);
  EXPECT_EQ(first->value("text-scale"), QLatin1String("1.25"));
  first.reset();  // Ends its orders.
  const auto kept = read_user_settings(folder.path());
  ASSERT_TRUE(test::has_value(kept));
  EXPECT_EQ(kept->text_scale, 1.25);
  auto second = with(*kept);
  EXPECT_EQ(second->value("text-scale"), QLatin1String("1.25"));
  EXPECT_NEAR(theme::text_scale(), 1.25, 0.51 / theme::kTextPixels);  // Whole pixels.
  press(*second, Qt::Key_Minus);
  second.reset();
  EXPECT_EQ(read_user_settings(folder.path())->text_scale, 1);
}

TEST_F(MainWindowTest, TheListOfKeysHasEveryAction) {
  window_->loop().stop();  // No session is needed.
  QKeyEvent ask(QEvent::KeyPress, Qt::Key_Question, Qt::ShiftModifier);
  QApplication::sendEvent(window_.get(), &ask);
  EXPECT_EQ(window_->value("keys"), QLatin1String("shown"));
  const QString text = window_->findChild<QLabel*>(QStringLiteral("keys"))->text();
  for (const Action& action : window_->actions().all()) {
    EXPECT_TRUE(text.contains(action.title)) << action.name.toStdString();
  }
  QKeyEvent escape(QEvent::KeyPress, Qt::Key_Escape, Qt::NoModifier);
  QApplication::sendEvent(window_.get(), &escape);
  EXPECT_EQ(window_->value("keys"), QLatin1String("hidden"));
}

TEST_F(MainWindowTest, EveryControlHasANameAndNoTextIsCut) {
  ASSERT_TRUE(reaches("session", "running"));
  window_->resize(1280, 800);
  QCoreApplication::processEvents();
  for (const auto& control : controls_of(*window_)) {
    EXPECT_GE(control["contrast"].get<double>(), 4.5) << control["name"];
    if (control["kind"] != "button") continue;
    EXPECT_NE(control["accessible_name"], "") << control["name"];
    EXPECT_FALSE(control["clipped"].get<bool>()) << control["name"];
    const QString name = QString::fromStdString(control["name"].get<std::string>());
    const bool of_rail = window_->rail().findChild<QWidget*>(name) != nullptr;
    EXPECT_GE(control["height_px"].get<int>(), of_rail ? 44 : 28) << control["name"];
  }
}

TEST_F(MainWindowTest, AnyTwoThousandEventsLeaveNoCrashAndEqualEpochs) {
  ASSERT_TRUE(reaches("view.ultrasound", "shown"));
  std::mt19937 random(11);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const auto controls = window_->findChildren<QWidget*>();
  constexpr std::array kButtons{Qt::LeftButton, Qt::MiddleButton, Qt::RightButton};
  for (int i = 0; i < 2000; ++i) {
    QWidget* to = controls[below(static_cast<int>(controls.size()))];
    const QPointF at(below(400) - 20, below(400) - 20);
    const auto button = kButtons[static_cast<std::size_t>(below(3))];
    const int kind = below(6);
    if (kind < 3) {
      constexpr std::array kTypes{QEvent::MouseButtonPress, QEvent::MouseMove,
                                  QEvent::MouseButtonRelease};
      QMouseEvent event(kTypes[static_cast<std::size_t>(kind)], at, to->mapToGlobal(at), button,
                        button, Qt::NoModifier);
      // Snapshots would write files.
      if (to->objectName() != QLatin1String("snapshot")) QApplication::sendEvent(to, &event);
    } else if (kind == 3) {
      QWheelEvent event(at, to->mapToGlobal(at), QPoint(), QPoint(0, below(4000) - 2000),
                        Qt::NoButton, Qt::NoModifier, Qt::NoScrollPhase, false);
      QApplication::sendEvent(to, &event);
    } else if (kind == 4) {
      constexpr std::array kKeys{Qt::Key_F1,       Qt::Key_F6,     Qt::Key_Space, Qt::Key_R,
                                 Qt::Key_1,        Qt::Key_2,      Qt::Key_4,     Qt::Key_F11,
                                 Qt::Key_Question, Qt::Key_Escape, Qt::Key_Tab};
      const auto key = kKeys[static_cast<std::size_t>(below(static_cast<int>(kKeys.size())))];
      QKeyEvent event(QEvent::KeyPress, key, Qt::NoModifier, QString(), below(4) == 0);
      QApplication::sendEvent(to, &event);
    } else if (below(40) == 0) {
      window_->resize(1 + below(900), 1 + below(700));
    }
    if (i % 10 == 0) QCoreApplication::processEvents();
  }
  EXPECT_EQ(report_.epochs_disagree(), 0U);
}

}  // namespace
}  // namespace nav::app
