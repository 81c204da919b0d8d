// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_source.hpp"

#include <algorithm>
#include <array>

#include "devices/ndi/ndi_errors.hpp"
#include "devices/ndi/ndi_hex.hpp"

namespace nav::devices {
namespace {

constexpr const char* kPortUnplugged = "it was unplugged; plug it in again";
constexpr std::size_t kReadBytes = std::size_t{1} << 14;
constexpr int kMostFailures = 3;
constexpr Duration kQuiet = std::chrono::milliseconds(30);
constexpr Duration kLongestDrain = std::chrono::milliseconds(500);
constexpr Duration kSpeedChange = std::chrono::milliseconds(150);
constexpr Duration kLookAgain = std::chrono::seconds(2);

}  // namespace

Result<std::unique_ptr<NdiSource>> NdiSource::create(NdiOptions options,
                                                     std::unique_ptr<NdiTransport> transport,
                                                     const Clock& clock, Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<NdiSource>(
      new NdiSource(std::move(options), std::move(transport), clock, diagnostics));
}

NdiSource::NdiSource(NdiOptions options, std::unique_ptr<NdiTransport> transport,
                     const Clock& clock, Diagnostics& diagnostics)
    : PolledSource(clock, diagnostics, "devices.ndi"),
      options_(std::move(options)),
      transport_(std::move(transport)),
      due_(clock.now()),
      baud_(options_.baud),
      form_(options_.form),
      tracks_(options_.streams.size()),
      retry_(options_.first_retry, options_.longest_retry) {
  for (const NdiStream& stream : options_.streams) {
    add_stream({stream.tool.name, StreamKind::kPoses, stream.role});
    // The reply to BX2 does not say that a tool was plugged in.
    if (stream.tool.rom.empty() && form_ == NdiForm::kBx2) form_ = NdiForm::kBx;
  }
  health_.samples.resize(streams().size());
  health_.tool_faults.resize(streams().size());
  health_.form = form_;
}

NdiHealth NdiSource::account() const {
  const std::lock_guard lock(mutex_);
  NdiHealth health = health_;
  if (is_stopped()) health.state = NdiState::kStopped;
  return health;
}

SourceHealth NdiSource::health() const { return source_health(account()); }

Watched NdiSource::watched() const {
  const bool connecting = state_ == NdiState::kConnecting;
  return {.fd = transport_->descriptor(),
          .read = !connecting,
          .write = connecting || (asked_ && sent_ < question_.size())};
}

void NdiSource::set_state(NdiState state, Timestamp due) {
  due_ = due;
  if (state == state_) return;
  state_ = state;
  const std::lock_guard lock(mutex_);
  health_.state = state;
}

bool NdiSource::is_tracking() const {
  return state_ == NdiState::kTracking || state_ == NdiState::kSilent;
}

/// Does what is due.
void NdiSource::advance(Timestamp now) {
  switch (state_) {
    case NdiState::kWaiting:
      return open(now);
    case NdiState::kConnecting:
      return lose({"connect_timeout", "no answer within " + ndi_seconds(options_.connect_timeout)});
    case NdiState::kResetting:
      if (!break_on_) return begin_setup(now);
      break_on_ = false;
      transport_->set_break(false);
      due_ = now + options_.reset_wait;
      return;
    case NdiState::kSetup:
    case NdiState::kTracking:
    case NdiState::kSilent:
      if (draining_) return repeat_question(now);
      if (asked_) return no_reply(now);
      if (switch_to_baud_ != 0) {
        if (auto failure = transport_->set_baud(switch_to_baud_)) return lose(*failure);
        switch_to_baud_ = 0;
        raised_ = true;
        return go_on_with_setup(now);
      }
      return ask_for_poses(now);
    case NdiState::kStopped:
      due_ = Timestamp::max();
      return;
  }
}

void NdiSource::open(Timestamp now) {
  buffer_.clear();
  filled_ = 0;
  asked_ = draining_ = raised_ = false;
  switch_to_baud_ = 0;
  if (const auto failure = transport_->open()) return lose(*failure);
  if (transport_->is_serial()) {
    break_on_ = true;
    transport_->set_break(true);
    set_state(NdiState::kResetting, now + options_.break_time);
  } else {
    set_state(NdiState::kConnecting, now + options_.connect_timeout);
  }
}

void NdiSource::begin_setup(Timestamp now) {
  filled_ = 0;
  std::vector<NdiTool> tools;
  for (const NdiStream& stream : options_.streams) tools.push_back(stream.tool);
  setup_.emplace(std::move(tools), transport_->is_serial() ? baud_ : 0);
  tracks_.begin();
  set_state(NdiState::kSetup, now);
  go_on_with_setup(now);
}

void NdiSource::attend(bool readable, bool writable) {
  if (transport_->descriptor() < 0) return;
  if (state_ == NdiState::kConnecting) {
    if (!writable) return;
    if (const auto failure = transport_->finish()) return lose(*failure);
    return begin_setup(clock().now());
  }
  if (readable) receive();
  if (writable && asked_ && sent_ < question_.size()) send_rest();
}

void NdiSource::receive() {
  if (buffer_.size() < filled_ + kReadBytes) buffer_.resize(filled_ + kReadBytes);
  const TcpTransfer got = transport_->receive(std::span(buffer_).subspan(filled_));
  const Timestamp now = clock().now();
  if (got.bytes > 0) {
    {
      const std::lock_guard lock(mutex_);
      health_.bytes += got.bytes;
    }
    if (draining_) {
      due_ = std::min(now + kQuiet, drain_end_);
    } else {
      filled_ += got.bytes;
      read_replies(now);
    }
  }
  if (got.failure) lose(*got.failure);
}

void NdiSource::read_replies(Timestamp now) {
  while (filled_ > 0 && !draining_ && transport_->descriptor() >= 0) {
    const NdiFraming framing = frame_ndi_reply(std::span(buffer_).first(filled_));
    if (framing.size == 0) return;
    if (framing.fault && state_ != NdiState::kResetting) {
      return bad_reply(to_string(*framing.fault), now);
    }
    if (!framing.fault) take_reply(framing.reply, now);
    if (framing.size > filled_) return;  // Taking it has emptied the buffer.
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(framing.size),
              buffer_.begin() + static_cast<std::ptrdiff_t>(filled_), buffer_.begin());
    filled_ -= framing.size;
  }
}

