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

/// What a set of predicates needs compiled in.
struct GlPredicateForm {
  std::string text;                 ///< Of predicate_shader().
  int feature_textures = 0;         ///< At most 3.
  bool feature_pairs = false;       ///< Features are tables of pairs of voxels.
  bool volume_in_features = false;  ///< VOLUME_IN_FEATURES of predicate_march.glsl.
  bool undefined = false;           ///< Some feature has voxels without a value.
  bool labels = false;
  bool log_importance = false;  ///< Else weights.
  bool look_table = false;      ///< Else Eqs. 6 to 8 for every sample.
  bool generic = false;         ///< Reads any set from a table; text is empty.
  auto operator<=>(const GlPredicateForm&) const = default;
};

/// How shaders interpolate between voxels of textures.
enum class GlFilter {
  kDevice,   ///< By the device's filter.
  kFetches,  ///< By hand, where that one is coarse, from eight fetches.
  kGathers,  ///< The same numbers, of the volume from two gathers of four voxels of its slices.
};

/// What a picture needs compiled in; everything else is a uniform. Two scenes with equal features
/// share a program. Internal to render/.
struct GlFeatures {
  enum class Classified { kPreIntegrated, kAtMiddle, kByGradientToo };
  enum class Shaded { kNot, kPhong, kGooch };

  Projection projection = Projection::kComposite;
  Classified classified = Classified::kPreIntegrated;
  Shaded shaded = Shaded::kNot;   ///< Needs gradients.
  bool emphasis = false;          ///< Shading by importance.
  bool gradient_texture = false;  ///< Gradients take one fetch instead of six.
  bool cutaway = false;
  bool cut_field = false;  ///< Of the cutaway: its surfaces come as a picture.
  bool skipping = false;   ///< Leaps over bricks that show nothing.
  bool adaptive = false;   ///< Several cells may be one.
  bool jitter = false;
  bool compute = false;       ///< A compute shader instead of a fragment shader.
  bool storage = false;       ///< Tables are storage buffers; of a compute shader.
  bool unrolled = false;      ///< Several cells are written one after the other: march.glsl.
  bool means = false;         ///< sparse_means.frag instead.
  bool sparse = false;        ///< Fewer rays than pixels.
  bool listed = false;        ///< Pixels of rays come from a list: render/gl/gl_packed_rays.hpp.
  bool plane = false;         ///< Ultrasound picture or its border.
  bool solids = false;        ///< Needle, spheres or lines.
  bool capsules = false;      ///< Some of them are longer than a sphere.
  bool shared_depth = false;  ///< Rays stop at VTK's opaque geometry.
  bool voxel_pairs = false;   ///< Volumes are tables of pairs of voxels.
  GlFilter filter = GlFilter::kDevice;
  std::optional<GlPredicateForm> predicates{};  ///< Instead of classification and shading.
  bool beside_ct = false;  ///< Predicates of a second volume: the CT has those as well.
  /// Something can move while the view stays: rays note what they meet.
  [[nodiscard]] bool signature() const { return (plane || solids || cutaway) && !sparse; }
  auto operator<=>(const GlFeatures&) const = default;
};

/// Text of the fragment or compute shader for a set of features: the #defines, then the file with
/// its blocks: raycast.frag, predicates.frag, two_volumes.frag or sparse_means.frag.
std::string raycast_source(const GlFeatures& features);
/// Textures that a program for a set of features declares: at most 12 without predicates.
int samplers_of(const GlFeatures& features);
/// Text of a file of shaders/ with its #include lines replaced, each block once; #include again
/// stands for a block that is there already.
std::string assembled_shader(const std::string& name);

/// A fragment shader's text as that of a compute shader: with COMPUTE, of OpenGL 4.3.
std::string as_compute(std::string text);

/// A linked program. Needs a current context, also to be destroyed.
class GlProgram {
 public:
  /// kUnsupportedData with the first line of the driver's log.
  static Result<std::unique_ptr<GlProgram>> link(const std::string& vertex,
                                                 const std::string& fragment);
  /// The same with one triangle that covers the viewport: fullscreen.vert.
  static Result<std::unique_ptr<GlProgram>> link_fullscreen(const std::string& fragment);
  /// The same of a compute shader; needs OpenGL 4.3.
  static Result<std::unique_ptr<GlProgram>> link_compute(const std::string& text);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const;
  /// Each sets a uniform of the program in use; one that the driver found unused is passed over. A
  /// name that its text does not have is a Bug.
  void set(const std::string& name, int value);
  void set(const std::string& name, double value);
  void set(const std::string& name, const Eigen::Vector2d& value);
  void set(const std::string& name, const Eigen::Vector3d& value);
  void set(const std::string& name, const Eigen::Vector4d& value);
  void set(const std::string& name, const Eigen::Vector2i& value);
  void set(const std::string& name, const Eigen::Vector3i& value);
  void set(const std::string& name, const Eigen::Vector4i& value);
  /// 1 to 4 numbers.
  void set(const std::string& name, const std::vector<double>& value);
  /// Of a uint.
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
  std::string text_;  ///< With all uniforms that are set.
  std::map<std::string, int> locations_;
};

/// Programs by feature set; compiles only what has not been asked for before.
class GlProgramCache {
 public:
  /// kUnsupportedData for more textures than fragment shaders of this device have, before anything
  /// is compiled.
  Result<GlProgram*> get(const GlFeatures& features);
  /// Whether the device has enough textures.
  [[nodiscard]] bool fits(const GlFeatures& features) const;
  /// An artificial limit of the device's textures, for tests.
  void set_most_samplers(int most) { most_samplers_ = most; }
  /// Compute shaders do not link, for tests.
  void refuse_compute() { refuses_compute_ = true; }
  [[nodiscard]] bool has(const GlFeatures& features) const { return programs_.contains(features); }
  /// How many programs have been compiled so far.
  [[nodiscard]] int compiled() const { return compiled_; }
  void clear() { programs_.clear(); }

 private:
  std::map<GlFeatures, std::unique_ptr<GlProgram>> programs_;
  int compiled_ = 0;
  int most_samplers_ = std::numeric_limits<int>::max();
  bool refuses_compute_ = false;
};

}  // namespace nav::render
