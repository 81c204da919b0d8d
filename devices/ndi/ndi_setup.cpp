// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_setup.hpp"

#include <algorithm>
#include <utility>

#include "devices/ndi/ndi_errors.hpp"
#include "devices/ndi/ndi_hex.hpp"
#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr Duration kQuick = std::chrono::seconds(1);
constexpr Duration kUsual = std::chrono::seconds(5);
constexpr Duration kLong = std::chrono::seconds(12);  ///< Initialising reads the tool's memory.

bool is_good(const NdiReply& reply) {
  return reply.kind == NdiReplyKind::kOkay || reply.kind == NdiReplyKind::kWarning;
}

/// Clause about a reply that should be another one.
std::string sentence_of(const NdiReply& reply) {
  constexpr std::size_t kMostText = 40;
  switch (reply.kind) {
    case NdiReplyKind::kError:
      return ndi_error_sentence(reply.code);
    case NdiReplyKind::kWarning:
      return ndi_warning_sentence(reply.code);
    case NdiReplyKind::kBinary:
      return "an unexpected binary reply";
    default:
      return "the unexpected reply '" + std::string(reply.text.substr(0, kMostText)) + "'";
  }
}

std::string place_text(const std::optional<NdiPlace>& place) {
  if (!place) return "no port is left for it";
  std::string text = "no usable tool is at port " + std::to_string(place->port);
  if (place->channel != 0) text += ", channel " + std::to_string(place->channel);
  return text;
}

}  // namespace

NdiSetup::NdiSetup(std::vector<NdiTool> tools, int baud)
    : wanted_(std::move(tools)),
      baud_(baud),
      found_(wanted_.size()),
      phases_{&NdiSetup::start_tracking,   &NdiSetup::enable_tools, &NdiSetup::find_plugged,
              &NdiSetup::initialise_ports, &NdiSetup::load_tools,   &NdiSetup::free_ports,
              &NdiSetup::free_left_over,   &NdiSetup::raise_speed,  &NdiSetup::say_hello} {
  run_phases();
}

void NdiSetup::look_again() {
  tried_.clear();
  plugged_.clear();
  plugged_fault_.clear();
  phases_ = {&NdiSetup::start_tracking,   &NdiSetup::enable_tools, &NdiSetup::find_plugged,
             &NdiSetup::initialise_ports, &NdiSetup::load_tools,   &NdiSetup::free_ports};
  ask("TSTOP", "", kUsual, [](const NdiReply&) {});
}

void NdiSetup::take(const NdiReply& reply) {
  NAV_CHECK(!steps_.empty());
  const Asked asked = std::move(steps_.front());
  steps_.pop_front();
  asked.handler(reply);
  if (failure_) {
    steps_.clear();
    phases_.clear();
  }
  run_phases();
}

void NdiSetup::run_phases() {
  while (steps_.empty() && !phases_.empty()) {
    const Phase phase = phases_.back();
    phases_.pop_back();
    (this->*phase)();
  }
}

void NdiSetup::ask(std::string_view name, const std::string& arguments, Duration longest,
                   Handler handler) {
  steps_.push_back({{ndi_command(name, arguments), longest}, std::move(handler)});
}

void NdiSetup::fail(const NdiReply& reply, const std::string& what) {
  failure_ = what + ": " + sentence_of(reply);
}

void NdiSetup::with_handles(const char* which, const std::function<void(const NdiHandle&)>& use) {
  ask("PHSR", which, kUsual, [this, use](const NdiReply& reply) {
    if (reply.kind != NdiReplyKind::kText) return fail(reply, "the ports cannot be listed");
    const auto handles = read_ndi_handles(reply.text);
    if (!handles) {
      failure_ = handles.error().message;
      return;
    }
    for (const NdiHandle& one : *handles) use(one);
  });
}

void NdiSetup::say_hello() {
  // A tracker that another program has left tracking answers nothing else.
  ask("TSTOP", "", kQuick, [](const NdiReply&) {});
  ask("INIT", "", kLong, [this](const NdiReply& reply) {
    if (!is_good(reply)) fail(reply, "the tracker cannot be initialised");
  });
  ask("VER", "0", kUsual, [this](const NdiReply& reply) {
    if (reply.kind == NdiReplyKind::kText) version_ = read_ndi_version(reply.text);
  });
}

void NdiSetup::raise_speed() {
  const auto arguments = baud_ > 9600 ? ndi_comm_arguments(baud_) : std::nullopt;
  if (!arguments) return;
  ask("COMM", *arguments, kUsual, [this](const NdiReply& reply) {
    if (is_good(reply)) return;
    notes_.push_back("the line stays at a lower rate than " + std::to_string(baud_) +
                     " baud: " + sentence_of(reply));
    const auto& rates = ndi_baud_rates();
    baud_ = *std::prev(std::ranges::find(rates, baud_));
    phases_.push_back(&NdiSetup::raise_speed);
  });
  steps_.back().step.repeatable = false;
  steps_.back().step.baud = baud_;
}

/// A tracker that was not reset still holds the wireless tools of the program before.
void NdiSetup::free_left_over() {
  with_handles("00", [this](const NdiHandle& port) {
    const std::string handle = ndi_to_hex(port.handle, 2);
    ask("PHINF", handle + "0021", kUsual, [this, handle](const NdiReply& reply) {
      const auto info = read_ndi_tool_info(reply.text);
      if (reply.kind != NdiReplyKind::kText || !info || info->wired) return;
      ask("PHF", handle, kUsual, [](const NdiReply&) {});
    });
  });
}

void NdiSetup::free_ports() {
  with_handles("01", [this](const NdiHandle& port) {
    ask("PHF", ndi_to_hex(port.handle, 2), kUsual, [](const NdiReply&) {});
  });
}

