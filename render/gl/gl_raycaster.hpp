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
#include "render/gl/gl_packed_rays.hpp"
#include "render/gl/gl_predicates.hpp"
#include "render/gl/gl_program.hpp"
#include "render/gl/gl_read.hpp"
#include "render/gl/gl_textures.hpp"
#include "render/gl/gl_timer.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/scene_compare.hpp"
#include "render/skipping/coarse_volumes.hpp"

namespace nav::render {

/// The GLSL ray caster: draws scenes into a single-precision target of its own. Every function
/// needs the context current; leaves all state that VTK tracks as it found it. Internal to render/.
class GlRaycaster {
 public:
  /// The surfaces of a cutaway around large meshes are interpolated between rays where that moves
  /// them by no more than this part of a cell (CutawayField::meet_all()).
  static constexpr double kMeshTolerance = 0.25;

  GlRaycaster() = default;
  ~GlRaycaster() { release(); }
  GlRaycaster(const GlRaycaster&) = delete;
  GlRaycaster& operator=(const GlRaycaster&) = delete;

  /// Precondition: a validated scene. Refuses what does not fit the device. Draws nothing when the
  /// picture would be the last one, and only puts in the ultrasound picture when nothing but that
  /// has changed. When something moved in the same view, casts the rays that meet it or met it
  /// before; geometry of others (depth) may always have changed, so that all rays are cast.
  Result<void> draw(const Scene& scene, const std::optional<SharedDepth>& depth = {});
  /// Blends the last picture over a part of the framebuffer that is bound: x, y of its lower left
  /// corner, width, height. A picture of fewer pixels is enlarged, bilinear between its rays.
  Result<void> composite(const std::array<int, 4>& at);
  /// The last picture, premultiplied, top row first. Waits for the device.
  [[nodiscard]] std::vector<RgbaF> read();
  /// What the last picture cost; reads the number of samples back from the device.
  /// All zero when no ray was cast.
  [[nodiscard]] RenderStatistics statistics();
  /// The same without samples and rays, for which it would have to be read back.
  [[nodiscard]] const RenderStatistics& timings() const { return statistics_; }
  /// Of these, what its rays took.
  [[nodiscard]] double cast_s() const { return statistics_.cast_s; }
  [[nodiscard]] bool is_provisional() const { return statistics_.provisional; }

  /// Programs compiled and textures sent since the beginning, for tests.
  [[nodiscard]] int compiled() const { return programs_.compiled(); }
  [[nodiscard]] const GlUploads& uploads() const { return whole_.textures.uploads(); }
  /// Of the ultrasound volume beside the CT.
  [[nodiscard]] const GlUploads& second_uploads() const { return second_.uploads(); }
  /// True when the device interpolates 16-bit voxels more coarsely than 1e-4 of a step, so that
  /// shaders interpolate by hand. Known after the first draw().
  [[nodiscard]] bool manual_filter() const { return manual_filter_.value_or(false); }
  /// By GlFilter::kGathers, in the last picture.
  [[nodiscard]] bool gathers() const { return whole_.textures.has_slices(); }
  /// An artificial limit of the device's arrays of slices, for tests.
  void set_most_slices(int slices) { most_slices_ = slices; }
  /// Volumes are pairs of voxels: known after the first draw().
  [[nodiscard]] bool voxel_pairs() const { return whole_.textures.has_voxel_pairs(); }
  [[nodiscard]] const GlPredicates& predicates() const { return whole_.predicates; }
  /// A set of predicates gets a program of its own with its picture after this many; until then one
  /// draws it that reads sets from a table, so that a new set waits for no compiler.
  static constexpr int kSettledAfter = 3;
  void set_settled_after(int pictures) { settled_after_ = pictures; }
  /// The next picture casts all its rays, for tests.
  void forget_picture() { last_.reset(); }
  /// Instead of kBytesAPicture, for tests.
  void set_bytes_a_picture(std::size_t bytes) { bytes_a_picture_ = bytes; }
  /// Decides instead of the measurement, for tests.
  void set_filter(GlFilter filter) {
    manual_filter_ = filter != GlFilter::kDevice;
    gathers_ = filter == GlFilter::kGathers;
    last_.reset();
  }
  /// Whether volumes are kept as pairs of voxels (VOXEL_PAIRS of shaders/include/ct.glsl): where
  /// the device draws in software, unless told otherwise, for tests.
  void set_voxel_pairs(bool wanted) {
    voxel_pairs_ = wanted;
    last_.reset();
  }
  /// Whether rays are cast by compute shaders, where every pixel has one: what the device does
  /// faster, unless told otherwise, for tests. Needs OpenGL 4.3.
  void set_compute(bool wanted) {
    compute_ = wanted;
    last_.reset();
  }
  /// As on a driver that takes none of them, for tests.
  void refuse_compute() { programs_.refuse_compute(); }
  /// Known after the first draw().
  [[nodiscard]] bool computes() const { return compute_.value_or(false); }
  /// Whether several cells are written one after the other: where the device draws in software,
  /// unless told otherwise, for tests.
  void set_unrolled(bool wanted) {
    unrolled_ = wanted;
    last_.reset();
  }
  /// Whether compute shaders read tables as storage buffers: not where the device draws in
  /// software, unless told otherwise, for tests.
  void set_storage(bool wanted) {
    storage_ = wanted;
    last_.reset();
  }
  /// Whether pictures are read back and timed as software rasterisers need it, unless told
  /// otherwise, for tests.
  void set_in_software(bool wanted) { in_software_ = wanted; }
  /// An artificial limit of the device's 3D textures, voxels along an edge, for tests.
  void set_largest_edge(int voxels) {
    whole_.textures.set_largest_edge(voxels);
    second_.set_largest_edge(voxels);
  }
  /// An artificial limit of its memory, voxels, for tests.
  void set_memory(std::size_t voxels) { whole_.textures.set_memory(voxels); }
  /// An artificial limit of the textures of a fragment shader, for tests.
  void set_most_samplers(int most) { programs_.set_most_samplers(most); }
  /// Whether gradients may be kept on the device, 8 bytes a voxel, for tests.
  void set_gradient_texture(bool allowed) {
    whole_.textures.set_gradient_texture(allowed);
    last_.reset();
  }
  /// Frees everything on the device.
  void release();

