// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::devices {

/// Sets the speed of an open serial port, any rate (termios2). 0, or the errno.
int set_serial_speed(int fd, int baud);

}  // namespace nav::devices
