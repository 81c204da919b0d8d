// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "io/sequence.hpp"
#include "nav/result.hpp"

namespace nav::io {

/// Writes a PLUS sequence metafile: .mha (raw or one zlib stream) or .nrrd (raw or gzip), by the
/// ending of the path. Pixels go to a temporary file beside the final one; finish() writes the
/// header before them, syncs and renames. Without a successful finish() neither file remains. Not
/// thread-safe.
class SequenceWriter {
 public:
  /// Uses width, height, depth, components, pixel_type, orientation ("MF" when empty), image_type
  /// ("BRIGHTNESS" when empty), compressed and fields of the header; other members are ignored.
  /// Keys in fields that the writer itself decides (DimSize, ElementType, …) are ignored too.
  static Result<SequenceWriter> create(const std::filesystem::path& path,
                                       const SequenceHeader& header);

  SequenceWriter(SequenceWriter&&) noexcept;
  SequenceWriter& operator=(SequenceWriter&&) noexcept;
  ~SequenceWriter();

  /// Appends a frame: its fields, timestamps, validity and pixels. The index is ignored: frames are
  /// numbered in order of arrival. Rejects a wrong number of bytes, non-finite times, and names or
  /// values that would break the header.
  Result<void> append(const SequenceImage& frame);
  [[nodiscard]] std::int64_t frame_count() const;
  /// Completes the file under its final name; rejects a sequence without frames.
  Result<void> finish();

 private:
  struct State;
  explicit SequenceWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace nav::io
