// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "io/detail/image_file.hpp"
#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

std::optional<PixelType> element_type(std::string_view text) {
  struct Name {
    std::string_view text;
    PixelType type;
  };
  // MET_LONG is 4 bytes in MetaIO.
  constexpr std::array kTypes = {
      Name{"MET_UCHAR", PixelType::kUint8},   Name{"MET_CHAR", PixelType::kInt8},
      Name{"MET_USHORT", PixelType::kUint16}, Name{"MET_SHORT", PixelType::kInt16},
      Name{"MET_UINT", PixelType::kUint32},   Name{"MET_INT", PixelType::kInt32},
      Name{"MET_ULONG", PixelType::kUint32},  Name{"MET_LONG", PixelType::kInt32},
      Name{"MET_FLOAT", PixelType::kFloat32}, Name{"MET_DOUBLE", PixelType::kFloat64}};
  for (const Name& name : kTypes) {
    if (name.text == text) return name.type;
  }
  return {};
}

Result<bool> flag(const ImageFile& file, std::string_view key, bool when_absent) {
  const std::string_view text = file.value(key);
  if (text.empty()) return when_absent;
  if (equals_ignoring_case(text, "True") || text == "1") return true;
  if (equals_ignoring_case(text, "False") || text == "0") return false;
  return bad_field(file, key, "True or False", text);
}

Result<void> read_sizes(ImageFile& file) {
  const auto dimensions = parse_int(file.value("NDims"));
  if (!dimensions || *dimensions < 2 || *dimensions > 4) {
    return bad_field(file, "NDims", "2, 3 or 4", file.value("NDims"));
  }
  const auto words = split_words(file.value("DimSize"));
  if (static_cast<std::int64_t>(words.size()) != *dimensions) {
    return bad_field(file, "DimSize", std::to_string(*dimensions) + " sizes",
                     file.value("DimSize"));
  }
  for (const std::string_view word : words) {
    const auto size = parse_int(word);
    if (!size || *size < 0) return bad_field(file, "DimSize", "sizes >= 0", file.value("DimSize"));
    file.sizes.push_back(*size);
  }
  if (!file.has("Kinds")) return {};
  file.kinds = split_words(file.value("Kinds"));
  if (file.kinds.size() != file.sizes.size()) {
    return bad_field(file, "Kinds", std::to_string(file.sizes.size()) + " kinds",
                     file.value("Kinds"));
  }
  return {};
}

Result<void> read_sample_type(ImageFile& file) {
  auto type = element_type(file.value("ElementType"));
  // PLUS writes recordings of poses alone so: images of 0 x 0 pixels have no type.
  const bool empty = std::ranges::count(file.sizes, 0) > 0;
  if (!type && empty && file.value("ElementType") == "MET_OTHER") type = PixelType::kUint8;
  if (!type) {
    return bad_field(file, "ElementType", "MET_UCHAR, MET_SHORT, … of one component",
                     file.value("ElementType"));
  }
  file.type = *type;
  if (file.has("ElementNumberOfChannels")) {
    const auto channels = parse_int(file.value("ElementNumberOfChannels"));
    if (!channels || *channels < 1 || *channels > 4) {
      return bad_field(file, "ElementNumberOfChannels", "1 to 4",
                       file.value("ElementNumberOfChannels"));
    }
    file.components = static_cast<int>(*channels);
  }
  const auto binary = flag(file, "BinaryData", true);
  if (!binary) return binary.error();
  if (!*binary) {
    return Error{ErrorCode::kUnsupportedData,
                 file.path.string() + ": BinaryData: expected True, found numbers as text"};
  }
  const auto element = flag(file, "ElementByteOrderMSB", false);
  if (!element) return element.error();
  const auto data = flag(file, "BinaryDataByteOrderMSB", *element);
  if (!data) return data.error();
  if (file.has("ElementByteOrderMSB") && *element != *data) {
    return bad_field(
        file, "ElementByteOrderMSB",
        "the same as BinaryDataByteOrderMSB, " + std::string(file.value("BinaryDataByteOrderMSB")),
        file.value("ElementByteOrderMSB"));
  }
  file.big_endian = *data;
  const auto compressed = flag(file, "CompressedData", false);
  if (!compressed) return compressed.error();
  file.encoding = *compressed ? Encoding::kDeflate : Encoding::kRaw;
  return {};
}

/// Size of raw samples in bytes; 0 when there are none or when it overflows (rejected later).
std::int64_t raw_bytes(const ImageFile& file) {
  std::int64_t bytes = static_cast<std::int64_t>(size_of(file.type)) * file.components;
  for (const std::int64_t size : file.sizes) {
    if (__builtin_mul_overflow(bytes, size, &bytes)) return 0;
  }
  return bytes;
}

