// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/window/window.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <poll.h>
#include <utility>
#include <vector>
// Included last, because X11 defines macros with everyday names.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace nav::render {
namespace {

using SteadyClock = std::chrono::steady_clock;

struct CloseDisplay {
  void operator()(Display* display) const { XCloseDisplay(display); }
};
using DisplayConnection = std::unique_ptr<Display, CloseDisplay>;

Result<DisplayConnection> connect_display() {
  DisplayConnection display(XOpenDisplay(nullptr));
  if (display) return display;
  const char* name = std::getenv("DISPLAY");
  return Error{ErrorCode::kUnavailable,
               "window: expected an X display, found " +
                   (name && *name ? "DISPLAY=" + std::string(name) + ", which does not answer"
                                  : std::string("DISPLAY not set"))};
}

/// One colour channel of a display's pixels.
class Channel {
 public:
  explicit Channel(unsigned long mask)
      : shift_(std::countr_zero(mask)), most_(static_cast<std::uint32_t>(mask >> shift_)) {}
  [[nodiscard]] std::uint32_t of(std::uint8_t value) const {
    return (value * most_ + 127) / 255 << shift_;
  }

 private:
  int shift_;
  std::uint32_t most_;
};

/// A window on an X display. One thread.
class XWindow {
 public:
  XWindow(DisplayConnection display, const WindowOptions& options) : display_(std::move(display)) {
    Display* d = display_.get();
    const int screen = DefaultScreen(d);
    input_.width = std::min(options.width, DisplayWidth(d, screen));
    input_.height = std::min(options.height, DisplayHeight(d, screen));
    constexpr unsigned long kDark = 0x101418;
    window_ = XCreateSimpleWindow(d, RootWindow(d, screen), 0, 0, unsigned_of(input_.width),
                                  unsigned_of(input_.height), 0, 0, kDark);
    XStoreName(d, window_, options.title.c_str());
    XSizeHints hints{};
    hints.flags = PMinSize;
    hints.min_width = options.least_width;
    hints.min_height = options.least_height;
    XSetWMNormalHints(d, window_, &hints);
    XSelectInput(d, window_,
                 ExposureMask | StructureNotifyMask | KeyPressMask | ButtonPressMask |
                     ButtonReleaseMask | ButtonMotionMask);
    delete_ = XInternAtom(d, "WM_DELETE_WINDOW", 0);
    XSetWMProtocols(d, window_, &delete_, 1);
    XMapWindow(d, window_);
  }
  ~XWindow() { XDestroyWindow(display_.get(), window_); }
  XWindow(const XWindow&) = delete;
  XWindow& operator=(const XWindow&) = delete;

  /// Handles the events that have come. True: there was input for the source.
  bool handle_events() {
    bool input = false;
    while (XPending(display_.get()) > 0) {
      XEvent event;
      XNextEvent(display_.get(), &event);
      input |= handle(event);
    }
    if (std::exchange(exposed_, false)) draw();
    return input;
  }
  /// Waits for an event, at most until a time. A signal ends the wait.
  void wait(SteadyClock::time_point until) {
    if (XPending(display_.get()) > 0) return;
    const auto rest =
        std::chrono::ceil<std::chrono::milliseconds>(until - SteadyClock::now()).count();
    pollfd connection{ConnectionNumber(display_.get()), POLLIN, 0};
    if (rest > 0) poll(&connection, 1, static_cast<int>(std::min<long>(rest, 1000)));
  }
  void show(Image2d<Rgba8> image) {
    image_ = std::move(image);
    draw();
  }
  [[nodiscard]] bool closed() const { return closed_; }
  /// Input since the last call.
  [[nodiscard]] WindowInput take_input() {
    WindowInput next;
    next.width = input_.width;
    next.height = input_.height;
    return std::exchange(input_, next);
  }

 private:
  enum class Drag { kNone, kOrbit, kPan, kZoom };
  static unsigned unsigned_of(int pixels) { return static_cast<unsigned>(std::max(pixels, 1)); }

  bool handle(XEvent& event) {
    switch (event.type) {
      case Expose:
        exposed_ = true;
        return false;
      case ConfigureNotify: {
        const auto& now = event.xconfigure;
        if (now.width == input_.width && now.height == input_.height) return false;
        input_.width = now.width;
        input_.height = now.height;
        return true;
      }
      case KeyPress:
        return handle_key(event.xkey);
      case ButtonPress:
        return handle_button(event.xbutton);
      case ButtonRelease:
        if (event.xbutton.button <= Button3) drag_ = Drag::kNone;
        return false;
      case MotionNotify:
        return handle_motion(event.xmotion.x, event.xmotion.y);
      case ClientMessage:
        closed_ |= static_cast<Atom>(event.xclient.data.l[0]) == delete_;
        return false;
      default:
        return false;
    }
  }
  bool handle_key(XKeyEvent& event) {
    char typed = 0;
    if (XLookupString(&event, &typed, 1, nullptr, nullptr) != 1) return false;
    closed_ |= typed == 'q' || typed == 'Q';
    input_.keys += typed;
    return true;
  }
  bool handle_button(const XButtonEvent& event) {
    constexpr double kWheelZoom = 1.1;
    at_x_ = event.x;
    at_y_ = event.y;
    switch (event.button) {
      case Button1:
        drag_ = Drag::kOrbit;
        return false;
      case Button2:
        drag_ = Drag::kPan;
        return false;
      case Button3:
        drag_ = Drag::kZoom;
        return false;
      case Button4:
        input_.zoom *= kWheelZoom;
        return true;
      case Button5:
        input_.zoom /= kWheelZoom;
        return true;
      default:
        return false;
    }
  }
  bool handle_motion(int x, int y) {
    const double height = std::max(1, input_.height);
    const Eigen::Vector2d drag(std::exchange(at_x_, x), std::exchange(at_y_, y));
    const Eigen::Vector2d way((x - drag.x()) / height, (drag.y() - y) / height);
    switch (drag_) {
      case Drag::kOrbit:
        input_.orbit += way;
        return true;
      case Drag::kPan:
        input_.pan += way;
        return true;
      case Drag::kZoom:
        input_.zoom *= std::exp(2 * way.y());
        return true;
      case Drag::kNone:
        return false;
    }
    return false;
  }

