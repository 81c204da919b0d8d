// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of the table of options. Each function appends the rows of its groups.
#include <vector>

#include "app/options/option.hpp"

/// Member of Settings in which a row stores its value.
#define NAV_SLOT(member) [](Settings& s) -> Slot { return &s.member; }

namespace nav::app {

namespace group {
inline constexpr const char* kGroupFiles = "Files";
inline constexpr const char* kGroupView = "3D view";
inline constexpr const char* kGroupWindow = "2D images of the CT";
inline constexpr const char* kGroupAppearance = "Appearance";
inline constexpr const char* kGroupRecording = "CT and recording";
inline constexpr const char* kGroupScanLines = "Scan lines and labels of 3D ultrasound";
inline constexpr const char* kGroupReplay = "Replay and live";
inline constexpr const char* kGroupVolume = "3D ultrasound";
inline constexpr const char* kGroupPredicateSet = "Predicate set";
inline constexpr const char* kGroupStrokes = "Strokes";
inline constexpr const char* kGroupImage = "Image";
inline constexpr const char* kGroupRegistration = "Registration";
inline constexpr const char* kGroupStart = "Start pose";
inline constexpr const char* kGroupMotion = "Motion of tissue";
inline constexpr const char* kGroupPlanes = "Planes";
inline constexpr const char* kGroupFusion = "Fusion";
inline constexpr const char* kGroupProcedure = "Simulated procedure";
inline constexpr const char* kGroupFeatures = "Features";
inline constexpr const char* kGroupReconstruction = "Reconstruction";
inline constexpr const char* kGroupPatient = "Patient";
inline constexpr const char* kGroupProbe = "Probe and motion";
inline constexpr const char* kGroupTissueMotion = "Breathing and deformation";
inline constexpr const char* kGroupNeedle = "Needle";
inline constexpr const char* kGroupTracker = "Tracker and time";
inline constexpr const char* kGroupPlan = "Plan";
inline constexpr const char* kGroupWindowRun = "Window";
inline constexpr const char* kGroupWindowState = "State of the window";
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
void add_reconstruct_rows(std::vector<Option>& rows);
void add_window_rows(std::vector<Option>& rows);
void add_simulate_rows(std::vector<Option>& rows);
/// Keys of the session file that no option sets.
void add_plan_rows(std::vector<Option>& rows);
void add_window_state_rows(std::vector<Option>& rows);

/// Needs that several rows share.
Requirement
recording_session();  ///< In a replay: a session of a recording, not the simulated procedure.
Requirement ultrasound_volume();   ///< In a replay: --us-volume.
Requirement sweep_to_register();   ///< In a registration: a sweep.
Requirement recording_to_slice();  ///< In slices: --recording.
Requirement dicom_folder();        ///< For --series.

/// Coordinates of a point, mm.
inline Range of_point() { return within(-1e7, 1e7); }

/// Number of a rule's message.
std::string found_number(double number);
/// Numbers of a point or translation in a rule's message.
std::string found_point(const Eigen::Vector3d& mm);

/// Puts a repeated value such as "LOW:HIGH=I" into an error: `expected …, found 'text'`.
Error unreadable(const std::string& expected, const std::string& text);

}  // namespace nav::app
