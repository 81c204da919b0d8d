// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/threads.hpp"

#include <algorithm>
#include <thread>

namespace nav {

int usable_threads(int wanted) {
  return std::min(wanted, static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
}

}  // namespace nav