/// Keeps the last bytes of a part, for samples that end where the file ends.
void take_end(DataPart& part, std::int64_t bytes) {
  const std::int64_t skipped = std::max<std::int64_t>(part.size - bytes, 0);
  part.offset += skipped;
  part.size -= skipped;
}

Result<void> find_data(ImageFile& file, std::int64_t data_offset, std::int64_t file_size) {
  const std::string_view name = file.value("ElementDataFile");
  std::int64_t skip = 0;
  if (file.has("HeaderSize")) {
    const auto size = parse_int(file.value("HeaderSize"));
    if (!size || *size < -1) {
      return bad_field(file, "HeaderSize", "-1 or a number of bytes", file.value("HeaderSize"));
    }
    skip = *size;
  }
  if (equals_ignoring_case(name, "LOCAL")) {
    if (skip > 0 && skip != data_offset) {
      return bad_field(file, "HeaderSize",
                       "-1, 0 or the length of this header, " + std::to_string(data_offset),
                       file.value("HeaderSize"));
    }
    file.data.push_back({file.path, data_offset, file_size - data_offset});
    const bool at_end = skip == -1 && file.encoding == Encoding::kRaw && raw_bytes(file) > 0;
    if (at_end) take_end(file.data.back(), raw_bytes(file));
  } else {
    auto parts = detached_parts(file, "ElementDataFile", name, std::max<std::int64_t>(skip, 0));
    if (!parts) return parts.error();
    file.data = std::move(*parts);
    if (skip == -1) {  // The samples are the last bytes of each file.
      const std::int64_t each = raw_bytes(file) / static_cast<std::int64_t>(file.data.size());
      for (DataPart& part : file.data) take_end(part, each);
    }
  }
  if (file.encoding == Encoding::kRaw || !file.has("CompressedDataSize")) return {};
  const auto stated = parse_int(file.value("CompressedDataSize"));
  if (!stated || *stated < 0) {
    return bad_field(file, "CompressedDataSize", "a number of bytes",
                     file.value("CompressedDataSize"));
  }
  // Bytes after the stream do not belong to it. A missing end is detected by decompression.
  if (file.data.size() != 1 || *stated == 0) return {};
  if (*stated != file.data[0].size && !file.pipe) {
    file.findings.push_back({.subject = file.path.string(),
                             .key = "CompressedDataSize",
                             .values = {std::to_string(*stated) + " bytes stated",
                                        std::to_string(file.data[0].size) + " bytes found"},
                             .used = "the stream that begins with the data"});
  }
  file.data[0].size = std::min(file.data[0].size, *stated);
  return {};
}

/// Rejects keys in another case, which programs that use MetaIO ignore, and others may not. Notes
/// keys that are one letter off.
Result<void> check_case(ImageFile& file) {
  constexpr std::array kKnown{"ObjectType",
                              "NDims",
                              "DimSize",
                              "ElementType",
                              "ElementDataFile",
                              "ElementNumberOfChannels",
                              "ElementSpacing",
                              "ElementSize",
                              "TransformMatrix",
                              "Rotation",
                              "Orientation",
                              "AnatomicalOrientation",
                              "Offset",
                              "Position",
                              "Origin",
                              "DistanceUnits",
                              "BinaryData",
                              "BinaryDataByteOrderMSB",
                              "CompressedData",
                              "CompressedDataSize",
                              "HeaderSize",
                              "ElementByteOrderMSB",
                              "Kinds",
                              "ElementToIntensityFunctionSlope",
                              "UltrasoundImageType",
                              "ElementToIntensityFunctionOffset",
                              "UltrasoundImageOrientation"};
  for (const char* key : kKnown) {
    const std::string_view other = other_case(file, key);
    if (other.empty()) {
      note_near_key(file, key, kKnown);
      continue;
    }
    return Error{ErrorCode::kMalformedData, file.path.string() + ": expected the key " + key +
                                                ", found it as " + excerpt(other) +
                                                ", which other programs ignore"};
  }
  return {};
}

}  // namespace

Result<void> interpret_meta_image(ImageFile& file, std::int64_t data_offset,
                                  std::int64_t file_size) {
  if (file.has("ObjectType") && file.value("ObjectType") != "Image") {
    return Error{ErrorCode::kUnsupportedData, file.path.string() +
                                                  ": ObjectType: expected Image, found '" +
                                                  excerpt(file.value("ObjectType")) + "'"};
  }
  if (const auto ok = check_case(file); !ok) return ok;
  compare_spellings(file, {"TransformMatrix", "Rotation", "Orientation"});
  compare_spellings(file, {"Offset", "Position", "Origin"});
  compare_spellings(file, {"ElementSpacing", "ElementSize"});
  if (const auto ok = read_sizes(file); !ok) return ok;
  if (const auto ok = read_sample_type(file); !ok) return ok;
  return find_data(file, data_offset, file_size);
}

}  // namespace nav::io::detail
