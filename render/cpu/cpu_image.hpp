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

/// A pixel before the ultrasound image is added: colour = base + weight · grey(column, row). The
/// opacity never depends on the grey, so a new ultrasound image at the same position needs no ray.
struct PixelRecord {
  float base[3];  ///< Everything else, including the background.
  float weight;   ///< Weight of the ultrasound image; 0: not visible here.
  float column;
  float row;
  std::uint64_t signature;  ///< Signature of everything that may change without casting every ray
                            ///< again.
};

/// The pixels of the last image of a CPU engine, and the buffers in which images were returned.
class CpuImage {
 public:
  /// Makes room for an image. Every record must be written again, except those of blocks that are
  /// blank(). \p background: colour of all blank blocks; null: no block is blank.
  void start(int width, int height, const Eigen::Vector3d* background);
  [[nodiscard]] bool has_size(int width, int height) const {
    return width == width_ && height == height_;
  }
  /// Record of pixel (x, y). Different threads may write different records.
  [[nodiscard]] PixelRecord& at(int x, int y) {
    return records_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x)];
  }
  /// True when the block of kBlock × kBlock pixels with pixel (x, y) shows only the background and
  /// was drawn that way. A block belongs to one thread.
  [[nodiscard]] bool blank(int x, int y) const { return blank_[block_of(x, y)] != 0; }
  void set_blank(int x, int y, bool blank) {
    blank_[block_of(x, y)] = static_cast<std::uint8_t>(blank);
  }
  static constexpr int kBlock = 8;
  /// Finds the pixels in which the ultrasound image is visible, after records were written.
  /// \p plane: false if it is visible in none.
  void collect(bool plane, int threads);
  /// The image with an ultrasound image added; null: none is added. Writes only the pixels that
  /// differ from those of a buffer that nobody else holds.
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
    std::uint64_t collected = 0;  ///< Value of collected_ when the pixels were written.
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
  std::vector<std::uint8_t> blank_;            ///< One flag per block.
  std::optional<Eigen::Vector3d> background_;  ///< Colour of the blank blocks.
  std::vector<PixelRecord> records_;
  std::vector<std::vector<Seen>> seen_;  ///< One list per row.
  std::uint64_t collected_ = 0;
  std::vector<Buffer> buffers_;
};

}  // namespace nav::render
