// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/brick_grid.hpp"
#include "render/gl_shape_rows.hpp"
#include "render/scene.hpp"
#include "render/transfer_table.hpp"

namespace nav::render {

/// A texture name that deletes itself; needs the context current. Internal to render/.
class GlTexture {
 public:
  GlTexture() = default;
  ~GlTexture() { release(); }
  GlTexture(const GlTexture&) = delete;
  GlTexture& operator=(const GlTexture&) = delete;
  /// The texture, made on first use.
  unsigned id();
  void release();

 private:
  unsigned id_ = 0;
};

/// A buffer texture with its buffer; needs the context current, as GlTexture. Internal to render/.
class GlTable {
 public:
  GlTable() = default;
  ~GlTable() { release(); }
  GlTable(const GlTable&) = delete;
  GlTable& operator=(const GlTable&) = delete;
  unsigned buffer_id();
  void release();

  GlTexture texture;

 private:
  unsigned buffer_ = 0;
};

/// How often each kind of texture was sent to the device.
struct GlUploads {
  int volumes = 0;
  int transfers = 0;
  int bricks = 0;
  int pictures = 0;
};

/// What the scenes need on the device, sent again only when it is another object or has other
/// values. Keeps a share of what it has sent, so an address cannot come to mean something else.
class GlTextures {
 public:
  /// Sends what has changed. kUnsupportedData when a volume does not fit the device, with its
  /// limits. Leaves the bindings of the active texture unit changed.
  Result<void> update(const Scene& scene);
  void release();

  [[nodiscard]] const GlUploads& uploads() const { return uploads_; }
  [[nodiscard]] const TransferTable& table() const { return *table_; }
  [[nodiscard]] Eigen::Vector3i brick_count() const { return ranges_.count; }
  [[nodiscard]] std::uint64_t bricks_occupied() const { return bricks_occupied_; }

  /// Objects of the cutaway of the last scene.
  [[nodiscard]] const spec::CutawayObjects<double>& cut() const { return cut_; }

  [[nodiscard]] int solid_count() const { return solid_count_; }

  GlTable transfer, importances, integrals;
  GlTexture ct, bricks, picture, solids, cut_objects;

 private:
  Result<void> update_volume(const std::shared_ptr<const Volume>& volume);
  void update_transfer(const TransferFunction& function);
  void update_bricks();
  void update_picture(const Image2d<std::uint8_t>& pixels);

  GlUploads uploads_;
  std::shared_ptr<const Volume> volume_;
  std::optional<TransferFunction> function_;
  std::optional<TransferTable> table_;
  std::shared_ptr<const Volume> ranges_volume_;
  BrickGrid ranges_;
  bool bricks_valid_ = false;
  std::uint64_t bricks_occupied_ = 0;
  Image2d<std::uint8_t> pixels_;
  spec::CutawayObjects<double> cut_;
  GlRows solid_rows_, cut_rows_;
  int solid_count_ = 0;
};

}  // namespace nav::render
