// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/clock_model.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace nav::tracking {
namespace {

DeviceTime device_at(double s) { return DeviceTime(DeviceClock::duration(std::llround(1e9 * s))); }
Timestamp session_at(double s) { return Timestamp(from_seconds(s)); }

/// A device of which every fifth sample is lost. Each sample arrives 8 ms and an exponential tail
/// of 5 ms after its acquisition, never before the sample before.
struct Device {
  double hz = 50;
  double ppm = 0;
  double resolution_s = 1e-6;
  double duration_s = 60;
  int seed = 1;
  std::function<double(double)> step_s = [](double) {
    return 0.0;
  };  ///< Step of the device's clock.
  std::function<double(double)> delay_s = [](double) { return 0.0; };  ///< More delay.

  /// Calls \p sample(time of acquisition, device time, time of reception) for each sample.
  template <class F>
  void run(F sample) const {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    std::exponential_distribution<double> tail(1 / 0.005);
    std::uniform_real_distribution<double> uniform;
    double last = 0;
    for (int i = 0; i < duration_s * hz; ++i) {
      const double t = i / hz;
      if (uniform(random) < 0.2) continue;
      const double stamp = 1000 + t * (1 + 1e-6 * ppm) + step_s(t);
      last = std::max(last, t + 0.008 + tail(random) + delay_s(t));
      sample(t, device_at(std::floor(stamp / resolution_s) * resolution_s), session_at(last));
    }
  }
};

double percentile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Errors of the mapped times from 10 s on but for a constant, ms.
std::vector<double> errors_ms(const Device& device, ClockModel& model) {
  std::vector<double> errors;
  device.run([&](double t, DeviceTime stamp, Timestamp received) {
    const auto reading = model.add(stamp, received);
    if (t > 10 && !reading.fault) errors.push_back(1e3 * (to_seconds(reading.acquired) - t));
  });
  const double constant = percentile(errors, 0.5);
  for (double& error : errors) error = std::abs(error - constant);
  return errors;
}

TEST(ClockModelTest, MapsADriftingClockToATenthOfAMillisecond) {
  for (const double ppm : {100.0, -200.0}) {
    for (const double hz : {20.0, 50.0, 400.0}) {
      ClockModel model;
      const Device device{.hz = hz, .ppm = ppm, .duration_s = 600};
      EXPECT_LE(percentile(errors_ms(device, model), 0.95), 0.1) << hz << " Hz, " << ppm << " ppm";
      EXPECT_NEAR(model.skew_ppm(), -ppm, 5);
      EXPECT_EQ(model.steps(), 0);
      EXPECT_EQ(model.state(), ClockState::kKnown);
    }
  }
}

TEST(ClockModelTest, MapsStampsOfAMillisecond) {
  ClockModel model;
  EXPECT_LE(
      percentile(errors_ms({.ppm = 100, .resolution_s = 1e-3, .duration_s = 600}, model), 0.95),
      0.7);
}

TEST(ClockModelTest, TheIntervalOfTheDriftContainsIt) {
  int within = 0;
  constexpr int kTrials = 60;
  for (int seed = 0; seed < kTrials; ++seed) {
    ClockModel model;
    const Device device{.ppm = 50, .resolution_s = 1e-5, .duration_s = 30, .seed = seed};
    device.run([&](double, DeviceTime stamp, Timestamp received) { model.add(stamp, received); });
    within += std::abs(model.skew_ppm() + 50) <= model.skew_ci95_ppm() ? 1 : 0;
  }
  EXPECT_GE(within, kTrials * 9 / 10);
}

TEST(ClockModelTest, AStepIsFoundAtOnceAndThenFollowed) {
  for (const double step_s : {0.15, -0.15, 10.0, -3600.0}) {
    for (const double hz : {20.0, 50.0, 400.0}) {
      int found = 0;
      constexpr int kTrials = 100;
      for (int seed = 0; seed < kTrials; ++seed) {
        ClockModel model;
        const Device device{
            .hz = hz, .ppm = 100, .duration_s = 14, .seed = seed, .step_s = [&](double t) {
              return t > 10 ? step_s : 0;
            }};
        bool at_once = false;
        std::optional<Timestamp> mapped;
        device.run([&](double t, DeviceTime stamp, Timestamp received) {
          const auto reading = model.add(stamp, received);
          at_once |= t > 10 && t < 10.2 && reading.fault;
          if (t > 13.9) {
            ASSERT_FALSE(reading.fault) << to_string(*reading.fault);
            EXPECT_NEAR(to_seconds(reading.acquired), t + 0.008, 0.005);
          }
        });
        found += at_once ? 1 : 0;
        EXPECT_EQ(model.steps(), 1);
        EXPECT_NEAR(to_seconds(model.change()), -step_s, 0.01);
      }
      EXPECT_GE(found, 99) << step_s << " s, " << hz << " Hz";
    }
  }
}

TEST(ClockModelTest, ALastingChangeOfTheDelayIsFollowed) {
  ClockModel model;
  int faults_after_a_second = 0;
  Device{.duration_s = 30, .delay_s = [](double t) { return t > 10 ? 0.08 : 0; }}.run(
      [&](double t, DeviceTime stamp, Timestamp received) {
        const auto reading = model.add(stamp, received);
        if (t > 11 && reading.fault) ++faults_after_a_second;
      });
  EXPECT_LE(faults_after_a_second, 5);
  EXPECT_EQ(model.steps(), 1);
}

TEST(ClockModelTest, SamplesThatWereHeldUpAreLateAndBeginNoEpoch) {
  ClockModel model;
  int late = 0;
  int after = 0;
  // Nothing arrives from 10 to 11.5 s; then everything does.
  Device{.duration_s = 30, .delay_s = [](double t) { return t > 10 && t < 11.5 ? 11.5 - t : 0; }}
      .run([&](double t, DeviceTime stamp, Timestamp received) {
        const auto reading = model.add(stamp, received);
        if (reading.fault == ClockFault::kLate) ++late;
        if (t > 10.1 && t < 11.4) {
          EXPECT_TRUE(reading.fault) << t;
        }
        if (t > 11.8 && reading.fault) ++after;
      });
  EXPECT_EQ(model.steps(), 0);
  EXPECT_GE(late, 40);
  EXPECT_LE(after, 6);
}

TEST(ClockModelTest, ABadStampCostsOneSample) {
  ClockModel model;
  int i = 0;
  int faults = 0;
  Device{.duration_s = 20}.run([&](double, DeviceTime stamp, Timestamp received) {
    ++i;
    if (i % 100 == 50) {
      // In the future, in the past, absurd, and repeated.
      const DeviceTime bad[] = {stamp + std::chrono::seconds(9), stamp - std::chrono::seconds(9),
                                DeviceTime::max(), DeviceTime::min()};
      EXPECT_TRUE(model.add(bad[i / 100 % 4], received).fault);
    }
    faults += model.add(stamp, received).fault ? 1 : 0;
    EXPECT_EQ(model.add(stamp, received).fault, ClockFault::kRepeated);
  });
  // After a late stamp nothing is believed for 100 ms.
  EXPECT_LE(faults, 4 * 6);
  EXPECT_EQ(model.steps(), 0);
}

TEST(ClockModelTest, ACounterIsTimedByItsFloorToo) {
  // Samples are counted; the true period is 1 % shorter than the nominal one of 20 ms.
  ClockModel model({.kind = ClockKind::kCounter});
  std::vector<double> errors;
  Device{.duration_s = 300}.run([&](double t, DeviceTime, Timestamp received) {
    const auto reading = model.add(device_at(t / 0.99), received);
    if (t > 10) errors.push_back(1e3 * (to_seconds(reading.acquired) - t - 0.008));
    EXPECT_NE(reading.fault, ClockFault::kEarly);
  });
  for (double& error : errors) error = std::abs(error);
  EXPECT_LE(percentile(errors, 0.95), 0.2);
  EXPECT_NEAR(model.skew_ppm(), -1e4, 50);
}

TEST(TickUnwrapperTest, ContinuesOverTheEndOfACounter) {
  TickUnwrapper short_clock(16, std::chrono::milliseconds(1));
  EXPECT_EQ(short_clock.add(65530).time_since_epoch(), std::chrono::milliseconds(65530));
  EXPECT_EQ(short_clock.add(4).time_since_epoch(), std::chrono::milliseconds(65540));
  EXPECT_EQ(short_clock.add(2).time_since_epoch(), std::chrono::milliseconds(65538));
  EXPECT_EQ(short_clock.add(65535).time_since_epoch(), std::chrono::milliseconds(65535));
  TickUnwrapper long_clock(32, std::chrono::duration<double, std::nano>(100));
  EXPECT_EQ(long_clock.add(0xffffffffU).time_since_epoch().count(), 429496729500);
  EXPECT_EQ(long_clock.add(1).time_since_epoch().count(), 429496729700);
}

}  // namespace
}  // namespace nav::tracking
