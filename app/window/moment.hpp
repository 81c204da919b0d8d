// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/predicates/predicate_volume.hpp"
#include "app/views/panels.hpp"
#include "nav/volume.hpp"
#include "render/scene.hpp"
#include "render/transfer/transfer_editor.hpp"
#include "session/guidance_error.hpp"
#include "session/navigator.hpp"
#include "session/placement.hpp"
#include "session/structure_distances.hpp"

namespace nav::app {

/// State of one input of a session, as the status line shows it.
struct InputStatus {
  std::string name;  ///< "ultrasound", "CT", "needle".
  Safety safety;
  std::optional<Timestamp> acquired{};  ///< Its newest sample, window's clock; absent: no age.
  std::optional<double> rate_hz{};      ///< Absent: unknown, or it does not come again and again.
  std::uint64_t drops = 0;              ///< Samples that were dropped, rejected or missing.
};

/// Everything that one refresh of the window shows: all its views and numbers come from here. The
/// thread of the session makes it; it does not change afterwards. Times without a frame are of the
/// window's clock.
struct Moment {
  std::uint64_t number = 0;   ///< Counts the refreshes of the session, from 1.
  std::uint64_t session = 0;  ///< Counts the sessions that were opened, from 1.
  session::Epoch epoch{};
  std::shared_ptr<const Volume> ct{};
  std::shared_ptr<const render::Scene> scene{};  ///< With the first camera of the session.
  std::optional<NeedlePlan> plan{};
  std::optional<session::Placement> placement{};  ///< Absent before the first image.
  render::HuWindow window{};                      ///< Grey window of the CT's slices.
  /// Intervals of the numbers in the epoch; absent without numbers.
  std::optional<session::GuidanceError> guidance_error{};
  /// Distance of the needle's tip from the nearest critical structure, while there are numbers.
  std::optional<session::NearestStructure> nearest{};
  std::uint64_t structures = 0;   ///< StructureOrder::number of the structures of `nearest`.
  std::string reference_frame{};  ///< Name of the patient's frame.
  double needle_length_mm = 0;
  bool needle_expected = false;
  /// 3D ultrasound that the scene draws by predicates; null: none.
  std::shared_ptr<const PredicateSource> predicates{};
  /// Histogram of the CT as it is drawn; null: the scene draws none by a transfer function.
  std::shared_ptr<const render::ValueCounts> counts{};
  bool stored = false;    ///< A stored volume without live images: nothing in it grows old.
  std::string kind{};     ///< "SIMULATED", "RECORDING", "LIVE" or "STORED VOLUME".
  std::string warning{};  ///< Sentence about registration and placement; may be empty.
  std::string notice{};   ///< Sentence about the session ("the recording has ended"); may be empty.
  std::vector<InputStatus> inputs{};
  Timestamp published{};
  std::optional<Timestamp> acquired{};  ///< Acquisition of its image.
  /// Times at which its image and its needle become stale.
  std::optional<Timestamp> ultrasound_until{}, needle_until{};
};
using SharedMoment = std::shared_ptr<const Moment>;

/// The context of the flat views of a moment. The moment must outlive it.
PanelContext context_of(const Moment& moment);

}  // namespace nav::app
