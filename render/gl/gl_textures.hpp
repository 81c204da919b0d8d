// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/gl/gl_shape_rows.hpp"
#include "render/gl/gl_volume_fit.hpp"
#include "render/scene.hpp"
#include "render/skipping/brick_grid.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::render {

/// A texture name that deletes itself. Needs the context current. Internal to render/.
class GlTexture {
 public:
  GlTexture() = default;
  ~GlTexture() { release(); }
  GlTexture(const GlTexture&) = delete;
  GlTexture& operator=(const GlTexture&) = delete;
  /// The texture, created on first use.
  unsigned id();
  void release();

 private:
  unsigned id_ = 0;
};

/// A buffer texture with its buffer. Needs the context current, like GlTexture. Internal to
/// render/.
class GlTable {
 public:
  GlTable() = default;
  ~GlTable() { release(); }
  GlTable(const GlTable&) = delete;
  GlTable& operator=(const GlTable&) = delete;
  unsigned buffer_id();
  /// Reserves memory of the process for the buffer. It holds zeros, uses no page before that page
  /// is touched, and exists as long as the buffer. Returns null if there is none. The device must
  /// be idle when it is released.
  void* own_memory(std::size_t bytes);
  [[nodiscard]] void* memory() const { return memory_; }
  void release();

  GlTexture texture;

 private:
  unsigned buffer_ = 0;
  void* memory_ = nullptr;
  std::size_t memory_bytes_ = 0;
};

/// Number of times each kind of texture was sent to the device.
struct GlUploads {
  int volumes = 0;
  int transfers = 0;
  int bricks = 0;
  int images = 0;
};

/// The data that scenes need on the device. Data is sent again only if it is another object or has
/// other values. Keeps a share of what it has sent, so that an address cannot come to mean
/// something else.
class GlTextures {
 public:
  /// Sends what has changed. Returns kUnsupportedData, with the device's limits, if a volume does
  /// not fit on the device. Leaves the bindings of the active texture unit changed.
  Result<void> update(const Scene& scene);
  /// Sends only a volume.
  Result<void> update_volume(const std::shared_ptr<const StoredVolume>& volume);
  /// True if the volume is on the device.
  [[nodiscard]] bool has(const std::shared_ptr<const StoredVolume>& volume) const {
    return volume_ == volume;
  }
  void release();

  [[nodiscard]] const GlUploads& uploads() const { return uploads_; }
  [[nodiscard]] const TransferTable& table() const { return *table_; }
  [[nodiscard]] Eigen::Vector3i brick_count() const { return ranges_.count; }
  [[nodiscard]] std::uint64_t bricks_occupied() const { return bricks_occupied_; }

  /// The volume to draw in place of one that the device may not hold: the same volume, or one with
  /// fewer voxels, made once. Leaves the bindings of the active texture unit changed.
  std::shared_ptr<const StoredVolume> fitting(const std::shared_ptr<const StoredVolume>& volume);
  /// Says how the last fitting() reduced the volume; empty: not reduced.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// Call it after update() failed. True if fitting() should be called again, for fewer voxels.
  bool ask_for_less();
  /// Sets an artificial limit of the device, for tests.
  void set_largest_edge(int voxels) { largest_edge_ = voxels; }
  /// Makes uploads of more voxels fail as if the device's memory were full, for tests.
  void set_memory(std::size_t voxels) { memory_voxels_ = voxels; }
  /// The objects of the cutaway of the last scene.
  [[nodiscard]] const spec::CutawayObjects<double>& cut() const { return cut_; }

  /// True if the gradients of the last scene are on the device.
  [[nodiscard]] bool has_gradients() const {
    if (source_) return gradients_of_ == source_;
    return gradient_texture_ && !pairs_ && gradients_of_ == volume_;
  }
  /// True if the last scene's gradient source is not on the device: gradients are the CT's.
  [[nodiscard]] bool lacks_gradient_source() const { return source_ && gradients_of_ != source_; }
  void set_gradient_texture(bool allowed) { gradient_texture_ = allowed; }
  /// Keeps volumes as tables of pairs of voxels instead of textures, if the device's tables can be
  /// large enough.
  void set_voxel_pairs(bool wanted);
  [[nodiscard]] bool has_voxel_pairs() const { return pairs_; }
  /// Keeps volumes as arrays of slices instead of 3D textures, for GlFilter::kGathers. Gradients
  /// stay 3D textures.
  void set_slices(bool wanted);
  [[nodiscard]] bool has_slices() const { return slices_; }
  [[nodiscard]] int solid_count() const { return solid_count_; }

  GlTable transfer, importances, integrals, ct_pairs;
  GlTexture ct, gradients, bricks, brick_ranges, image, solids, cut_objects;

 private:
  void update_transfer(const TransferFunction& function);
  void update_gradients();
  void update_ranges();
  void update_bricks();
  void update_brick_ranges();
  void update_image(const Image2d<std::uint8_t>& pixels);

  [[nodiscard]] bool send_volume(const StoredVolume& volume);
  [[nodiscard]] bool accepts(const std::array<int, 3>& size) const;

  int largest_edge_ = std::numeric_limits<int>::max();
  std::shared_ptr<const StoredVolume> full_;  ///< The volume of the last fitting().
  std::shared_ptr<const StoredVolume> fitted_;
  std::string note_;
  std::shared_ptr<const StoredVolume> limited_;  ///< The volume to which most_voxels_ applies.
  std::size_t most_voxels_ = std::numeric_limits<std::size_t>::max();
  std::size_t memory_voxels_ = std::numeric_limits<std::size_t>::max();
  bool out_of_memory_ = false;
  GlUploads uploads_;
  std::shared_ptr<const StoredVolume> volume_;
  bool wants_pairs_ = false;
  bool pairs_ = false;  ///< true: volume_ is on the device as pairs.
  bool slices_ = false;
  bool gradient_texture_ = true;
  std::shared_ptr<const StoredVolume> gradients_of_;  ///< Volume of the gradient texture; absent:
                                                      ///< not worth one.
  std::shared_ptr<const StoredVolume> gradients_tried_;
  std::shared_ptr<const StoredVolume> source_;  ///< Scene::gradient_source of the last scene.
  std::optional<TransferFunction> function_;
  std::optional<TransferTable> table_;
  std::shared_ptr<const StoredVolume> ranges_volume_;
  BrickGrid ranges_;
  std::shared_ptr<const StoredVolume> part_ranges_of_;
  BrickGrid part_ranges_;
  bool bricks_valid_ = false;
  /// The volume whose ranges are on the device.
  std::shared_ptr<const StoredVolume> brick_ranges_of_;
  std::uint64_t bricks_occupied_ = 0;
  Image2d<std::uint8_t> pixels_;
  spec::CutawayObjects<double> cut_;
  GlRows solid_rows_, cut_rows_;
  int solid_count_ = 0;
};

}  // namespace nav::render
