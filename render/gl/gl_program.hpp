// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// The parts of a predicate set that must be compiled in.
struct GlPredicateForm {
  std::string text;                 ///< The result of predicate_shader().
  int feature_textures = 0;         ///< At most 3.
  bool feature_pairs = false;       ///< Features are tables of pairs of voxels.
  bool volume_in_features = false;  ///< VOLUME_IN_FEATURES of predicate_march.glsl.
  bool undefined = false;           ///< Some feature has undefined voxels.
  bool labels = false;
  bool log_importance = false;    ///< false: weights.
  bool appearance_table = false;  ///< false: Eqs. 6 to 8 for every sample.
  bool shading = false;           ///< PredicateShading.
  bool generic = false;           ///< Reads any set from a table; text is empty.
  auto operator<=>(const GlPredicateForm&) const = default;
};

/// Ways in which shaders interpolate between the voxels of textures.
enum class GlFilter {
  kDevice,   ///< The device's filter.
  kFetches,  ///< Eight fetches, interpolated by hand; if the filter is coarse.
  kGathers,  ///< Like kFetches, but the volume from two gathers of four voxels.
};

/// The parts of an image that must be compiled in; everything else is a uniform. Two scenes with
/// equal features share a program. Internal to render/.
struct GlFeatures {
  enum class Classified { kPreIntegrated, kAtMiddle, kByGradientToo };
  enum class Shaded { kNot, kPhong, kGooch };

  Projection projection = Projection::kComposite;
  Classified classified = Classified::kPreIntegrated;
  Shaded shaded = Shaded::kNot;   ///< Needs gradients.
  bool emphasis = false;          ///< Shading by importance.
  bool gradient_texture = false;  ///< Gradients take one fetch instead of six.
  bool cutaway = false;
  bool cut_field = false;  ///< The surfaces of the cutaway come as an image.
  bool skipping = false;   ///< Leaps over bricks that show nothing.
  bool jitter = false;
  bool compute = false;       ///< A compute shader, not a fragment shader.
  bool storage = false;       ///< Tables are storage buffers; only in compute shaders.
  bool unrolled = false;      ///< Several cells are written one after the other: march.glsl.
  bool means = false;         ///< sparse_means.frag instead.
  bool sparse = false;        ///< Fewer rays than pixels.
  bool plane = false;         ///< An ultrasound image or its border.
  bool solids = false;        ///< Needle, spheres or lines.
  bool capsules = false;      ///< Some of them are longer than a sphere.
  bool shared_depth = false;  ///< Rays stop at VTK's opaque geometry.
  bool voxel_pairs = false;   ///< Volumes are tables of pairs of voxels.
  GlFilter filter = GlFilter::kDevice;
  std::optional<GlPredicateForm> predicates{};  ///< Replace classification and shading.
  bool beside_ct = false;                       ///< Predicates of a second volume beside the CT.
  /// True if something can move while the view stays: then rays note what they meet.
  [[nodiscard]] bool signature() const { return (plane || solids || cutaway) && !sparse; }
  auto operator<=>(const GlFeatures&) const = default;
};

/// Text of the fragment or compute shader for a set of features: the #defines, then the file with
/// its blocks. The file is raycast.frag, predicates.frag, two_volumes.frag or sparse_means.frag.
std::string raycast_source(const GlFeatures& features);
/// Number of textures that a program for a set of features declares: at most 12 without predicates.
int samplers_of(const GlFeatures& features);
/// Text of a file of shaders/ with its #include lines replaced, each block once. `#include again`
/// repeats a block.
std::string assembled_shader(const std::string& name);

/// Turns the text of a fragment shader into that of a compute shader: defines COMPUTE, uses OpenGL
/// 4.3.
std::string as_compute(std::string text);

/// A linked program. Needs a current context, also for its destruction.
class GlProgram {
 public:
  /// Links two shaders. Errors: kUnsupportedData with the first line of the driver's log.
  static Result<std::unique_ptr<GlProgram>> link(const std::string& vertex,
                                                 const std::string& fragment);
  /// Links a fragment shader with one triangle that covers the viewport: fullscreen.vert.
  static Result<std::unique_ptr<GlProgram>> link_fullscreen(const std::string& fragment);
  /// Links a compute shader; needs OpenGL 4.3.
  static Result<std::unique_ptr<GlProgram>> link_compute(const std::string& text);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const;
  /// Each set() sets a uniform of the program in use. A uniform that the driver found unused is
  /// skipped. A name that the text does not contain is a Bug.
  void set(const std::string& name, int value);
  void set(const std::string& name, double value);
  void set(const std::string& name, const Eigen::Vector2d& value);
  void set(const std::string& name, const Eigen::Vector3d& value);
  void set(const std::string& name, const Eigen::Vector4d& value);
  void set(const std::string& name, const Eigen::Vector2i& value);
  void set(const std::string& name, const Eigen::Vector3i& value);
  void set(const std::string& name, const Eigen::Vector4i& value);
  /// Sets 1 to 4 numbers.
  void set(const std::string& name, const std::vector<double>& value);
  /// Sets a uint.
  void set_bits(const std::string& name, std::uint32_t value);
  void set(const std::string& name, const Eigen::Matrix2d& value);
  void set(const std::string& name, const Eigen::Matrix3d& value);
  void set(const std::string& name, const Eigen::Matrix4d& value);

 private:
  GlProgram(unsigned id, std::string text) : id_(id), text_(std::move(text)) {}
  static Result<std::unique_ptr<GlProgram>> linked(const std::vector<unsigned>& shaders,
                                                   const std::string& text);
  int location(const std::string& name);
  unsigned id_;
  std::string text_;  ///< The source, which contains the names of all uniforms.
  std::map<std::string, int> locations_;
};

/// Programs keyed by features; compiles each only once.
class GlProgramCache {
 public:
  /// Gets a program. Returns kUnsupportedData if it needs more textures than fragment shaders of
  /// this device have; nothing is compiled then.
  Result<GlProgram*> get(const GlFeatures& features);
  /// True if the device has enough textures.
  [[nodiscard]] bool fits(const GlFeatures& features) const;
  /// An artificial limit of the device's textures, for tests.
  void set_most_samplers(int most) { most_samplers_ = most; }
  /// Makes compute shaders fail to link, for tests.
  void reject_compute() { refuses_compute_ = true; }
  [[nodiscard]] bool has(const GlFeatures& features) const { return programs_.contains(features); }
  /// Number of programs compiled so far.
  [[nodiscard]] int compiled() const { return compiled_; }
  void clear() { programs_.clear(); }

 private:
  std::map<GlFeatures, std::unique_ptr<GlProgram>> programs_;
  int compiled_ = 0;
  int most_samplers_ = std::numeric_limits<int>::max();
  bool refuses_compute_ = false;
};

}  // namespace nav::render
