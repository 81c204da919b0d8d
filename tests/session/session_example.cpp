// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "registration/acceptance.hpp"
#include "registration/search/skin_search.hpp"
#include "session/driver.hpp"
#include "session/placement.hpp"

/// Opens a recording, registers the CT to it and prints where every image lies in the CT.
/// Usage: session_example sweep.igs.mha ct.mha
int main(int, char** arguments) {
  using namespace nav;
  CollectingDiagnostics diagnostics;
  const auto fail = [](const Error& error) {
    std::cerr << error.message << '\n';
    return 1;
  };
  // Open a source.
  session::SourceOptions source;
  source.recording = arguments[1];
  const auto ct = session::read_session_ct({.path = arguments[2]}, diagnostics);
  if (!ct) return fail(ct.error());
  auto recorded = session::RecordedSession::open(source, diagnostics);
  if (!recorded) return fail(recorded.error());
  // Register the CT to its images.
  std::vector<TrackedFrame> images;
  const auto played = recorded->play([&](const tracking::PairedFrame& paired) {
    if (paired.tracked) images.push_back(*paired.tracked);
  });
  if (!played) return fail(played.error());
  const auto sweep = Sweep::create(std::move(images), "calibration of the recording");
  if (!sweep) return fail(sweep.error());
  const auto effort = registration::Effort::kUsual;
  const auto found = registration::register_on_skin(**ct, *sweep, registration::with_effort(effort),
                                                    {}, diagnostics);
  if (!found) return fail(found.error());
  const auto target = found->ct_from_reference * sweep->centroid();
  if (!registration::decide(*found, registration::limits_for(effort), target).accepted) return 2;
  // Get epochs.
  if (const auto again = recorded->rewind(); !again) return fail(again.error());
  recorded->set_placement({found->ct_from_reference, {SafetyState::kValid, ""}});
  session::Driver driver(recorded->session(), {});
  for (;;) {
    const auto epoch = driver.next();
    if (!epoch) return fail(epoch.error());
    if (!*epoch) return 0;
    std::cout << to_seconds((*epoch)->now) << " s: " << to_string((*epoch)->plane.state) << ", "
              << (*epoch)->ct_from_image->translation_mm().transpose() << " mm\n";
  }
}
