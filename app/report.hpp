// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/output_folder.hpp"
#include "io/json.hpp"
#include "nav/diagnostics.hpp"
#include "registration/acceptance.hpp"
#include "registration/image_registration.hpp"
#include "render/engine.hpp"
#include "render/quality/step_search.hpp"
#include "render/slices/slice.hpp"
#include "session/placement.hpp"
#include "session/registration_file.hpp"
#include "session/tissue_follower.hpp"

namespace nav::app {

io::Json json_of(const tracking::StreamLedger& ledger);
io::Json json_of(const registration::Decision& decision);
/// JSON key of a registration's pose; it differs for accepted and refused registrations.
inline const char* pose_key(const registration::Decision& decision) {
  return decision.accepted ? session::kAcceptedPose : session::kRefusedPose;
}
io::Json json_of(const session::TissueFollower::Summary& summary);
/// Rows of the report table with the summary: name and value.
std::vector<std::pair<std::string, std::string>> rows_of(
    const session::TissueFollower::Summary& summary);
io::Json json_of(const registration::ImageRegistrationResult& result,
                 const registration::Decision& decision, const Point<frames::Ct>& target);
/// Adds the keys `diagnostics`, all messages, and `findings`, those that name what contradicts.
void add_messages(io::Json& report, const std::vector<DiagnosticEntry>& entries);
/// Null when the user gave a step.
io::Json json_of(const std::optional<render::StepChoice>& step);
io::Json json_of(const render::HuWindow& window);
/// Null when the view is not a projection.
io::Json json_of(const std::optional<render::GreyWindow>& window);
/// Reports the warnings and findings of a placement.
void report_placement(const session::Placement& placement, Diagnostics& diagnostics);
/// Reports each warning with which a registration was accepted.
void report_warnings(const std::vector<std::string>& warnings, Diagnostics& diagnostics);
/// List of 16 numbers, row-major.
io::Json json_of(const Eigen::Matrix4d& matrix);
/// Number, or null when it is not finite (JSON has no NaN).
io::Json json_number(double value);
/// Number, or null when it is absent or not finite.
io::Json json_number(const std::optional<double>& value);

/// Writes JSON to the argument of --json: a file, or standard output for "-".
Result<void> write_json(const io::Json& json, const std::string& where);

/// Contents of an HTML report.
struct HtmlReport {
  std::string title;
  std::string summary;                                      ///< One paragraph; plain text.
  bool warning = false;                                     ///< The summary has a warning colour.
  std::vector<std::pair<std::string, std::string>> images;  ///< File and caption.
  std::vector<std::pair<std::string, std::vector<std::pair<std::string, std::string>>>> tables;
};

/// HTML page that needs no other files than its images, which lie in the same folder. All text is
/// escaped.
std::string to_html(const HtmlReport& report);

/// Text such as "12.3 mm"; "withdrawn" when the value is not finite. digits: after the point.
std::string quantity(double value, int digits, const std::string& unit);

}  // namespace nav::app
