// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

namespace nav::bench {

/// Processor time of the calling thread, s: the time of a registration with one thread, independent
/// of the other threads of the process.
inline double thread_time_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processor time of work() on the calling thread, s.
template <class Work>
double timed(const Work& work) {
  const double before = thread_time_s();
  work();
  return thread_time_s() - before;
}

}  // namespace nav::bench
