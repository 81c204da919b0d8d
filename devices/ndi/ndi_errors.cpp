// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_errors.hpp"

#include <algorithm>
#include <iterator>

#include "devices/ndi/ndi_hex.hpp"

namespace nav::devices {
namespace {

struct NdiSentence {
  std::uint8_t code;
  const char* meaning;
  const char* remedy;
};

constexpr const char* kReport = "report this to the authors of Sonde";
constexpr const char* kRestart = "switch the tracker off and on";
constexpr const char* kService = "switch the tracker off and on; if it stays, it needs service";
constexpr const char* kCable = "check the cable of the tracker and its length";
constexpr const char* kPlug = "plug the tool in again";
constexpr const char* kRom = "check the tool's .rom file, or have the tool's memory rewritten";

constexpr NdiSentence kErrors[] = {
    {0x01, "the tracker does not know the command", "update the tracker's firmware"},
    {0x02, "the command is too long", kReport},
    {0x03, "the command is too short", kReport},
    {0x04, "the command arrived damaged", kCable},
    {0x05, "the command took too long", kRestart},
    {0x06, "the tracker cannot use this baud rate", "choose a lower one"},
    {0x07, "the command has a wrong number of parameters", kReport},
    {0x08, "the tracker does not know this port", kPlug},
    {0x09, "the tracking priority is not known", kReport},
    {0x0A, "the lamp is not known", kReport},
    {0x0B, "the state of the lamp is not known", kReport},
    {0x0C, "the command is not allowed in this mode", "it was probably reset; it is set up again"},
    {0x0D, "no tool is at this port", kPlug},
    {0x0E, "the port is not initialised", kPlug},
    {0x0F, "the port is not enabled", kPlug},
    {0x10, "the tracker is not initialised", "it was probably reset; it is set up again"},
    {0x11, "tracking cannot be stopped", kRestart},
    {0x12, "tracking cannot be started", kService},
    {0x13, "the tool cannot be initialised", kRom},
    {0x14, "the parameters of the measuring volume are wrong", kService},
    {0x15, "the tracker cannot be initialised", kService},
    {0x16, "the diagnostic mode cannot be started", kRestart},
    {0x17, "the diagnostic mode cannot be stopped", kRestart},
    {0x19, "the firmware's version cannot be read", kService},
    {0x1A, "an internal error of the tracker", kService},
    {0x1D, "the memory of the tool cannot be searched", kPlug},
    {0x1E, "the memory of the tool cannot be read", kRom},
    {0x1F, "the memory of the tool cannot be written", kRom},
    {0x20, "the memory of the tool cannot be selected", kPlug},
    {0x21, "the current of the tool cannot be tested", kPlug},
    {0x23, "a parameter of the command is out of range", kReport},
    {0x24, "the measuring volume cannot be selected", kService},
    {0x25, "the list of features cannot be read", kService},
    {0x29, "the main firmware is damaged", kService},
    {0x2A, "the memory of the tracker is full", "use fewer tools"},
    {0x2B, "the port was not allocated", kPlug},
    {0x2C, "the tool was unplugged meanwhile", kPlug},
    {0x2D, "all ports are in use", "use fewer tools"},
    {0x2E, "the versions of the firmware do not fit each other", kService},
    {0x31, "the state of the input or output is not known", kReport},
    {0x32, "the tool cannot do this", "check that its .rom file is meant for it"},
    {0x33, "the tracker does not have this feature", "check the tracker's licence"},
};

}  // namespace

std::string ndi_error_sentence(std::uint8_t code) {
  const std::string begin = "error " + ndi_to_hex(code, 2) + ": ";
  const auto* found = std::ranges::find(kErrors, code, &NdiSentence::code);
  if (found == std::end(kErrors)) {
    return begin + "its meaning is not known to Sonde; look it up in the guide of the tracker";
  }
  return begin + found->meaning + "; " + found->remedy;
}

std::string ndi_warning_sentence(std::uint8_t code) {
  if (code == 0)
    return "warning: the tool has an error that does not stop it; " + std::string(kRom);
  return "warning " + ndi_to_hex(code, 2) +
         ": its meaning is not known to Sonde; look it up in the guide of the tracker";
}

}  // namespace nav::devices
