// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/feed.hpp"

#include <utility>

namespace nav::app {

bool shows_volume_alone(const SessionConfig& config) {
  return config.source.kind == SessionConfig::SourceKind::kRecording && config.predicates.alone &&
         config.source.recording.empty() && config.ct.path.empty();
}

Result<std::unique_ptr<Feed>> open_feed(const SessionConfig& config, bool loop, const Clock& clock,
                                        Console& console) {
  using Kind = SessionConfig::SourceKind;
  if (config.source.kind == Kind::kSimulated) return open_simulated_feed(config, clock, console);
  if (shows_volume_alone(config)) return open_volume_feed(config, console);
  if (auto ok = require_path(config.ct.path, "ct.path", "a CT"); !ok) return ok.error();
  if (config.source.kind == Kind::kLive) return open_live_feed(config, clock, console);
  if (config.source.recording.empty()) return open_ct_feed(config, console);
  return open_recorded_feed(config, loop, console);
}

Result<void> Feed::start_recording(const std::filesystem::path& path) {
  return Error{ErrorCode::kUsage,
               path.string() + ": expected live devices to record, found a session without them"};
}

session::Session::Listener placing_listener(PlacedView& view, session::Session& session,
                                            std::optional<Error>& failure, RecordingOf recording) {
  return [&view, &session, &failure,
          recording = std::move(recording)](const tracking::PairedImage& paired) {
    if (!paired.tracked || failure) return;
    const TrackedImage& image = *paired.tracked;
    const auto placed =
        view.take(image, recording ? std::optional(recording(image.frame)) : std::nullopt);
    if (!placed) {
      failure = placed.error();
    } else if (*placed) {
      session.navigator().set_placement(**placed);
    }
  };
}

}  // namespace nav::app
