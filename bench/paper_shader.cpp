// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW first: every other GL header depends on it.
#include <algorithm>
#include <optional>
#include <vector>
#include <vtkOpenGLRenderWindow.h>

#include "bench/gl_frames.hpp"
#include "bench/paper_shader.hpp"
#include "render/gl/gl_compute.hpp"
#include "render/gl/gl_device.hpp"
#include "render/gl/gl_filter_probe.hpp"
#include "render/gl/gl_program.hpp"
#include "render/gl/gl_read.hpp"
#include "render/gl/gl_speed_probe.hpp"
#include "render/gl/gl_target.hpp"
#include "render/gl/gl_textures.hpp"
#include "render/gl/gl_timer.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/gl/gl_upload.hpp"
#include "render/predicates/shader.hpp"
#include "render/vtk/vtk_offscreen.hpp"

namespace nav::bench {
namespace {

using render::GlProgram;
using render::PredicateSet;
using render::RenderedImage;
using render::Scene;

constexpr int kLabelUnit = render::kLabels;
constexpr int kFirstFeature = render::kTarget + 1;

/// Eqs. 6 to 8 as sums over the bars of the true predicates, one after the other.
std::string bars_text(const PredicateSet& set) {
  std::string uniforms;
  std::string body = "vec4 sum_bars(uint entries) {\n  vec4 sum = vec4(0.0);\n";
  for (std::size_t j = 0; j < set.size(); ++j) {
    const std::string bar = "bar" + std::to_string(j);
    uniforms += "uniform vec3 " + bar + ";\n";
    body += "  if ((entries & " + std::to_string(1U << j) + "u) != 0u) sum += vec4(1.0, " + bar +
            ".x, " + bar + ".x * " + bar + ".y, " + bar + ".x * " + bar + ".y * " + bar + ".z);\n";
  }
  return uniforms + body + "  return sum;\n}\n";
}

/// gathers: uses texture gathers of slices, which are as fast as the device's filter.
std::string fetches_text(std::size_t features, bool gathers) {
  const std::string kind = gathers ? "sampler2DArray" : "sampler3D";
  const std::string function = gathers ? "gathered" : "trilinear";
  std::string uniforms =
      "#define FEATURES " + std::to_string(std::max<std::size_t>(features, 1)) + "\n";
  std::string body = (gathers ? "float " : "vec4 ") + function + "(" + kind +
                     " volume, vec3 index);\n"
                     "void fetch_features(out vec4 texels[FEATURES], vec3 index) {\n";
  if (features == 0) body += "  texels[0] = vec4(0.0);\n";
  for (std::size_t i = 0; i < features; ++i) {
    const std::string name = "paper_feature" + std::to_string(i);
    uniforms += "uniform " + kind + " " + name + ";\n";
    body += "  texels[" + std::to_string(i) + "] = vec4(" + function + "(" + name + ", index));\n";
  }
  return uniforms + body + "}\n";
}

std::string fragment_text(const PredicateSet& set, bool manual_filter) {
  std::string text = render::assembled_shader("paper_predicates.frag");
  const std::size_t after_version = text.find('\n', text.find("#version")) + 1;
  const std::string defines = std::string(set.labels() ? "#define LABELS\n" : "") +
                              (manual_filter ? "#define MANUAL_FILTER\n#define GATHERS\n" : "");
  return text.insert(after_version, defines +
                                        fetches_text(set.channels().size() - 1, manual_filter) +
                                        bars_text(set) + render::plain_predicate_shader(set));
}

void bind(int unit, GLenum kind, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(kind, texture);
}

class PaperShader final : public render::Engine {
 public:
  PaperShader(std::unique_ptr<render::OffscreenWindow> window, const PaperShaderOptions& options,
              bool compute, bool manual_filter)
      : window_(std::move(window)),
        reads_(options.reads),
        compute_(compute),
        manual_filter_(manual_filter) {}
  ~PaperShader() override {
    current();
    program_.reset();
    textures_.clear();
    target_.release();
    read_buffer_.release();
    timer_.release();
    window_->release_thread();
  }
  PaperShader(const PaperShader&) = delete;
  PaperShader& operator=(const PaperShader&) = delete;

