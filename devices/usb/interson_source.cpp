// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/interson_source.hpp"

#include <utility>

namespace nav::devices {
namespace {

/// 16 lines, which take 4 ms at 15 images a second.
constexpr std::size_t kIntersonTransfer = 16 * kIntersonLineBytes;
constexpr int kIntersonQueued = 8;

}  // namespace

Result<void> validate(const IntersonOptions& options) {
  if (options.image.empty()) {
    return Error{ErrorCode::kUsage, "Interson probe: expected a name of the images, found none"};
  }
  if (auto ok = validate(options.settings); !ok) return ok;
  if (auto ok = validate(options.shape); !ok) return ok;
  return validate(options.times);
}

Result<std::unique_ptr<IntersonSource>> IntersonSource::create(IntersonOptions options,
                                                               std::string name, UsbOpener open,
                                                               const Clock& clock,
                                                               Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<IntersonSource>(
      new IntersonSource(std::move(options), std::move(name), std::move(open), clock, diagnostics));
}

IntersonSource::IntersonSource(IntersonOptions options, std::string name, UsbOpener open,
                               const Clock& clock, Diagnostics& diagnostics)
    : UsbSource(std::move(name), options.times, std::move(open), clock, diagnostics,
                "devices.interson"),
      options_(std::move(options)),
      scan_(options_.shape, kIntersonLines, kIntersonSamples) {
  add_stream({options_.image, StreamKind::kImages});
}

void IntersonSource::write(const std::vector<IntersonWrite>& writes) {
  for (const IntersonWrite& one : writes) {
    link().control(interson_write_setup(one.reg), {std::byte{one.value}});
  }
}

void IntersonSource::begin(Timestamp now) {
  phase_ = Phase::kSetup;
  set_step(now);
}

Timestamp IntersonSource::step(Timestamp now) {
  switch (phase_) {
    case Phase::kSetup:
      write(interson_setup(options_.settings));
      phase_ = Phase::kMotor;
      return now + kIntersonMotorStart;
    case Phase::kMotor:
      assembler_.restart();
      link().keep_reading(kIntersonIn, kIntersonTransfer, kIntersonQueued);
      write(interson_start());
      phase_ = Phase::kScanning;
      expect(now);
      return Timestamp::max();
    case Phase::kScanning:
      break;
  }
  return Timestamp::max();
}

void IntersonSource::end() { write(interson_stop()); }

void IntersonSource::control_failed(UsbEnd end) {
  if (phase_ == Phase::kScanning) return;
  lose({"setup", std::string("the probe rejects its setup (") + to_string(end) + ")"});
}

void IntersonSource::take(const UsbTransfer& transfer, Timestamp received) {
  if (transfer.endpoint != kIntersonIn) return;
  assembler_.take(transfer.bytes, received,
                  [&](IntersonNews&& news) { take_news(std::move(news), received); });
}

void IntersonSource::take_news(IntersonNews&& news, Timestamp received) {
  if (news.kind == IntersonNews::Kind::kBad) return count(news.cause);
  heard(received);
  sequence_ += news.advance;
  if (news.advance > 1) count("lost_images", news.advance - 1);
  Sample sample{.sequence = sequence_, .received = received};
  if (news.kind == IntersonNews::Kind::kIncomplete) {
    const std::string message = "expected " + std::to_string(kIntersonLines) +
                                " lines of an image, found " + std::to_string(news.lines);
    count("incomplete");
    report_once(Severity::kWarning, "incomplete", message + "; it is not shown");
    sample.what = MissingImage{"incomplete", message};
  } else {
    UltrasoundImage image;
    image.acquired = news.begun + (news.ended - news.begun) / 2;
    image.received = received;
    image.sequence = sequence_;
    image.pixels = scan_.convert(news.samples);
    image.grid = scan_.grid();
    image.outline = scan_.outline();
    sample.what = std::move(image);
  }
  deliver(std::move(sample));
}

}  // namespace nav::devices