void NdiSource::take_reply(const NdiReply& reply, Timestamp now) {
  if (state_ == NdiState::kResetting) {
    // Before the end of BREAK the lines are not in step yet.
    if (reply.kind == NdiReplyKind::kReset && !break_on_) begin_setup(now);
    return;
  }
  if (!asked_ || reply.kind == NdiReplyKind::kReset) return take_unasked(reply);
  asked_ = false;
  raised_ = false;
  const bool was_repeated = failures_ > 0;
  if (is_tracking()) {
    take_tracking_reply(reply, now);
  } else {
    take_setup_reply(reply, now);
  }
  // The first question may be answered too, after all.
  if (was_repeated && !asked_ && is_tracking()) drain(now);
}

void NdiSource::take_unasked(const NdiReply& reply) {
  if (reply.kind == NdiReplyKind::kReset) {
    return lose({"reset", "the tracker was reset; it is set up again"});
  }
  const std::lock_guard lock(mutex_);
  ++health_.bad_replies["unasked"];
}

void NdiSource::take_setup_reply(const NdiReply& reply, Timestamp now) {
  const int baud = setup_->step()->baud;
  const bool switches = baud != 0 && reply.kind == NdiReplyKind::kOkay;
  const bool was_repeated = failures_ > 0;
  setup_->take(reply);
  failures_ = 0;
  for (const std::string& note : setup_->notes()) report_once(Severity::kWarning, note);
  if (switches) {
    switch_to_baud_ = baud;
    due_ = now + kSpeedChange;
    return;
  }
  // The first question may be answered too, after all.
  if (was_repeated && setup_->step() != nullptr) return drain(now);
  go_on_with_setup(now);
}

