// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav {

/// Limits the threads asked for to one per core: more bring nothing, and TBB prints a warning.
/// 0 (all cores) stays 0.
int usable_threads(int wanted);

}  // namespace nav
