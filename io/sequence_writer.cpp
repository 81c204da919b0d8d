// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/sequence_writer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iomanip>
#include <optional>
#include <set>
#include <sstream>

#include "io/atomic_file.hpp"
#include "io/detail/image_file.hpp"
#include "io/detail/scratch_file.hpp"
#include "io/detail/text.hpp"

namespace nav::io {

namespace {

/// True for keys that the writer decides itself, in both formats.
bool is_structural(std::string_view key) {
  static const std::set<std::string_view> kKeys = {"ObjectType",
                                                   "NDims",
                                                   "AnatomicalOrientation",
                                                   "BinaryData",
                                                   "BinaryDataByteOrderMSB",
                                                   "ElementByteOrderMSB",
                                                   "CenterOfRotation",
                                                   "CompressedData",
                                                   "CompressedDataSize",
                                                   "DimSize",
                                                   "Kinds",
                                                   "ElementNumberOfChannels",
                                                   "ElementSpacing",
                                                   "ElementSize",
                                                   "ElementType",
                                                   "ElementDataFile",
                                                   "HeaderSize",
                                                   "Offset",
                                                   "TransformMatrix",
                                                   "UltrasoundImageOrientation",
                                                   "UltrasoundImageType",
                                                   "dimension",
                                                   "encoding",
                                                   "endian",
                                                   "kinds",
                                                   "sizes",
                                                   "space dimension",
                                                   "space directions",
                                                   "space origin",
                                                   "space",
                                                   "spacings",
                                                   "space units",
                                                   "type",
                                                   "data file",
                                                   "datafile",
                                                   "byte skip",
                                                   "byteskip",
                                                   "line skip",
                                                   "lineskip",
                                                   "ultrasound image orientation",
                                                   "ultrasound image type"};
  return kKeys.count(key) != 0 || detail::is_frame_key(key);
}

bool is_one_line(std::string_view text) {
  return std::none_of(text.begin(), text.end(),
                      [](char c) { return c == '\n' || c == '\r' || c == '\0'; });
}

bool is_key(std::string_view text) {
  return !text.empty() && is_one_line(text) && detail::trim(text) == text &&
         text.find_first_of("=:") == std::string_view::npos && text.front() != '#';
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

const char* meta_type(PixelType type) {
  constexpr std::array kNames = {"MET_UCHAR", "MET_CHAR", "MET_USHORT", "MET_SHORT",
                                 "MET_UINT",  "MET_INT",  "MET_FLOAT",  "MET_DOUBLE"};
  return kNames[static_cast<std::size_t>(type)];
}

const char* nrrd_type(PixelType type) {
  constexpr std::array kNames = {"uint8",  "int8",  "uint16", "int16",
                                 "uint32", "int32", "float",  "double"};
  return kNames[static_cast<std::size_t>(type)];
}

std::string spatial_sizes(const SequenceHeader& header) {
  std::string text = std::to_string(header.width) + " " + std::to_string(header.height) + " ";
  if (header.depth > 1) text += std::to_string(header.depth) + " ";
  return text;
}

std::string repeated(const std::string& word, int count, const std::string& separator) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i > 0 ? separator : "") + word;
  return text;
}

std::string identity_matrix(int n) {
  std::string text;
  for (int i = 0; i < n * n; ++i)
    text += std::string(i > 0 ? " " : "") + (i % (n + 1) == 0 ? "1" : "0");
  return text;
}

// PLUS pads these fields so that its tools can change them in place. The padding is kept for these
// tools.
constexpr std::size_t kFrameCountWidth = 16;
constexpr std::size_t kCompressedSizeWidth = 40;

constexpr const char* kBigEndian = std::endian::native == std::endian::big ? "True" : "False";

}  // namespace

struct SequenceWriter::State {
  std::filesystem::path path;
  SequenceHeader header;
  bool nrrd = false;
  detail::ScratchFile pixels;
  std::optional<detail::Deflater> deflater{};
  std::string frame_lines{};
  std::int64_t frames = 0;
  bool broken = false;  ///< An append failed half-way: the file would be wrong.

  [[nodiscard]] std::string meta_header() const;
  [[nodiscard]] std::string nrrd_header() const;
  [[nodiscard]] std::string extra_fields(const char* separator) const;
  void add_line(const std::string& name, const std::string& value);
  Result<void> add_pixels(std::span<const std::byte> bytes);
  Result<void> check(const SequenceImage& frame) const;
};

std::string SequenceWriter::State::extra_fields(const char* separator) const {
  std::string text;
  for (const auto& [key, value] : header.fields) {
    if (!is_structural(key)) text += key + separator + value + "\n";
  }
  return text;
}

