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
#include "session/registration_file.hpp"
#include "session/tissue_follower.hpp"

namespace nav::app {

io::Json json_of(const tracking::StreamLedger& ledger);
io::Json json_of(const registration::Decision& decision);
/// Key of the pose of an accepted or a rejected registration.
inline const char* pose_key(const registration::Decision& decision) {
  return decision.accepted ? session::kAcceptedPose : session::kRefusedPose;
}
io::Json json_of(const session::TissueFollower::Summary& summary);
/// The same as rows of a table.
std::vector<std::pair<std::string, std::string>> rows_of(
    const session::TissueFollower::Summary& summary);
io::Json json_of(const registration::ImageRegistrationResult& result,
                 const registration::Decision& decision, const Point<frames::Ct>& target);
io::Json json_of(const std::vector<DiagnosticEntry>& entries);
/// Null where the user gave a step.
io::Json json_of(const std::optional<render::StepChoice>& step);
io::Json json_of(const render::HuWindow& window);
/// Null where nothing is projected.
io::Json json_of(const std::optional<render::GreyWindow>& window);
/// One line of the log for each warning that a registration was accepted with.
void report_warnings(const std::vector<std::string>& warnings, Diagnostics& diagnostics);
/// 16 numbers, row-major.
io::Json json_of(const Eigen::Matrix4d& matrix);
/// A number, or null when it is not finite (JSON has no NaN).
io::Json json_number(double value);
/// The same; null where there is none.
io::Json json_number(const std::optional<double>& value);

/// Writes JSON where --json asked: a file, or standard output for "-".
Result<void> write_json(const io::Json& json, const std::string& where);

/// The parts of an HTML report.
struct HtmlReport {
  std::string title;
  std::string summary;   ///< One paragraph; plain text.
  bool warning = false;  ///< The summary stands on a warning colour.
  std::vector<std::pair<std::string, std::string>> pictures;  ///< File and caption.
  std::vector<std::pair<std::string, std::vector<std::pair<std::string, std::string>>>> tables;
};

/// Self-contained page beside its pictures. All text is escaped.
std::string to_html(const HtmlReport& report);

/// "12.3 mm": digits after the point, unit; "withdrawn" when not finite.
std::string quantity(double value, int digits, const std::string& unit);

}  // namespace nav::app
