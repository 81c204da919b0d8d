// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/registration_desk.hpp"

#include <QCoreApplication>
#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

#include "tests/support/test_data.hpp"
#include "tests/window/application.hpp"
#include "tests/window/moments.hpp"

namespace nav::app {
namespace {

using ::testing::HasSubstr;
using Pose = Transform<frames::Ct, frames::Reference>;

std::shared_ptr<const Volume> box() {
  constexpr int kSide = 20;
  VoxelGrid grid;
  grid.size = {kSide, kSide, kSide};
  grid.spacing_mm = Eigen::Vector3d::Constant(10);
  grid.directions = Eigen::Matrix3d::Identity();
  grid.origin_mm = Eigen::Vector3d::Constant(-100);
  return std::make_shared<const Volume>(
      *Volume::create(grid, std::vector<std::int16_t>(kSide * kSide * kSide, 0), "box"));
}

class RegistrationDeskTest : public ::testing::Test {
 protected:
  RegistrationDeskTest() {
    test::application();
    page_ = std::make_unique<RegistrationPage>(nullptr);
    moment_ = test::valid_moment(1, test::kStart);
    moment_->ct = box();
    moment_->reference_frame = "Reference";
    moment_->placement = session::Placement{
        .placement = {in_use_, {SafetyState::kValid, ""}}, .kind = "registered", .statement = ""};
    desk_ = std::make_unique<RegistrationDesk>(
        *page_, RegistrationDesk::Hears{
                    .moment = [this] { return moment_; },
                    .config = [] { return SessionConfig(); },
                    .cursor = [this] { return std::optional(Point<frames::Ct>{cursor_}); },
                    .place = [this](const session::Placement& one) { shown_ = one; },
                    .judged = [this](const RegistrationCandidate& one,
                                     bool accepted) { judged_ = std::pair(one, accepted); },
                    .by_eye = [](bool) {},
                    .file = [this](const char* suffix) { return folder_ / suffix; },
                    .job = [](const JobNews&, double, double) {}});
  }
  /// Points at a landmark of the CT and touches where a patient at \p truth has it.
  void add_landmark(const Eigen::Vector3d& ct_mm, const Pose& truth) {
    cursor_ = ct_mm;
    page_->point();
    const Point<frames::Reference> touched = truth.inverse() * Point<frames::Ct>{ct_mm};
    // The window computes the tip in the CT by the placement that is in use.
    const Point<frames::Ct> tip = in_use_ * touched;
    auto next = std::make_shared<Moment>(*moment_);
    next->epoch.ct_from_needle.emplace(Eigen::Quaterniond::Identity(), tip.mm);
    moment_ = next;
    page_->touch();
  }
  /// Waits for the worker's answer.
  void wait_while(const std::string& state) {
    for (int i = 0; i < 2000 && desk_->state() == state; ++i) {
      QCoreApplication::processEvents();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  const Pose in_use_{Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ())),
                     Eigen::Vector3d(5, -3, 2)};
  const Pose truth_{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX())),
                    Eigen::Vector3d(10, 4, -6)};
  test::TemporaryFolder folder_;
  Eigen::Vector3d cursor_ = Eigen::Vector3d::Zero();
  std::shared_ptr<Moment> moment_;
  std::optional<session::Placement> shown_;
  std::optional<std::pair<RegistrationCandidate, bool>> judged_;
  std::unique_ptr<RegistrationPage> page_;
  std::unique_ptr<RegistrationDesk> desk_;
};

TEST_F(RegistrationDeskTest, LandmarksGiveThePoseAndTheUserAcceptsIt) {
  for (const auto& at :
       {Eigen::Vector3d(60, 0, 0), Eigen::Vector3d(-60, 10, 0), Eigen::Vector3d(0, 70, 20),
        Eigen::Vector3d(10, -60, -50), Eigen::Vector3d(-20, 20, 70)}) {
    add_landmark(at, truth_);
  }
  EXPECT_EQ(desk_->landmarks(), 5U);
  page_->fit();
  wait_while("none");
  ASSERT_EQ(desk_->state(), "waiting") << page_->words().toStdString();
  EXPECT_THAT(page_->words().toStdString(), HasSubstr("Residuals: L1 0.0 mm"));
  EXPECT_THAT(page_->words().toStdString(), HasSubstr("Predicted error at the target"));
  // Until the user's word it is degraded.
  ASSERT_TRUE(shown_);
  EXPECT_EQ(shown_->placement.safety.state, SafetyState::kDegraded);
  EXPECT_NEAR((shown_->placement.ct_from_reference.matrix() - truth_.matrix()).norm(), 0, 1e-9);
  page_->accept();
  EXPECT_EQ(desk_->state(), "accepted");
  EXPECT_EQ(shown_->placement.safety.state, SafetyState::kValid);
  ASSERT_TRUE(judged_ && judged_->second);
  EXPECT_TRUE(session::read_registration(judged_->first.file)) << "it can be used by other verbs";
}

