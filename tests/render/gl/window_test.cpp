// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/window/window.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include "render/engine.hpp"
#include "render/gl/gl_volume_prop.hpp"
#include "render/vtk/vtk_convert.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"
#include "tests/support/matchers.hpp"
// Included last, because X11 defines macros with everyday names.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace nav::render {
namespace {

#define SONDE_REQUIRE_DISPLAY() \
  if (std::getenv("DISPLAY") == nullptr) GTEST_SKIP() << "no X display (run under xvfb-run)"

TEST(SceneInAWindowTest, IsTheSameImageAsOfTheHeadlessEngine) {
  SONDE_REQUIRE_DISPLAY();
  Scene scene = test::ball_scene(test::oblique_grid(), 160, 120);
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  scene.needle = test::test_needle(scene.ct->grid(), SafetyState::kValid);
  scene.spheres = test::test_spheres(scene.ct->grid());
  CollectingDiagnostics diagnostics;
  auto engine = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(engine));
  const auto headless = (*engine)->render(scene);
  ASSERT_TRUE(test::has_value(headless));
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->SetSize(scene.width, scene.height);
  SceneView view(*window);
  ASSERT_TRUE(test::has_value(view.draw(std::make_shared<const Scene>(scene))));
  const Image2d<Rgba8> shown = read_pixels(*window);
  test::keep_image("window", shown);
  // The window blends in 8 bits and rounds colour and background separately. The engine rounds
  // once.
  constexpr int kTwoRoundings = 1;
  const auto found = test::difference(shown, to_8bit(headless->pixels), kTwoRoundings);
  EXPECT_EQ(found.fraction_above, 0) << found.max;
}

TEST(SceneInAWindowTest, ShowsUltrasoundInACtLikeTheHeadlessEngine) {
  SONDE_REQUIRE_DISPLAY();
  VoxelGrid where = test::centred_grid({15, 15, 15}, {1, 0.8, 0.9});
  where.origin_mm.y() += 9;
  Scene scene = test::fog_scene(where, 0.05);
  scene.width = 64;
  scene.height = 48;
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->SetSize(scene.width, scene.height);
  SceneView view(*window);
  CollectingDiagnostics diagnostics;
  auto engine = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(engine));
  Image2d<Rgba8> last;
  for (const double importance : {1.0, 0.5, 0.0}) {
    scene.ultrasound->ct_importance = importance;
    ASSERT_TRUE(test::has_value(view.draw(std::make_shared<const Scene>(scene))));
    const Image2d<Rgba8> shown = read_pixels(*window);
    const auto headless = (*engine)->render(scene);
    ASSERT_TRUE(test::has_value(headless));
    EXPECT_EQ(test::difference(shown, to_8bit(headless->pixels), 1).fraction_above, 0);
    if (!last.empty()) {
      EXPECT_GT(test::difference(shown, last, 1).fraction_above, 0.05) << importance;
    }
    last = shown;
  }
  EXPECT_EQ(view.raycaster().compiled(), 1);
}

TEST(SceneInAWindowTest, IsTheSameImageAfterItsContextIsLost) {
  SONDE_REQUIRE_DISPLAY();
  auto scene = std::make_shared<Scene>(test::ball_scene(test::cube_grid(24, 1.0), 96, 64));
  scene->plane = test::test_plane(scene->ct->grid(), SafetyState::kValid);
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->SetSize(scene->width, scene->height);
  SceneView view(*window);
  ASSERT_TRUE(test::has_value(view.draw(scene)));
  const Image2d<Rgba8> before = read_pixels(*window);
  // The context of the window ends here, with all its textures and programs.
  window->Finalize();
  ASSERT_TRUE(test::has_value(view.draw(scene)));
  const Image2d<Rgba8> after = read_pixels(*window);
  ASSERT_EQ(after.pixels().size(), before.pixels().size());
  EXPECT_EQ(
      std::memcmp(after.pixels().data(), before.pixels().data(), before.pixels().size_bytes()), 0);
  const auto background = after.pixels().front();
  EXPECT_TRUE(std::any_of(after.pixels().begin(), after.pixels().end(),
                          [&](const Rgba8& p) { return p.r != background.r; }));
}

/// Image with a colour of its own in every pixel.
Image2d<Rgba8> colours(int width, int height) {
  std::vector<Rgba8> pixels;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      pixels.push_back({static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                        static_cast<std::uint8_t>(x * y), 255});
    }
  }
  return {width, height, std::move(pixels)};
}

struct XConnection {
  XConnection() : display(XOpenDisplay(nullptr)) {}
  ~XConnection() { XCloseDisplay(display); }
  XConnection(const XConnection&) = delete;
  XConnection& operator=(const XConnection&) = delete;
  Display* display;
};

