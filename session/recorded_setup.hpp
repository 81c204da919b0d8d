// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "nav/result.hpp"
#include "session/session.hpp"

namespace nav::session {

/// Name of the metadata of a recording in which the setup of its session stands.
inline constexpr const char* kSetupMetadata = "sonde.setup";

/// The parts of a setup that a replay needs: calibration, tip of the needle, fixed reference,
/// temporal offset. Numbers have all their digits, so that a replay gives the same bits.
std::map<std::string, std::string> facts_of(const SessionSetup& setup);

/// The setup of such facts; keys that are missing leave the defaults. \p name: of the recording,
/// for messages. kMalformedData for values that are no numbers or no rigid transforms.
Result<SessionSetup> setup_from(const std::map<std::string, std::string>& facts,
                                const std::string& name);

}  // namespace nav::session
