// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <glm/gtc/type_ptr.hpp>
#include <iomanip>
#include <set>
#include <sstream>
#include <vector>

#include "nav/check.hpp"
#include "render/gl/gl_convert.hpp"
#include "render/gl/gl_program.hpp"
#include "render/spec/ray_spec.hpp"
#include "shaders/shaders.hpp"

namespace nav::render {
namespace {

void append_block(const std::string& name, std::set<std::string>& done, std::string& out) {
  if (!done.insert(name).second) return;
  const std::string_view text = shaders::source(name);
  NAV_CHECK(!text.empty(), name);
  std::istringstream lines{std::string(text)};
  const auto included = [](const std::string& line, std::string_view how) {
    return line.substr(how.size(), line.rfind('"') - how.size());
  };
  constexpr std::string_view kInclude = "#include \"";
  constexpr std::string_view kAgain = "#include again \"";
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kInclude)) {
      append_block(included(line, kInclude), done, out);
    } else if (line.starts_with(kAgain)) {
      std::set<std::string> none;
      append_block(included(line, kAgain), none, out);
    } else {
      out += line + '\n';
    }
  }
}

/// The first line of a log that contains "error", otherwise its first line.
std::string first_error(const std::vector<char>& log) {
  const std::string text(log.data());
  const std::size_t error = text.find("error");
  const std::size_t before = error == std::string::npos ? error : text.rfind('\n', error);
  const std::size_t start = before == std::string::npos ? 0 : before + 1;
  return text.substr(start, text.find('\n', start) - start);
}

Result<GLuint> compile(GLenum kind, const std::string& text) {
  const GLuint shader = glCreateShader(kind);
  const char* pointer = text.c_str();
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  GLint ok = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::vector<char> log(4096, '\0');
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size() - 1), nullptr, log.data());
  glDeleteShader(shader);
  return Error{ErrorCode::kUnsupportedData,
               "shader: it does not compile, the driver says " + first_error(log)};
}

void define(std::string& defines, bool on, const char* name) {
  if (on) defines += std::string("#define ") + name + '\n';
}

/// The defines of raycast.frag only.
std::string transfer_defines(const GlFeatures& features) {
  std::string defines;
  using Classified = GlFeatures::Classified;
  using Shaded = GlFeatures::Shaded;
  const bool composite = features.projection == Projection::kComposite;
  const bool shading = composite && features.shaded != Shaded::kNot;
  define(defines, !composite, "PROJECTION");
  define(defines, features.projection == Projection::kMaximum, "MAXIMUM");
  define(defines, features.projection == Projection::kMinimum, "MINIMUM");
  define(defines, composite && features.classified == Classified::kPreIntegrated, "PREINTEGRATED");
  define(defines, composite && features.classified == Classified::kByGradientToo,
         "GRADIENT_WINDOWS");
  define(defines, shading, "SHADING");
  define(defines, shading && features.shaded == Shaded::kPhong, "PHONG");
  define(defines, shading && features.shaded == Shaded::kGooch, "GOOCH");
  define(defines, shading || (composite && features.classified == Classified::kByGradientToo),
         "GRADIENTS");
  define(defines, features.gradient_texture, "GRADIENT_TEXTURE");
  define(defines, shading && features.emphasis, "EMPHASIS");
  define(defines, composite && (features.cutaway || (shading && features.emphasis)), "IMPORTANCE");
  define(defines, features.skipping, "SKIPPING");
  define(defines, features.sparse, "SPARSE");
  return defines;
}

/// The defines of predicates.frag only, with the text of the set.
std::string predicate_defines(const GlPredicateForm& form) {
  std::string defines;
  if (form.feature_textures > 0)
    defines += "#define FEATURES " + std::to_string(form.feature_textures) + '\n';
  define(defines, form.feature_pairs, "FEATURE_PAIRS");
  define(defines, form.volume_in_features, "VOLUME_IN_FEATURES");
  define(defines, form.undefined, "UNDEFINED");
  define(defines, form.labels, "LABELS");
  define(defines, form.log_importance, "LOG_IMPORTANCE");
  define(defines, form.appearance_table, "APPEARANCE_TABLE");
  define(defines, form.shading, "PREDICATE_SHADING");
  define(defines, form.generic, "GENERIC");
  return defines + form.text;
}

std::string common_defines(const GlFeatures& features) {
  const bool composite = features.projection == Projection::kComposite;
  std::string defines;
  define(defines, composite && features.cutaway, "CUTAWAY");
  define(defines, composite && features.cutaway && features.cut_field, "CUT_FIELD");
  define(defines, features.jitter, "JITTER");
  define(defines, features.plane, "PLANE");
  define(defines, features.solids, "SOLIDS");
  define(defines, features.solids && features.capsules, "CAPSULES");
  define(defines, features.shared_depth, "SHARED_DEPTH");
  define(defines, features.signature(), "SIGNATURE");
  define(defines, features.voxel_pairs, "VOXEL_PAIRS");
  define(defines, features.filter != GlFilter::kDevice, "MANUAL_FILTER");
  define(defines, features.filter == GlFilter::kGathers, "GATHERS");
  return defines;
}

