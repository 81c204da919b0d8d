// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "devices/ndi/ndi_poses.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "nav/result.hpp"

namespace nav::devices {

/// Command that asks for poses.
enum class NdiForm { kBx2, kBx, kTx };
/// "BX2", "BX" or "TX".
const char* to_string(NdiForm form);

/// The whole command, which asks for tools out of the volume too.
const std::string& ndi_form_command(NdiForm form);
/// Form to go on with when a tracker answers with this error: the next one, if the error says that
/// the command or its options are not known; otherwise, and after TX, absent.
std::optional<NdiForm> ndi_form_after(NdiForm form, std::uint8_t error);
/// Reads the reply to ndi_form_command(). kMalformedData where it has another form.
Result<void> read_ndi_poses(NdiForm form, const NdiReply& reply, NdiReadings& out);

}  // namespace nav::devices
