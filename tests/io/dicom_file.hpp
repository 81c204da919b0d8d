// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/io/support.hpp"

namespace nav::test {

/// Little-endian bytes of an integer.
template <class T>
std::string le(T value) {
  std::string out;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    out += static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 255);
  }
  return out;
}

/// DICOM data set built by hand (explicit VR, little-endian), so that the tests can give the
/// readers every fault that a file can have.
class DicomFile {
 public:
  DicomFile& text(std::uint32_t tag, const std::string& vr, std::string value) {
    if (value.size() % 2 != 0) value += vr == "UI" ? '\0' : ' ';
    return raw(tag, vr, value);
  }
  DicomFile& us(std::uint32_t tag, unsigned value) {
    return raw(tag, "US", le(static_cast<std::uint16_t>(value)));
  }
  DicomFile& raw(std::uint32_t tag, const std::string& vr, const std::string& value) {
    elements_[tag] = {vr, value};
    return *this;
  }
  DicomFile& sequence(std::uint32_t tag, const std::vector<DicomFile>& items) {
    std::string value;
    for (const DicomFile& item : items) {
      const std::string content = item.data_set();
      value +=
          le<std::uint32_t>(0xe000fffe) + le(static_cast<std::uint32_t>(content.size())) + content;
    }
    return raw(tag, "SQ", value);
  }
  DicomFile& erase(std::uint32_t tag) {
    elements_.erase(tag);
    return *this;
  }
  /// Pixel data in fragments: an empty offset table, followed by one fragment per frame.
  DicomFile& encapsulated(const std::vector<std::string>& fragments, const std::string& syntax) {
    std::string value = le<std::uint32_t>(0xe000fffe) + le<std::uint32_t>(0);
    for (std::string fragment : fragments) {
      if (fragment.size() % 2 != 0) fragment += '\0';
      value += le<std::uint32_t>(0xe000fffe) + le(static_cast<std::uint32_t>(fragment.size())) +
               fragment;
    }
    value += le<std::uint32_t>(0xe0ddfffe) + le<std::uint32_t>(0);
    elements_[0x7fe00010] = {"encapsulated", value};
    syntax_ = syntax;
    return *this;
  }

  /// Writes the file without value representations (implicit VR little-endian), the transfer syntax
  /// that every program must read. Not for data sets with sequences.
  DicomFile& implicit() {
    implicit_ = true;
    syntax_ = "1.2.840.10008.1.2";
    return *this;
  }

  [[nodiscard]] std::string data_set() const {
    std::string out;
    for (const auto& [tag, element] : elements_) {
      out += implicit_ ? implicit_bytes(tag, element.second) : element_bytes(tag, element);
    }
    return out;
  }
  [[nodiscard]] std::string bytes() const {
    DicomFile meta;
    meta.text(0x00020010, "UI", syntax_);
    meta.text(0x00020002, "UI", "1.2.840.10008.5.1.4.1.1.2");
    meta.text(0x00020003, "UI", "1.2.3.4");
    const std::string group = meta.data_set();
    DicomFile length;
    length.raw(0x00020000, "UL", le(static_cast<std::uint32_t>(group.size())));
    return std::string(128, '\0') + "DICM" + length.data_set() + group + data_set();
  }

 private:
  using Element = std::pair<std::string, std::string>;
  static std::string element_bytes(std::uint32_t tag, const Element& element) {
    const auto& [vr, value] = element;
    std::string out =
        le(static_cast<std::uint16_t>(tag >> 16)) + le(static_cast<std::uint16_t>(tag));
    if (vr == "encapsulated") return out + "OB" + le<std::uint16_t>(0) + le(0xffffffffU) + value;
    if (vr == "OW" || vr == "OB" || vr == "SQ") {
      return out + vr + le<std::uint16_t>(0) + le(static_cast<std::uint32_t>(value.size())) + value;
    }
    return out + vr + le(static_cast<std::uint16_t>(value.size())) + value;
  }
  static std::string implicit_bytes(std::uint32_t tag, const std::string& value) {
    return le(static_cast<std::uint16_t>(tag >> 16)) + le(static_cast<std::uint16_t>(tag)) +
           le(static_cast<std::uint32_t>(value.size())) + value;
  }
  std::map<std::uint32_t, Element> elements_;
  bool implicit_ = false;
  std::string syntax_ = "1.2.840.10008.1.2.1";
};

constexpr int kDicomColumns = 5;
constexpr int kDicomRows = 4;

/// CT slice of 5 x 4 pixels, 0.5 mm wide and 0.75 mm high. \p stored (i, j) gives the pixel values.
/// \p position and \p orientation have the text form of their DICOM tags.
inline DicomFile ct_slice(const std::string& position, const std::function<int(int, int)>& stored,
                          const std::string& orientation = "1\\0\\0\\0\\1\\0",
                          int columns = kDicomColumns, int rows = kDicomRows) {
  std::vector<std::int16_t> pixels;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) pixels.push_back(static_cast<std::int16_t>(stored(i, j)));
  }
  DicomFile d;
  d.text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\AXIAL")
      .text(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2");
  d.text(0x00080018, "UI", "1.2.3.4").text(0x00080060, "CS", "CT");
  d.text(0x0020000d, "UI", "1.2.3").text(0x0020000e, "UI", "1.2.3.1");
  d.text(0x00200032, "DS", position).text(0x00200037, "DS", orientation);
  d.us(0x00280002, 1).text(0x00280004, "CS", "MONOCHROME2");
  d.us(0x00280010, static_cast<unsigned>(rows)).us(0x00280011, static_cast<unsigned>(columns));
  d.text(0x00280030, "DS", "0.75\\0.5");
  d.us(0x00280100, 16).us(0x00280101, 16).us(0x00280102, 15).us(0x00280103, 1);
  d.text(0x00281052, "DS", "-1000").text(0x00281053, "DS", "1");
  d.raw(0x7fe00010, "OW", bytes_of(pixels));
  return d;
}

/// Returns one frame in the run-length code of DICOM: literal runs only, high bytes before low
/// bytes.
inline std::string run_length_code(const std::vector<std::int16_t>& pixels) {
  std::vector<std::string> segments;
  for (const int shift : {8, 0}) {
    std::string plane;
    for (const std::int16_t p : pixels) {
      plane += static_cast<char>((static_cast<std::uint16_t>(p) >> shift) & 255);
    }
    std::string code;
    for (std::size_t i = 0; i < plane.size(); i += 128) {
      const std::string run = plane.substr(i, 128);
      code += static_cast<char>(run.size() - 1) + run;
    }
    if (code.size() % 2 != 0) code += '\0';
    segments.push_back(code);
  }
  std::string header = le<std::uint32_t>(2) + le<std::uint32_t>(64) +
                       le(static_cast<std::uint32_t>(64 + segments[0].size()));
  header.resize(64, '\0');
  return header + segments[0] + segments[1];
}

}  // namespace nav::test
