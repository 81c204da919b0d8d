// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_state.hpp"
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <chrono>

#include "nav/stopwatch.hpp"
#include "render/gl/gl_compute.hpp"
#include "render/gl/gl_device.hpp"
#include "render/gl/gl_filter_probe.hpp"
#include "render/gl/gl_raycaster.hpp"
#include "render/gl/gl_speed_probe.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/gl/gl_upload.hpp"
#include "render/interruptible.hpp"
#include "render/scene_compare.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

void bind(GlUnit unit, GLenum target, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture);
}

void bind_volume(GlUnit unit, GlTextures& textures) {
  const bool pairs = textures.has_voxel_pairs();
  bind(unit, pairs ? GL_TEXTURE_BUFFER : gl::kind_of_volumes(textures.has_slices()),
       pairs ? textures.ct_pairs.texture.id() : textures.ct.id());
}

void unbind_all() {
  for (const auto unit :
       {gl::kOpacityStorage, gl::kAppearancesStorage, gl::kPointsStorage, gl::kTransferStorage})
    gl::bind_storage(unit, 0);
  // In one call: a hundred calls took a card 0.2 ms.
  if (GLEW_VERSION_4_4 != 0 || GLEW_ARB_multi_bind != 0) {
    glBindTextures(kCt, kTarget - kCt + 1, nullptr);
    return;
  }
  for (int unit = kCt; unit <= kTarget; ++unit) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    for (const GLenum target :
         {GL_TEXTURE_2D, GL_TEXTURE_3D, GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BUFFER})
      glBindTexture(target, 0);
  }
}

/// Links a program that fills the viewport, on first use.
Result<void> prepare(std::unique_ptr<GlProgram>& program, const char* fragment) {
  if (program) return {};
  auto linked = GlProgram::link_fullscreen(assembled_shader(fragment));
  if (!linked) return linked.error();
  program = std::move(linked).value();
  return {};
}

/// Rejects a reduced volume. Features belong to the volume's own grid; means of either would give
/// other predicates.
Result<void> whole(const StoredVolume& volume, const StoredVolume& fitted) {
  if (&fitted == &volume) return {};
  const auto& size = volume.grid().size;
  return Error{
      ErrorCode::kUnsupportedData,
      "predicates: expected a volume that fits into the memory of this OpenGL device, found " +
          std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
          std::to_string(size[2]) + " voxels; the CPU engine draws it"};
}

/// True if the scene shows predicates of its volume, or of a second volume.
bool shows_predicates(const Scene& scene) {
  return drawn_by_predicates(scene) || has_two_volumes(scene);
}

}  // namespace

Result<void> GlRaycaster::draw(const Scene& scene, const std::optional<SharedDepth>& depth) {
  Scene keyed = scene;
  // The background is not part of the layers, but with sparse rays it decides which squares are
  // even.
  if (!sparse_rays(scene) || computes()) keyed.background_rgb.setZero();
  const SceneChange change = last_ && !depth ? change_between(*last_, keyed) : SceneChange::kView;
  statistics_ = {};
  cast_ = change >= SceneChange::kGeometry;
  statistics_.note = whole_.textures.note();
  if (change == SceneChange::kNothing) return {};
  last_.reset();
  const GlStateGuard guard;
  glActiveTexture(GL_TEXTURE0 + kTarget);
  Scene fitted = keyed;
  Result<void> drawn;
  do {
    fitted.ct = whole_.textures.fitting(scene.ct);
    // Means of voxels are smooth, and have a grid of their own.
    fitted.gradient_source = fitted.ct == scene.ct ? scene.gradient_source : nullptr;
    drawn = drawn_by_predicates(scene) ? whole(*scene.ct, *fitted.ct) : Result<void>();
    if (drawn) drawn = draw_fitted(fitted, depth, change);
  } while (!drawn && whole_.textures.ask_for_less());
  if (drawn && layers_) drawn = resolve(fitted);
  statistics_.note = whole_.textures.note();
  if (drawn && whole_.textures.lacks_gradient_source()) {
    statistics_.note += std::string(statistics_.note.empty() ? "" : "; ") +
                        "shading is not smoothed: the gradients do not fit on the device";
  }
  unbind_all();
  if (!drawn) return drawn;
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return Error{ErrorCode::kUnavailable,
                 "OpenGL: ray casting ended with error " + std::to_string(error)};
  }
  if (!depth && !statistics_.provisional) last_ = std::move(keyed);
  return {};
}

