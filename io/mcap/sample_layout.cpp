// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/sample_layout.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "io/mcap/mcap_bytes.hpp"
#include "nav/check.hpp"

namespace nav::io::mcap {
namespace {

// Bits of the flags of a pose or an image.
constexpr std::uint8_t kClockUnsure = 1;
constexpr std::uint8_t kHasTrackerError = 2;
constexpr std::uint8_t kHasOutline = 2;
constexpr std::uint8_t kKnownFlags = 3;

/// Numbers of the statuses in the file; they never change.
constexpr std::array kStatuses = {TrackingStatus::kOk,       TrackingStatus::kUnknown,
                                  TrackingStatus::kOccluded, TrackingStatus::kOutOfVolume,
                                  TrackingStatus::kTimeout,  TrackingStatus::kInvalid};

std::uint8_t status_number(TrackingStatus status) {
  for (std::size_t i = 0; i < kStatuses.size(); ++i) {
    if (kStatuses[i] == status) return static_cast<std::uint8_t>(i);
  }
  return std::numeric_limits<std::uint8_t>::max();
}

void put_time(ByteWriter& out, Timestamp time) { out.signed64(time.time_since_epoch().count()); }
Timestamp take_time(ByteReader& from) { return Timestamp(Duration(from.signed64())); }

void put_fields(ByteWriter& out, const PoseSample& sample) {
  const RawPose& pose = sample.pose;
  put_time(out, pose.acquired);
  put_time(out, pose.received);
  out.number(status_number(pose.status));
  out.number(static_cast<std::uint8_t>((pose.clock_unsure ? kClockUnsure : 0) |
                                       (sample.tracker_error_mm ? kHasTrackerError : 0)));
  out.float64(sample.tracker_error_mm.value_or(0.0));
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) out.float64(pose.tracker_from_body(row, column));
  }
}

void put_fields(ByteWriter& out, const UltrasoundImage& image) {
  put_time(out, image.acquired);
  put_time(out, image.received);
  out.number(image.sequence);
  out.number(static_cast<std::uint8_t>((image.clock_unsure ? kClockUnsure : 0) |
                                       (image.outline ? kHasOutline : 0)));
  const Eigen::Matrix2d& mm = image.grid.mm_per_pixel;
  for (const double value : {mm(0, 0), mm(0, 1), mm(1, 0), mm(1, 1), image.grid.origin_mm.x(),
                             image.grid.origin_mm.y()}) {
    out.float64(value);
  }
  const SectorOutline outline = image.outline.value_or(SectorOutline{{0, 0}, 0, 0, 0});
  for (const double value : {outline.apex_mm.x(), outline.apex_mm.y(), outline.radius_min_mm,
                             outline.radius_max_mm, outline.half_angle_rad}) {
    out.float64(value);
  }
  out.number(static_cast<std::uint32_t>(image.pixels.width()));
  out.number(static_cast<std::uint32_t>(image.pixels.height()));
}

void put_fields(ByteWriter& out, const MissingImage& missing) {
  out.text(missing.cause);
  out.text(missing.message);
}

void put_fields(ByteWriter& out, const ButtonSample& button) {
  put_time(out, button.acquired);
  out.number(static_cast<std::uint8_t>(button.pressed ? 1 : 0));
}

std::optional<PoseSample> take_pose(ByteReader& from) {
  PoseSample sample;
  sample.pose.acquired = take_time(from);
  sample.pose.received = take_time(from);
  const auto status = from.number<std::uint8_t>();
  const auto flags = from.number<std::uint8_t>();
  const double error_mm = from.float64();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      sample.pose.tracker_from_body(row, column) = from.float64();
    }
  }
  if (!from.done() || status >= kStatuses.size() || flags > kKnownFlags) return std::nullopt;
  sample.pose.status = kStatuses[status];
  sample.pose.clock_unsure = (flags & kClockUnsure) != 0;
  if ((flags & kHasTrackerError) != 0) sample.tracker_error_mm = error_mm;
  return sample;
}