void NdiSource::go_on_with_setup(Timestamp now) {
  for (std::size_t i = 0; i < streams().size(); ++i) {
    const std::string& fault = setup_->tools()[i].fault;
    if (!fault.empty()) report_once(Severity::kWarning, streams()[i].name + ": " + fault);
    const std::lock_guard lock(mutex_);
    health_.tool_faults[i] = fault;
  }
  if (setup_->failure()) return lose({"setup", *setup_->failure()});
  const NdiStep* step = setup_->step();
  if (step == nullptr) return setup_done(now);
  failures_ = 0;
  ask(step->command, step->longest, now);
}

void NdiSource::setup_done(Timestamp now) {
  const NdiVersion& version = setup_->version();
  tracks_.assign(setup_->tools(), version.firmware);
  reported_loss_.clear();
  const bool again = look_again_ != Timestamp{};
  if (!again) {
    const std::lock_guard lock(mutex_);
    ++health_.connections;
    health_.version = version;
  }
  look_again_ = now + kLookAgain;
  report(Severity::kInfo, "tracking: " + version.firmware + " " + version.serial);
  answered_ = now;
  set_state(NdiState::kTracking, now);
}

void NdiSource::ask_for_poses(Timestamp now) {
  failures_ = 0;
  ask(ndi_form_command(form_), options_.silence, now);
}

void NdiSource::ask(const std::string& command, Duration longest, Timestamp now) {
  question_ = command;
  longest_ = longest;
  sent_ = 0;
  asked_ = true;
  asked_at_ = now;
  due_ = now + longest;
  send_rest();
}

void NdiSource::send_rest() {
  const auto bytes = std::as_bytes(std::span(question_)).subspan(sent_);
  const TcpTransfer sent = transport_->send(bytes);
  sent_ += sent.bytes;
  if (sent.failure) lose(*sent.failure);
}

/// The time for a reply is over.
void NdiSource::no_reply(Timestamp now) {
  const bool begun = filled_ > 0;
  if (is_tracking()) {
    if (now - answered_ >= options_.lost) {
      return lose({"silent", "nothing has come for " + ndi_seconds(options_.lost)});
    }
    if (state_ != NdiState::kSilent && !begun) {
      {
        const std::lock_guard lock(mutex_);
        ++health_.silences;
      }
      set_state(NdiState::kSilent, now);
      report_once(Severity::kWarning, "nothing has come for " + ndi_seconds(options_.silence));
    }
  }
  bad_reply(begun ? to_string(NdiFault::kTruncated) : "no_reply", now);
}

/// A reply that cannot be used: when the line is quiet, the question is asked again.
void NdiSource::bad_reply(const std::string& cause, Timestamp now) {
  {
    const std::lock_guard lock(mutex_);
    ++health_.bad_replies[cause];
  }
  report_once(Severity::kWarning, "a reply could not be used: " + cause);
  const bool expected = asked_;
  if (state_ == NdiState::kSetup && expected) {
    const NdiStep* step = setup_->step();
    if (step == nullptr || !step->repeatable || failures_ + 1 >= kMostFailures) {
      if (raised_) {
        const auto& rates = ndi_baud_rates();
        const auto rate = std::ranges::find(rates, baud_);
        if (rate != rates.begin()) baud_ = *std::prev(rate);
      }
      return lose({cause == "no_reply" ? "no_reply" : "bad_replies",
                   raised_ ? "nothing comes at the higher baud rate; a lower one is tried"
                           : "the tracker does not answer as expected; check that it is an NDI "
                             "tracker, switched on and not in use"});
    }
  }
  if (expected) ++failures_;
  if (is_tracking() && now - answered_ >= options_.lost) {
    return lose({"bad_replies", "no intact reply for " + ndi_seconds(options_.lost)});
  }
  drain(now);
}

void NdiSource::drain(Timestamp now) {
  filled_ = 0;
  draining_ = true;
  drain_end_ = now + kLongestDrain;
  due_ = now + kQuiet;
}

