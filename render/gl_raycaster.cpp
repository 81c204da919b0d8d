// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl_state.hpp"
// GLEW first: every other GL header depends on it.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "render/gl_raycaster.hpp"
#include "render/ray_spec.hpp"

namespace nav::render {
namespace {

/// Texture units, above those that VTK hands out itself.
enum Unit { kCt = 20, kTransfer, kBricks, kPicture, kSpheres, kDepth, kTarget };

void bind(Unit unit, GLenum target, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture);
}

/// Makes a texture the target of the framebuffer that is bound.
void attach(GlTexture& texture, GLenum attachment, GLint format, int width, int height) {
  glBindTexture(GL_TEXTURE_2D, texture.id());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
  glBindTexture(GL_TEXTURE_2D, 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture.id(), 0);
}

void switch_off_tests() {
  for (const GLenum test : {GL_BLEND, GL_DEPTH_TEST, GL_CULL_FACE, GL_SCISSOR_TEST})
    glDisable(test);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_FALSE);
}

GlFeatures features_of(const Scene& scene, bool shared_depth, bool manual_filter) {
  GlFeatures features;
  features.shading = scene.shading.enabled;
  features.plane = scene.plane && scene.plane->safety.state != SafetyState::kLost;
  features.needle = scene.needle && scene.needle->safety.state != SafetyState::kLost;
  features.spheres = !scene.spheres.empty();
  features.skipping = scene.quality.skip_empty_bricks;
  features.shared_depth = shared_depth;
  features.manual_filter = manual_filter;
  return features;
}

/// The largest multiple of the step that is in front of the volume for every ray, mm, >= 0.
double t_base_mm(const spec::View<double>& view, const VoxelGrid& grid, double step_mm) {
  const Eigen::Vector3d to_centre = grid.centre().mm - grid.origin_mm - view.eye;
  const double distance = view.orthographic ? to_centre.dot(view.forward) : to_centre.norm();
  const double front = distance - 0.5 * grid.extent_mm().norm();
  return std::max(0.0, std::floor(front / step_mm) * step_mm);
}

void set_camera(GlProgram& program, const Scene& scene) {
  const VoxelGrid& grid = scene.ct->grid();
  const auto view = spec::make_view<double>(scene.camera, scene.width, scene.height, grid);
  const double step_mm = spec::step_mm(scene.quality, grid);
  const double base_mm = t_base_mm(view, grid, step_mm);
  program.set("base_local", Eigen::Vector3d(view.eye + base_mm * view.forward));
  program.set("t_base_mm", base_mm);
  program.set("right", view.right);
  program.set("up", view.up);
  program.set("forward", view.forward);
  program.set("pixel_size", 2 * view.half_height / scene.height);
  program.set("picture_size", Eigen::Vector2d(scene.width, scene.height));
  program.set("orthographic", static_cast<int>(view.orthographic));
  program.set("step_mm", step_mm);
}

void set_volume(GlProgram& program, const VoxelGrid& grid) {
  program.set("ct", kCt);
  program.set("ct_size", Eigen::Vector3i(grid.size[0], grid.size[1], grid.size[2]));
  const Eigen::Matrix3d index_from_local =
      grid.spacing_mm.cwiseInverse().asDiagonal() * grid.directions.transpose();
  program.set("index_from_local", index_from_local);
}

void set_plane(GlProgram& program, const spec::PlaneSurface<double>& plane) {
  program.set("us_picture", kPicture);
  program.set("image_from_local", plane.image_from_local);
  program.set("image_origin", plane.origin);
  program.set("pixel_from_mm", plane.pixel_from_mm);
  program.set("grid_origin_mm", plane.grid_origin_mm);
  program.set("mm_across", plane.mm_across);
  program.set("has_outline", static_cast<int>(plane.has_outline));
  program.set("outline", Eigen::Vector4d(plane.apex_mm.x(), plane.apex_mm.y(), plane.radius_min_mm,
                                         plane.radius_max_mm));
  program.set("outline_half", Eigen::Vector2d(plane.sin_half, plane.cos_half));
  program.set("shows_picture", static_cast<int>(plane.shows_picture));
  program.set("border_rgb", plane.border_rgb);
  program.set("plane_opacity", plane.opacity);
}

void set_needle(GlProgram& program, const spec::CapsuleSurface<double>& needle) {
  program.set("needle_a", needle.a);
  program.set("needle_b", needle.b);
  program.set("needle_radius", needle.radius);
  program.set("needle_rgba",
              Eigen::Vector4d(needle.rgb.x(), needle.rgb.y(), needle.rgb.z(), needle.alpha));
}

}  // namespace