std::optional<SectorOutline> take_outline(ByteReader& from, bool is_there) {
  SectorOutline outline;
  outline.apex_mm.x() = from.float64();
  outline.apex_mm.y() = from.float64();
  outline.radius_min_mm = from.float64();
  outline.radius_max_mm = from.float64();
  outline.half_angle_rad = from.float64();
  if (!is_there) return std::nullopt;
  return outline;
}

template <class Pixel>
std::vector<Pixel> take_pixels(ByteReader& from) {
  const auto bytes = from.bytes(from.left());
  std::vector<Pixel> pixels(bytes.size() / sizeof(Pixel));
  if (!pixels.empty()) std::memcpy(pixels.data(), bytes.data(), bytes.size());
  return pixels;
}

std::optional<UltrasoundImage> take_image(ByteReader& from, bool colours) {
  UltrasoundImage image;
  image.acquired = take_time(from);
  image.received = take_time(from);
  image.sequence = from.number<std::uint64_t>();
  const auto flags = from.number<std::uint8_t>();
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) {
      image.grid.mm_per_pixel(row, column) = from.float64();
    }
  }
  image.grid.origin_mm.x() = from.float64();
  image.grid.origin_mm.y() = from.float64();
  image.outline = take_outline(from, (flags & kHasOutline) != 0);
  image.clock_unsure = (flags & kClockUnsure) != 0;
  const auto width = from.number<std::uint32_t>();
  const auto height = from.number<std::uint32_t>();
  const std::size_t sizeof_pixel = colours ? sizeof(Rgb8) : 1;
  constexpr std::uint32_t kMostSide = std::numeric_limits<std::int32_t>::max();
  if (!from.ok() || flags > kKnownFlags || width > kMostSide || height > kMostSide ||
      from.left() % sizeof_pixel != 0 ||
      std::uint64_t{width} * height != from.left() / sizeof_pixel) {
    return std::nullopt;
  }
  const auto w = static_cast<int>(width);
  const auto h = static_cast<int>(height);
  if (colours) {
    image.colours = {w, h, take_pixels<Rgb8>(from)};
    image.pixels = luma(image.colours);
  } else {
    image.pixels = {w, h, take_pixels<std::uint8_t>(from)};
  }
  return image;
}

std::optional<MissingImage> take_missing(ByteReader& from) {
  MissingImage missing;
  missing.cause = from.text();
  missing.message = from.text();
  if (!from.done()) return std::nullopt;
  return missing;
}

std::optional<ButtonSample> take_button(ByteReader& from) {
  ButtonSample button;
  button.acquired = take_time(from);
  const auto pressed = from.number<std::uint8_t>();
  if (!from.done() || pressed > 1) return std::nullopt;
  button.pressed = pressed == 1;
  return button;
}

template <class Part>
bool set(Sample& sample, std::optional<Part> part) {
  if (!part) return false;
  sample.what = *std::move(part);
  return true;
}

bool take_fields(Sample& sample, SampleKind kind, ByteReader& from) {
  switch (kind) {
    case SampleKind::kPose:
      return set(sample, take_pose(from));
    case SampleKind::kImage:
      return set(sample, take_image(from, false));
    case SampleKind::kColourImage:
      return set(sample, take_image(from, true));
    case SampleKind::kMissingImage:
      return set(sample, take_missing(from));
    case SampleKind::kButton:
      return set(sample, take_button(from));
  }
  return false;
}

// Every chunk repeats these texts, so they are short; docs/recording.md explains the fields.
constexpr const char* kHeadText =
    "u64 sequence, i64 received_ns, u8 has_device_time, i64 device_time_ns, ";
constexpr const char* kPoseText =
    "i64 acquired_ns, i64 pose_received_ns, u8 status, u8 flags, f64 tracker_error_mm, "
    "f64[4][4] tracker_from_body_mm";
