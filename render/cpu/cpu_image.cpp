// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_image.hpp"

#include <atomic>

#include "nav/index.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

/// Number of images that a caller may hold at once before buffers are newly allocated each time.
constexpr std::size_t kMostBuffers = 4;

}  // namespace

void CpuImage::start(int width, int height, const Eigen::Vector3d* background) {
  const bool kept = background != nullptr && background_ == *background;
  background_ = background != nullptr ? std::optional(*background) : std::nullopt;
  blocks_across_ = (width + kBlock - 1) / kBlock;
  const int blocks = blocks_across_ * ((height + kBlock - 1) / kBlock);
  if (!kept || !has_size(width, height)) blank_.assign(as_size(blocks), 0);
  if (has_size(width, height)) return;
  buffers_.clear();
  width_ = width;
  height_ = height;
  records_.assign(as_size(width) * as_size(height), PixelRecord{});
  seen_.assign(as_size(height), {});
}

void CpuImage::collect(bool plane, int threads) {
  ++collected_;
  if (!plane) {
    for (std::vector<Seen>& seen : seen_) seen.clear();
    return;
  }
  for_each_index(height_, threads, [&](int y) {
    std::vector<Seen>& seen = seen_[as_size(y)];
    seen.clear();
    const PixelRecord* row = &at(0, y);
    for (int x = 0; x < width_; ++x) {
      const PixelRecord& r = row[x];
      if (!(r.weight > 0)) continue;
      seen.push_back({.x = x,
                      .base = {r.base[0], r.base[1], r.base[2]},
                      .weight = r.weight,
                      .column = r.column,
                      .row = r.row});
    }
  });
}

CpuImage::Buffer& CpuImage::free_buffer() {
  for (Buffer& buffer : buffers_) {
    if (buffer.pixels.use_count() > 1) continue;
    // The last holder has finished reading before it releases the buffer.
    std::atomic_thread_fence(std::memory_order_acquire);
    return buffer;
  }
  if (buffers_.size() == kMostBuffers) buffers_.erase(buffers_.begin());
  buffers_.push_back({std::make_shared<std::vector<RgbaF>>(records_.size()), 0});
  return buffers_.back();
}

void CpuImage::write_bases(std::vector<RgbaF>& pixels, int threads) const {
  for_each_index(height_, threads, [&](int y) {
    const std::size_t first = as_size(y) * as_size(width_);
    for (std::size_t i = first; i < first + as_size(width_); ++i) {
      const PixelRecord& r = records_[i];
      pixels[i] = {r.base[0], r.base[1], r.base[2], 1.0F};
    }
  });
}

Image2d<RgbaF> CpuImage::finish(const spec::PlaneSurface<float>* plane, int threads) {
  Buffer& buffer = free_buffer();
  if (buffer.collected != collected_) write_bases(*buffer.pixels, threads);
  buffer.collected = collected_;
  if (plane != nullptr) {
    for_each_index(height_, threads, [&](int y) {
      RgbaF* row = buffer.pixels->data() + as_size(y) * as_size(width_);
      for (const Seen& s : seen_[as_size(y)]) {
        const float light = s.weight * spec::image_at(*plane, s.column, s.row);
        row[s.x] = {s.base[0] + light, s.base[1] + light, s.base[2] + light, 1.0F};
      }
    });
  }
  return Image2d<RgbaF>::shared(width_, height_, buffer.pixels);
}

}  // namespace nav::render
