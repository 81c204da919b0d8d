// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "nav/check.hpp"
#include "nav/image.hpp"
#include "nav/result.hpp"
#include "nav/statistics.hpp"

namespace nav::bench {

/// User and system time of the whole process with all threads, s.
double process_time_s();
/// Memory of the process in RAM, bytes; 0 if the system does not tell it.
std::size_t resident_bytes();

/// The pixels in the middle of blocks of factor × factor pixels of an image. factor: odd, so that
/// they are the pixels of an image at that lower resolution.
template <class T>
Image2d<T> middles(const Image2d<T>& image, int factor) {
  NAV_CHECK(factor > 0 && factor % 2 == 1, factor);
  std::vector<T> pixels;
  for (int y = factor / 2; y < image.height(); y += factor) {
    for (int x = factor / 2; x < image.width(); x += factor) pixels.push_back(image.at(x, y));
  }
  return {image.width() / factor, image.height() / factor, std::move(pixels)};
}

/// Time of one run, medians of several.
struct Taken {
  double cpu_s = 0;
  double wall_s = 0;
  double cpu_scatter_s = 0;  ///< Median distance of runs from cpu_s.
};

/// A measured operation; a failure ends the measurement.
using Task = std::function<Result<void>()>;

/// Limits on the repeats of tasks.
struct Repeats {
  int times = 3;        ///< >= 1.
  double enough_s = 2;  ///< No further repeat of a task after this total process time.
};

/// Medians of tasks run in turn (A B C A B C …), so that other load on the machine affects all of
/// them equally.
Result<std::vector<Taken>> time_in_turn(const std::vector<Task>& tasks, const Repeats& repeats);

/// Runs tasks in turn for a tenth of a second, each at least once, because devices lower their
/// clock when they have little to do.
Result<void> keep_busy(const std::vector<Task>& tasks);

}  // namespace nav::bench
