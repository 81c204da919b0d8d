// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "devices/can/encoder_arm.hpp"

namespace nav::session {

/// Reads the calibrated kinematics of an arm (docs/devices/can-arm.md). Errors name the file and
/// the key: "arm.json.joints[2].node: expected …, found …".
Result<devices::ArmModel> read_arm_file(const std::filesystem::path& path);

/// Text of an arm file, as read_arm_file() takes it.
std::string arm_file_text(const devices::ArmModel& arm);

}  // namespace nav::session
