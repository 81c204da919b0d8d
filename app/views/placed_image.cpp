// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/placed_image.hpp"

#include "app/report.hpp"
#include "session/navigator.hpp"
#include "session/placement.hpp"
#include "session/recorded_session.hpp"

namespace nav::app {
namespace {

Error without_pose(const std::string& found) {
  return {ErrorCode::kUsage, "--frame: expected an image with a pose, found " + found};
}

}  // namespace

Result<PlacedImage> placed_image(const SessionConfig& config, const Volume& ct,
                                 std::optional<std::int64_t> number, Console& console) {
  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  const auto sweep = session::survey(*session, config.source.skip_bad_frames);
  if (!sweep) return sweep.error();
  if (!sweep->warning.empty()) console.report(Severity::kWarning, "recording", sweep->warning);
  const std::int64_t total = session->total_images();
  const std::int64_t wanted = number.value_or(total / 2);
  if (wanted < 0 || wanted >= total) {
    return Error{ErrorCode::kUsage, "--frame: expected 0 to " + std::to_string(total - 1) +
                                        ", found " + std::to_string(wanted)};
  }
  const auto sector = config.source.whole_image ? std::nullopt : session::sector_of(*sweep);
  if (sector) session->set_outline(*sector);
  const auto placement =
      session::place_ct(config.placement, ct, *sweep, sweep->recording, session->reference_frame());
  if (!placement) return placement.error();
  report_placement(*placement, console);
  if (!placement->outside.empty()) {
    console.report(Severity::kWarning, "placement", placement->outside);
  }
  session->set_placement(placement->placement);

  std::optional<tracking::PairedImage> paired;
  std::optional<session::Epoch> epoch;
  const auto take = [&](const tracking::PairedImage& one) {
    if (one.sequence == static_cast<std::uint64_t>(wanted)) paired = one;
  };
  for (bool more = true; more && !paired;) {
    const auto stepped = session->step(take);
    if (!stepped) return stepped.error();
    more = *stepped;
    if (paired) epoch = session->refresh();
  }
  const std::string name = "image " + std::to_string(wanted);
  if (!paired) return without_pose(name + " without pixels or time");
  if (!paired->tracked) return without_pose(name + ": " + paired->cause);
  const TrackedImage& tracked = *paired->tracked;
  PlacedImage found{
      {tracked.frame, placement->placement.ct_from_reference * tracked.reference_from_image, 1.0,
       compose({session::tracking_safety(tracked), placement->placement.safety})},
      {},
      placement->kind == "registered"};
  if (!config.source.needle_frame.empty()) {
    // Not the newest pose: with a temporal offset the image is older, or it waited for its pose.
    found.ct_from_needle = session->navigator().needle_at(tracked.frame.acquired);
    if (!found.ct_from_needle) {
      const std::string& cause = epoch->needle.cause;
      return Error{ErrorCode::kNotFound, "--needle-frame: expected a needle with a pose at " +
                                             name + ", found " +
                                             (cause.empty() ? "none at its time" : cause)};
    }
  }
  return found;
}

}  // namespace nav::app