void GlRaycaster::set_uniforms(GlProgram& program, const GlFeatures& features, const Scene& scene,
                               const std::optional<SharedDepth>& depth) {
  const VoxelGrid& grid = scene.ct->grid();
  set_camera(program, scene);
  set_volume(program, grid);
  const TransferTable& table = textures_.table();
  program.set("transfer", kTransfer);
  program.set("transfer_first_hu", table.first_hu);
  program.set("transfer_per_hu", table.per_hu);
  program.set("transfer_last", table.entries() - 1.0);
  constexpr double kNeverReached = 2;
  program.set("opaque_at", scene.quality.opaque_at < 1 ? scene.quality.opaque_at : kNeverReached);
  if (features.shading || features.needle || features.spheres) {
    const Shading& light = scene.shading;
    program.set("shade_light",
                Eigen::Vector4d(light.ambient, light.diffuse, light.specular, light.shininess));
  }
  if (features.shading) {
    program.set("half_per_spacing", Eigen::Vector3d(0.5 * grid.spacing_mm.cwiseInverse()));
  }
  if (features.skipping) {
    program.set("brick_distance", kBricks);
    program.set("brick_count", textures_.brick_count());
    program.set("brick_size", static_cast<double>(kGlBrickVoxels));
  }
  if (features.plane) set_plane(program, *spec::make_plane<double>(*scene.plane, grid));
  if (features.needle) set_needle(program, *spec::make_needle<double>(*scene.needle, grid));
  if (features.spheres) {
    program.set("spheres", kSpheres);
    program.set("sphere_count", static_cast<int>(scene.spheres.size()));
  }
  if (features.shared_depth) {
    program.set("vtk_depth", kDepth);
    program.set("depth_rows", depth->rows);
  }
}

Result<void> GlRaycaster::draw(const Scene& scene, const std::optional<SharedDepth>& depth) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const GlStateGuard guard;
  glActiveTexture(GL_TEXTURE0 + kTarget);
  if (auto ok = prepare_target(scene.width, scene.height); !ok) return ok;
  auto coarse = filter_is_coarse();
  if (!coarse) return coarse.error();
  if (auto sent = textures_.update(scene); !sent) return sent;
  const GlFeatures features = features_of(scene, depth.has_value(), *coarse);
  auto program = programs_.get(features);
  if (!program) return program.error();
  (*program)->use();
  set_uniforms(**program, features, scene, depth);
  bind(kCt, GL_TEXTURE_3D, textures_.ct.id());
  bind(kTransfer, GL_TEXTURE_1D, textures_.transfer.id());
  bind(kBricks, GL_TEXTURE_3D, textures_.bricks.id());
  bind(kPicture, GL_TEXTURE_2D, textures_.picture.id());
  bind(kSpheres, GL_TEXTURE_2D, textures_.spheres.id());
  bind(kDepth, GL_TEXTURE_2D, depth ? depth->texture : 0);
  glFinish();
  const auto prepared = Clock::now();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, width_, height_);
  switch_off_tests();
  draw_triangle();
  glFinish();
  const std::chrono::duration<double> prepare_s = prepared - start;
  const std::chrono::duration<double> cast_s = Clock::now() - prepared;
  statistics_ = {};
  statistics_.rays = static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height_);
  if (features.skipping) {
    statistics_.bricks = static_cast<std::uint64_t>(textures_.brick_count().prod());
    statistics_.bricks_occupied = textures_.bricks_occupied();
  }
  statistics_.prepare_s = prepare_s.count();
  statistics_.cast_s = cast_s.count();
  for (int unit = kCt; unit <= kTarget; ++unit) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    for (const GLenum target : {GL_TEXTURE_1D, GL_TEXTURE_2D, GL_TEXTURE_3D}) {
      glBindTexture(target, 0);
    }
  }
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return Error{ErrorCode::kUnavailable,
                 "OpenGL: expected the ray casting pass to succeed, found "
                 "error " +
                     std::to_string(error)};
  }
  return {};
}

Result<void> GlRaycaster::composite(int x, int y) {
  if (!composite_program_) {
    auto program =
        GlProgram::link(assembled_shader("fullscreen.vert"), assembled_shader("composite.frag"));
    if (!program) return program.error();
    composite_program_ = std::move(program).value();
  }
  const GlStateGuard guard;
  switch_off_tests();
  glViewport(x, y, width_, height_);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  composite_program_->use();
  composite_program_->set("picture", kTarget);
  composite_program_->set("viewport_origin", Eigen::Vector2i(x, y));
  bind(kTarget, GL_TEXTURE_2D, target_.id());
  draw_triangle();
  glBindTexture(GL_TEXTURE_2D, 0);
  return {};
}

