// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/cutaway_mesh.hpp"
#include "render/engine.hpp"
#include "render/gl/gl_cost_sums.hpp"
#include "render/gl/gl_lattice.hpp"
#include "render/gl/gl_predicates.hpp"
#include "render/gl/gl_program.hpp"
#include "render/gl/gl_read.hpp"
#include "render/gl/gl_textures.hpp"
#include "render/gl/gl_timer.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/scene_compare.hpp"
#include "render/skipping/coarse_volumes.hpp"

namespace nav::render {

/// The GLSL ray caster. It draws scenes into its own single-precision target. Every function needs
/// the context current and leaves all state that VTK tracks as it was. Internal to render/.
class GlRaycaster {
 public:
  /// Largest shift, as a part of a cell, by which surfaces of a cutaway around large meshes may be
  /// interpolated between rays (CutawayField::meet_all()).
  static constexpr double kMeshTolerance = 0.25;

  GlRaycaster() = default;
  ~GlRaycaster() { release(); }
  GlRaycaster(const GlRaycaster&) = delete;
  GlRaycaster& operator=(const GlRaycaster&) = delete;

  /// Draws a scene. Precondition: a validated scene. Rejects what does not fit on the device. Draws
  /// nothing if the image would equal the last one. Only inserts the ultrasound image if nothing
  /// else has changed. If something moved in the same view, it casts the rays that meet it now or
  /// met it before. With depth, which is the geometry of others, it casts all rays, because that
  /// geometry may always have changed.
  Result<void> draw(const Scene& scene, const std::optional<SharedDepth>& depth = {});
  /// Makes draw() end with kCancelled when it is asked to; null: never. A software rasteriser is
  /// asked between rows of pixels, a graphics card before its rays only. It must outlive draw().
  void set_interrupt(const Interrupt* interrupt) { interrupt_ = interrupt; }
  /// Blends the last image over a part of the framebuffer that is bound: x, y of its lower left
  /// corner, width, height. An image with fewer pixels is enlarged, bilinear between its rays.
  Result<void> composite(const std::array<int, 4>& at);
  /// The last image, premultiplied, top row first. Waits for the device.
  [[nodiscard]] std::vector<RgbaF> read();
  /// The cost of the last image; reads the number of samples back from the device. All zero if no
  /// ray was cast.
  [[nodiscard]] RenderStatistics statistics();
  /// The cost without samples and rays, which would have to be read back.
  [[nodiscard]] const RenderStatistics& timings() const { return statistics_; }
  /// The time of the rays alone, s.
  [[nodiscard]] double cast_s() const { return statistics_.cast_s; }
  [[nodiscard]] bool is_provisional() const { return statistics_.provisional; }

  /// Numbers of programs compiled and textures sent since the beginning, for tests.
  [[nodiscard]] int compiled() const { return programs_.compiled(); }
  [[nodiscard]] const GlUploads& uploads() const { return whole_.textures.uploads(); }
  /// Number of textures sent for the ultrasound volume beside the CT.
  [[nodiscard]] const GlUploads& second_uploads() const { return second_.uploads(); }
  /// True if the device interpolates 16-bit voxels more coarsely than 1e-4 of a step, so that
  /// shaders interpolate by hand. Known after the first draw().
  [[nodiscard]] bool manual_filter() const { return manual_filter_.value_or(false); }
  /// True if the last image used GlFilter::kGathers.
  [[nodiscard]] bool gathers() const { return whole_.textures.has_slices(); }
  /// Sets an artificial limit of the device's arrays of slices, for tests.
  void set_most_slices(int slices) { most_slices_ = slices; }
  /// True if volumes are pairs of voxels. Known after the first draw().
  [[nodiscard]] bool voxel_pairs() const { return whole_.textures.has_voxel_pairs(); }
  [[nodiscard]] const GlPredicates& predicates() const { return whole_.predicates; }
  /// Number of images after which a predicate set gets its own program. Until then a generic
  /// program, which reads sets from a table, draws it, so that a new set does not wait for a
  /// compiler.
  static constexpr int kSettledAfter = 3;
  void set_settled_after(int images) { settled_after_ = images; }
  /// Makes the next image cast all its rays, for tests.
  void forget_image() { last_.reset(); }
  /// Replaces kBytesAImage, for tests.
  void set_bytes_a_image(std::size_t bytes) { bytes_a_image_ = bytes; }
  /// Replaces the measurement of the filter, for tests.
  void set_filter(GlFilter filter) {
    manual_filter_ = filter != GlFilter::kDevice;
    gathers_ = filter == GlFilter::kGathers;
    last_.reset();
  }
  /// Keeps volumes as pairs of voxels (VOXEL_PAIRS of shaders/include/ct.glsl). Default: if the
  /// device draws in software. For tests.
  void set_voxel_pairs(bool wanted) {
    voxel_pairs_ = wanted;
    last_.reset();
  }
  /// Casts rays by compute shaders, for every pixel. Default: what the device does faster. Needs
  /// OpenGL 4.3. For tests.
  void set_compute(bool wanted) {
    compute_ = wanted;
    last_.reset();
  }
  /// Behaves like a driver that accepts no compute shader, for tests.
  void reject_compute() { programs_.reject_compute(); }
  /// True if compute shaders cast the rays. Known after the first draw().
  [[nodiscard]] bool computes() const { return compute_.value_or(false); }
  /// Writes several cells one after the other. Default: if the device draws in software. For tests.
  void set_unrolled(bool wanted) {
    unrolled_ = wanted;
    last_.reset();
  }
  /// Makes compute shaders read tables as storage buffers. Default: unless the device draws in
  /// software. For tests.
  void set_storage(bool wanted) {
    storage_ = wanted;
    last_.reset();
  }
  /// Reads images back and times them as software rasterisers need it. Default: if the device is
  /// one. For tests.
  void set_in_software(bool wanted) { in_software_ = wanted; }
  /// Sets an artificial limit of the device's 3D textures, voxels along an edge, for tests.
  void set_largest_edge(int voxels) {
    whole_.textures.set_largest_edge(voxels);
    second_.set_largest_edge(voxels);
  }
  /// Sets an artificial limit of its memory, in voxels, for tests.
  void set_memory(std::size_t voxels) { whole_.textures.set_memory(voxels); }
  /// Sets an artificial limit of the textures of a fragment shader, for tests.
  void set_most_samplers(int most) { programs_.set_most_samplers(most); }
  /// Allows gradients to be kept on the device, 8 bytes per voxel, for tests.
  void set_gradient_texture(bool allowed) {
    whole_.textures.set_gradient_texture(allowed);
    last_.reset();
  }
  /// Frees everything on the device.
  void release();