Result<void> GlRaycaster::cast(const Scene& scene, const std::optional<SharedDepth>& depth,
                               bool same_view) {
  const auto start = std::chrono::steady_clock::now();
  if (auto known = know_device(); !known) return known;
  if (auto sent = update(scene); !sent) return sent;
  GlTextures& textures = source_->textures;
  GlFeatures features = features_of(scene, textures, depth.has_value(), *manual_filter_);
  features.unrolled = *unrolled_;
  features.compute = *compute_;
  features.storage = *compute_ && *storage_;
  // A ray for every pixel errs less. Choosing among rays would cost such a device more than casting
  // them.
  if (features.compute) features.sparse = false;
  if (shows_predicates(scene)) features.predicates = form_now(features);
  const bool keep = same_view && drawn_with_ == features && features.signature() &&
                    (!features.predicates || source_->predicates.unchanged());
  drawn_with_.reset();
  if (auto ok = prepare_targets(scene.width, scene.height, features.plane, features.signature());
      !ok) {
    return ok;
  }
  const auto sparse = features.sparse ? sparse_rays(scene) : std::nullopt;
  if (sparse) {
    if (auto ok = lattice_.prepare(width_, height_, layers_, framebuffer_, *sparse); !ok) return ok;
  } else {
    lattice_.release();
  }
  const int compiled = programs_.compiled();
  auto program = programs_.get(features);
  if (!program && features.compute && programs_.fits(features)) {
    compute_ = false;  // The driver does not accept it as a compute shader.
    return cast(scene, depth, same_view);
  }
  if (!program) return program.error();
  const bool first = programs_.compiled() > compiled;
  (*program)->use();
  set_uniforms(**program, features, scene, textures, depth);
  bind_textures(depth, features.projection != Projection::kComposite);
  if (features.predicates) bind_predicates(**program, features.predicates->generic, scene);
  begin_keeping(**program, keep);
  if (first) draw_one_pixel(features);
  GlProgram* means = nullptr;
  if (sparse) {
    const GlFeatures of_means = means_features(features);
    auto got = programs_.get(of_means);
    if (!got) return got.error();
    means = *got;
    means->use();
    set_means_uniforms(*means, of_means, scene, textures, depth);
  }
  if (interrupted()) return interrupted_error("gl");
  given_up_ = false;
  timer_.begin(*in_software_);
  write_everything();
  if (sparse) {
    lattice_.draw(**program, *means, [this](int rows) { draw_in_bands(rows); });
  } else {
    cast_every_pixel(features);
  }
  statistics_.cast_s = timer_.end_s();
  if (given_up_) return interrupted_error("gl");
  statistics_.prepare_s = std::max(seconds_since(start) - statistics_.cast_s, 0.0);
  drawn_with_ = std::move(features);
  count_bricks(*drawn_with_);
  return {};
}

