// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <string_view>
#include <vector>
#include <zlib.h>

#include "io/sequence.hpp"
#include "nav/diagnostics.hpp"

namespace nav::test {

inline void put(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline std::string get(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Returns one zlib stream (\p window 15) or gzip stream (31).
inline std::string deflated(std::string_view bytes, int window = 15) {
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY);
  std::string out(compressBound(bytes.size()) + 64, '\0');
  z.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

/// Returns the bytes of the values in the byte order of this machine.
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  std::string out(values.size() * sizeof(T), '\0');
  std::memcpy(out.data(), values.data(), out.size());
  return out;
}

/// Returns the bytes of the values, each value with its bytes reversed.
template <class T>
std::string swapped_bytes_of(const std::vector<T>& values) {
  std::string out = bytes_of(values);
  for (std::size_t i = 0; i < out.size(); i += sizeof(T)) {
    std::reverse(out.begin() + static_cast<std::ptrdiff_t>(i),
                 out.begin() + static_cast<std::ptrdiff_t>(i + sizeof(T)));
  }
  return out;
}

/// Succeeds if the message of an entry with \p severity contains every string of \p pieces.
inline ::testing::AssertionResult says(const CollectingDiagnostics& diagnostics, Severity severity,
                                       std::initializer_list<std::string> pieces) {
  std::string all;
  for (const auto& entry : diagnostics.entries()) {
    bool match = entry.severity == severity;
    for (const std::string& piece : pieces) {
      match = match && entry.message.find(piece) != std::string::npos;
    }
    if (match) return ::testing::AssertionSuccess();
    all += std::string("\n  ") + to_string(entry.severity) + ": " + entry.message;
  }
  return ::testing::AssertionFailure() << "nothing said contains all the pieces; said:" << all;
}

inline std::string text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace nav::test
