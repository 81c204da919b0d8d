// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "nav/image.hpp"

namespace nav::render {

/// Reads images back from the device through memory to which the device copies them. Reading video
/// memory itself can take 350 ms for 832 × 624 pixels (docs/rendering-performance.md). Needs the
/// context current, also for release(). Internal to render/.
class GlReadBuffer {
 public:
  GlReadBuffer() = default;
  ~GlReadBuffer() { release(); }
  GlReadBuffer(const GlReadBuffer&) = delete;
  GlReadBuffer& operator=(const GlReadBuffer&) = delete;

  /// Reads the colours of an attachment of the framebuffer that is bound for reading, from its
  /// lower left corner on, bottom row first. Waits for the device. direct: without that memory,
  /// which software rasterisers do not need.
  void read(unsigned attachment, int width, int height, bool direct, std::vector<RgbaF>& pixels);
  void release();

 private:
  /// Makes a buffer of at least this many bytes, in memory of the process if the driver can.
  void make_room(std::size_t bytes);

  unsigned buffer_ = 0;
  std::size_t room_ = 0;  ///< Size in bytes.
};

}  // namespace nav::render
