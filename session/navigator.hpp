// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "nav/plan.hpp"
#include "nav/safety.hpp"
#include "nav/sweep.hpp"
#include "tracking/frame_ledger.hpp"
#include "tracking/frame_pairer.hpp"

namespace nav::session {

/// What arrives, in order of arrival on the session clock.
struct ProbePose {
  RawPose raw;
};
struct ReferencePose {
  RawPose raw;
};
struct NeedlePose {
  RawPose raw;
};
/// A picture that the source itself could not deliver (0 x 0, invalid status, wrong type).
struct MissingFrame {
  std::uint64_t sequence;
  std::string cause;    ///< Stable name for the ledger.
  std::string message;  ///< One sentence.
};
struct SessionEvent {
  Timestamp received;
  std::variant<UltrasoundFrame, ProbePose, ReferencePose, NeedlePose, MissingFrame> what;
};

/// Where the CT lies, and how far that is believed.
struct CtPlacement {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  Safety safety;
};

/// Everything that one display refresh shows: all views and numbers of the refresh come from it.
struct Epoch {
  Timestamp now;
  std::optional<TrackedFrame> frame;  ///< The newest paired picture, however old.
  bool frame_is_new = false;          ///< First refresh that has it.
  Safety ultrasound;                  ///< Freshness and tracking of the picture.
  Safety placement;                   ///< Of the CT.
  Safety plane;                       ///< The picture inside the CT: the worst of both.
  std::optional<Transform<frames::Ct, frames::Image>> ct_from_image;
  Safety needle;
  std::optional<Transform<frames::Ct, frames::Needle>> ct_from_needle;
  std::optional<Timestamp> needle_acquired;  ///< Of the oldest pose that it is made of.
  /// Only while the whole chain is valid; otherwise withdrawn.
  std::optional<NeedleGuidance> guidance;
};

/// What a tracked picture's own state is, apart from its age.
Safety tracking_safety(const TrackedFrame& frame);
/// An epoch when nothing more comes: what was live is stale, what was lost stays lost, and numbers
/// are withdrawn.
Epoch ended(Epoch epoch, const std::string& cause);

struct NavigatorOptions {
  tracking::PairingOptions pairing;
  Duration frame_period = std::chrono::milliseconds(50);  ///< Expected; decides freshness.
  Duration needle_period = std::chrono::milliseconds(20);
};

/// The live part of a session: takes events in, gives epochs out, and accounts for every picture.
/// One thread; time is an argument.
class Navigator {
 public:
  Navigator(const Transform<frames::Probe, frames::Image>& probe_from_image,
            std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference,
            const NavigatorOptions& options, Diagnostics& diagnostics);

  void on_event(const SessionEvent& event);
  /// Pairs what can be paired by now; every settled picture goes to the listener, in order.
  void settle(Timestamp now, bool end_of_stream,
              const std::function<void(const tracking::PairedFrame&)>& listener);
  /// One display refresh. The newest picture counts as shown when it is new; those between two
  /// refreshes as superseded.
  Epoch refresh(Timestamp now);
  /// An epoch at a later time, up to which nothing has come: what has grown old is stale or lost,
  /// and its numbers are withdrawn.
  [[nodiscard]] Epoch aged(Epoch epoch, Timestamp now) const;
  /// Where the needle was at a time; absent where it had no pose then.
  [[nodiscard]] std::optional<Transform<frames::Ct, frames::Needle>> needle_at(
      Timestamp time) const;
  /// Ends the session: the picture that no refresh came for counts as superseded.
  void finish();

  void set_placement(CtPlacement placement) { placement_ = std::move(placement); }
  void set_plan(const NeedlePlan& plan) { plan_ = plan; }
  [[nodiscard]] const tracking::FrameLedger& ledger() const { return ledger_; }
  [[nodiscard]] std::map<std::string, std::uint64_t> rejected_poses() const;

 private:
  void refresh_needle(Epoch& epoch) const;

  NavigatorOptions options_;
  Diagnostics& diagnostics_;
  tracking::FramePairer pairer_;
  tracking::PoseGate<frames::Needle> needle_gate_;
  tracking::PoseBuffer<frames::Needle> needle_poses_;
  tracking::PoseGate<frames::Reference> reference_gate_;
  tracking::PoseBuffer<frames::Reference> reference_poses_;
  std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_;
  tracking::FrameLedger ledger_;
  std::map<std::string, std::uint64_t> rejected_needle_poses_;
  std::optional<TrackedFrame> newest_;
  bool newest_shown_ = false;
  std::optional<CtPlacement> placement_;
  std::optional<NeedlePlan> plan_;
};

}  // namespace nav::session