Result<void> GlRaycaster::know_device() {
  const bool software = runs_in_software(reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
  if (!voxel_pairs_) voxel_pairs_ = software;
  if (!unrolled_) unrolled_ = software;
  if (!in_software_) in_software_ = software;
  // Mesa's rasteriser reads other values from storage buffers for rays that have left a loop.
  if (!storage_) storage_ = !software;
  if (!manual_filter_) {
    auto coarse = filter_is_coarse();
    if (!coarse) return coarse.error();
    manual_filter_ = *coarse;
  }
  if (!compute_) compute_ = compute_is_faster();
  return {};
}

void GlRaycaster::cast_every_pixel(const GlFeatures& features) {
  if (features.compute) return dispatch(width_, height_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, width_, height_);
  draw_in_bands(height_);
}

/// Fills a viewport with this many rows. A software rasteriser draws some rows at a time, so that
/// it can be interrupted in between; the pixels do not depend on it.
void GlRaycaster::draw_in_bands(int height) {
  constexpr int kRows = 64;  // A multiple of the rasteriser's tiles.
  if (!*in_software_ || interrupt_ == nullptr || !interrupt_->possible()) return draw_triangle();
  glEnable(GL_SCISSOR_TEST);
  for (int y = 0; y < height && !given_up_; y += kRows) {
    given_up_ = interrupted();
    if (given_up_) break;
    glScissor(0, y, width_, kRows);
    draw_triangle();
    glFinish();  // Otherwise nothing is drawn before the image is read.
  }
  glDisable(GL_SCISSOR_TEST);
}

void GlRaycaster::count_bricks(const GlFeatures& features) {
  if (features.predicates) {
    statistics_.bricks = source_->predicates.bricks();
    statistics_.bricks_occupied = source_->predicates.bricks_occupied();
  }
  if (features.skipping) {
    const GlTextures& textures = source_->textures;
    statistics_.bricks += static_cast<std::uint64_t>(textures.brick_count().prod());
    const bool composite = features.projection == Projection::kComposite;
    statistics_.bricks_occupied += composite ? textures.bricks_occupied() : 0;
  }
}

GlPredicateForm GlRaycaster::form_now(GlFeatures features) {
  const GlPredicateForm own = source_->predicates.form();
  features.predicates = own;
  bool settled = programs_.has(features);
  if (source_ == &whole_) {
    images_wanted_ = wanted_ == features ? images_wanted_ + 1 : 0;
    wanted_ = features;
    settled = settled || images_wanted_ >= settled_after_;
  }
  // Beside a CT, devices compile the generic program for longer than the set's own program:
  // docs/rendering-performance.md
  const bool too_long = features.beside_ct && !*in_software_;
  const auto generic = source_->predicates.generic_form();
  if (!generic || settled || too_long) return own;
  features.predicates = generic;
  return programs_.fits(features) ? *generic : own;
}

void GlRaycaster::begin_keeping(GlProgram& program, bool keep) {
  if (!signed_) return;
  program.set("keeps", static_cast<int>(keep));
  program.set("signatures", kSignatures);
  bind(kSignatures, GL_TEXTURE_2D, signatures_before_.id());
  if (!keep) return;
  // Rays may not read what they write, so a copy holds what they met before.
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glReadBuffer(GL_COLOR_ATTACHMENT4);
  glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, width_, height_);
  // Rays that stay cost nothing.
  constexpr std::array<float, 4> kNothing{};
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_SCISSOR_TEST);
  glClearBufferfv(GL_COLOR, 1, kNothing.data());
}

Result<void> GlRaycaster::update(const Scene& scene) {
  auto& [textures, predicates] = *source_;
  const auto fits = [&](const StoredVolume& volume) {
    return gl::fits_slices(volume.grid().size) && volume.grid().size[2] <= most_slices_;
  };
  const bool slices = *manual_filter_ && gathers_ && fits(*scene.ct) &&
                      (!has_two_volumes(scene) || fits(*scene.ultrasound->volume));
  textures.set_slices(slices);
  second_.set_slices(slices);
  textures.set_voxel_pairs(*voxel_pairs_);
  if (auto sent = textures.update(scene); !sent) return sent;
  predicates.set_voxel_pairs(drawn_by_predicates(scene) && textures.has_voxel_pairs());
  if (drawn_by_predicates(scene)) {
    if (auto sent = predicates.update(scene); !sent) return sent;
  }
  if (auto sent = update_second(scene); !sent) return sent;
  send_field(scene);
  return {};
}

Result<void> GlRaycaster::update_second(const Scene& scene) {
  if (!scene.ultrasound) second_.release();
  if (!has_two_volumes(scene)) return {};
  const auto& volume = scene.ultrasound->volume;
  if (auto ok = whole(*volume, *second_.fitting(volume)); !ok) return ok;
  {
    const gl::PackedRows packed;
    if (auto sent = second_.update_volume(volume); !sent) return sent;
  }
  return source_->predicates.update(ultrasound_scene(scene));
}

void GlRaycaster::bind_predicates(GlProgram& program, bool generic, const Scene& scene) {
  if (!has_two_volumes(scene)) return source_->predicates.bind(program, generic, scene);
  bind_volume(kSecondVolume, second_);
  source_->predicates.bind(program, generic, ultrasound_scene(scene),
                           GlPredicates::Beside{scene.ultrasound->ct_importance, reach_mm(scene)});
}

void GlRaycaster::bind_textures(const std::optional<SharedDepth>& depth, bool projects) {
  GlTextures& textures = source_->textures;
  bind_volume(kCt, textures);
  bind(kGradients, GL_TEXTURE_3D, textures.gradients.id());
  bind(kTransfer, GL_TEXTURE_BUFFER, textures.transfer.texture.id());
  bind(kImportances, GL_TEXTURE_BUFFER, textures.importances.texture.id());
  bind(kIntegrals, GL_TEXTURE_BUFFER, textures.integrals.texture.id());
  gl::bind_storage(gl::kPointsStorage, textures.integrals.buffer_id());
  gl::bind_storage(gl::kTransferStorage, textures.transfer.buffer_id());
  bind(kBricks, GL_TEXTURE_3D, projects ? textures.brick_ranges.id() : textures.bricks.id());
  bind(kSolids, GL_TEXTURE_2D, textures.solids.id());
  bind(kCutObjects, GL_TEXTURE_2D, textures.cut_objects.id());
  bind(kCutField, GL_TEXTURE_2D, field_spans_.id());
  bind(kDepth, GL_TEXTURE_2D, depth ? depth->texture : 0);
}

