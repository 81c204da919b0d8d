// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/session_window.hpp"

#include <array>
#include <utility>

#include "app/interrupt.hpp"
#include "app/views/live_view.hpp"
#include "render/window/window.hpp"

namespace nav::app {
namespace {

/// The loop of one window.
class WindowLoop {
 public:
  WindowLoop(const SessionWindow& play, PlacedView& placed, session::Driver& driver,
             Console& console)
      : play_(play),
        placed_(placed),
        driver_(driver),
        console_(console),
        view_(placed.presenter()) {}

  Result<void> run() {
    const PixelSize size = composed_size(placed_.presenter().view_size());
    const PixelSize least = composed_size(view_size_within({}));
    const Interrupt interrupt;
    const auto window =
        render::show_window([this](const render::WindowInput& input) { return image(input); },
                            {.width = size.width,
                             .height = size.height,
                             .least_width = least.width,
                             .least_height = least.height,
                             .close_when = [&] {
                               const bool asked = play_.close_when && play_.close_when();
                               return interrupt.asked() || asked || (last_ && !seen_);
                             }});
    return failure_ ? Result<void>(*failure_) : window;
  }

 private:
  Result<Image2d<Rgba8>> image(render::WindowInput input) {
    const bool first = !seen_;
    // Nothing is to be seen yet that could be moved.
    if (first) input = render::WindowInput{.width = input.width, .height = input.height};
    bool changed = view_.apply(input);
    presented_ = false;
    if (!last_) changed |= advance(clock_.now());
    if (!seen_ || !(changed || view_.wants_refinement(clock_.now()))) return Image2d<Rgba8>();
    auto drawn = presented_ ? view_.draw_presented(*seen_, clock_.now())
                            : view_.draw(*seen_, clock_.now(), last_ && !failure_);
    if (!drawn) return drawn;
    placed_.say_note();
    // The search for the step of the first image takes seconds.
    if (first) driver_.restart_pace(clock_.now());
    return drawn;
  }

  /// Takes what has come by now. True if the window has to show something else.
  bool advance(Timestamp now) {
    auto epoch = play_.next(now);
    if (epoch && *epoch) {
      seen_ = std::move(**epoch);
      const auto taken = play_.take(*seen_);
      if (taken) {
        presented_ = *taken;
        return true;
      }
      epoch = taken.error();
    }
    last_ = !epoch || driver_.over();
    if (!epoch) failure_ = epoch.error();
    if (!last_) return seen_ && has_aged(driver_, *seen_, now);
    if (!seen_) return false;
    // Once more, as no longer live, with the cause.
    seen_ = session::ended(*std::move(seen_), failure_ ? failure_->message : play_.ended);
    if (!failure_) console_.say(play_.ended + ": close the window, or press Ctrl-C");
    return true;
  }

  const SessionWindow& play_;
  PlacedView& placed_;
  session::Driver& driver_;
  Console& console_;
  MonotonicClock clock_;
  LiveView view_;
  std::optional<Error> failure_;
  std::optional<session::Epoch> seen_;
  bool presented_ = false;  ///< take() has drawn the newest epoch.
  bool last_ = false;       ///< Nothing more comes.
};

}  // namespace

bool has_aged(const session::Driver& driver, session::Epoch& epoch, Timestamp clock_now) {
  const auto states = [](const session::Epoch& e) {
    return std::array{e.plane.state, e.needle.state};
  };
  const auto before = states(epoch);
  epoch = driver.aged(std::move(epoch), clock_now);
  return states(epoch) != before;
}

Result<void> play_in_window(const SessionWindow& play, PlacedView& view, session::Driver& driver,
                            Console& console) {
  return WindowLoop(play, view, driver, console).run();
}

}  // namespace nav::app
