// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/calibration_file.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "io/sequence.hpp"
#include "io/transform_tree.hpp"

namespace nav::session {
namespace {

bool is_sequence_name(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  constexpr std::array<std::string_view, 4> kEndings{".mha", ".mhd", ".nrrd", ".nhdr"};
  return std::ranges::find(kEndings, extension) != kEndings.end();
}

/// Transforms of the first frame of a PLUS sequence that do not lead to the tracker or the patient:
/// its calibrations.
Result<std::vector<io::CoordinateDefinition>> recorded_calibrations(const SourceOptions& options) {
  auto reader = io::SequenceReader::open(options.plus_config);
  if (!reader) return reader.error();
  const auto frame = reader->frame_fields(0);
  if (!frame) return frame.error();
  const std::string reference =
      options.reference_frame.empty() ? "Reference" : options.reference_frame;
  std::vector<io::CoordinateDefinition> found;
  for (const std::string& name : io::transform_names(*frame)) {
    const auto frames = io::split_transform_name(name);
    if (!frames || frames->second == options.tracker_frame || frames->second == reference) {
      continue;
    }
    const auto value = io::transform(*frame, name);
    if (!value) return value.error();
    found.push_back(
        {.from = frames->first, .to = frames->second, .to_from_from = value->to_from_from});
  }
  return found;
}

}  // namespace

Result<io::PlusConfig> read_calibrations(const SourceOptions& options) {
  if (!is_sequence_name(options.plus_config)) return io::read_plus_config(options.plus_config);
  auto recorded = recorded_calibrations(options);
  if (!recorded) return recorded.error();
  io::PlusConfig calibrations;
  calibrations.path = options.plus_config;
  calibrations.transforms = *std::move(recorded);
  return calibrations;
}

}  // namespace nav::session