/// The only window on the display. No window manager runs in the tests.
Window only_window(Display* display) {
  Window root = DefaultRootWindow(display);
  Window parent = 0;
  Window* children = nullptr;
  unsigned count = 0;
  XQueryTree(display, root, &root, &parent, &children, &count);
  const Window found = count > 0 ? children[count - 1] : 0;
  XFree(children);
  return found;
}

/// Pixels of the upper left corner of the only window, as the display shows them.
Image2d<Rgba8> shown_pixels(int width, int height) {
  const XConnection x;
  XImage* image = XGetImage(x.display, only_window(x.display), 0, 0, static_cast<unsigned>(width),
                            static_cast<unsigned>(height), AllPlanes, ZPixmap);
  std::vector<Rgba8> pixels;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const unsigned long p = XGetPixel(image, column, row);
      pixels.push_back({static_cast<std::uint8_t>(p >> 16), static_cast<std::uint8_t>(p >> 8),
                        static_cast<std::uint8_t>(p), 255});
    }
  }
  XDestroyImage(image);
  return {width, height, std::move(pixels)};
}

/// Sends an event of the mouse or the keyboard to the only window.
void send(int type, int x_px, int y_px, unsigned button_or_key) {
  const XConnection x;
  XEvent event{};
  event.type = type;
  event.xbutton.display = x.display;
  event.xbutton.window = only_window(x.display);
  event.xbutton.root = DefaultRootWindow(x.display);
  event.xbutton.x = x_px;
  event.xbutton.y = y_px;
  event.xbutton.same_screen = 1;
  if (type == ButtonPress || type == ButtonRelease) event.xbutton.button = button_or_key;
  if (type == KeyPress) {
    event.xkey.keycode = XKeysymToKeycode(x.display, button_or_key);
  }
  XSendEvent(x.display, event.xbutton.window, 0, 0, &event);
  XSync(x.display, 0);
}

TEST(WindowTest, ShowsTheImagesOfItsSource) {
  SONDE_REQUIRE_DISPLAY();
  const auto image = colours(200, 120);
  Image2d<Rgba8> seen;
  int asked = 0;
  const ImageSource source = [&](const WindowInput& input) {
    EXPECT_EQ(input.width, 240);
    EXPECT_EQ(input.height, 160);
    ++asked;
    if (asked == 1) return image;
    seen = shown_pixels(240, 160);
    return Image2d<Rgba8>();
  };
  ASSERT_TRUE(test::has_value(show_window(
      source,
      {.width = 240, .height = 160, .refresh_hz = 50, .close_when = [&] { return asked > 4; }})));
  ASSERT_EQ(seen.width(), 240);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 200; ++x) ASSERT_EQ(seen.at(x, y), image.at(x, y)) << x << ", " << y;
  }
  EXPECT_EQ(seen.at(239, 159), (Rgba8{0x10, 0x14, 0x18, 255})) << "outside of the image";
}

TEST(WindowTest, IsNoLargerThanTheScreen) {
  SONDE_REQUIRE_DISPLAY();
  int width = 0;
  const ImageSource source = [&](const WindowInput& input) {
    width = input.width;
    return colours(20, 20);
  };
  ASSERT_TRUE(test::has_value(show_window(
      source, {.width = 100000, .height = 100, .close_when = [&] { return width > 0; }})));
  const XConnection x;
  EXPECT_EQ(width, DisplayWidth(x.display, DefaultScreen(x.display)));
}

TEST(WindowTest, ReportsDragsWheelAndKeysAndClosesByQ) {
  SONDE_REQUIRE_DISPLAY();
  WindowInput sum;
  int asked = 0;
  const ImageSource source = [&](const WindowInput& input) {
    sum.orbit += input.orbit;
    sum.pan += input.pan;
    sum.zoom *= input.zoom;
    sum.keys += input.keys;
    if (++asked == 3) {
      send(MotionNotify, 90, 90, 0);  // Without a button: nothing.
      send(ButtonPress, 10, 50, Button1);
      send(MotionNotify, 20, 30, 0);
      send(MotionNotify, 30, 30, 0);
      send(ButtonRelease, 30, 30, Button1);
      send(ButtonPress, 0, 0, Button2);
      send(MotionNotify, 0, 50, 0);
      send(ButtonRelease, 0, 50, Button2);
      send(ButtonPress, 0, 0, Button4);
      send(ButtonPress, 0, 0, Button4);
      send(KeyPress, 0, 0, 'r');
    }
    if (asked == 6) send(KeyPress, 0, 0, 'q');
    return Image2d<Rgba8>();
  };
  ASSERT_TRUE(test::has_value(
      show_window(source, {.width = 200, .height = 100, .refresh_hz = 100, .close_after_s = 20})));
  EXPECT_LT(asked, 1000) << "q closes";
  EXPECT_NEAR((sum.orbit - Eigen::Vector2d(0.2, 0.2)).norm(), 0, 1e-12);
  EXPECT_NEAR((sum.pan - Eigen::Vector2d(0, -0.5)).norm(), 0, 1e-12);
  EXPECT_NEAR(sum.zoom, 1.21, 1e-12);
  EXPECT_EQ(sum.keys.substr(0, 1), "r");
}

