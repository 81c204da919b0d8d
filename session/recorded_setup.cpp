// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/recorded_setup.hpp"

#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

namespace nav::session {
namespace {

using Facts = std::map<std::string, std::string>;

constexpr const char* kProbeFromImage = "probe_from_image_mm";
constexpr const char* kProbeFromPixels = "probe_from_pixels_mm";
constexpr const char* kBodyFromTip = "needle_body_from_tip_mm";
constexpr const char* kFixedReference = "reference_from_tracker_mm";
constexpr const char* kTemporalOffset = "temporal_offset_ns";

std::string text_of(const Eigen::Matrix4d& matrix) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(std::numeric_limits<double>::max_digits10);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) text << matrix(row, column) << ' ';
  }
  return text.str();
}

std::optional<Eigen::Matrix4d> matrix_from(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      if (!(stream >> matrix(row, column)) || !std::isfinite(matrix(row, column))) {
        return std::nullopt;
      }
    }
  }
  return matrix;
}

}  // namespace

std::map<std::string, std::string> facts_of(const SessionSetup& setup) {
  Facts facts;
  if (setup.calibration) {
    facts[kProbeFromImage] = text_of(setup.calibration->probe_from_image.matrix());
  }
  if (setup.probe_from_pixels) facts[kProbeFromPixels] = text_of(*setup.probe_from_pixels);
  if (setup.body_from_tip) facts[kBodyFromTip] = text_of(*setup.body_from_tip);
  if (setup.fixed_reference) facts[kFixedReference] = text_of(setup.fixed_reference->matrix());
  facts[kTemporalOffset] = std::to_string(setup.navigator.pairing.temporal_offset.count());
  return facts;
}

Result<SessionSetup> setup_from(const Facts& facts, const std::string& name) {
  SessionSetup setup;
  const auto bad = [&](const std::string& key, const std::string& why) {
    return Error{ErrorCode::kMalformedData, name + ": " + kSetupMetadata + "." + key + ": " + why};
  };
  for (const auto& [key, text] : facts) {
    if (key == kTemporalOffset) {
      std::istringstream stream(text);
      Duration::rep ns = 0;
      if (!(stream >> ns)) return bad(key, "expected a whole number, found '" + text + "'");
      setup.navigator.pairing.temporal_offset = Duration(ns);
      if (auto ok = tracking::validate(setup.navigator.pairing); !ok) {
        return bad(key, ok.error().message);
      }
      continue;
    }
    const bool known = key == kProbeFromImage || key == kProbeFromPixels || key == kBodyFromTip ||
                       key == kFixedReference;
    if (!known) continue;
    const auto matrix = matrix_from(text);
    if (!matrix) return bad(key, "expected 16 finite numbers, found '" + text + "'");
    if (key == kProbeFromPixels) {
      setup.probe_from_pixels = *matrix;
    } else if (key == kBodyFromTip) {
      setup.body_from_tip = *matrix;
    } else if (key == kProbeFromImage) {
      auto rigid = rigid_from_matrix<frames::Probe, frames::Image>(*matrix);
      if (!rigid) return bad(key, rigid.error().message);
      setup.calibration = ProbeCalibration{*rigid};
    } else {
      auto rigid = rigid_from_matrix<frames::Reference, frames::Tracker>(*matrix);
      if (!rigid) return bad(key, rigid.error().message);
      setup.fixed_reference = *rigid;
    }
  }
  return setup;
}

}  // namespace nav::session
