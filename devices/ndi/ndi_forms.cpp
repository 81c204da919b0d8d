// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_forms.hpp"

#include <algorithm>

#include "devices/ndi/ndi_commands.hpp"
#include "devices/ndi/ndi_errors.hpp"

namespace nav::devices {
namespace {

/// Codes of ERROR that a tracker gives to a command or to options that it does not know.
bool is_not_understood(std::uint8_t code) {
  constexpr std::uint8_t kCodes[] = {kNdiInvalidCommand, 0x02, 0x03, 0x07, 0x23, 0x33};
  return std::ranges::count(kCodes, code) > 0;
}

}  // namespace

const char* to_string(NdiForm form) {
  switch (form) {
    case NdiForm::kBx2:
      return "BX2";
    case NdiForm::kBx:
      return "BX";
    case NdiForm::kTx:
      return "TX";
  }
  return "unknown";
}

const std::string& ndi_form_command(NdiForm form) {
  static const std::string bx2 = ndi_command("BX2", "--6d=tools");
  static const std::string bx = ndi_command("BX", "0801");
  static const std::string tx = ndi_command("TX", "0801");
  if (form == NdiForm::kBx2) return bx2;
  return form == NdiForm::kBx ? bx : tx;
}

std::optional<NdiForm> ndi_form_after(NdiForm form, std::uint8_t error) {
  if (form == NdiForm::kTx || !is_not_understood(error)) return std::nullopt;
  return form == NdiForm::kBx2 ? NdiForm::kBx : NdiForm::kTx;
}

Result<void> read_ndi_poses(NdiForm form, const NdiReply& reply, NdiReadings& out) {
  const bool binary = reply.kind == NdiReplyKind::kBinary;
  if (binary != (form != NdiForm::kTx)) {
    return Error{ErrorCode::kMalformedData, "NDI: the reply is of another form than the question"};
  }
  if (form == NdiForm::kBx2) return read_ndi_bx2(reply.body, out);
  return binary ? read_ndi_bx(reply.body, out) : read_ndi_tx(reply.text, out);
}

}  // namespace nav::devices
