// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/pixel_type.hpp"
#include "nav/image.hpp"
#include "nav/pose.hpp"
#include "nav/result.hpp"

namespace nav::io {

/// What a PLUS/IGSIO sequence metafile (.igs.mha, .mha, .mhd, .nrrd, .nhdr) says of all its frames.
struct SequenceHeader {
  std::filesystem::path path;
  std::string format;  ///< "MetaImage" or "NRRD".
  int width = 0;       ///< Columns; 0 in tracker-only recordings.
  int height = 0;      ///< Rows; 0 in tracker-only recordings.
  int depth = 1;       ///< Slices of one frame; 1 unless 3D + time.
  int components = 1;  ///< Samples per pixel, interleaved: 1, or 3 for colour.
  PixelType pixel_type = PixelType::kUint8;
  std::string orientation;  ///< As in the file ("MF", "UNA", "FM", "XX"); empty when absent.
  std::string image_type;   ///< As in the file ("BRIGHTNESS", "RGB_COLOR"); empty when absent.
  std::int64_t frame_count = 0;
  /// Frames whose pixels the file can hold by its length; less than frame_count when a raw file was
  /// cut short. Equals frame_count for compressed files, where only reading can tell.
  std::int64_t readable_frames = 0;
  bool compressed = false;
  std::map<std::string, std::string> fields;  ///< Every header key outside frames, as in the file.

  /// Bytes of one frame: width * height * depth * components * size of a sample.
  [[nodiscard]] std::size_t frame_bytes() const;
};

/// One frame of a sequence.
struct SequenceFrame {
  std::int64_t index = 0;
  std::optional<double> timestamp_s;             ///< Field Timestamp, s; finite.
  std::optional<double> unfiltered_timestamp_s;  ///< Field UnfilteredTimestamp, s; finite.
  bool image_valid = false;                   ///< Not declared invalid, and the frame is not 0 x 0.
  std::map<std::string, std::string> fields;  ///< Every Seq_Frame field, name without the prefix.
  std::vector<std::byte> pixels;              ///< Native endian, in the orientation of the file.
};

/// 16 numbers of a frame that nobody has judged yet: p_to = matrix * p_from. Rigid transforms are
/// in mm. NaN only with a status other than ok and unknown.
struct NamedTransform {
  std::string name;  ///< "ProbeToTracker".
  Eigen::Matrix4d to_from_from;
  TrackingStatus status;  ///< kUnknown when the file gives none: never ok.
};

/// Names ("ProbeToTracker") of the transforms that a frame carries, sorted.
std::vector<std::string> transform_names(const SequenceFrame& frame);

/// The transform of that name ("ProbeToTracker", without the suffix "Transform"). Numbers are
/// row-major and independent of the locale. Errors: kNotFound when the frame has none of that name;
/// kMalformedData unless there are exactly 16 finite numbers (finite is not asked of a pose whose
/// status says that there was none).
Result<NamedTransform> transform(const SequenceFrame& frame, std::string_view name);

/// Puts a transform and its status in the fields of a frame, as PLUS writes them. kUnknown writes
/// no status.
void set_transform(SequenceFrame& frame, const NamedTransform& transform);

/// What a status text of PLUS means; texts that PLUS does not know are kInvalid, never ok.
TrackingStatus tracking_status_from_text(std::string_view text);

/// The B-mode picture of a frame, flipped to columns toward the marked side and rows away from the
/// transducer ("MF"), whatever the file holds. Refuses, in one sentence: colour, samples that are
/// not 8-bit, radio-frequency data and orientations, unknown or absent orientation, several slices,
/// 0 x 0 and invalid images.
Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceFrame& frame);

/// Reads frames one by one; pixel data are never all in memory. Raw files are read in any order;
/// compressed ones forward, an earlier index inflates again from the start. Offsets are 64 bits.
/// Not thread-safe: one reader per thread.
class SequenceReader {
 public:
  /// Reads the header, at most 512 MiB of it, and checks its claims against the length of the file
  /// before anything of their size is allocated.
  static Result<SequenceReader> open(const std::filesystem::path& path);

  SequenceReader(SequenceReader&&) noexcept;
  SequenceReader& operator=(SequenceReader&&) noexcept;
  ~SequenceReader();

  [[nodiscard]] const SequenceHeader& header() const;
  /// A frame with its pixels; index in [0, frame_count). Errors name the frame: kUsage out of
  /// range, kMalformedData for cut pixel data or a timestamp that is not a finite number.
  Result<SequenceFrame> read(std::int64_t index);
  /// The same without pixels, which are not touched.
  [[nodiscard]] Result<SequenceFrame> frame_fields(std::int64_t index) const;

 private:
  struct State;
  explicit SequenceReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// The files beside a MetaImage or NRRD header in which its samples are, of a sequence or a volume;
/// none where they follow the header, and for what no reader takes for one.
std::vector<std::filesystem::path> sample_files(const std::filesystem::path& header);

/// Whether the pixels of every frame that the header declares are there: kMalformedData where the
/// file is cut short or DimSize says too much. Inflates compressed data once, to the end.
Result<void> check_complete(SequenceReader& reader);

}  // namespace nav::io
