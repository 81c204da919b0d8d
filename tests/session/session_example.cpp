// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "registration/acceptance.hpp"
#include "registration/search/skin_search.hpp"
#include "session/driver.hpp"
#include "session/placement.hpp"

/// The value of a result. Prints the error and ends the program where there is none.
auto checked(auto result) {
  if (!result) std::exit((std::cerr << result.error().message << '\n', 1));
  if constexpr (requires { *result; }) return *std::move(result);
}

/// Registers a CT to a recording and prints the position of each image, by sweep.igs.mha ct.mha.
int main(int, char** arguments) {
  using namespace nav;
  using namespace nav::registration;
  CollectingDiagnostics diagnostics;
  const session::SourceOptions source{.recording = arguments[1]};
  const auto ct = checked(session::read_session_ct({.path = arguments[2]}, diagnostics));
  auto recorded = checked(session::RecordedSession::open(source, diagnostics));
  std::vector<TrackedImage> images;
  checked(recorded.play([&](const tracking::PairedImage& paired) {
    if (paired.tracked) images.push_back(*paired.tracked);
  }));
  const auto sweep = checked(Sweep::create(std::move(images), "calibration of the recording"));
  const auto effort = with_effort(Effort::kUsual);
  const auto found = checked(register_on_skin(*ct, sweep, effort, {}, diagnostics));
  const auto target = found.ct_from_reference * sweep.centroid();
  if (!decide(found, limits_for(Effort::kUsual), target).accepted) return 2;
  checked(recorded.rewind());
  recorded.set_placement({found.ct_from_reference, {SafetyState::kValid, ""}});
  session::Driver driver(recorded.session(), {});
  while (const auto epoch = checked(driver.next())) {
    std::cout << to_seconds(epoch->now) << " s: " << to_string(epoch->plane.state) << ", "
              << epoch->ct_from_image->translation_mm().transpose() << " mm\n";
  }
}
