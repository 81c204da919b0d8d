// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of the table of options. Each function appends the rows of its groups.
#include <vector>

#include "app/options/option.hpp"

/// Where a row stores its value: a member of Settings.
#define NAV_SLOT(member) [](Settings& s) -> Slot { return &s.member; }

namespace nav::app {

namespace group {
inline constexpr const char* kFiles = "Files";
inline constexpr const char* kView = "3D view";
inline constexpr const char* kWindow = "2D images of the CT";
inline constexpr const char* kAppearance = "Appearance";
inline constexpr const char* kRecording = "CT and recording";
inline constexpr const char* kScanLines = "Scan lines and labels of 3D ultrasound";
inline constexpr const char* kReplay = "Replay";
inline constexpr const char* kVolume = "3D ultrasound";
inline constexpr const char* kPredicateSet = "Predicate set";
inline constexpr const char* kStrokes = "Strokes";
inline constexpr const char* kImage = "Image";
inline constexpr const char* kRegistration = "Registration";
inline constexpr const char* kStart = "Start pose";
inline constexpr const char* kMotion = "Motion of tissue";
inline constexpr const char* kPlanes = "Planes";
inline constexpr const char* kFusion = "Fusion";
inline constexpr const char* kProcedure = "Simulated procedure";
inline constexpr const char* kFeatures = "Features";
inline constexpr const char* kPatient = "Patient";
inline constexpr const char* kProbe = "Probe and motion";
inline constexpr const char* kTissueMotion = "Breathing and deformation";
inline constexpr const char* kNeedle = "Needle";
inline constexpr const char* kTracker = "Tracker and time";
inline constexpr const char* kPlan = "Plan";
}  // namespace group

/// 3D view and appearance: demo, replay.
void add_view_rows(std::vector<Option>& rows);
void add_appearance_rows(std::vector<Option>& rows);
/// CT, recording and placement: replay, register, slices; files of all verbs of sessions.
void add_file_rows(std::vector<Option>& rows);
void add_recording_rows(std::vector<Option>& rows);
/// 3D ultrasound: predicates, replay.
void add_volume_rows(std::vector<Option>& rows);
void add_predicate_rows(std::vector<Option>& rows);
/// Options that only one verb has.
void add_replay_rows(std::vector<Option>& rows);
void add_register_rows(std::vector<Option>& rows);
void add_slices_rows(std::vector<Option>& rows);
void add_derive_rows(std::vector<Option>& rows);
void add_simulate_rows(std::vector<Option>& rows);
/// Keys of the session file that no option sets.
void add_plan_rows(std::vector<Option>& rows);

/// Needs that several rows share.
Requirement
recording_session();  ///< In a replay: a session of a recording, not the simulated procedure.
Requirement ultrasound_volume();   ///< In a replay: --us-volume.
Requirement sweep_to_register();   ///< In a registration: a sweep.
Requirement recording_to_slice();  ///< In slices: --recording.
Requirement dicom_folder();        ///< For --series.

/// Puts a repeated value such as "LOW:HIGH=I" into an error: `expected …, found 'text'`.
Error unreadable(const std::string& expected, const std::string& text);

}  // namespace nav::app