/// After draining: the lost reply is asked for again, or what was due goes on.
void NdiSource::repeat_question(Timestamp now) {
  draining_ = false;
  if (asked_) return ask(question_, longest_, now);
  if (switch_to_baud_ != 0) {
    due_ = now;
    return;
  }
  if (state_ == NdiState::kSetup) return go_on_with_setup(now);
  ask_for_poses(now);
}

void NdiSource::take_tracking_reply(const NdiReply& reply, Timestamp now) {
  if (reply.kind == NdiReplyKind::kError) return take_tracking_error(reply, now);
  if (const auto read = read_ndi_poses(form_, reply, readings_); !read) {
    report_once(Severity::kWarning, read.error().message);
    return bad_reply(to_string(NdiFault::kLayout), now);
  }
  answered_ = now;
  if (state_ == NdiState::kSilent) {
    report(Severity::kInfo, "replies come again");
    forget_report("nothing has come for " + ndi_seconds(options_.silence));
  }
  retry_.reset();
  const std::size_t before = ready().size();
  take_readings(now);
  const Duration pause = ready().size() > before ? Duration(0) : options_.idle_period;
  set_state(NdiState::kTracking, std::max(now + pause, asked_at_ + options_.shortest_period));
  look_for_plugged(now);
}

void NdiSource::take_tracking_error(const NdiReply& reply, Timestamp now) {
  if (const auto next = ndi_form_after(form_, reply.code)) {
    form_ = *next;
    {
      const std::lock_guard lock(mutex_);
      health_.form = form_;
    }
    due_ = now;
    return;
  }
  const std::string cause = "error_" + ndi_to_hex(reply.code, 2);
  {
    const std::lock_guard lock(mutex_);
    ++health_.bad_replies[cause];
  }
  const bool was_reset = reply.code == kNdiWrongMode || reply.code == kNdiNotInitialised;
  if (was_reset) return lose({"reset", ndi_error_sentence(reply.code)});
  report_once(Severity::kWarning, ndi_error_sentence(reply.code));
  if (now - answered_ >= options_.lost) return lose({"errors", ndi_error_sentence(reply.code)});
  due_ = now + options_.silence;
}

void NdiSource::take_readings(Timestamp now) {
  const std::size_t before = ready().size();
  const NdiTracks::Taken taken = tracks_.take(readings_, now, ready());
  for (const std::size_t stream : taken.unplugged) {
    report_once(Severity::kWarning, streams()[stream].name + ": " + kPortUnplugged);
  }
  const std::lock_guard lock(mutex_);
  health_.repeats += taken.repeats;
  health_.undeclared += taken.undeclared;
  for (const std::size_t stream : taken.unplugged) health_.tool_faults[stream] = kPortUnplugged;
  for (std::size_t i = before; i < ready().size(); ++i) ++health_.samples[ready()[i].stream];
}

/// Sets ports up again when the tracker says that a tool was plugged in, and one is wanted.
void NdiSource::look_for_plugged(Timestamp now) {
  if ((readings_.system_status & kNdiPortOccupied) == 0 || now < look_again_) return;
  bool wanted = false;
  for (std::size_t i = 0; i < streams().size(); ++i) {
    if (!options_.streams[i].tool.rom.empty() || tracks_.is_usable(i)) continue;
    setup_->forget(i);
    wanted = true;
  }
  if (!wanted) return;
  setup_->look_again();
  forget_reports();
  set_state(NdiState::kSetup, now);
  go_on_with_setup(now);
}

void NdiSource::lose(const TcpFailure& failure) {
  transport_->close();
  const bool was_tracking = look_again_ != Timestamp{};
  filled_ = 0;
  asked_ = draining_ = false;
  look_again_ = {};
  const Timestamp now = clock().now();
  {
    const std::lock_guard lock(mutex_);
    health_.cause = failure.cause;
    ++health_.losses[failure.cause];
  }
  if (reported_loss_ != failure.message) {
    reported_loss_ = failure.message;
    report(Severity::kWarning, failure.message + "; it is tried again");
  }
  if (was_tracking) {
    retry_.reset();
    forget_reports();
  }
  set_state(NdiState::kWaiting, now + retry_.take());
}

}  // namespace nav::devices
