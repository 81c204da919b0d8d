// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_state.hpp"
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "nav/stopwatch.hpp"
#include "render/gl/gl_compute.hpp"
#include "render/gl/gl_device.hpp"
#include "render/gl/gl_program.hpp"
#include "render/gl/gl_speed_probe.hpp"
#include "render/gl/gl_target.hpp"

namespace nav::render {
namespace {

constexpr int kSpeedSide = 512;  ///< Side of the image, pixels.

/// The least time of several turns, s.
double least_time(const std::function<void()>& draw) {
  constexpr int kTurns = 4;  // The first one translates the program.
  double least = 1e9;
  for (int turn = 0; turn < kTurns; ++turn) {
    glFinish();
    const auto start = std::chrono::steady_clock::now();
    draw();
    glFinish();
    least = std::min(least, seconds_since(start));
  }
  return least;
}

bool measure_compute() {
  constexpr double kWorthIt = 1.25;
  constexpr int kArithmetic = 500;
  const std::string text = assembled_shader("speed_probe.frag");
  auto fragment = GlProgram::link_fullscreen(text);
  auto compute = GlProgram::link_compute(as_compute(text));
  if (!fragment || !compute) return false;
  GlTarget target;
  if (!target.bind(kSpeedSide, kSpeedSide)) return false;
  (*fragment)->use();
  (*fragment)->set("turns", kArithmetic);
  const double fragment_s = least_time([&] { target.draw(); });
  (*compute)->use();
  (*compute)->set("turns", kArithmetic);
  const gl::ImageTargets bound({{target.texture(), GL_RGBA32F}});
  const double compute_s = least_time([] { gl::dispatch(kSpeedSide, kSpeedSide); });
  return compute_s * kWorthIt < fragment_s;
}

}  // namespace

bool compute_is_faster() {
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const std::string device = renderer ? renderer : "";
  if (runs_in_software(device) || GLEW_VERSION_4_3 == 0) return false;
  static std::mutex mutex;
  static std::map<std::string, bool> known;
  const std::lock_guard lock(mutex);
  const auto found = known.find(device);
  if (found != known.end()) return found->second;
  return known[device] = measure_compute();
}

}  // namespace nav::render
