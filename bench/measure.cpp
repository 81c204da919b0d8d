// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/measure.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>
#include <sys/resource.h>
#include <unistd.h>

#include "nav/stopwatch.hpp"

namespace nav::bench {

double process_time_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0;
  std::size_t resident = 0;
  if (!(file >> total >> resident)) return 0;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

Result<std::vector<Taken>> time_in_turn(const std::vector<Task>& tasks, const Repeats& repeats) {
  std::vector<std::vector<double>> cpu(tasks.size());
  std::vector<std::vector<double>> wall(tasks.size());
  for (int turn = 0; turn < std::max(repeats.times, 1); ++turn) {
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (std::accumulate(cpu[i].begin(), cpu[i].end(), 0.0) > repeats.enough_s) continue;
      const double cpu_before = process_time_s();
      const auto wall_before = std::chrono::steady_clock::now();
      if (auto done = tasks[i](); !done) return done.error();
      cpu[i].push_back(process_time_s() - cpu_before);
      wall[i].push_back(seconds_since(wall_before));
    }
  }
  std::vector<Taken> taken;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const double middle = median(cpu[i]);
    std::vector<double> off;
    for (const double one : cpu[i]) off.push_back(std::abs(one - middle));
    taken.push_back({middle, median(wall[i]), median(std::move(off))});
  }
  return taken;
}

Result<void> keep_busy(const std::vector<Task>& tasks) {
  constexpr double kLongEnough_s = 0.1;
  const auto start = std::chrono::steady_clock::now();
  do {
    for (const Task& task : tasks) {
      if (auto done = task(); !done) return done;
    }
  } while (seconds_since(start) < kLongEnough_s);
  return {};
}

}  // namespace nav::bench
