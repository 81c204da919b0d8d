// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "nav/image.hpp"
#include "render/spec/ray_spec_surfaces.hpp"

namespace nav::render {

/// A pixel before the ultrasound picture is put in: colour = base + weight · grey(column, row).
/// Opacity never depends on the grey, so a new ultrasound picture at the same place needs no ray.
struct PixelRecord {
  float base[3];  ///< Everything else, background included.
  float weight;   ///< Of the ultrasound picture; 0: not seen here.
  float column;
  float row;
  std::uint64_t signature;  ///< Of all that may change without casting every ray anew.
};

/// The pixels of the last picture of a CPU engine, and the buffers that it was given out in.
class CpuPicture {
 public:
  /// Room for a picture, every record of which is to be written anew but for those of blocks that
  /// are blank(). background: what all blank blocks show; null: none are.
  void start(int width, int height, const Eigen::Vector3d* background);
  [[nodiscard]] bool has_size(int width, int height) const {
    return width == width_ && height == height_;
  }
  /// Record of pixel (x, y); different ones may be written by different threads.
  [[nodiscard]] PixelRecord& at(int x, int y) {
    return records_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x)];
  }
  /// Whether the block of kBlock × kBlock pixels with pixel (x, y) shows the background alone, and
  /// was drawn as that. A block is only of one thread.
  [[nodiscard]] bool blank(int x, int y) const { return blank_[block_of(x, y)] != 0; }
  void set_blank(int x, int y, bool blank) {
    blank_[block_of(x, y)] = static_cast<std::uint8_t>(blank);
  }
  static constexpr int kBlock = 8;
  /// After records were written: finds the pixels in which the ultrasound picture is seen. plane:
  /// false: in none.
  void collect(bool plane, int threads);
  /// The picture with an ultrasound picture put in; null: none is drawn. Writes only the pixels
  /// that differ from those of a buffer that nobody else holds any more.
  Image2d<RgbaF> finish(const spec::PlaneSurface<float>* plane, int threads);

 private:
  struct Seen {
    int x;
    float base[3];
    float weight;
    float column;
    float row;
  };
  struct Buffer {
    std::shared_ptr<std::vector<RgbaF>> pixels;
    std::uint64_t collected = 0;  ///< Which records its unseen pixels are from.
  };

  Buffer& free_buffer();
  void write_bases(std::vector<RgbaF>& pixels, int threads) const;

  [[nodiscard]] std::size_t block_of(int x, int y) const {
    return static_cast<std::size_t>(y / kBlock) * static_cast<std::size_t>(blocks_across_) +
           static_cast<std::size_t>(x / kBlock);
  }

  int width_ = 0;
  int height_ = 0;
  int blocks_across_ = 0;
  std::vector<std::uint8_t> blank_;            ///< By block.
  std::optional<Eigen::Vector3d> background_;  ///< Of the blank blocks.
  std::vector<PixelRecord> records_;
  std::vector<std::vector<Seen>> seen_;  ///< By row.
  std::uint64_t collected_ = 0;
  std::vector<Buffer> buffers_;
};

}  // namespace nav::render