void GlRaycaster::send_field(const Scene& scene) {
  if (!CutawayField::needed(scene)) {
    field_.reset();
    return;
  }
  const std::optional<CutawayField> before = std::exchange(field_, std::nullopt);
  field_.emplace(scene, before ? &*before : nullptr);
  const auto view =
      spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid());
  const double tolerance_mm = kMeshTolerance * spec::step_mm(scene.quality, scene.ct->grid());
  const auto spans = field_->meet_all(view, 0, tolerance_mm);
  static_assert(sizeof(spec::CutawaySpan<float>) == 2 * sizeof(float));
  glActiveTexture(GL_TEXTURE0 + kTarget);
  glBindTexture(GL_TEXTURE_2D, field_spans_.id());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RG32F, scene.width, scene.height, 0, GL_RG, GL_FLOAT,
               spans.data());
  glBindTexture(GL_TEXTURE_2D, 0);
}

Result<void> GlRaycaster::resolve(const Scene& scene) {
  if (auto ok = prepare(resolve_program_, "resolve.frag"); !ok) return ok;
  resolve_program_->use();
  resolve_program_->set("front", kFront);
  resolve_program_->set("behind", kBehind);
  resolve_program_->set("live_at", kLiveAt);
  resolve_program_->set("us_image", kImage);
  resolve_program_->set("plane_opacity", scene.plane->opacity);
  resolve_program_->set("opaque_at", opaque_at(scene));
  resolve_program_->set("by_weight", static_cast<int>(shows_predicates(scene)));
  bind(kFront, GL_TEXTURE_2D, targets_.front.id());
  bind(kBehind, GL_TEXTURE_2D, targets_.behind.id());
  bind(kLiveAt, GL_TEXTURE_2D, targets_.live_at.id());
  bind(kImage, GL_TEXTURE_2D, source_->textures.image.id());
  glBindFramebuffer(GL_FRAMEBUFFER, resolve_framebuffer_);
  glViewport(0, 0, width_, height_);
  write_everything();
  draw_triangle();
  return {};
}

Result<void> GlRaycaster::composite(const std::array<int, 4>& at) {
  if (auto ok = prepare(composite_program_, "composite.frag"); !ok) return ok;
  const GlStateGuard guard;
  write_everything();
  glViewport(at[0], at[1], at[2], at[3]);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  composite_program_->use();
  composite_program_->set("image", kTarget);
  // Pixels are square: heights give the scale, and both images have the same middle.
  const double scale = static_cast<double>(height_) / at[3];
  const Eigen::Vector2d corner(at[0], at[1]);
  const Eigen::Vector2d middle(0.5 * at[2], 0.5 * at[3]);
  composite_program_->set("scale", scale);
  composite_program_->set("offset", Eigen::Vector2d(Eigen::Vector2d(0.5 * width_, 0.5 * height_) -
                                                    scale * (corner + middle)));
  bind(kTarget, GL_TEXTURE_2D, image().id());
  draw_triangle();
  glBindTexture(GL_TEXTURE_2D, 0);
  return {};
}

std::vector<RgbaF> GlRaycaster::read() {
  const GlStateGuard guard;
  const auto height = static_cast<std::size_t>(height_);
  const auto width = static_cast<std::ptrdiff_t>(width_);
  std::vector<RgbaF> pixels;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, layers_ ? resolve_framebuffer_ : framebuffer_);
  // Reads rows from the top on, if the device can write them so.
  const bool from_top = GLEW_MESA_pack_invert != 0;
  if (from_top) glPixelStorei(GL_PACK_INVERT_MESA, GL_TRUE);
  read_buffer_.read(GL_COLOR_ATTACHMENT0, width_, height_, in_software_.value_or(false), pixels);
  if (from_top) glPixelStorei(GL_PACK_INVERT_MESA, GL_FALSE);
  for (std::size_t row = 0; !from_top && row < height / 2; ++row) {
    const auto top = pixels.begin() + static_cast<std::ptrdiff_t>(row) * width;
    const auto bottom = pixels.begin() + static_cast<std::ptrdiff_t>(height - 1 - row) * width;
    std::swap_ranges(top, top + width, bottom);
  }
  return pixels;
}