 private:
  /// What pictures of a scene are drawn from.
  struct Source {
    GlTextures textures;
    GlPredicates predicates;
  };

  Result<void> prepare_targets(int width, int height, bool layers, bool signatures);
  Result<void> draw_fitted(const Scene& scene, const std::optional<SharedDepth>& depth,
                           SceneChange change);
  /// Of a scene whose picture has to be provisional; else none.
  [[nodiscard]] Result<std::optional<PredicateSet>> set_lacking(const Scene& scene) const;
  Result<void> cast_coarse(const Scene& scene, const PredicateSet& set,
                           const std::optional<SharedDepth>& depth);
  void release_coarse();
  /// same_view: rays that meet what they met before may keep their pixels.
  Result<void> cast(const Scene& scene, const std::optional<SharedDepth>& depth, bool same_view);
  /// What draws the predicates of the last scene: their own program or the generic one.
  GlPredicateForm form_now(GlFeatures features);
  /// Prepares the targets so that rays of the program in use keep what they may.
  void begin_keeping(GlProgram& program, bool keep);
  void count_bricks(const GlFeatures& features);
  Result<void> resolve(const Scene& scene);
  /// The surfaces of a cutaway around large meshes, which are searched for every ray beforehand.
  void send_field(const Scene& scene);
  Result<void> update(const Scene& scene);
  Result<void> update_second(const Scene& scene);
  void bind_predicates(GlProgram& program, bool generic, const Scene& scene);
  void bind_textures(const std::optional<SharedDepth>& depth, bool projects);
  [[nodiscard]] GlTexture& picture() { return layers_ ? resolved_ : targets_.front; }
  void release_targets();
  /// Measures what the device does well, once.
  Result<void> know_device();
  void cast_every_pixel(const GlFeatures& features);
  void draw_one_pixel(const GlFeatures& features);
  void dispatch(int width, int height);
  void draw_triangle();

  GlProgramCache programs_;
  std::unique_ptr<GlProgram> resolve_program_;
  std::unique_ptr<GlProgram> composite_program_;
  Source whole_;
  std::optional<Source> coarse_;  ///< Of provisional pictures, while there are any.
  Source* source_ = &whole_;      ///< Of the last picture.
  CoarseVolumes coarse_volumes_;
  std::optional<Scene> provisional_;  ///< Whose provisional picture the last one was.
  std::size_t bytes_a_picture_ = kBytesAPicture;
  GlTextures second_;  ///< The ultrasound volume beside the CT.
  int settled_after_ = kSettledAfter;
  std::optional<GlFeatures> wanted_;  ///< Of the last picture by predicates, their own program.
  int pictures_wanted_ = 0;           ///< Drawn with these features without their own program.
  GlLattice lattice_;                 ///< With fewer rays than pixels.
  GlPackedRays packed_rays_;          ///< The same where OpenGL runs on the processor.
  std::optional<CutawayField> field_;
  GlTexture field_spans_;
  GlLayers targets_;
  GlTexture resolved_;
  GlTexture signatures_;         ///< Of the rays, with signed_.
  GlTexture signatures_before_;  ///< Of the picture that the targets hold.
  unsigned framebuffer_ = 0;
  unsigned resolve_framebuffer_ = 0;
  bool layers_ = false;                   ///< The scene has a plane.
  bool signed_ = false;                   ///< The targets include signatures.
  std::optional<GlFeatures> drawn_with_;  ///< Of the program that filled the targets.
  std::optional<Scene> last_;             ///< Whose picture the targets hold.
  unsigned vertex_array_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::optional<bool> manual_filter_;
  bool gathers_ = true;  ///< By hand, where volumes fit.
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
  bool cast_ = false;  ///< The last picture took rays through the volume.
};

}  // namespace nav::render