void NdiSetup::load_tools() {
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    if (!wanted_[i].rom.empty() && !found_[i].handle) load(i);
  }
}

void NdiSetup::load(std::size_t tool) {
  auto rom = read_ndi_rom(wanted_[tool].rom);
  if (!rom) {
    found_[tool].fault = rom.error().message;
    return;
  }
  ask("PHRQ", "*********1****", kUsual, [this, tool, rom = *rom](const NdiReply& reply) {
    const auto handle = ndi_from_hex<std::uint8_t>(reply.text);
    if (reply.kind != NdiReplyKind::kText || !handle) {
      found_[tool].fault = "no port for a wireless tool: " + sentence_of(reply);
      return;
    }
    found_[tool] = {.handle = *handle};
    upload(tool, *handle, rom);
  });
}

/// Puts the upload before the other steps, so that one tool is loaded after the other.
void NdiSetup::upload(std::size_t tool, std::uint8_t handle, const std::string& rom) {
  std::deque<Asked> others = std::exchange(steps_, {});
  for (std::size_t at = 0; at < rom.size(); at += kNdiRomChunk) {
    ask("PVWR", ndi_rom_arguments(handle, rom, at), kUsual, [=, this](const NdiReply& reply) {
      if (is_good(reply) || !found_[tool].handle) return;
      give_up_tool(handle, wanted_[tool].rom.string() +
                               " cannot be loaded into the tracker: " + sentence_of(reply));
    });
  }
  std::ranges::move(others, std::back_inserter(steps_));
}

/// Initialising a port may show others, such as a second tool in one plug.
void NdiSetup::initialise_ports() {
  const auto before = tried_.size();
  with_handles("02", [this](const NdiHandle& port) {
    if (std::ranges::count(tried_, port.handle) > 0) return;
    tried_.push_back(port.handle);
    ask("PINIT", ndi_to_hex(port.handle, 2), kLong,
        [this, handle = port.handle](const NdiReply& reply) { take_initialised(handle, reply); });
  });
  const Handler list = steps_.back().handler;
  steps_.back().handler = [this, before, list](const NdiReply& reply) {
    list(reply);
    if (tried_.size() > before) phases_.push_back(&NdiSetup::initialise_ports);
  };
}

void NdiSetup::take_initialised(std::uint8_t handle, const NdiReply& reply) {
  const auto tool = tool_of(handle);
  const std::string name = tool ? wanted_[*tool].name : "port handle " + ndi_to_hex(handle, 2);
  if (reply.kind == NdiReplyKind::kWarning) notes_.push_back(name + ": " + sentence_of(reply));
  if (!is_good(reply)) give_up_tool(handle, sentence_of(reply));
}

void NdiSetup::find_plugged() {
  with_handles("00", [this](const NdiHandle& port) {
    constexpr std::uint16_t kInitialised = 1U << 4;
    if ((port.status & kInitialised) == 0 || tool_of(port.handle)) return;
    ask("PHINF", ndi_to_hex(port.handle, 2) + "0021", kUsual,
        [this, handle = port.handle](const NdiReply& reply) {
          if (reply.kind != NdiReplyKind::kText) return;
          const auto info = read_ndi_tool_info(reply.text);
          if (info && info->wired) plugged_.push_back({{info->port, info->channel}, handle});
        });
  });
}

void NdiSetup::assign_plugged() {
  const auto is_taken = [&](const Plugged& one) {
    return tool_of(one.handle) || std::ranges::any_of(wanted_, [&](const NdiTool& tool) {
             return tool.place == one.place;
           });
  };
  std::ranges::sort(plugged_, {}, &Plugged::place);
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    if (!wanted_[i].rom.empty() || found_[i].handle) continue;
    const auto& place = wanted_[i].place;
    const auto found = std::ranges::find_if(
        plugged_, [&](const Plugged& one) { return place ? one.place == *place : !is_taken(one); });
    if (found != plugged_.end()) {
      found_[i] = {.handle = found->handle};
    } else {
      found_[i].fault =
          place_text(place) + "; " +
          (plugged_fault_.empty() ? "plug it in" : "a tool failed: " + plugged_fault_);
    }
  }
}

void NdiSetup::enable_tools() {
  assign_plugged();
  bool any = false;
  for (const Tool& tool : found_) {
    if (!tool.handle) continue;
    any = true;
    ask("PENA", ndi_to_hex(*tool.handle, 2) + "D", kUsual,
        [this, handle = *tool.handle](const NdiReply& reply) {
          if (!is_good(reply)) give_up_tool(handle, "it cannot be enabled: " + sentence_of(reply));
        });
  }
  if (!any) failure_ = "none of the tools can be tracked";
}

void NdiSetup::start_tracking() {
  if (failure_) return;
  if (std::ranges::none_of(found_, [](const Tool& tool) { return tool.handle.has_value(); })) {
    failure_ = "none of the tools can be tracked";
    return;
  }
  ask("TSTART", "", kUsual, [this](const NdiReply& reply) {
    if (!is_good(reply)) fail(reply, "tracking does not begin");
  });
  steps_.back().step.repeatable = false;
}

void NdiSetup::give_up_tool(std::uint8_t handle, const std::string& why) {
  if (const auto tool = tool_of(handle)) {
    found_[*tool] = {.fault = why};
    if (!wanted_[*tool].rom.empty()) {
      ask("PHF", ndi_to_hex(handle, 2), kUsual, [](const NdiReply&) {});
    }
  } else {
    plugged_fault_ = why;
  }
}

std::optional<std::size_t> NdiSetup::tool_of(std::uint8_t handle) const {
  for (std::size_t i = 0; i < found_.size(); ++i) {
    if (found_[i].handle == handle) return i;
  }
  return std::nullopt;
}

}  // namespace nav::devices