std::string constants() {
  std::string defines;
  // The reference engine uses these constants too, so there is one definition for all.
  const auto constant = [&](const char* name, double value) {
    std::ostringstream number;
    number << std::scientific << std::setprecision(9) << value;
    defines += std::string("const float ") + name + " = " + number.str() + ";\n";
  };
  constant("kBorderMm", spec::kBorderMm);
  constant("kBorderPixels", spec::kBorderPixels);
  constant("kEdgeOnSine", spec::kEdgeOnSine);
  constant("kGoochBlue", spec::kGoochBlue);
  constant("kGoochYellow", spec::kGoochYellow);
  constant("kFadeVaries", spec::kFadeVaries);
  defines += "const int kFadeSteps = " + std::to_string(spec::kFadeSteps) + ";\n";
  constant("kMostShades", spec::kMostShades);
  return defines;
}

int samplers_of_device(int most) {
  GLint units = 0;
  glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
  return std::min<int>(units, most);
}

}  // namespace

int samplers_of(const GlFeatures& f) {
  const auto count = [](std::initializer_list<bool> used) {
    return static_cast<int>(std::count(used.begin(), used.end(), true));
  };
  // From the pass before: front and spent; with a plane also behind and live_at.
  if (f.means) return count({true, f.solids, f.shared_depth}) + (f.plane ? 4 : 2);
  int samplers = count({true, f.solids, f.cutaway, f.shared_depth, f.signature()});
  if (f.predicates) {
    const GlPredicateForm& p = *f.predicates;
    // Textures of bricks, appearances and opacity.
    samplers +=
        3 + p.feature_textures + count({p.undefined, p.labels, p.shading, p.generic, f.beside_ct});
  }
  if (!f.predicates || f.beside_ct) {
    const bool pre_integrated = f.classified == GlFeatures::Classified::kPreIntegrated;
    const bool shaded = f.shaded != GlFeatures::Shaded::kNot;
    samplers += count({true, f.cutaway || (shaded && f.emphasis), pre_integrated, f.skipping,
                       f.gradient_texture});
  }
  return samplers;
}

std::string assembled_shader(const std::string& name) {
  std::set<std::string> done;
  std::string out;
  append_block(name, done, out);
  return out;
}

std::string as_compute(std::string text) {
  constexpr std::string_view kFragment = "#version 410 core\n";
  NAV_CHECK(text.starts_with(kFragment));
  return text.replace(0, kFragment.size(), "#version 430 core\n#define COMPUTE\n");
}

std::string raycast_source(const GlFeatures& features) {
  const bool both = features.predicates && features.beside_ct;
  std::string text = assembled_shader(features.means        ? "sparse_means.frag"
                                      : both                ? "two_volumes.frag"
                                      : features.predicates ? "predicates.frag"
                                                            : "raycast.frag");
  if (features.compute) text = as_compute(std::move(text));
  const std::size_t after_version = text.find('\n') + 1;
  std::string defines;
  define(defines, both, "TWO_VOLUMES");
  define(defines, features.unrolled, "UNROLLED");
  define(defines, features.storage, "STORAGE");
  if (features.predicates) defines += predicate_defines(*features.predicates);
  if (both || !features.predicates) defines += transfer_defines(features);
  return text.insert(after_version, defines + common_defines(features) + constants());
}

Result<std::unique_ptr<GlProgram>> GlProgram::link(const std::string& vertex,
                                                   const std::string& fragment) {
  auto vs = compile(GL_VERTEX_SHADER, vertex);
  if (!vs) return vs.error();
  auto fs = compile(GL_FRAGMENT_SHADER, fragment);
  if (!fs) {
    glDeleteShader(*vs);
    return fs.error();
  }
  return linked({*vs, *fs}, fragment);
}

Result<std::unique_ptr<GlProgram>> GlProgram::link_fullscreen(const std::string& fragment) {
  return link(assembled_shader("fullscreen.vert"), fragment);
}

Result<std::unique_ptr<GlProgram>> GlProgram::link_compute(const std::string& text) {
  auto shader = compile(GL_COMPUTE_SHADER, text);
  if (!shader) return shader.error();
  return linked({*shader}, text);
}