RenderStatistics GlRaycaster::statistics() {
  RenderStatistics statistics = statistics_;
  if (!cast_) return statistics;
  const bool sparse = drawn_with_ && drawn_with_->sparse;
  const GlStateGuard guard;
  const std::uint64_t rays_before = statistics.rays;
  const GlCostSums::Source source{framebuffer_, targets_.spent.id(), width_, height_};
  cost_sums_.add(source, in_software_.value_or(false), read_buffer_, statistics);
  const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  if (sparse) statistics.pixels_without_ray += pixels - (statistics.rays - rays_before);
  return statistics;
}

Result<void> GlRaycaster::prepare_targets(int width, int height, bool layers, bool signatures) {
  if (framebuffer_ != 0 && width == width_ && height == height_ && layers == layers_ &&
      signatures == signed_) {
    return {};
  }
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (width > largest || height > largest) {
    return Error{ErrorCode::kUnsupportedData,
                 "image: expected at most " + std::to_string(largest) +
                     " pixels along an edge on this OpenGL device, found " + std::to_string(width) +
                     " x " + std::to_string(height)};
  }
  release_targets();
  width_ = width;
  height_ = height;
  layers_ = layers;
  signed_ = signatures;
  glActiveTexture(GL_TEXTURE0 + kTarget);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  if (signatures) {
    gl::attach(signatures_before_, GL_COLOR_ATTACHMENT4, GL_RG32UI, width, height);
    gl::attach(signatures_, GL_COLOR_ATTACHMENT4, GL_RG32UI, width, height);
  }
  targets_.attach(width, height, layers, signatures);
  if (auto ok = gl::complete_framebuffer(); !ok || !layers) return ok;
  glGenFramebuffers(1, &resolve_framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, resolve_framebuffer_);
  gl::attach(resolved_, GL_COLOR_ATTACHMENT0, GL_RGBA32F, width, height);
  return gl::complete_framebuffer();
}

void GlRaycaster::release_targets() {
  targets_.release();
  for (GlTexture* texture : {&resolved_, &signatures_, &signatures_before_}) texture->release();
  for (unsigned* framebuffer : {&framebuffer_, &resolve_framebuffer_}) {
    if (*framebuffer != 0) glDeleteFramebuffers(1, framebuffer);
    *framebuffer = 0;
  }
}

/// Drivers translate a program when they first draw with it. This is done here, so that it does not
/// count as time of the rays.
void GlRaycaster::draw_one_pixel(const GlFeatures& features) {
  if (features.compute) return dispatch(1, 1);
  write_everything();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, 1, 1);
  draw_triangle();
}

/// Runs the compute shader in use, which writes the targets.
void GlRaycaster::dispatch(int width, int height) {
  const gl::ImageTargets targets({{targets_.front.id(), GL_RGBA32F},
                                  {targets_.spent.id(), GL_RGBA32F},
                                  {layers_ ? targets_.behind.id() : 0, GL_RGBA32F},
                                  {layers_ ? targets_.live_at.id() : 0, GL_RG32F},
                                  {signed_ ? signatures_.id() : 0, GL_RG32UI}});
  gl::dispatch(width, height);
}

void GlRaycaster::draw_triangle() {
  if (vertex_array_ == 0) glGenVertexArrays(1, &vertex_array_);
  glBindVertexArray(vertex_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlRaycaster::release() {
  last_.reset();
  drawn_with_.reset();
  wanted_.reset();
  whole_.textures.release();
  whole_.predicates.release();
  release_coarse();
  second_.release();
  field_.reset();
  field_spans_.release();
  release_targets();
  lattice_.release();
  programs_.clear();
  resolve_program_.reset();
  composite_program_.reset();
  if (vertex_array_ != 0) glDeleteVertexArrays(1, &vertex_array_);
  vertex_array_ = 0;
  manual_filter_.reset();
  voxel_pairs_.reset();
  compute_.reset();
  unrolled_.reset();
  in_software_.reset();
  storage_.reset();
  read_buffer_.release();
  timer_.release();
  cost_sums_.release();
}

}  // namespace nav::render
