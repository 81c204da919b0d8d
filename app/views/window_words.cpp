// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/window_words.hpp"

namespace nav::app {
namespace {

using render::rgb8;
using render::WindowWords;
using Align = WindowWords::Align;

class Column {
 public:
  Column(std::vector<WindowWords>& words, double y, WindowWords::Stack stack)
      : words_(words), y_(y), stack_(stack) {}
  void add(const std::string& line, Rgba8 colour) {
    if (line.empty()) return;
    words_.push_back({line, colour, 0.01, y_, Align::kLeft, 14, stack_});
  }

 private:
  std::vector<WindowWords>& words_;
  double y_;
  WindowWords::Stack stack_;
};

void add_orientation(const render::Camera& camera, std::vector<WindowWords>& words) {
  const ViewLetters letters = view_letters(camera);
  words.push_back({letters.left, kWords, 0.01, 0.5, Align::kLeft, 17});
  words.push_back({letters.right, kWords, 0.99, 0.5, Align::kRight, 17});
  words.push_back({letters.up, kWords, 0.5, 0.025, Align::kCentre, 17});
  words.push_back({letters.down, kWords, 0.5, 0.975, Align::kCentre, 17});
}

void add_state(const std::string& input, const Safety& safety, Column& column) {
  const std::string cause = safety.cause.empty() ? "" : ": " + safety.cause;
  column.add(input + " " + to_string(safety.state) + cause, colour_of(safety.state));
}

}  // namespace

std::vector<WindowWords> window_words(const PanelContext& context, bool ended) {
  const session::Epoch& epoch = context.epoch;
  const Rgba8 amber = colour_of(SafetyState::kDegraded);
  std::vector<WindowWords> words;
  add_orientation(context.camera, words);
  Column above(words, 0.07, WindowWords::Stack::kDown);
  above.add(context.banner, amber);
  if (ended) above.add("the recording has ended: last image, not live", amber);
  if (context.grey) {
    above.add(words_of_window(context.grey->level_hu, context.grey->width_hu), kWords);
  }
  above.add(context.note, amber);
  above.add(context.warning, amber);
  Column below(words, 0.93, WindowWords::Stack::kUp);
  for (auto entry = context.legend.rbegin(); entry != context.legend.rend(); ++entry) {
    below.add(entry->name + " " + entry->importance_words(), entry->colour);
  }
  if (epoch.guidance && !ended) below.add(guidance_words(*epoch.guidance), kWords);
  if (context.plan || context.needle_expected) add_state("needle", epoch.needle, below);
  add_state("CT", epoch.placement, below);
  add_state("ultrasound", epoch.ultrasound, below);
  return words;
}

}  // namespace nav::app
