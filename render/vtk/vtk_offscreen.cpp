// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glx.h>
#include <array>
#include <optional>
#include <sstream>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLState.h>
#include <vtkSmartPointer.h>

#include "render/vtk/vtk_offscreen.hpp"

namespace nav::render {
namespace {

Error unavailable(const std::string& missing, const std::string& found) {
  return {ErrorCode::kUnavailable, "off-screen OpenGL: expected " + missing +
                                       " (Debian: libegl1, libegl-mesa0), found " + found};
}

std::string egl_error() {
  std::ostringstream text;
  text << "EGL error 0x" << std::hex << eglGetError();
  return text.str();
}

/// Opens and initialises an EGL display; tries surfaceless platforms first.
EGLDisplay open_display() {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const std::string extensions = client ? client : "";
  const auto initialised = [](EGLDisplay display) {
    return display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr);
  };
  const auto get_platform = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      eglGetProcAddress("eglGetPlatformDisplayEXT"));
  const auto query_devices =
      reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  // EGL lists real devices before software ones, so a GPU is preferred.
  if (get_platform && query_devices &&
      extensions.find("EGL_EXT_platform_device") != std::string::npos) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count)) {
      for (EGLint i = 0; i < count; ++i) {
        EGLDisplay display =
            get_platform(EGL_PLATFORM_DEVICE_EXT, devices[std::size_t(i)], nullptr);
        if (initialised(display)) return display;
      }
    }
  }
  if (get_platform && extensions.find("EGL_MESA_platform_surfaceless") != std::string::npos) {
    EGLDisplay display = get_platform(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (initialised(display)) return display;
  }
  EGLDisplay display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
  return initialised(display) ? display : EGL_NO_DISPLAY;
}

/// Opens a core context of the newest available version, at least 4.1. why: receives the reason if
/// there is none.
EGLContext open_context(EGLDisplay display, std::string& why) {
  if (!eglBindAPI(EGL_OPENGL_API)) {
    why = "EGL without desktop OpenGL";
    return EGL_NO_CONTEXT;
  }
  const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &count) || count < 1) {
    why = "no EGL configuration for OpenGL";
    return EGL_NO_CONTEXT;
  }
  for (const auto& [major, minor] : {std::pair{4, 5}, {4, 3}, {4, 1}}) {
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 major,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 minor,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    if (context != EGL_NO_CONTEXT) return context;
  }
  why = "no OpenGL 4.1 core context, " + egl_error();
  return EGL_NO_CONTEXT;
}

/// Owns the EGL context. The display stays open, because EGL shares it within the process.
struct EglContext {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  EglContext() = default;
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  ~EglContext() {
    if (context == EGL_NO_CONTEXT) return;
    if (is_current()) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
  }
  [[nodiscard]] bool make_current() const {
    // An X11 window on this thread must release its context first; VTK takes it again before it
    // draws there.
    if (glXGetCurrentContext() != nullptr) {
      glXMakeCurrent(glXGetCurrentDisplay(), None, nullptr);
    }
    return eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE;
  }
  [[nodiscard]] bool is_current() const { return eglGetCurrentContext() == context; }
};

/// VTK's window for foreign contexts, made current on EGL.
class EglRenderWindow final : public vtkGenericOpenGLRenderWindow {
 public:
  static EglRenderWindow* New();
  vtkTypeMacro(EglRenderWindow,
               vtkGenericOpenGLRenderWindow) void use(std::shared_ptr<EglContext> context) {
    context_ = std::move(context);
  }
  [[nodiscard]] bool ready() const { return this->Initialized && this->GlewInitValid; }

  void MakeCurrent() override {
    if (context_ && !context_->is_current()) (void)context_->make_current();
  }
  bool IsCurrent() override { return context_ && context_->is_current(); }
  int SupportsOpenGL() override { return 1; }
  vtkTypeBool IsDirect() override { return 1; }

  /// Accepts the result 4 (GLEW_ERROR_NO_GLX_DISPLAY) of glewInit(). Debian's GLEW is the GLX
  /// build: without an X display it returns this after it has loaded every OpenGL entry point.
  void OpenGLInitContext() override {
    if (this->Initialized) return;
    this->ContextCreationTime.Modified();
    constexpr GLenum kNoGlxDisplay = 4;
    glewExperimental = GL_TRUE;
    const GLenum result = glewInit();
    while (glGetError() != GL_NO_ERROR) {
    }
    this->GlewInitValid =
        (result == GLEW_OK || result == kNoGlxDisplay) && glCreateShader && glTexImage3D;
    if (!this->GlewInitValid) return;
    this->Initialized = true;
    GLfloat width_range[2] = {1, 1};
    glGetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, width_range);
    this->MaximumHardwareLineWidth = width_range[1];
  }

 protected:
  EglRenderWindow() = default;

 private:
  std::shared_ptr<EglContext> context_;
};
vtkStandardNewMacro(EglRenderWindow)

}  // namespace

struct OffscreenWindow::Impl {
  std::shared_ptr<EglContext> context = std::make_shared<EglContext>();
  vtkSmartPointer<EglRenderWindow> window;
  std::string device;
};

OffscreenWindow::OffscreenWindow(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

OffscreenWindow::~OffscreenWindow() {
  impl_->window->MakeCurrent();
  impl_->window->Finalize();
}

Result<std::unique_ptr<OffscreenWindow>> OffscreenWindow::create(int width, int height) {
  auto impl = std::make_unique<Impl>();
  impl->context->display = open_display();
  if (impl->context->display == EGL_NO_DISPLAY) {
    return unavailable("an EGL display", "none, " + egl_error());
  }
  std::string why;
  impl->context->context = open_context(impl->context->display, why);
  if (impl->context->context == EGL_NO_CONTEXT) return unavailable("OpenGL 4.1 core on EGL", why);
  if (!impl->context->make_current()) {
    return unavailable("EGL_KHR_surfaceless_context", egl_error());
  }
  impl->window = vtkSmartPointer<EglRenderWindow>::New();
  impl->window->use(impl->context);
  impl->window->SetOwnContext(0);
  impl->window->SetMultiSamples(0);
  impl->window->SetSize(width, height);
  impl->window->SetFrameBlitModeToNoBlit();
  impl->window->OpenGLInitContext();
  if (!impl->window->ready()) return unavailable("OpenGL entry points through GLEW", "none");
  impl->window->OpenGLInit();
  impl->window->SetReadyForRendering(true);
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  impl->device = renderer ? renderer : "unnamed OpenGL device";
  return std::unique_ptr<OffscreenWindow>(new OffscreenWindow(std::move(impl)));
}

vtkOpenGLRenderWindow& OffscreenWindow::window() { return *impl_->window; }
void OffscreenWindow::release_thread() {
  if (!impl_->context->is_current()) return;
  eglMakeCurrent(impl_->context->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}
const std::string& OffscreenWindow::device() const { return impl_->device; }

}  // namespace nav::render