std::string SequenceWriter::State::meta_header() const {
  const int n = header.depth > 1 ? 4 : 3;
  std::string text = "ObjectType = Image\nNDims = " + std::to_string(n) + "\n";
  text += "AnatomicalOrientation = RAI\nBinaryData = True\nBinaryDataByteOrderMSB = ";
  text += std::string(kBigEndian) + "\nCenterOfRotation = " + repeated("0", n, " ") + "\n";
  text += std::string("CompressedData = ") + (header.compressed ? "True" : "False") + "\n";
  if (header.compressed) {
    text += "CompressedDataSize = " + padded(std::to_string(pixels.size()), kCompressedSizeWidth) +
            "\n";
  }
  text += "DimSize = " + spatial_sizes(header) + padded(std::to_string(frames), kFrameCountWidth) +
          "\nKinds = " + repeated("domain", n - 1, " ") + " list\n";
  text += "ElementNumberOfChannels = " + std::to_string(header.components) + "\n";
  text += "ElementSpacing = " + repeated("1", n, " ") + "\nElementType = ";
  text += std::string(meta_type(header.pixel_type)) + "\nOffset = " + repeated("0", n, " ") + "\n";
  text += "TransformMatrix = " + identity_matrix(n) + "\n";
  text += "UltrasoundImageOrientation = " + header.orientation + "\n";
  text += "UltrasoundImageType = " + header.image_type + "\n" + extra_fields(" = ");
  return text + frame_lines + "ElementDataFile = LOCAL\n";
}

std::string SequenceWriter::State::nrrd_header() const {
  const bool colour = header.components > 1;
  const int spatial = header.depth > 1 ? 3 : 2;
  std::string directions;
  for (int axis = 0; axis < spatial; ++axis) {
    directions += "(";
    for (int i = 0; i < spatial; ++i)
      directions += std::string(i > 0 ? "," : "") + (i == axis ? "1" : "0");
    directions += ") ";
  }
  std::string text =
      "NRRD0004\n# Complete NRRD file format specification at:\n"
      "# http://teem.sourceforge.net/nrrd/format.html\n";
  text += "dimension: " + std::to_string(spatial + 1 + (colour ? 1 : 0)) + "\n";
  text += std::string("encoding: ") + (header.compressed ? "gz" : "raw") + "\n";
  text +=
      std::string("endian: ") + (std::endian::native == std::endian::big ? "big" : "little") + "\n";
  text += std::string("kinds: ") + (colour ? "vector " : "") + repeated("domain", spatial, " ") +
          " list\n";
  text += "sizes: " + (colour ? std::to_string(header.components) + " " : std::string()) +
          spatial_sizes(header) + padded(std::to_string(frames), kFrameCountWidth) + "\n";
  text += "space dimension: " + std::to_string(spatial) + "\n";
  text += std::string("space directions: ") + (colour ? "none " : "") + directions + "none\n";
  text += "space origin: (" + repeated("0", spatial, ",") + ")\n";
  text += std::string("type: ") + nrrd_type(header.pixel_type) + "\n";
  text += "ultrasound image orientation:=" + header.orientation + "\n";
  text += "ultrasound image type:=" + header.image_type + "\n" + extra_fields(":=");
  return text + frame_lines + "\n";
}

void SequenceWriter::State::add_line(const std::string& name, const std::string& value) {
  std::ostringstream number;
  number << std::setw(4) << std::setfill('0') << frames;
  frame_lines += "Seq_Frame" + number.str() + "_" + name + (nrrd ? ":=" : " = ") + value + "\n";
}

Result<void> SequenceWriter::State::add_pixels(std::span<const std::byte> bytes) {
  if (!deflater) return pixels.append(bytes);
  return deflater->write(bytes,
                         [&](std::span<const std::byte> piece) { return pixels.append(piece); });
}

Result<void> SequenceWriter::State::check(const SequenceImage& frame) const {
  const std::string where = path.string() + ": frame " + std::to_string(frames) + ": ";
  const std::size_t bytes = header.frame_bytes();
  const bool blank = frame.pixels.empty() && !frame.image_valid;
  if (frame.pixels.size() != bytes && !blank) {
    return Error{ErrorCode::kUsage, where + "expected " + std::to_string(bytes) +
                                        " bytes of pixels, found " +
                                        std::to_string(frame.pixels.size())};
  }
  for (const auto& time : {frame.timestamp_s, frame.unfiltered_timestamp_s}) {
    if (time && !std::isfinite(*time)) {
      return Error{ErrorCode::kUsage,
                   where + "expected a finite timestamp, found " + detail::to_text(*time)};
    }
  }
  for (const auto& [name, value] : frame.fields) {
    if (!is_key(name) || !is_one_line(value)) {
      return Error{ErrorCode::kUsage, where + "expected a field of one line, found '" +
                                          detail::excerpt(name) + "' = '" + detail::excerpt(value) +
                                          "'"};
    }
  }
  return {};
}

