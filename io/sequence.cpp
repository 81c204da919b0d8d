// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/sequence.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "io/detail/image_file.hpp"
#include "io/detail/pixel_stream.hpp"
#include "io/detail/text.hpp"
#include "io/detail/within_memory.hpp"

namespace nav::io {

namespace {

struct FrameField {
  std::int64_t frame;
  std::string_view name;
  std::string_view value;
};

bool before(const FrameField& a, const FrameField& b) {
  return a.frame != b.frame ? a.frame < b.frame : a.name < b.name;
}

std::string frame_name(const SequenceHeader& header, std::int64_t index) {
  return header.path.string() + ": frame " + std::to_string(index);
}

/// Splits a key such as "Seq_Frame0012_Timestamp"; nothing when it has another form.
std::optional<FrameField> frame_field(const detail::Field& field) {
  constexpr std::size_t kPrefix = std::string_view("Seq_Frame").size();
  const std::string_view rest = field.first.substr(kPrefix);
  const auto digits = rest.find('_');
  if (digits == std::string_view::npos || digits == 0 || digits + 1 == rest.size()) return {};
  const auto number = detail::parse_int(rest.substr(0, digits));
  if (!number || *number < 0) return {};
  return FrameField{*number, rest.substr(digits + 1), field.second};
}

/// Interprets the axes of the file: columns, rows, [slices], [time].
Result<void> interpret_axes(const detail::ImageFile& file, SequenceHeader& header) {
  const auto& sizes = file.sizes;
  const std::string_view last = file.kinds.empty() ? std::string_view("list") : file.kinds.back();
  bool is_list = last == "list" || last == "time";
  if (file.kinds.empty() && sizes.size() == 2) is_list = false;
  const std::size_t spatial = sizes.size() - (is_list ? 1 : 0);
  const bool list_elsewhere =
      std::count(file.kinds.begin(), file.kinds.end(), "list") > (last == "list" ? 1 : 0);
  if (list_elsewhere || spatial < 2 || spatial > 3) {
    return Error{ErrorCode::kUnsupportedData,
                 header.path.string() +
                     ": expected 2 or 3 axes in space, then at most one list of frames, found " +
                     std::to_string(sizes.size()) + " axes of kinds '" +
                     detail::excerpt(file.value(file.format == "NRRD" ? "kinds" : "Kinds")) + "'"};
  }
  for (std::size_t axis = 0; axis < spatial; ++axis) {
    if (sizes[axis] > std::numeric_limits<int>::max()) {
      return Error{ErrorCode::kMalformedData, header.path.string() +
                                                  ": expected sides below 2^31, found " +
                                                  std::to_string(sizes[axis])};
    }
  }
  header.width = static_cast<int>(sizes[0]);
  header.height = static_cast<int>(sizes[1]);
  header.depth = spatial == 3 ? static_cast<int>(sizes[2]) : 1;
  header.frame_count = is_list ? sizes.back() : 1;
  if (header.frame_count < 1) {
    return Error{ErrorCode::kMalformedData,
                 header.path.string() + ": expected at least 1 frame, found an empty sequence"};
  }
  // Two days at 60 Hz. Frames without pixels need no space in a file, but each needs time.
  constexpr std::int64_t kMostFrames = 10'000'000;
  if (header.frame_count > kMostFrames) {
    return Error{ErrorCode::kMalformedData, header.path.string() + ": expected at most " +
                                                std::to_string(kMostFrames) + " frames, found " +
                                                std::to_string(header.frame_count)};
  }
  return {};
}

/// Computes the number of frames that the raw data can hold; rejects data that do not hold one.
Result<void> check_length(const detail::ImageFile& file, SequenceHeader& header) {
  header.readable_frames = header.frame_count;
  const std::size_t frame_bytes = header.frame_bytes();
  if (header.compressed || frame_bytes == 0) return {};
  if (file.available_bytes >= file.sample_bytes) return {};
  header.readable_frames = file.available_bytes / static_cast<std::int64_t>(frame_bytes);
  if (header.readable_frames > 0) {
    header.findings.push_back(
        {.subject = header.path.string(),
         .key = "length of the samples",
         .values = {std::to_string(header.frame_count) + " frames stated",
                    std::to_string(header.readable_frames) + " with all their pixels"},
         .used = "those with all their pixels"});
    return {};
  }
  return Error{ErrorCode::kMalformedData,
               header.path.string() + ": frame 0: expected " + std::to_string(frame_bytes) +
                   " bytes of pixels, found " + std::to_string(file.available_bytes)};
}

/// Rejects impossible spacings, which mark a damaged header; the spacing of a sequence is not used
/// otherwise. The list axis of NRRD has no spacing, which is written as NaN.
Result<void> check_spacing(const detail::ImageFile& file) {
  const bool nrrd = file.format == "NRRD";
  const std::string_view key = nrrd ? "spacings" : "ElementSpacing";
  for (const std::string_view word : detail::split_words(file.value(key))) {
    const auto number = detail::parse_double(word);
    if (number && std::isfinite(*number) && *number > 0) continue;
    if (nrrd && detail::equals_ignoring_case(word, "nan")) continue;
    return detail::bad_field(file, key, "positive spacing", file.value(key));
  }
  return {};
}

Result<SequenceHeader> interpret(const detail::ImageFile& file) {
  SequenceHeader header;
  header.path = file.path;
  header.findings = file.findings;
  header.format = file.format;
  header.components = file.components;
  header.pixel_type = file.type;
  header.compressed = file.encoding == detail::Encoding::kDeflate;
  const bool nrrd = file.format == "NRRD";
  header.orientation =
      file.value(nrrd ? "ultrasound image orientation" : "UltrasoundImageOrientation");
  header.image_type = file.value(nrrd ? "ultrasound image type" : "UltrasoundImageType");
  for (const auto& [key, value] : file.keys) header.fields.emplace(key, value);
  if (const auto ok = interpret_axes(file, header); !ok) return ok.error();
  if (const auto ok = check_length(file, header); !ok) return ok.error();
  if (const auto ok = check_spacing(file); !ok) return ok.error();
  return header;
}

/// Fields of all frames, ordered by frame and name. There may be many more frames than fields.
Result<std::vector<FrameField>> collect_frame_fields(const detail::ImageFile& file,
                                                     SequenceHeader& header) {
  std::vector<FrameField> fields;
  for (const detail::Field& field : file.fields) {
    if (!detail::is_frame_key(field.first)) continue;
    const auto parsed = frame_field(field);
    if (!parsed) {
      header.fields.emplace(field.first, field.second);
      continue;
    }
    if (parsed->frame >= header.frame_count) {
      return Error{ErrorCode::kMalformedData,
                   header.path.string() + ": " + detail::excerpt(field.first) +
                       ": expected a frame below " + std::to_string(header.frame_count) +
                       ", found " + std::to_string(parsed->frame)};
    }
    fields.push_back(*parsed);
  }
  std::stable_sort(fields.begin(), fields.end(), before);
  for (std::size_t i = 1; i < fields.size(); ++i) {
    const FrameField& a = fields[i - 1];
    const FrameField& b = fields[i];
    if (a.frame == b.frame && a.name == b.name && a.value != b.value) {
      return Error{ErrorCode::kMalformedData,
                   frame_name(header, a.frame) + ": " + detail::excerpt(a.name) +
                       ": expected one value, found '" + detail::excerpt(a.value) + "' and '" +
                       detail::excerpt(b.value) + "'"};
    }
  }
  return fields;
}

Result<std::optional<double>> time_field(const SequenceHeader& header, const SequenceImage& frame,
                                         const std::string& name) {
  const auto found = frame.fields.find(name);
  if (found == frame.fields.end()) return std::optional<double>();
  const auto seconds = detail::parse_double(found->second);
  if (!seconds || !std::isfinite(*seconds)) {
    return Error{ErrorCode::kMalformedData, frame_name(header, frame.index) + ": " + name +
                                                ": expected a finite number of seconds, found '" +
                                                detail::excerpt(found->second) + "'"};
  }
  return seconds;
}

/// MetaImage uses the key ImageStatus, NRRD uses Status; files without either hold images.
bool declared_invalid(const SequenceImage& frame) {
  for (const char* key : {"ImageStatus", "Status"}) {
    const auto found = frame.fields.find(key);
    if (found != frame.fields.end()) return found->second != "OK";
  }
  return false;
}

}  // namespace

std::size_t SequenceHeader::frame_bytes() const {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
         static_cast<std::size_t>(depth) * static_cast<std::size_t>(components) *
         size_of(pixel_type);
}

struct SequenceReader::State {
  detail::ImageFile file;
  SequenceHeader header;
  std::vector<FrameField> frame_fields;
  detail::PixelStream pixels;

