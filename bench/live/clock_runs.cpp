// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/live/clock_runs.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>

#include "bench/measure.hpp"
#include "nav/statistics.hpp"
#include "sim/random.hpp"
#include "tracking/clock_model.hpp"

namespace nav::bench {
namespace {

constexpr double kRate = 1 + 100e-6;
constexpr double kLeastDelayS = 0.008, kTailS = 0.005, kLoss = 0.2;
constexpr double kClockStepS = 0.15, kFoundS = 0.2;
constexpr double kLearnedS = 10;

/// One arrival: true time, stamp of the device, reception.
struct Arrival {
  double physical_s;
  DeviceTime stamp;
  Timestamp received;
};

/// Arrivals of a device in order.
class Link {
 public:
  Link(double rate_hz, double stamp_ms, sim::Random random)
      : rate_hz_(rate_hz), stamp_s_(1e-3 * stamp_ms), random_(random) {}
  /// \p set_s: what the clock was set by.
  Arrival next(double set_s = 0) {
    do {
      ++count_;
    } while (random_.uniform(0, 1) < kLoss);
    const double physical_s = static_cast<double>(count_) / rate_hz_;
    last_s_ =
        std::max(last_s_, physical_s + kLeastDelayS - kTailS * std::log(random_.uniform(1e-12, 1)));
    const double stamp_s = stamp_s_ * std::floor((kRate * physical_s + set_s) / stamp_s_);
    return {physical_s, DeviceTime(DeviceClock::duration(std::llround(1e9 * stamp_s))),
            Timestamp(from_seconds(last_s_))};
  }

 private:
  double rate_hz_, stamp_s_;
  sim::Random random_;
  std::uint64_t count_ = 0;
  double last_s_ = 0;
};

/// True if a clock that is set after 20 s is found soon.
bool finds_step(double rate_hz, double stamp_ms, sim::Random random) {
  Link link(rate_hz, stamp_ms, random);
  tracking::ClockModel model;
  const double at_s = 20 + random.uniform(0, 5);
  const double set_s = random.uniform(0, 1) < 0.5 ? kClockStepS : -kClockStepS;
  while (true) {
    const Arrival probe = link.next();
    (void)model.add(probe.stamp, probe.received);
    if (probe.physical_s >= at_s) break;
  }
  const double begin_s = at_s;
  while (true) {
    const Arrival arrival = link.next(set_s);
    const auto reading = model.add(arrival.stamp, arrival.received);
    // Found: no wrong time is believed any more.
    if (reading.fault || reading.began_epoch) return true;
    if (arrival.physical_s > begin_s + kFoundS) return false;
  }
}

ClockRuns run_of(double rate_hz, double stamp_ms, const ClockRunsOptions& options) {
  ClockRuns row{.rate_hz = rate_hz, .stamp_ms = stamp_ms};
  Link link(rate_hz, stamp_ms, sim::Random(options.seed, 1));
  std::vector<Arrival> arrivals;
  while (arrivals.empty() || arrivals.back().physical_s < options.seconds) {
    arrivals.push_back(link.next());
  }
  std::vector<tracking::ClockModel::Reading> readings(arrivals.size());
  tracking::ClockModel model;
  const double before = process_time_s();
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    readings[i] = model.add(arrivals[i].stamp, arrivals[i].received);
  }
  row.ns_per_sample = 1e9 * (process_time_s() - before) / static_cast<double>(arrivals.size());
  std::vector<double> errors_ms;
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    if (readings[i].fault) ++row.rejected;
    if (arrivals[i].physical_s < kLearnedS) continue;
    errors_ms.push_back(1e3 *
                        (to_seconds(readings[i].acquired) - arrivals[i].physical_s - kLeastDelayS));
  }
  // Stamps that are rounded down are early by half their resolution: a constant.
  const double constant_ms = median(errors_ms);
  for (double& error : errors_ms) error = std::abs(error - constant_ms);
  row.error_max_ms = *std::max_element(errors_ms.begin(), errors_ms.end());
  row.error_p95_ms = quantile(std::move(errors_ms), 0.95);
  row.skew_ppm = model.skew_ppm();
  row.false_steps = model.steps();
  int found = 0;
  for (int i = 0; i < options.steps; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    found += finds_step(rate_hz, stamp_ms, sim::Random(options.seed, 100 + number)) ? 1 : 0;
  }
  row.steps_found = static_cast<double>(found) / options.steps;
  return row;
}

}  // namespace

Result<std::vector<ClockRuns>> measure_clock_runs(const ClockRunsOptions& options,
                                                  const std::function<void(double)>& progress) {
  if (!(options.seconds >= 60 && options.seconds <= 86400) || options.steps < 1) {
    return Error{ErrorCode::kUsage, "clock: expected 60 to 86400 s and steps >= 1, found " +
                                        std::to_string(options.seconds) + " s and " +
                                        std::to_string(options.steps) + " steps"};
  }
  std::vector<ClockRuns> rows;
  constexpr double kRates[] = {20, 50, 400};
  constexpr double kStamps[] = {0.001, 1};
  for (const double stamp_ms : kStamps) {
    for (const double rate_hz : kRates) {
      rows.push_back(run_of(rate_hz, stamp_ms, options));
      progress(static_cast<double>(rows.size()) / 6);
    }
  }
  return rows;
}

std::string to_text(const std::vector<ClockRuns>& rows) {
  std::ostringstream text;
  text << "clock: device 100 ppm fast, delay 8 ms with a tail of 5 ms, 20 % losses\n"
       << "rate Hz  stamps ms  error ms p95   max  skew ppm  rejected  false steps"
          "  steps of 150 ms found  ns/sample\n"
       << std::fixed;
  for (const ClockRuns& r : rows) {
    text << std::setprecision(0) << std::setw(7) << r.rate_hz << std::setprecision(3)
         << std::setw(11) << r.stamp_ms << std::setw(14) << r.error_p95_ms << std::setw(6)
         << std::setprecision(2) << r.error_max_ms << std::setprecision(1) << std::setw(10)
         << r.skew_ppm << std::setw(10) << r.rejected << std::setw(13) << r.false_steps
         << std::setprecision(3) << std::setw(23) << r.steps_found << std::setprecision(0)
         << std::setw(11) << r.ns_per_sample << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