SequenceWriter::SequenceWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
SequenceWriter::SequenceWriter(SequenceWriter&&) noexcept = default;
SequenceWriter& SequenceWriter::operator=(SequenceWriter&&) noexcept = default;
SequenceWriter::~SequenceWriter() = default;

Result<SequenceWriter> SequenceWriter::create(const std::filesystem::path& path,
                                              const SequenceHeader& header) {
  const std::string name = path.filename().string();
  const auto reject = [&](const std::string& what) {
    return Error{ErrorCode::kUsage, path.string() + ": " + what};
  };
  const bool nrrd = name.ends_with(".nrrd");
  if (!nrrd && !name.ends_with(".mha")) return reject("expected a name ending in .mha or .nrrd");
  if (header.width < 0 || header.height < 0 || header.depth < 1 || header.components < 1 ||
      header.components > 4) {
    return reject("expected sizes >= 0, depth >= 1 and 1 to 4 components, found " +
                  std::to_string(header.width) + " x " + std::to_string(header.height) + " x " +
                  std::to_string(header.depth) + " of " + std::to_string(header.components));
  }
  for (const auto& [key, value] : header.fields) {
    if (is_structural(key)) continue;
    if (!is_key(key) || !is_one_line(value)) {
      return reject("expected a header field of one line, found '" + detail::excerpt(key) + "'");
    }
  }
  auto pixels = detail::ScratchFile::create(path);
  if (!pixels) return pixels.error();
  auto state = std::make_unique<State>(
      State{.path = path, .header = header, .nrrd = nrrd, .pixels = std::move(*pixels)});
  if (header.orientation.empty()) state->header.orientation = "MF";
  if (header.image_type.empty()) state->header.image_type = "BRIGHTNESS";
  if (!is_one_line(header.orientation) || !is_one_line(header.image_type)) {
    return reject("expected an orientation and image type of one line");
  }
  if (header.compressed) {
    auto deflater = detail::Deflater::create(nrrd ? detail::DeflateFormat::kGzip
                                                  : detail::DeflateFormat::kZlib);
    if (!deflater) return deflater.error();
    state->deflater = std::move(*deflater);
  }
  return SequenceWriter(std::move(state));
}

Result<void> SequenceWriter::append(const SequenceImage& frame) {
  State& s = *state_;
  if (const auto ok = s.check(frame); !ok) return ok;
  std::map<std::string, std::string> fields = frame.fields;
  const auto put_time = [&](const char* name, const std::optional<double>& time) {
    if (!time) return;
    const auto old = fields.find(name);
    // The text of the file is kept if it has the same value, because it keeps all digits.
    if (old != fields.end() && detail::parse_double(old->second) == time) return;
    fields[name] = detail::to_text(*time);
  };
  put_time("Timestamp", frame.timestamp_s);
  put_time("UnfilteredTimestamp", frame.unfiltered_timestamp_s);
  fields.erase("ImageStatus");
  fields.erase("Status");
  for (const auto& [name, value] : fields) s.add_line(name, value);
  s.add_line(s.nrrd ? "Status" : "ImageStatus", frame.image_valid ? "OK" : "INVALID");
  ++s.frames;
  const std::vector<std::byte> blank(frame.pixels.empty() ? s.header.frame_bytes() : 0);
  const auto ok = s.add_pixels(frame.pixels.empty() ? blank : frame.pixels);
  if (!ok) s.broken = true;
  return ok;
}

std::int64_t SequenceWriter::frame_count() const { return state_->frames; }

Result<void> SequenceWriter::finish() {
  State& s = *state_;
  if (s.broken) {
    return Error{
        ErrorCode::kIo,
        s.path.string() + ": expected complete frames, found one that could not be written"};
  }
  if (s.frames == 0) {
    return Error{ErrorCode::kRefused, s.path.string() + ": expected at least 1 frame, found none"};
  }
  if (s.deflater) {
    const auto ok = s.deflater->finish(
        [&](std::span<const std::byte> piece) { return s.pixels.append(piece); });
    if (!ok) return ok;
    s.deflater.reset();
  }
  s.broken = true;  // From here on, frames can no longer be appended, even if an error follows.
  auto file = AtomicFile::create(s.path);
  if (!file) return file.error();
  if (const auto ok = file->write(s.nrrd ? s.nrrd_header() : s.meta_header()); !ok) return ok;
  const auto copied =
      s.pixels.read_all([&](std::span<const std::byte> piece) { return file->write(piece); });
  if (!copied) return copied;
  return file->commit();
}

}  // namespace nav::io