  [[nodiscard]] std::string name() const override { return "paper shader"; }
  [[nodiscard]] std::string device() const override { return window_->device(); }

  Result<RenderedImage> render_image(const Scene& scene,
                                     const render::Interrupt& /*interrupt*/) override {
    if (auto ok = validate(scene); !ok) return ok.error();
    if (!scene.predicates) {
      return Error{ErrorCode::kUnsupportedData,
                   "paper shader: expected a scene with predicates, found none"};
    }
    current();
    auto image = draw(scene);
    window_->release_thread();
    return image;
  }

 private:
  void current() { window_->window().MakeCurrent(); }

  Result<RenderedImage> draw(const Scene& scene) {
    auto set = PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
    if (!set) return set.error();
    if (auto ok = prepare(*set); !ok) return ok.error();
    if (auto ok = target_.bind(scene.width, scene.height); !ok) return ok.error();
    program_->use();
    set_uniforms(scene, *set);
    timer_.begin(render::runs_in_software(window_->device()));
    if (compute_) {
      const render::gl::ImageTargets bound({{target_.texture(), GL_RGBA32F}});
      render::gl::dispatch(scene.width, scene.height);
    } else {
      target_.draw();
    }
    const double cast_s = timer_.end_s();
    RenderedImage image =
        reads_ ? read(scene) : RenderedImage{blank_.of(scene.width, scene.height), {}};
    image.statistics.cast_s = cast_s;
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
      return Error{ErrorCode::kUnavailable,
                   "paper shader: OpenGL ended with error " + std::to_string(error)};
    }
    return image;
  }

  Result<void> prepare(const PredicateSet& set) {
    std::string text = fragment_text(set, manual_filter_);
    if (text != text_) {
      auto linked = compute_ ? GlProgram::link_compute(render::as_compute(text))
                             : GlProgram::link_fullscreen(text);
      if (!linked) return linked.error();
      program_ = std::move(linked).value();
      text_ = std::move(text);
    }
    return send(set);
  }

  Result<void> send(const PredicateSet& set) {
    std::vector<std::shared_ptr<const StoredVolume>> volumes;
    for (const auto& channel : set.channels()) {
      if (channel.has_undefined) {
        return Error{
            ErrorCode::kUnsupportedData,
            "paper shader: expected features without undefined voxels, found " + channel.name};
      }
      volumes.push_back(channel.codes);
    }
    const bool same =
        volumes == volumes_ && labels_of_ == (set.labels() ? set.labels()->bits().data() : nullptr);
    if (same) return {};
    const render::gl::PackedRows packed;
    textures_.clear();
    for (const auto& volume : volumes) {
      const auto& n = volume->grid().size;
      start_texture(volumes_kind(), GL_LINEAR);
      glTexImage3D(volumes_kind(), 0, GL_R16_SNORM, n[0], n[1], n[2], 0, GL_RED, GL_SHORT,
                   volume->values().data());
    }
    volumes_ = std::move(volumes);
    labels_of_ = nullptr;
    if (!set.labels()) return {};
    const auto& n = set.labels()->grid().size;
    start_texture(GL_TEXTURE_3D, GL_NEAREST);
    glTexImage3D(GL_TEXTURE_3D, 0, GL_R32UI, n[0], n[1], n[2], 0, GL_RED_INTEGER, GL_UNSIGNED_INT,
                 set.labels()->bits().data());
    labels_of_ = set.labels()->bits().data();
    return {};
  }

  [[nodiscard]] GLenum volumes_kind() const { return render::gl::kind_of_volumes(manual_filter_); }

  void start_texture(GLenum kind, GLint filter) {
    textures_.push_back(std::make_unique<render::GlTexture>());
    bind(render::kTarget, kind, textures_.back()->id());
    render::gl::set_sampling(kind, filter);
  }

