// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nav/sample.hpp"

namespace nav::io::mcap {

/// Kind of a recorded sample; each has a layout of its own, docs/recording.md.
enum class SampleKind { kPose, kImage, kMissingImage, kButton, kColourImage };
inline constexpr std::size_t kSampleKinds = 5;

/// Name of the schema, with its version: "sonde.Pose.1", …
const char* schema_name(SampleKind kind);
/// Description of the layout, stored in the schema: the types and names of the fields.
std::string schema_text(SampleKind kind);
/// The kind with that schema name; absent for unknown kinds and versions.
std::optional<SampleKind> sample_kind(std::string_view schema_name);
SampleKind kind_of(const Sample& sample);

/// The bytes of a sample: those that were written, and pixels that stay in the sample.
struct EncodedSample {
  std::span<const std::byte> fields;
  std::span<const std::byte> pixels;
};
/// Writes all of a sample but its stream into \p buffer, which is cleared first. Every bit of every
/// number is kept. The result is valid while buffer and sample are.
EncodedSample encode(const Sample& sample, std::vector<std::byte>& buffer);
/// Reads a sample of a kind; its stream is 0. Absent when the bytes do not have the layout.
std::optional<Sample> decode(SampleKind kind, std::span<const std::byte> bytes);

}  // namespace nav::io::mcap
