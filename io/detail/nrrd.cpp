// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "io/detail/image_file.hpp"
#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

std::optional<PixelType> nrrd_type(std::string_view text) {
  struct Name {
    std::string_view text;
    PixelType type;
  };
  constexpr std::array kTypes = {Name{"signed char", PixelType::kInt8},
                                 Name{"int8", PixelType::kInt8},
                                 Name{"int8_t", PixelType::kInt8},
                                 Name{"uchar", PixelType::kUint8},
                                 Name{"unsigned char", PixelType::kUint8},
                                 Name{"uint8", PixelType::kUint8},
                                 Name{"uint8_t", PixelType::kUint8},
                                 Name{"short", PixelType::kInt16},
                                 Name{"short int", PixelType::kInt16},
                                 Name{"signed short", PixelType::kInt16},
                                 Name{"signed short int", PixelType::kInt16},
                                 Name{"int16", PixelType::kInt16},
                                 Name{"int16_t", PixelType::kInt16},
                                 Name{"ushort", PixelType::kUint16},
                                 Name{"unsigned short", PixelType::kUint16},
                                 Name{"unsigned short int", PixelType::kUint16},
                                 Name{"uint16", PixelType::kUint16},
                                 Name{"uint16_t", PixelType::kUint16},
                                 Name{"int", PixelType::kInt32},
                                 Name{"signed int", PixelType::kInt32},
                                 Name{"int32", PixelType::kInt32},
                                 Name{"int32_t", PixelType::kInt32},
                                 Name{"uint", PixelType::kUint32},
                                 Name{"unsigned int", PixelType::kUint32},
                                 Name{"uint32", PixelType::kUint32},
                                 Name{"uint32_t", PixelType::kUint32},
                                 Name{"float", PixelType::kFloat32},
                                 Name{"double", PixelType::kFloat64}};
  for (const Name& name : kTypes) {
    if (name.text == text) return name.type;
  }
  return {};
}

Result<void> read_nrrd_sizes(ImageFile& file) {
  const auto dimension = parse_int(file.value("dimension"));
  if (!dimension || *dimension < 2 || *dimension > 5) {
    return bad_field(file, "dimension", "2 to 5", file.value("dimension"));
  }
  const std::string_view text = file.value("sizes");
  const auto words = split_words(text);
  if (static_cast<std::int64_t>(words.size()) != *dimension) {
    return bad_field(file, "sizes", std::to_string(*dimension) + " sizes", text);
  }
  for (const std::string_view word : words) {
    const auto size = parse_int(word);
    if (!size || *size < 0) return bad_field(file, "sizes", "sizes >= 0", text);
    file.sizes.push_back(*size);
  }
  if (file.has("kinds")) {
    file.kinds = split_words(file.value("kinds"));
    if (file.kinds.size() != file.sizes.size()) {
      return bad_field(file, "kinds", std::to_string(file.sizes.size()) + " kinds",
                       file.value("kinds"));
    }
    // A first axis of one of these kinds holds the components of one sample; it is not an axis of
    // the image.
    constexpr std::array<std::string_view, 5> kSampleKinds = {"vector", "RGB-color", "3-color",
                                                              "RGBA-color", "4-color"};
    if (std::find(kSampleKinds.begin(), kSampleKinds.end(), file.kinds[0]) != kSampleKinds.end()) {
      if (file.sizes[0] < 1 || file.sizes[0] > 4) {
        return bad_field(file, "sizes", "1 to 4 components", text);
      }
      file.components = static_cast<int>(file.sizes[0]);
      file.component_axes = 1;
      file.sizes.erase(file.sizes.begin());
      file.kinds.erase(file.kinds.begin());
    }
  }
  if (file.sizes.size() < 2 || file.sizes.size() > 4) {
    return bad_field(file, "sizes", "2 to 4 axes besides the components", text);
  }
  return {};
}