  void set_uniforms(const Scene& scene, const PredicateSet& set) {
    GlProgram& p = *program_;
    set_rays(p, scene);
    const auto& volume = set.channels()[0];
    p.set("intensity_of_volume", Eigen::Vector2d(volume.scale, volume.offset));
    p.set("per_opacity_length", 1 / scene.predicates->opacity_length_mm);
    p.set("most_opacity", render::PredicateScene::kMostOpacity);
    p.set("spacing_mm", scene.ct->grid().spacing_mm);
    const render::PredicateUniforms uniforms = predicate_uniforms(set);
    for (const auto& [name, value] : uniforms.values) p.set(name, value);
    for (const auto& [name, mask] : uniforms.masks) p.set_bits(name, mask);
    for (std::size_t i = 0; i < set.leaves().size(); ++i)
      p.set_bits("leaf" + std::to_string(i) + "_undefined", 0);
    for (std::size_t j = 0; j < set.size(); ++j) {
      const auto& w = set.weights()[j];
      p.set("bar" + std::to_string(j), Eigen::Vector3d(w.impact, w.saturation, w.hue_deg));
    }
    bind(render::kCt, volumes_kind(), textures_[0]->id());
    for (std::size_t c = 0; c < set.channels().size(); ++c) {
      const auto& channel = set.channels()[c];
      p.set("channel" + std::to_string(c) + "_scale",
            Eigen::Vector2d(channel.offset, channel.scale));
      if (c == 0) continue;
      const int unit = kFirstFeature + static_cast<int>(c);
      p.set("paper_feature" + std::to_string(c - 1), unit);
      bind(unit, volumes_kind(), textures_[c]->id());
    }
    p.set("paper_labels", kLabelUnit);
    if (set.labels()) bind(kLabelUnit, GL_TEXTURE_3D, textures_.back()->id());
  }

  RenderedImage read(const Scene& scene) {
    const auto width = static_cast<std::size_t>(scene.width);
    const auto height = static_cast<std::size_t>(scene.height);
    std::vector<RgbaF> pixels(width * height);
    std::vector<RgbaF> rows;
    read_buffer_.read(GL_COLOR_ATTACHMENT0, scene.width, scene.height, false, rows);
    const Eigen::Vector3f background = scene.background_rgb.cast<float>();
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        const RgbaF& p = rows[(height - 1 - y) * width + x];
        const float rest = 1 - p.a;
        pixels[y * width + x] = {p.r + rest * background.x(), p.g + rest * background.y(),
                                 p.b + rest * background.z(), 1};
      }
    }
    return {{scene.width, scene.height, std::move(pixels)}, {}};
  }

  std::unique_ptr<render::OffscreenWindow> window_;
  bool reads_;
  bool compute_;        ///< The faster choice on the device, like the GL engine.
  bool manual_filter_;  ///< True if the device's filter is coarse, like the GL engine.
  BlankImage blank_;
  std::unique_ptr<GlProgram> program_;
  std::string text_;
  std::vector<std::unique_ptr<render::GlTexture>> textures_;  ///< Volume, features, labels.
  std::vector<std::shared_ptr<const StoredVolume>> volumes_;
  const std::uint32_t* labels_of_ = nullptr;
  render::GlTarget target_;
  render::GlReadBuffer read_buffer_;
  render::GlTimer timer_;
};

}  // namespace

Result<std::unique_ptr<render::Engine>> make_paper_shader(const PaperShaderOptions& options) {
  auto window = render::OffscreenWindow::create(16, 16);
  if (!window) return window.error();
  (*window)->window().MakeCurrent();
  const bool compute = options.compute ? *options.compute : render::compute_is_faster();
  const auto manual_filter =
      options.manual_filter ? Result<bool>(*options.manual_filter) : render::filter_is_coarse();
  (*window)->release_thread();
  if (!manual_filter) return manual_filter.error();
  return std::unique_ptr<render::Engine>(
      std::make_unique<PaperShader>(std::move(window).value(), options, compute, *manual_filter));
}

}  // namespace nav::bench