  void draw() {
    if (image_.empty()) return;
    Display* d = display_.get();
    const Visual* visual = DefaultVisual(d, DefaultScreen(d));
    const Channel red(visual->red_mask);
    const Channel green(visual->green_mask);
    const Channel blue(visual->blue_mask);
    std::vector<std::uint32_t> pixels;
    pixels.reserve(image_.pixels().size());
    for (const Rgba8& p : image_.pixels()) {
      pixels.push_back(red.of(p.r) | green.of(p.g) | blue.of(p.b));
    }
    XImage image{};
    image.width = image_.width();
    image.height = image_.height();
    image.format = ZPixmap;
    image.data = reinterpret_cast<char*>(pixels.data());
    image.byte_order = std::endian::native == std::endian::little ? LSBFirst : MSBFirst;
    image.bitmap_bit_order = image.byte_order;
    image.bitmap_unit = 32;
    image.bitmap_pad = 32;
    image.depth = DefaultDepth(d, DefaultScreen(d));
    image.bits_per_pixel = 32;
    image.bytes_per_line = 4 * image_.width();
    if (XInitImage(&image) == 0) return;
    XPutImage(d, window_, DefaultGC(d, DefaultScreen(d)), &image, 0, 0, 0, 0,
              unsigned_of(image_.width()), unsigned_of(image_.height()));
    // Width or height 0: to the edge of the window.
    if (image_.width() < input_.width) XClearArea(d, window_, image_.width(), 0, 0, 0, 0);
    if (image_.height() < input_.height) XClearArea(d, window_, 0, image_.height(), 0, 0, 0);
    // Waits for the server, so that images never pile up on the way to it.
    XSync(d, 0);
  }

  DisplayConnection display_;
  Window window_ = 0;
  Atom delete_ = 0;
  WindowInput input_;
  Image2d<Rgba8> image_;
  Drag drag_ = Drag::kNone;
  int at_x_ = 0;  ///< Last position of the mouse while a button is down, pixels.
  int at_y_ = 0;
  bool exposed_ = false;
  bool closed_ = false;
};

/// An error unless pixels have 32 bits with at least 8 for each colour.
Result<void> check_colours(Display& display) {
  const int screen = DefaultScreen(&display);
  const Visual* visual = DefaultVisual(&display, screen);
  const int depth = DefaultDepth(&display, screen);
  bool wide = false;
  int count = 0;
  XPixmapFormatValues* formats = XListPixmapFormats(&display, &count);
  for (int i = 0; i < count; ++i) {
    wide |= formats[i].depth == depth && formats[i].bits_per_pixel == 32;
  }
  XFree(formats);
  const auto bits = [](unsigned long mask) { return std::popcount(mask); };
  if (wide && bits(visual->red_mask) >= 8 && bits(visual->green_mask) >= 8 &&
      bits(visual->blue_mask) >= 8) {
    return {};
  }
  return Error{
      ErrorCode::kUnavailable,
      "window: expected a display with 24 bits per pixel or more, found " + std::to_string(depth)};
}

}  // namespace

Result<void> show_window(const ImageSource& source, const WindowOptions& options) {
  if (!(options.refresh_hz > 0 && options.refresh_hz <= 1000)) {
    return Error{ErrorCode::kUsage, "window.refresh_hz: expected a value in (0, 1000], found " +
                                        std::to_string(options.refresh_hz)};
  }
  auto display = connect_display();
  if (!display) return display.error();
  if (auto ok = check_colours(**display); !ok) return ok;
  XWindow window(std::move(*display), options);
  const auto seconds = [](double s) {
    return std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(s));
  };
  std::optional<SteadyClock::time_point> close_at;
  if (options.close_after_s > 0) close_at = SteadyClock::now() + seconds(options.close_after_s);
  const auto period = seconds(1 / options.refresh_hz);
  auto next = SteadyClock::now();
  for (;;) {
    const bool input = window.handle_events();
    const auto now = SteadyClock::now();
    if (window.closed() || (close_at && now >= *close_at)) return {};
    if (options.close_when && options.close_when()) return {};
    if (!input && now < next) {
      window.wait(close_at ? std::min(next, *close_at) : next);
      continue;
    }
    if (now >= next) next = std::max(next + period, now);
    auto image = source(window.take_input());
    if (!image) return image.error();
    if (!image->empty()) window.show(std::move(*image));
  }
}

}  // namespace nav::render