constexpr const char* kImageText =
    "i64 acquired_ns, i64 image_received_ns, u64 image_sequence, u8 flags, f64[2][2] mm_per_pixel, "
    "f64[2] origin_mm, f64[5] outline_mm_rad, u32 width, u32 height, ";
constexpr const char* kGreyText = "u8[height][width] pixels";
constexpr const char* kColourText = "u8[height][width][3] rgb";
constexpr const char* kButtonText = "i64 acquired_ns, u8 pressed";
constexpr const char* kMissingText = "u32 size, u8[size] cause, u32 size, u8[size] message";

}  // namespace

const char* schema_name(SampleKind kind) {
  switch (kind) {
    case SampleKind::kPose:
      return "sonde.Pose.1";
    case SampleKind::kImage:
      return "sonde.Image.1";
    case SampleKind::kColourImage:
      return "sonde.ColourImage.1";
    case SampleKind::kButton:
      return "sonde.Button.1";
    case SampleKind::kMissingImage:
      break;
  }
  return "sonde.MissingImage.1";
}

std::string schema_text(SampleKind kind) {
  const std::string head = kHeadText;
  switch (kind) {
    case SampleKind::kPose:
      return head + kPoseText;
    case SampleKind::kImage:
      return head + kImageText + kGreyText;
    case SampleKind::kColourImage:
      return head + kImageText + kColourText;
    case SampleKind::kButton:
      return head + kButtonText;
    case SampleKind::kMissingImage:
      break;
  }
  return head + kMissingText;
}

std::optional<SampleKind> sample_kind(std::string_view name) {
  for (const SampleKind kind : {SampleKind::kPose, SampleKind::kImage, SampleKind::kMissingImage,
                                SampleKind::kButton, SampleKind::kColourImage}) {
    if (name == schema_name(kind)) return kind;
  }
  return std::nullopt;
}

SampleKind kind_of(const Sample& sample) {
  if (std::holds_alternative<PoseSample>(sample.what)) return SampleKind::kPose;
  if (std::holds_alternative<ButtonSample>(sample.what)) return SampleKind::kButton;
  const auto* image = std::get_if<UltrasoundImage>(&sample.what);
  if (image == nullptr) return SampleKind::kMissingImage;
  return image->colours.empty() ? SampleKind::kImage : SampleKind::kColourImage;
}

EncodedSample encode(const Sample& sample, std::vector<std::byte>& buffer) {
  buffer.clear();
  ByteWriter out(buffer);
  out.number(sample.sequence);
  put_time(out, sample.received);
  out.number(static_cast<std::uint8_t>(sample.device_time ? 1 : 0));
  out.signed64(sample.device_time.value_or(DeviceTime{}).time_since_epoch().count());
  std::visit([&](const auto& what) { put_fields(out, what); }, sample.what);
  const auto* image = std::get_if<UltrasoundImage>(&sample.what);
  if (image == nullptr) return {buffer, {}};
  if (image->colours.empty()) return {buffer, std::as_bytes(image->pixels.pixels())};
  NAV_CHECK(image->colours.width() == image->pixels.width() &&
                image->colours.height() == image->pixels.height(),
            image->colours.width(), image->colours.height());
  return {buffer, std::as_bytes(image->colours.pixels())};
}

std::optional<Sample> decode(SampleKind kind, std::span<const std::byte> bytes) {
  ByteReader from(bytes);
  Sample sample;
  sample.sequence = from.number<std::uint64_t>();
  sample.received = take_time(from);
  const auto has_device_time = from.number<std::uint8_t>();
  const DeviceTime device_time{DeviceClock::duration(from.signed64())};
  if (!from.ok() || has_device_time > 1) return std::nullopt;
  if (has_device_time == 1) sample.device_time = device_time;
  if (!take_fields(sample, kind, from)) return std::nullopt;
  return sample;
}

}  // namespace nav::io::mcap
