// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/background.hpp"

#include <gtest/gtest.h>
#include <latch>
#include <stdexcept>

#include "registration/image_registration.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

using Registration = InBackground<ImageRegistrationResult>;

Registration::Work work(Diagnostics& diagnostics, int starts) {
  return [&diagnostics, starts](const Registration::Progress& progress) {
    return register_sweep(test::blob_scene().ct, test::blob_scene().sweep,
                          test::off_by(test::true_pose(), 5, 0.05, 1), test::small_options(starts),
                          diagnostics, progress);
  };
}

TEST(InBackgroundTest, FindsTheSameResultAsTheCallersThread) {
  CollectingDiagnostics diagnostics;
  const auto direct = work(diagnostics, 0)([](double) { return true; });
  ASSERT_TRUE(test::has_value(direct));
  Registration running(work(diagnostics, 0));
  double last = 0;
  while (running.poll() == nullptr) {
    const double now = running.progress();
    EXPECT_GE(now, last);
    last = now;
    std::this_thread::yield();
  }
  const auto& found = running.wait();
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(running.progress(), 1.0);
  EXPECT_EQ(found->ct_from_reference.translation_mm(), direct->ct_from_reference.translation_mm());
  EXPECT_EQ(running.poll(), &found);
  running.cancel();  // Too late to change the result.
  EXPECT_TRUE(test::has_value(running.wait()));
}

TEST(InBackgroundTest, CancelEndsTheSearchWithoutAResult) {
  CollectingDiagnostics diagnostics;
  Registration running(work(diagnostics, 20000));
  running.cancel();
  EXPECT_TRUE(test::rejects(running.wait(), ErrorCode::kCancelled, {"cancelled"}));
  EXPECT_LT(running.progress(), 1.0);
}

TEST(InBackgroundTest, TheDestructorCancelsAndWaits) {
  std::latch begun(1);
  bool cancelled = false;
  {
    InBackground<int> running([&](const InBackground<int>::Progress& progress) -> Result<int> {
      begun.count_down();
      while (progress(0.5)) std::this_thread::yield();
      cancelled = true;
      return Error{ErrorCode::kCancelled, "cancelled"};
    });
    begun.wait();
    EXPECT_EQ(running.poll(), nullptr);
  }
  EXPECT_TRUE(cancelled);
}

TEST(InBackgroundTest, ErrorsAndExceptionsReachTheCaller) {
  InBackground<int> refused([](const auto&) -> Result<int> {
    return Error{ErrorCode::kUsage, "levels: expected at least 1, found 0"};
  });
  EXPECT_TRUE(test::rejects(refused.wait(), ErrorCode::kUsage, {"levels"}));
  InBackground<int> broken([](const auto&) -> Result<int> { throw std::bad_alloc(); });
  EXPECT_THROW(broken.wait(), std::bad_alloc);
}

}  // namespace
}  // namespace nav::registration
