// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW first: every other GL header depends on it.
#include <glm/gtc/type_ptr.hpp>
#include <iomanip>
#include <set>
#include <sstream>
#include <vector>

#include "nav/check.hpp"
#include "render/gl_convert.hpp"
#include "render/gl_program.hpp"
#include "render/ray_spec.hpp"
#include "shaders/shaders.hpp"

namespace nav::render {
namespace {

void append_block(const std::string& name, std::set<std::string>& done, std::string& out) {
  if (!done.insert(name).second) return;
  const std::string_view text = shaders::source(name);
  NAV_CHECK(!text.empty(), name);
  std::istringstream lines{std::string(text)};
  constexpr std::string_view kInclude = "#include \"";
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kInclude)) {
      append_block(line.substr(kInclude.size(), line.rfind('"') - kInclude.size()), done, out);
    } else {
      out += line + '\n';
    }
  }
}

std::string first_line(const std::vector<char>& log) {
  const std::string text(log.data());
  return text.substr(0, text.find('\n'));
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
               "shader: expected it to compile, the driver says " + first_line(log)};
}

}  // namespace

std::string assembled_shader(const std::string& name) {
  std::set<std::string> done;
  std::string out;
  append_block(name, done, out);
  return out;
}

std::string raycast_fragment_source(const GlFeatures& features) {
  std::string text = assembled_shader("raycast.frag");
  const std::size_t after_version = text.find('\n', text.find("#version")) + 1;
  std::string defines;
  const auto add = [&](bool on, const char* name) {
    if (on) defines += std::string("#define ") + name + '\n';
  };
  using Classified = GlFeatures::Classified;
  using Shaded = GlFeatures::Shaded;
  const bool composite = features.projection == Projection::kComposite;
  const bool shading = composite && features.shaded != Shaded::kNot;
  add(!composite, "PROJECTION");
  add(features.projection == Projection::kMaximum, "MAXIMUM");
  add(features.projection == Projection::kMinimum, "MINIMUM");
  add(composite && features.classified == Classified::kPreIntegrated, "PREINTEGRATED");
  add(composite && features.classified == Classified::kByGradientToo, "GRADIENT_WINDOWS");
  add(shading, "SHADING");
  add(shading && features.shaded == Shaded::kPhong, "PHONG");
  add(shading && features.shaded == Shaded::kGooch, "GOOCH");
  add(shading || (composite && features.classified == Classified::kByGradientToo), "GRADIENTS");
  add(features.gradient_texture, "GRADIENT_TEXTURE");
  add(shading && features.emphasis, "EMPHASIS");
  add(composite && features.cutaway, "CUTAWAY");
  add(composite && features.cutaway && features.cut_field, "CUT_FIELD");
  add(composite && (features.cutaway || (shading && features.emphasis)), "IMPORTANCE");
  add(composite && features.skipping, "SKIPPING");
  add(features.jitter, "JITTER");
  add(features.plane, "PLANE");
  add(features.solids, "SOLIDS");
  add(features.solids && features.capsules, "CAPSULES");
  add(features.shared_depth, "SHARED_DEPTH");
  add(features.manual_filter, "MANUAL_FILTER");
  // Constants that the reference engine uses too: one definition for all.
  const auto constant = [&](const char* name, double value) {
    std::ostringstream number;
    number << std::scientific << std::setprecision(9) << value;
    defines += std::string("const float ") + name + " = " + number.str() + ";\n";
  };
  constant("kBorderMm", spec::kBorderMm);
  constant("kEdgeOnSine", spec::kEdgeOnSine);
  constant("kGoochBlue", spec::kGoochBlue);
  constant("kGoochYellow", spec::kGoochYellow);
  defines += "const int kFadeSteps = " + std::to_string(spec::kFadeSteps) + ";\n";
  return text.insert(after_version, defines);
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
  const GLuint id = glCreateProgram();
  glAttachShader(id, *vs);
  glAttachShader(id, *fs);
  glLinkProgram(id);
  glDeleteShader(*vs);
  glDeleteShader(*fs);
  std::unique_ptr<GlProgram> program(new GlProgram(id, fragment));
  GLint ok = GL_FALSE;
  glGetProgramiv(id, GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::vector<char> log(4096, '\0');
  glGetProgramInfoLog(id, static_cast<GLsizei>(log.size() - 1), nullptr, log.data());
  return Error{ErrorCode::kUnsupportedData,
               "shader: expected it to link, the driver says " + first_line(log)};
}

GlProgram::~GlProgram() { glDeleteProgram(id_); }

void GlProgram::use() const { glUseProgram(id_); }

int GlProgram::location(const std::string& name) {
  const auto found = locations_.find(name);
  if (found != locations_.end()) return found->second;
  const int location = glGetUniformLocation(id_, name.c_str());
  NAV_CHECK(location >= 0 || fragment_.find(name) != std::string::npos, name);
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
void GlProgram::set(const std::string& name, const Eigen::Matrix2d& value) {
  glUniformMatrix2fv(location(name), 1, GL_FALSE, glm::value_ptr(to_gpu<2>(value)));
}
void GlProgram::set(const std::string& name, const Eigen::Matrix3d& value) {
  glUniformMatrix3fv(location(name), 1, GL_FALSE, glm::value_ptr(to_gpu<3>(value)));
}
void GlProgram::set(const std::string& name, const Eigen::Matrix4d& value) {
  glUniformMatrix4fv(location(name), 1, GL_FALSE, glm::value_ptr(to_gpu<4>(value)));
}

Result<GlProgram*> GlProgramCache::get(const GlFeatures& features) {
  const auto found = programs_.find(features);
  if (found != programs_.end()) return found->second.get();
  ++compiled_;
  auto program =
      GlProgram::link(assembled_shader("fullscreen.vert"), raycast_fragment_source(features));
  if (!program) return program.error();
  return (programs_[features] = std::move(program).value()).get();
}

}  // namespace nav::render