TEST(WindowTest, ReportsANewSize) {
  SONDE_REQUIRE_DISPLAY();
  int asked = 0;
  int height = 0;
  const ImageSource source = [&](const WindowInput& input) {
    height = input.height;
    if (++asked == 2) {
      const XConnection x;
      XResizeWindow(x.display, only_window(x.display), 150, 130);
      XSync(x.display, 0);
    }
    return colours(input.width, input.height);
  };
  ASSERT_TRUE(test::has_value(show_window(
      source,
      {.width = 100, .height = 100, .refresh_hz = 50, .close_after_s = 20, .close_when = [&] {
         return height == 130;
       }})));
  EXPECT_EQ(height, 130);
}

TEST(WindowTest, ClosesByItself) {
  SONDE_REQUIRE_DISPLAY();
  int asked = 0;
  const ImageSource source = [&](const WindowInput&) {
    ++asked;
    return Image2d<Rgba8>();
  };
  EXPECT_TRUE(test::has_value(show_window(source, {.refresh_hz = 100, .close_after_s = 0.5})));
  EXPECT_GT(asked, 3);
}

TEST(WindowTest, TheHeadlessEngineDrawsForAWindow) {
  SONDE_REQUIRE_DISPLAY();
  const Scene scene = test::ball_scene(test::cube_grid(16, 1.0), 64, 48);
  CollectingDiagnostics diagnostics;
  auto engine = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(engine));
  int rendered = 0;
  const ImageSource source = [&](const WindowInput&) -> Result<Image2d<Rgba8>> {
    const auto image = (*engine)->render(scene);
    if (!image) return image.error();
    ++rendered;
    return to_8bit(image->pixels);
  };
  EXPECT_TRUE(test::has_value(
      show_window(source, {.refresh_hz = 50, .close_when = [&] { return rendered > 2; }})));
}

TEST(WindowTest, AnErrorOfTheSourceClosesTheWindow) {
  SONDE_REQUIRE_DISPLAY();
  int asked = 0;
  const ImageSource source = [&](const WindowInput&) -> Result<Image2d<Rgba8>> {
    if (++asked < 3) return colours(20, 20);
    return Error{ErrorCode::kNumerical, "no image"};
  };
  EXPECT_TRUE(test::rejects(show_window(source, {.refresh_hz = 100, .close_after_s = 10}),
                            ErrorCode::kNumerical, {"no image"}));
  EXPECT_EQ(asked, 3);
}

TEST(WindowTest, RejectsAnInvalidRefreshRate) {
  const ImageSource nothing = [](const WindowInput&) { return Image2d<Rgba8>(); };
  EXPECT_TRUE(
      test::rejects(show_window(nothing, {.refresh_hz = 0}), ErrorCode::kUsage, {"refresh_hz"}));
}

constexpr double kRoundingMm = 1e-9;

TEST(WindowCameraTest, OrbitKeepsTheDistanceAndTurnsTheEye) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Eigen::Vector3d before = camera.eye_ct.mm - camera.look_at_ct.mm;
  const Camera yawed = orbited(camera, 0.3, 0);
  const Eigen::Vector3d after = yawed.eye_ct.mm - yawed.look_at_ct.mm;
  EXPECT_NEAR(after.norm(), before.norm(), kRoundingMm);
  EXPECT_NEAR(std::acos(after.normalized().dot(before.normalized())), 0.3, kRoundingMm);
  const Eigen::Vector3d right = (-before).cross(camera.up_ct.v);
  EXPECT_GT((yawed.eye_ct.mm - camera.eye_ct.mm).dot(right), 0);
  const Camera pitched = orbited(camera, 0, 0.3);
  EXPECT_GT((pitched.eye_ct.mm - camera.eye_ct.mm).dot(camera.up_ct.v), 0);
}

TEST(WindowCameraTest, OrbitPassesThePole) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Camera start = camera;
  for (int i = 0; i < 100; ++i) camera = orbited(camera, 0, 2 * M_PI / 100);
  EXPECT_LT((camera.eye_ct.mm - start.eye_ct.mm).norm(), kRoundingMm);
}