TEST_F(RegistrationDeskTest, ARejectedRegistrationLeavesThePlacementAsItWas) {
  for (const auto& at : {Eigen::Vector3d(60, 0, 0), Eigen::Vector3d(-60, 10, 0),
                         Eigen::Vector3d(0, 70, 20), Eigen::Vector3d(10, -60, -50)}) {
    add_landmark(at, truth_);
  }
  page_->fit();
  wait_while("none");
  ASSERT_EQ(desk_->state(), "waiting") << page_->words().toStdString();
  page_->reject();
  EXPECT_EQ(desk_->state(), "rejected");
  EXPECT_EQ(shown_->placement.ct_from_reference.matrix(), in_use_.matrix());
  EXPECT_EQ(shown_->placement.safety.state, SafetyState::kValid);
  EXPECT_FALSE(judged_->second);
}

TEST_F(RegistrationDeskTest, LandmarksOnOneLineAreRejectedWithTheCause) {
  for (const double x : {-60.0, -20.0, 10.0, 60.0}) {
    add_landmark(Eigen::Vector3d(x, 0, 0), truth_);
  }
  page_->fit();
  wait_while("none");
  EXPECT_EQ(desk_->state(), "refused");
  EXPECT_THAT(page_->words().toStdString(), HasSubstr("collinear"));
  EXPECT_FALSE(shown_) << "nothing is placed";
}

TEST_F(RegistrationDeskTest, TwoLandmarksAreTooFew) {
  add_landmark(Eigen::Vector3d(60, 0, 0), truth_);
  add_landmark(Eigen::Vector3d(0, 60, 0), truth_);
  page_->fit();
  EXPECT_THAT(page_->words().toStdString(), HasSubstr("there are 2"));
  EXPECT_EQ(desk_->state(), "none");
}

TEST_F(RegistrationDeskTest, ANeedleThatIsNotTrackedTouchesNothing) {
  auto next = std::make_shared<Moment>(*moment_);
  next->epoch.needle = {SafetyState::kLost, "the marker is hidden"};
  moment_ = next;
  page_->touch();
  EXPECT_EQ(desk_->landmarks(), 0U);
  EXPECT_THAT(page_->words().toStdString(), HasSubstr("the marker is hidden"));
}

TEST_F(RegistrationDeskTest, ByEyeShiftsTurnsAndUndoes) {
  page_->set_by_eye(true);
  cursor_ = {20, 0, 0};
  desk_->nudge({.shift = Eigen::Vector3d::UnitX(), .turn = Eigen::Vector3d::Zero()});
  ASSERT_TRUE(shown_);
  EXPECT_EQ(shown_->placement.safety.state, SafetyState::kDegraded);
  // The CT goes 1 mm to the left, so the patient's points lie 1 mm to the right in it.
  const Point<frames::Reference> point{{1, 2, 3}};
  const Point<frames::Ct> before = in_use_ * point;
  EXPECT_NEAR((shown_->placement.ct_from_reference * point).mm.x(), before.mm.x() - 1, 1e-12);
  desk_->nudge({.shift = Eigen::Vector3d::Zero(), .turn = Eigen::Vector3d::UnitZ()});
  const Pose turned = shown_->placement.ct_from_reference;
  // The point under the cursor stays where it is.
  const Pose shifted(in_use_.rotation(), in_use_.translation_mm() - Eigen::Vector3d::UnitX());
  const Point<frames::Reference> under = shifted.inverse() * Point<frames::Ct>{cursor_};
  EXPECT_NEAR(((turned * under).mm - cursor_).norm(), 0, 1e-9);
  EXPECT_TRUE(desk_->undo());
  EXPECT_TRUE(desk_->undo());
  EXPECT_NEAR((shown_->placement.ct_from_reference.matrix() - in_use_.matrix()).norm(), 0, 1e-12);
  EXPECT_FALSE(desk_->undo());
  EXPECT_TRUE(desk_->redo());
  page_->accept();
  ASSERT_TRUE(judged_ && judged_->second);
  EXPECT_TRUE(judged_->first.file.empty());
  EXPECT_EQ(shown_->placement.safety.state, SafetyState::kDegraded);
}

TEST_F(RegistrationDeskTest, ADragByEyeIsOneStepOfUndo) {
  const EyeMovement left{.shift_mm = Eigen::Vector3d::UnitX()};
  desk_->move(left);
  EXPECT_FALSE(shown_) << "the CT is placed only by eye";
  page_->set_by_eye(true);
  desk_->drag(true);
  for (int i = 0; i < 5; ++i) desk_->move(left);
  desk_->move({.turn_rad = 0.1 * Eigen::Vector3d::UnitZ(), .about = {{20, 0, 0}}});
  desk_->drag(false);
  const Pose turned = shown_->placement.ct_from_reference;
  const Pose shifted(in_use_.rotation(), in_use_.translation_mm() - 5 * Eigen::Vector3d::UnitX());
  const Point<frames::Ct> about{{20, 0, 0}};
  EXPECT_NEAR(((turned * (shifted.inverse() * about)).mm - about.mm).norm(), 0, 1e-9);
  EXPECT_NEAR(turned.rotation().angularDistance(in_use_.rotation()), 0.1, 1e-9);
  EXPECT_TRUE(desk_->undo());
  EXPECT_NEAR((shown_->placement.ct_from_reference.matrix() - in_use_.matrix()).norm(), 0, 1e-12);
  EXPECT_FALSE(desk_->undo());
}

}  // namespace
}  // namespace nav::app