  /// Reads the bytes of one frame. Compressed data may claim a thousand times their size, so memory
  /// for them grows as they are decoded.
  Result<void> fill(std::int64_t offset, std::size_t bytes, std::vector<std::byte>& out) {
    constexpr std::size_t kBlock = 16 << 20;
    const std::size_t block = header.compressed ? kBlock : bytes;
    for (std::size_t done = 0; done < bytes; done = out.size()) {
      out.resize(std::min(bytes, done + block));
      const auto read =
          pixels.read(offset + static_cast<std::int64_t>(done), std::span(out).subspan(done));
      if (!read) return read;
    }
    return {};
  }
};

SequenceReader::SequenceReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
SequenceReader::SequenceReader(SequenceReader&&) noexcept = default;
SequenceReader& SequenceReader::operator=(SequenceReader&&) noexcept = default;
SequenceReader::~SequenceReader() = default;

Result<SequenceReader> SequenceReader::open(const std::filesystem::path& path) {
  auto file = detail::read_image_file(path, true);
  if (!file) return file.error();
  auto header = interpret(*file);
  if (!header) return header.error();
  auto fields = collect_frame_fields(*file, *header);
  if (!fields) return fields.error();
  auto pixels = detail::PixelStream::open(file->data, file->encoding, file->pipe);
  if (!pixels) return pixels.error();
  return SequenceReader(std::make_unique<State>(
      State{std::move(*file), std::move(*header), std::move(*fields), std::move(*pixels)}));
}

const SequenceHeader& SequenceReader::header() const { return state_->header; }

Result<SequenceImage> SequenceReader::frame_fields(std::int64_t index) const {
  const SequenceHeader& header = state_->header;
  if (index < 0 || index >= header.frame_count) {
    return Error{ErrorCode::kUsage, frame_name(header, index) + ": expected a frame in 0 to " +
                                        std::to_string(header.frame_count - 1)};
  }
  SequenceImage frame;
  frame.index = index;
  const auto& all = state_->frame_fields;
  for (auto it = std::lower_bound(all.begin(), all.end(), FrameField{index, {}, {}}, before);
       it != all.end() && it->frame == index; ++it) {
    frame.fields.emplace(it->name, it->value);
  }
  auto timestamp = time_field(header, frame, "Timestamp");
  if (!timestamp) return timestamp.error();
  auto unfiltered = time_field(header, frame, "UnfilteredTimestamp");
  if (!unfiltered) return unfiltered.error();
  frame.timestamp_s = *timestamp;
  frame.unfiltered_timestamp_s = *unfiltered;
  frame.image_valid = header.frame_bytes() > 0 && !declared_invalid(frame);
  return frame;
}

Result<SequenceImage> SequenceReader::read(std::int64_t index) {
  auto frame = frame_fields(index);
  if (!frame) return frame;
  const SequenceHeader& header = state_->header;
  const std::size_t bytes = header.frame_bytes();
  if (bytes == 0) return frame;
  const auto fail = [&](const Error& error) {
    // These name the file already.
    const bool of_file = error.code == ErrorCode::kIo || error.code == ErrorCode::kUnavailable;
    if (of_file) return Error{error.code, error.message + " (frame " + std::to_string(index) + ")"};
    return Error{error.code, frame_name(header, index) + ": " + error.message};
  };
  const std::int64_t offset = index * static_cast<std::int64_t>(bytes);
  if (index >= header.readable_frames) {
    return fail(
        {ErrorCode::kMalformedData, "pixel data cut short: expected " +
                                        std::to_string(offset + static_cast<std::int64_t>(bytes)) +
                                        " bytes up to its end, found " +
                                        std::to_string(state_->file.available_bytes)});
  }
  const auto filled = detail::within_memory(header.path, static_cast<double>(bytes), [&] {
    return state_->fill(offset, bytes, frame->pixels);
  });
  if (!filled) return fail(filled.error());
  if (index + 1 == header.frame_count) {
    if (const auto ok = state_->pixels.expect_end(); !ok) return fail(ok.error());
  }
  if (state_->file.big_endian != (std::endian::native == std::endian::big)) {
    detail::swap_bytes(frame->pixels, size_of(header.pixel_type));
  }
  return frame;
}

std::vector<std::filesystem::path> sample_files(const std::filesystem::path& header) {
  std::vector<std::filesystem::path> files;
  const auto file = detail::read_image_file(header);
  if (!file) return files;
  for (const detail::DataPart& part : file->data) {
    if (part.path != header) files.push_back(part.path);
  }
  return files;
}

Result<void> check_complete(SequenceReader& reader) {
  const SequenceHeader& header = reader.header();
  if (header.readable_frames < header.frame_count) {
    return Error{ErrorCode::kMalformedData,
                 header.path.string() + ": pixel data cut short: expected " +
                     std::to_string(header.frame_count) + " frames (" +
                     (header.format == "NRRD" ? "sizes" : "DimSize") + "), found " +
                     std::to_string(header.readable_frames) + " complete ones"};
  }
  // Invalid fields of a frame are not an error of the length, which is checked here.
  if (!header.compressed || !reader.frame_fields(header.frame_count - 1)) return {};
  const auto last = reader.read(header.frame_count - 1);
  if (!last) return last.error();
  return {};
}

}  // namespace nav::io