TEST(WindowCameraTest, PanMovesByFractionsOfTheImageHeight) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  camera.orthographic = true;
  const Camera moved = panned(camera, 0, 0.25);
  const Eigen::Vector3d shift = moved.look_at_ct.mm - camera.look_at_ct.mm;
  EXPECT_NEAR(shift.norm(), 0.25 * camera.orthographic_height_mm, kRoundingMm);
  EXPECT_LT((moved.eye_ct.mm - camera.eye_ct.mm - shift).norm(), kRoundingMm);
  EXPECT_NEAR(shift.dot(camera.look_at_ct.mm - camera.eye_ct.mm), 0, kRoundingMm);
}

TEST(WindowCameraTest, ZoomDividesDistanceAndHeight) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const Camera nearer = zoomed(camera, 2);
  EXPECT_NEAR((nearer.eye_ct.mm - nearer.look_at_ct.mm).norm(),
              0.5 * (camera.eye_ct.mm - camera.look_at_ct.mm).norm(), kRoundingMm);
  EXPECT_NEAR(nearer.orthographic_height_mm, 0.5 * camera.orthographic_height_mm, kRoundingMm);
}

bool is_seen_by(const Camera& camera) {
  Scene scene = test::ball_scene(test::cube_grid(16, 1.0));
  scene.camera = camera;
  return test::has_value(validate(scene));
}

TEST(WindowCameraTest, ZoomingNeverLosesTheCamera) {
  constexpr int kManyTurns = 2000;
  for (const bool orthographic : {false, true}) {
    Camera start = test::ball_scene(test::cube_grid(16, 1.0)).camera;
    start.orthographic = orthographic;
    for (const double factor : {1.1, 1 / 1.1}) {
      Camera camera = start;
      for (int i = 0; i < kManyTurns; ++i) camera = zoomed(camera, factor);
      EXPECT_TRUE(is_seen_by(camera)) << orthographic << ' ' << factor;
      // The return from the limit takes as many turns as the way from here to the limit.
      const auto size = [&](const Camera& c) {
        return orthographic ? c.orthographic_height_mm : (c.eye_ct.mm - c.look_at_ct.mm).norm();
      };
      int turns = 0;
      while (turns < kManyTurns && (size(camera) > size(start)) == (factor < 1)) {
        camera = zoomed(camera, 1 / factor);
        ++turns;
      }
      EXPECT_LT(turns, 150) << orthographic << ' ' << factor;
    }
  }
}

TEST(WindowCameraTest, DraggingNeverLosesTheCamera) {
  constexpr int kManyDrags = 1000;
  for (const bool orthographic : {false, true}) {
    Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
    camera.orthographic = orthographic;
    for (int i = 0; i < kManyDrags; ++i) camera = zoomed(camera, 0.5);
    for (int i = 0; i < kManyDrags; ++i) camera = panned(camera, 1, -1);
    EXPECT_TRUE(is_seen_by(camera)) << orthographic;
    for (int i = 0; i < kManyDrags; ++i) {
      camera = orbited(camera, 0.7, -0.4);
      camera = zoomed(camera, i % 2 == 0 ? 0.1 : 9.0);
    }
    EXPECT_TRUE(is_seen_by(camera)) << orthographic;
    const Camera back = panned(camera, -1, 1);
    EXPECT_TRUE(is_seen_by(back)) << orthographic;
  }
}

TEST(WindowCameraTest, InputMovesTheSceneWithTheMouse) {
  const Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  const auto same = [](const Camera& a, const Camera& b) {
    return (a.eye_ct.mm - b.eye_ct.mm).norm() + (a.look_at_ct.mm - b.look_at_ct.mm).norm() <
           kRoundingMm;
  };
  WindowInput input;
  EXPECT_TRUE(same(moved(camera, input), camera));
  input.orbit = {0.1, 0.2};
  EXPECT_TRUE(same(moved(camera, input), orbited(camera, -0.1 * M_PI, -0.2 * M_PI)));
  input = {};
  input.pan = {0.1, 0.2};
  EXPECT_TRUE(same(moved(camera, input), panned(camera, -0.1, -0.2)));
  input = {};
  input.zoom = 2;
  EXPECT_TRUE(same(moved(camera, input), zoomed(camera, 2)));
}

TEST(WindowCameraTest, AViewBeyondTheLimitsCanOnlyReturn) {
  Camera camera = test::ball_scene(test::cube_grid(16, 1.0)).camera;
  constexpr double kFarMm = 1e6;
  camera.eye_ct.mm = camera.look_at_ct.mm + Eigen::Vector3d(0, -kFarMm, 0);
  const auto distance_mm = [](const Camera& c) { return (c.eye_ct.mm - c.look_at_ct.mm).norm(); };
  EXPECT_NEAR(distance_mm(zoomed(camera, 0.5)), kFarMm, kFarMm * kRoundingMm);
  EXPECT_NEAR(distance_mm(zoomed(camera, 2)), kFarMm / 2, kFarMm * kRoundingMm);
}

}  // namespace
}  // namespace nav::render