Result<void> read_encoding(ImageFile& file) {
  const std::string_view encoding = file.value("encoding");
  if (encoding == "raw") {
    file.encoding = Encoding::kRaw;
  } else if (encoding == "gz" || encoding == "gzip") {
    file.encoding = Encoding::kDeflate;
  } else {
    return Error{
        ErrorCode::kUnsupportedData,
        file.path.string() + ": encoding: expected raw or gzip, found '" + excerpt(encoding) + "'"};
  }
  const std::string_view endian = file.value("endian");
  if (endian == "big" || endian == "little") {
    file.big_endian = endian == "big";
  } else if (!endian.empty() || size_of(file.type) > 1) {
    return bad_field(file, "endian", "little or big", endian);
  }
  return {};
}

Result<void> find_nrrd_data(ImageFile& file, std::int64_t data_offset, std::int64_t file_size) {
  for (const char* key : {"line skip", "lineskip"}) {
    if (file.has(key) && file.value(key) != "0") {
      return Error{
          ErrorCode::kUnsupportedData,
          file.path.string() + ": line skip: expected 0, found '" + excerpt(file.value(key)) + "'"};
    }
  }
  const char* skip_key = file.has("byte skip") ? "byte skip" : "byteskip";
  std::int64_t skip = 0;
  if (file.has(skip_key)) {
    const auto bytes = parse_int(file.value(skip_key));
    const bool from_end = bytes && *bytes == -1 && file.encoding == Encoding::kRaw;
    if (!bytes || (*bytes < 0 && !from_end) || (*bytes > 0 && file.encoding != Encoding::kRaw)) {
      return bad_field(file, skip_key, "a number of bytes, raw data only", file.value(skip_key));
    }
    skip = *bytes;
  }
  const char* name_key = file.has("data file") ? "data file" : "datafile";
  if (file.has(name_key)) {
    auto parts =
        detached_parts(file, name_key, file.value(name_key), std::max<std::int64_t>(skip, 0));
    if (!parts) return parts.error();
    file.data = std::move(*parts);
  } else {
    const std::int64_t there = std::max<std::int64_t>(file_size - data_offset, 0);
    const std::int64_t skipped = std::clamp<std::int64_t>(skip, 0, there);
    file.data.push_back({file.path, data_offset + skipped, there - skipped});
  }
  if (skip != -1) return {};
  std::int64_t bytes = static_cast<std::int64_t>(size_of(file.type)) * file.components;
  for (const std::int64_t size : file.sizes) {
    if (__builtin_mul_overflow(bytes, size, &bytes)) return {};  // The sizes are rejected later.
  }
  const std::int64_t each = bytes / static_cast<std::int64_t>(file.data.size());
  for (DataPart& part : file.data) {
    const std::int64_t excess = std::max<std::int64_t>(part.size - each, 0);
    part.offset += excess;
    part.size -= excess;
  }
  return {};
}

/// Finds the keys of the format whatever their case, as Teem does. Notes keys that are one letter
/// off.
void ignore_case(ImageFile& file) {
  constexpr std::array kKnown{"dimension",
                              "sizes",
                              "type",
                              "endian",
                              "encoding",
                              "kinds",
                              "space",
                              "spacings",
                              "space dimension",
                              "space directions",
                              "space origin",
                              "space units",
                              "thicknesses",
                              "measurement frame",
                              "axis mins",
                              "axismins",
                              "axis maxs",
                              "axismaxs",
                              "sample units",
                              "sampleunits",
                              "old min",
                              "oldmin",
                              "old max",
                              "oldmax",
                              "line skip",
                              "lineskip",
                              "byte skip",
                              "byteskip",
                              "data file",
                              "datafile"};
  for (const char* key : kKnown) {
    const std::string_view other = other_case(file, key);
    if (!other.empty()) {
      file.keys.emplace(key, file.value(other));
    } else {
      note_near_key(file, key, kKnown);
    }
  }
}

}  // namespace

Result<void> interpret_nrrd(ImageFile& file, std::int64_t data_offset, std::int64_t file_size) {
  ignore_case(file);
  const auto type = nrrd_type(file.value("type"));
  if (!type) return bad_field(file, "type", "int16, uint8, float, …", file.value("type"));
  file.type = *type;
  compare_spellings(file, {"byte skip", "byteskip"});
  compare_spellings(file, {"data file", "datafile"});
  if (const auto ok = read_nrrd_sizes(file); !ok) return ok;
  if (const auto ok = read_encoding(file); !ok) return ok;
  return find_nrrd_data(file, data_offset, file_size);
}

}  // namespace nav::io::detail
