// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"

namespace nav::app {

/// An error where Qt would end the program: there is no display, or it does not answer.
Result<void> check_display();

}  // namespace nav::app