std::vector<RgbaF> GlRaycaster::read() const {
  const GlStateGuard guard;
  const auto width = static_cast<std::size_t>(width_);
  const auto height = static_cast<std::size_t>(height_);
  std::vector<RgbaF> pixels(width * height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, pixels.data());
  for (std::size_t row = 0; row < height / 2; ++row) {
    const auto top = pixels.begin() + static_cast<std::ptrdiff_t>(row * width);
    const auto bottom = pixels.begin() + static_cast<std::ptrdiff_t>((height - 1 - row) * width);
    std::swap_ranges(top, top + width_, bottom);
  }
  return pixels;
}

RenderStatistics GlRaycaster::statistics() const {
  RenderStatistics statistics = statistics_;
  const GlStateGuard guard;
  std::vector<float> cost(2 * static_cast<std::size_t>(statistics.rays));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glReadBuffer(GL_COLOR_ATTACHMENT1);
  glReadPixels(0, 0, width_, height_, GL_RG, GL_FLOAT, cost.data());
  for (std::size_t i = 0; i < cost.size(); i += 2) {
    statistics.volume_samples += static_cast<std::uint64_t>(cost[i]);
    statistics.gradient_samples += static_cast<std::uint64_t>(cost[i + 1]);
  }
  return statistics;
}

Result<void> GlRaycaster::prepare_target(int width, int height) {
  if (framebuffer_ != 0 && width == width_ && height == height_) return {};
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (width > largest || height > largest) {
    return Error{ErrorCode::kUnsupportedData,
                 "picture: expected at most " + std::to_string(largest) +
                     " pixels along an edge on this OpenGL device, found " + std::to_string(width) +
                     " x " + std::to_string(height)};
  }
  width_ = width;
  height_ = height;
  if (framebuffer_ == 0) glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  attach(target_, GL_COLOR_ATTACHMENT0, GL_RGBA32F, width, height);
  attach(cost_, GL_COLOR_ATTACHMENT1, GL_RG32F, width, height);
  constexpr std::array<GLenum, 2> kBoth{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(static_cast<GLsizei>(kBoth.size()), kBoth.data());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return {};
  return Error{ErrorCode::kUnavailable,
               "OpenGL: expected a single-precision colour target, found none"};
}

Result<bool> GlRaycaster::filter_is_coarse() {
  if (manual_filter_) return *manual_filter_;
  constexpr int kFractions = 1024;
  constexpr double kTolerance = 1e-4;  // 0.1 HU at a step of 1000 HU; 8-bit fractions miss by 2e-3.
  auto program =
      GlProgram::link(assembled_shader("fullscreen.vert"), assembled_shader("filter_probe.frag"));
  if (!program) return program.error();
  GlTexture texels;
  GlTexture target;
  constexpr std::array<std::int16_t, 2> kZeroAndOne{0, 32767};
  glBindTexture(GL_TEXTURE_3D, texels.id());
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_R16_SNORM, 2, 1, 1, 0, GL_RED, GL_SHORT, kZeroAndOne.data());
  glBindTexture(GL_TEXTURE_2D, target.id());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, kFractions, 1, 0, GL_RGBA, GL_FLOAT, nullptr);
  GLuint framebuffer = 0;
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.id(), 0);
  glBindTexture(GL_TEXTURE_2D, 0);
  (*program)->use();
  (*program)->set("two_texels", kTarget);
  (*program)->set("sample_count", static_cast<double>(kFractions));
  glViewport(0, 0, kFractions, 1);
  switch_off_tests();
  draw_triangle();
  std::array<float, std::size_t{4} * kFractions> values{};
  glReadPixels(0, 0, kFractions, 1, GL_RGBA, GL_FLOAT, values.data());
  glDeleteFramebuffers(1, &framebuffer);
  glBindTexture(GL_TEXTURE_3D, 0);
  double worst = 0;
  for (int i = 0; i < kFractions; ++i) {
    const double truth = static_cast<double>(i) / kFractions;
    worst = std::max(worst, std::abs(values[std::size_t{4} * static_cast<std::size_t>(i)] - truth));
  }
  manual_filter_ = worst > kTolerance;
  return *manual_filter_;
}

void GlRaycaster::draw_triangle() {
  if (vertex_array_ == 0) glGenVertexArrays(1, &vertex_array_);
  glBindVertexArray(vertex_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlRaycaster::release() {
  textures_.release();
  target_.release();
  cost_.release();
  programs_.clear();
  composite_program_.reset();
  if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
  if (vertex_array_ != 0) glDeleteVertexArrays(1, &vertex_array_);
  framebuffer_ = 0;
  vertex_array_ = 0;
  manual_filter_.reset();
}

}  // namespace nav::render
