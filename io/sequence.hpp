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
#include "nav/diagnostics.hpp"
#include "nav/grey_scale.hpp"
#include "nav/image.hpp"
#include "nav/pose.hpp"
#include "nav/result.hpp"

namespace nav::io {

/// Header of a PLUS/IGSIO sequence metafile (.igs.mha, .mha, .mhd, .nrrd, .nhdr): the properties of
/// all its frames.
struct SequenceHeader {
  std::filesystem::path path;
  std::string format;  ///< "MetaImage" or "NRRD".
  int width = 0;       ///< Number of columns; 0 in tracker-only recordings.
  int height = 0;      ///< Number of rows; 0 in tracker-only recordings.
  int depth = 1;       ///< Slices of one frame; 1 except for 3D + time.
  int components = 1;  ///< Samples per pixel, interleaved: 1, or 3 for colour.
  PixelType pixel_type = PixelType::kUint8;
  std::string orientation;  ///< Text of the file ("MF", "UNA", "FM", "XX"); empty when absent.
  std::string image_type;   ///< Text of the file ("BRIGHTNESS", "RGB_COLOR"); empty when absent.
  std::int64_t frame_count = 0;
  /// Number of frames whose pixels fit in the length of the file; less than frame_count when a raw
  /// file is cut short. Equal to frame_count for compressed files, for which only reading can tell.
  std::int64_t readable_frames = 0;
  std::vector<Finding> findings;  ///< Fields that contradict each other or the data.
  bool compressed = false;
  std::map<std::string, std::string> fields;  ///< Every header key outside frames, as in the file.

  /// Size of one frame in bytes: width * height * depth * components * size of a sample.
  [[nodiscard]] std::size_t frame_bytes() const;
};

/// One frame of a sequence: an image with its fields.
struct SequenceImage {
  std::int64_t index = 0;
  std::optional<double> timestamp_s;             ///< Field Timestamp, s; finite.
  std::optional<double> unfiltered_timestamp_s;  ///< Field UnfilteredTimestamp, s; finite.
  bool image_valid = false;                   ///< Not declared invalid, and the frame is not 0 x 0.
  std::map<std::string, std::string> fields;  ///< Every Seq_Frame field, name without prefix.
  std::vector<std::byte> pixels;              ///< Native byte order, orientation of the file.
};

/// Unchecked 4 x 4 matrix of a frame: p_to = matrix * p_from. Rigid transforms are in mm. It is NaN
/// only with a status other than ok and unknown.
struct NamedTransform {
  std::string name;  ///< "ProbeToTracker".
  Eigen::Matrix4d to_from_from;
  TrackingStatus status;  ///< kUnknown when the file gives none; it never counts as ok.
};

/// Sorted names ("ProbeToTracker") of the transforms of a frame.
std::vector<std::string> transform_names(const SequenceImage& frame);

/// Transform with that name ("ProbeToTracker", without the suffix "Transform"). Numbers are
/// row-major and independent of the locale. Errors: kNotFound when the frame has no such transform;
/// kMalformedData unless it has exactly 16 finite numbers. NaN is accepted when the status says
/// that there was no pose.
Result<NamedTransform> transform(const SequenceImage& frame, std::string_view name);

/// Writes a transform and its status into the fields of a frame, in the format of PLUS. kUnknown
/// writes no status.
void set_transform(SequenceImage& frame, const NamedTransform& transform);

/// Meaning of a PLUS status text. Texts that PLUS does not define are kInvalid, never ok.
TrackingStatus tracking_status_from_text(std::string_view text);

/// Image of a frame in 8 bits: its brightness and, unless it is grey, its colours.
struct DecodedImage {
  Image2d<std::uint8_t> pixels;
  Image2d<Rgb8> colours{};  ///< Same size as pixels, which are their luma; empty: grey.
};

/// B-mode image of a frame, flipped so that columns increase towards the marked side and rows away
/// from the transducer ("MF"). Reads 8-bit and 16-bit samples, grey or RGB. Rejects other samples,
/// negative values, radio-frequency data and their orientations, unknown or absent orientation,
/// several slices, 0 x 0, and invalid images.
Result<DecodedImage> sequence_image(const SequenceHeader& header, const SequenceImage& frame,
                                    GreyScale& scale);
/// Brightness of that image.
Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceImage& frame, GreyScale& scale);
/// The image of a single frame, with a scale of its own.
Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceImage& frame);

/// Reads frames one by one; the pixel data are never all in memory. Raw files are read in any
/// order. Compressed files are read forward; an earlier index decompresses from the start again.
/// Offsets have 64 bits. Not thread-safe: use one reader per thread.
class SequenceReader {
 public:
  /// Reads the header, at most 512 MiB of it, and checks its sizes against the length of the file
  /// before memory is allocated for them.
  static Result<SequenceReader> open(const std::filesystem::path& path);

  SequenceReader(SequenceReader&&) noexcept;
  SequenceReader& operator=(SequenceReader&&) noexcept;
  ~SequenceReader();

  [[nodiscard]] const SequenceHeader& header() const;
  /// Reads a frame with its pixels; index in [0, frame_count). Errors name the frame: kUsage when
  /// out of range, kMalformedData for truncated pixel data or a timestamp that is not a finite
  /// number.
  Result<SequenceImage> read(std::int64_t index);
  /// Reads the fields of a frame without its pixels.
  [[nodiscard]] Result<SequenceImage> frame_fields(std::int64_t index) const;

 private:
  struct State;
  explicit SequenceReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Separate files with the samples of a MetaImage or NRRD header, sequence or volume; none when the
/// samples follow the header or the file is not readable as such.
std::vector<std::filesystem::path> sample_files(const std::filesystem::path& header);

/// Checks that the pixels of every declared frame exist. kMalformedData when the file is cut short
/// or DimSize is too large. Decompresses compressed data once, to the end.
Result<void> check_complete(SequenceReader& reader);

}  // namespace nav::io
