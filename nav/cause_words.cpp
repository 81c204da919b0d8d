// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/cause_words.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace nav {
namespace {

using Words = std::pair<std::string_view, std::string_view>;

/// Causes about a body; they follow its name.
constexpr std::array kOfBodies{Words{"no_pose_yet", "has no pose yet"},
                               Words{"before_first_pose", "had its first pose later"},
                               Words{"not_tracked", "is not tracked"},
                               Words{"pose_gap", "has a gap in its poses"},
                               Words{"status_not_ok", "has poses without the status ok"},
                               Words{"not_rigid", "has poses that are not rigid"},
                               Words{"outside_working_volume", "is outside the working volume"},
                               Words{"time_not_increasing", "has times that do not increase"},
                               Words{"clock_not_believed", "has times that cannot be true"},
                               Words{"too_fast", "moved faster than a hand"},
                               Words{"off_path", "left its path"}};

constexpr std::array kOthers{
    Words{"no_timestamp", "there is no time stamp"},
    Words{"unusable_picture", "the image cannot be used"},
    Words{"time_not_increasing", "the times of the images do not increase"},
    Words{"time_in_future", "the images have times in the future"},
    Words{"clock_not_believed", "the times of the images cannot be true"},
    Words{"no_image", "there are no pixels"},
    Words{"invalid_pixel_grid", "the size of the pixels cannot be true"},
    Words{"no_calibration", "no calibration of the probe fits the images"},
    Words{"time_repeated", "the device repeats its time"},
    Words{"clock_ahead", "the clock of the device is ahead"},
    Words{"after_late", "data were held up"},
    Words{"late", "data came late"},
    Words{"no_listener", "nothing listens there"},
    Words{"connect_timeout", "no answer to the attempt to connect"},
    Words{"closed", "the connection was closed"},
    Words{"reset", "the connection was reset"},
    Words{"timeout", "no answer in time"},
    Words{"not_serial", "it is no serial port"},
    Words{"permission", "no permission to open it"},
    Words{"busy", "another program uses it"},
    Words{"unplugged", "it was unplugged"},
    Words{"queue_full", "too many were waiting"},
    Words{"not_used", "nothing uses it"}};

template <std::size_t N>
std::string_view words_in(const std::array<Words, N>& list, std::string_view name) {
  const auto found = std::ranges::find(list, name, &Words::first);
  return found == list.end() ? std::string_view() : found->second;
}

std::string spaced(std::string_view name) {
  std::string text(name);
  std::ranges::replace(text, '_', ' ');
  return text;
}

}  // namespace

std::string words_of_cause(std::string_view name) {
  const auto dot = name.find('.');
  if (dot != std::string_view::npos) {
    const std::string_view body = name.substr(0, dot);
    const std::string_view cause = name.substr(dot + 1);
    const std::string_view words = words_in(kOfBodies, cause);
    const std::string subject = body == "Probe"       ? "the probe"
                                : body == "Reference" ? "the patient reference"
                                : body == "Needle"    ? "the needle"
                                                      : std::string(body);
    if (!words.empty()) return subject + " " + std::string(words);
    return subject + ": " + spaced(cause);
  }
  const std::string_view words = words_in(kOthers, name);
  return words.empty() ? spaced(name) : std::string(words);
}

}  // namespace nav