/// Links the shaders, and deletes them.
Result<std::unique_ptr<GlProgram>> GlProgram::linked(const std::vector<unsigned>& shaders,
                                                     const std::string& text) {
  const GLuint id = glCreateProgram();
  for (const GLuint shader : shaders) glAttachShader(id, shader);
  glLinkProgram(id);
  for (const GLuint shader : shaders) glDeleteShader(shader);
  std::unique_ptr<GlProgram> program(new GlProgram(id, text));
  GLint ok = GL_FALSE;
  glGetProgramiv(id, GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::vector<char> log(4096, '\0');
  glGetProgramInfoLog(id, static_cast<GLsizei>(log.size() - 1), nullptr, log.data());
  return Error{ErrorCode::kUnsupportedData,
               "shader: it does not link, the driver says " + first_error(log)};
}

GlProgram::~GlProgram() { glDeleteProgram(id_); }

void GlProgram::use() const { glUseProgram(id_); }

int GlProgram::location(const std::string& name) {
  const auto found = locations_.find(name);
  if (found != locations_.end()) return found->second;
  const int location = glGetUniformLocation(id_, name.c_str());
  NAV_CHECK(location >= 0 || text_.find(name) != std::string::npos, name);
  return locations_[name] = location;
}

void GlProgram::set(const std::string& name, int value) { glUniform1i(location(name), value); }
void GlProgram::set(const std::string& name, double value) {
  glUniform1f(location(name), static_cast<float>(value));
}
void GlProgram::set(const std::string& name, const Eigen::Vector2d& value) {
  glUniform2fv(location(name), 1, glm::value_ptr(to_gpu<2>(value)));
}
void GlProgram::set(const std::string& name, const Eigen::Vector3d& value) {
  glUniform3fv(location(name), 1, glm::value_ptr(to_gpu<3>(value)));
}
void GlProgram::set(const std::string& name, const Eigen::Vector4d& value) {
  glUniform4fv(location(name), 1, glm::value_ptr(to_gpu<4>(value)));
}
void GlProgram::set(const std::string& name, const Eigen::Vector2i& value) {
  glUniform2iv(location(name), 1, value.data());
}
void GlProgram::set(const std::string& name, const Eigen::Vector3i& value) {
  glUniform3iv(location(name), 1, value.data());
}
void GlProgram::set(const std::string& name, const Eigen::Vector4i& value) {
  glUniform4iv(location(name), 1, value.data());
}
void GlProgram::set(const std::string& name, const std::vector<double>& value) {
  const std::vector<float> v(value.begin(), value.end());
  using Send = void (*)(GLint, const float*);
  constexpr Send kSend[] = {[](GLint at, const float* p) { glUniform1fv(at, 1, p); },
                            [](GLint at, const float* p) { glUniform2fv(at, 1, p); },
                            [](GLint at, const float* p) { glUniform3fv(at, 1, p); },
                            [](GLint at, const float* p) { glUniform4fv(at, 1, p); }};
  NAV_CHECK(!v.empty() && v.size() <= std::size(kSend), v.size());
  kSend[v.size() - 1](location(name), v.data());
}
void GlProgram::set_bits(const std::string& name, std::uint32_t value) {
  glUniform1ui(location(name), value);
}
void GlProgram::set(const std::string& name, const Eigen::Matrix2d& value) {
  glUniformMatrix2fv(location(name), 1, GL_FALSE, glm::value_ptr(to_gpu<2>(value)));
}
void GlProgram::set(const std::string& name, const Eigen::Matrix3d& value) {
  glUniformMatrix3fv(location(name), 1, GL_FALSE, glm::value_ptr(to_gpu<3>(value)));
}
void GlProgram::set(const std::string& name, const Eigen::Matrix4d& value) {
  glUniformMatrix4fv(location(name), 1, GL_FALSE, glm::value_ptr(to_gpu<4>(value)));
}

bool GlProgramCache::fits(const GlFeatures& features) const {
  return samplers_of(features) <= samplers_of_device(most_samplers_);
}

Result<GlProgram*> GlProgramCache::get(const GlFeatures& features) {
  const auto found = programs_.find(features);
  if (found != programs_.end()) return found->second.get();
  if (!fits(features)) {
    return Error{ErrorCode::kUnsupportedData,
                 "OpenGL: expected at least " + std::to_string(samplers_of(features)) +
                     " textures in a fragment shader for this scene, found "
                     "GL_MAX_TEXTURE_IMAGE_UNITS " +
                     std::to_string(samplers_of_device(most_samplers_)) +
                     "; the CPU engine draws it"};
  }
  if (features.compute && refuses_compute_) {
    return Error{ErrorCode::kUnsupportedData, "shader: the driver rejected it before"};
  }
  ++compiled_;
  const std::string text = raycast_source(features);
  auto program =
      features.compute ? GlProgram::link_compute(text) : GlProgram::link_fullscreen(text);
  if (!program) return program.error();
  return (programs_[features] = std::move(program).value()).get();
}

}  // namespace nav::render
