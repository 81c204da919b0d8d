// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/image.hpp"

namespace nav::render {

/// Reads pictures back from the device, through memory of the driver's that it copies them to: to
/// read video memory itself takes a hundred times as long (832 × 624 pixels on an H100: 350 ms).
/// Needs the context current, also to be released. Internal to render/.
class GlReadBuffer {
 public:
  GlReadBuffer() = default;
  ~GlReadBuffer() { release(); }
  GlReadBuffer(const GlReadBuffer&) = delete;
  GlReadBuffer& operator=(const GlReadBuffer&) = delete;

  /// The colours of an attachment of the framebuffer that is bound for reading, from its lower left
  /// corner on, bottom row first. Waits for the device. direct: without that memory, which software
  /// rasterisers do not need.
  void read(unsigned attachment, int width, int height, bool direct, std::vector<RgbaF>& pixels);
  void release();

 private:
  unsigned buffer_ = 0;
};

}  // namespace nav::render