 private:
  /// The data from which images of a scene are drawn.
  struct Source {
    GlTextures textures;
    GlPredicates predicates;
  };

  Result<void> prepare_targets(int width, int height, bool layers, bool signatures);
  Result<void> draw_fitted(const Scene& scene, const std::optional<SharedDepth>& depth,
                           SceneChange change);
  /// The predicate set of a scene whose image has to be provisional; otherwise none.
  [[nodiscard]] Result<std::optional<PredicateSet>> set_lacking(const Scene& scene) const;
  Result<void> cast_coarse(const Scene& scene, const PredicateSet& set,
                           const std::optional<SharedDepth>& depth);
  void release_coarse();
  /// Casts the rays. same_view: rays that meet what they met before may keep their pixels.
  Result<void> cast(const Scene& scene, const std::optional<SharedDepth>& depth, bool same_view);
  /// The form that draws the predicates of the last scene: their own program or the generic one.
  GlPredicateForm form_now(GlFeatures features);
  /// Prepares the targets so that rays of the program in use keep the pixels that they may keep.
  void begin_keeping(GlProgram& program, bool keep);
  void count_bricks(const GlFeatures& features);
  Result<void> resolve(const Scene& scene);
  /// Sends the surfaces of a cutaway around large meshes, which are computed for every ray
  /// beforehand.
  void send_field(const Scene& scene);
  Result<void> update(const Scene& scene);
  Result<void> update_second(const Scene& scene);
  void bind_predicates(GlProgram& program, bool generic, const Scene& scene);
  void bind_textures(const std::optional<SharedDepth>& depth, bool projects);
  [[nodiscard]] GlTexture& image() { return layers_ ? resolved_ : targets_.front; }
  void release_targets();
  /// Finds out once what the device does well.
  Result<void> know_device();
  void cast_every_pixel(const GlFeatures& features);
  void draw_one_pixel(const GlFeatures& features);
  void dispatch(int width, int height);
  void draw_triangle();
  void draw_in_bands(int height);
  [[nodiscard]] bool interrupted() const {
    return interrupt_ != nullptr && interrupt_->requested();
  }

  GlProgramCache programs_;
  std::unique_ptr<GlProgram> resolve_program_;
  std::unique_ptr<GlProgram> composite_program_;
  Source whole_;
  std::optional<Source> coarse_;  ///< Source of provisional images, while there are any.
  Source* source_ = &whole_;      ///< The source of the last image.
  CoarseVolumes coarse_volumes_;
  std::optional<Scene> provisional_;  ///< The scene of the last image if it was provisional.
  std::size_t bytes_a_image_ = kBytesAImage;
  GlTextures second_;  ///< The ultrasound volume beside the CT.
  int settled_after_ = kSettledAfter;
  std::optional<GlFeatures> wanted_;  ///< Last features wanted, with the set's own program.
  int images_wanted_ = 0;             ///< Images drawn with them by the generic program.
  GlLattice lattice_;                 ///< Casts fewer rays than pixels.
  std::optional<CutawayField> field_;
  GlTexture field_spans_;
  GlLayers targets_;
  GlTexture resolved_;
  GlTexture signatures_;         ///< Signatures of the rays, with signed_.
  GlTexture signatures_before_;  ///< Signatures of the image that the targets hold.
  unsigned framebuffer_ = 0;
  unsigned resolve_framebuffer_ = 0;
  bool layers_ = false;                   ///< true: the scene has a plane.
  bool signed_ = false;                   ///< true: the targets include signatures.
  std::optional<GlFeatures> drawn_with_;  ///< Features of the program that filled the targets.
  std::optional<Scene> last_;             ///< The scene whose image the targets hold.
  unsigned vertex_array_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::optional<bool> manual_filter_;
  bool gathers_ = true;  ///< Interpolates with gathers if volumes fit.
  int most_slices_ = std::numeric_limits<int>::max();
  std::optional<bool> voxel_pairs_;
  std::optional<bool> compute_;
  std::optional<bool> unrolled_;
  std::optional<bool> in_software_;
  std::optional<bool> storage_;
  RenderStatistics statistics_;
  GlTimer timer_;
  GlReadBuffer read_buffer_;
  GlCostSums cost_sums_;
  bool cast_ = false;                     ///< true: the last image cast rays.
  const Interrupt* interrupt_ = nullptr;  ///< Null: no image is interrupted.
  bool given_up_ = false;                 ///< true: rays of this image were left out.
};

}  // namespace nav::render
