// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/recorded_setup.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

namespace nav::session {
namespace {

using Facts = std::map<std::string, std::string>;

constexpr const char* kProbeFromImage = "probe_from_image";
constexpr const char* kProbeFromPixels = "probe_from_pixels_mm";
constexpr const char* kBodyFromTip = "needle_body_from_tip_mm";
constexpr const char* kFixedReference = "reference_from_tracker";
constexpr const char* kTemporalOffset = "temporal_offset_ns";
constexpr const char* kScreenWatch = "screen_watch";

template <class Numbers>
std::string text_of(const Numbers& numbers) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(std::numeric_limits<double>::max_digits10);
  for (const auto number : numbers) text << (text.tellp() > 0 ? " " : "") << number;
  return text.str();
}

/// Row by row.
std::string text_of_matrix(const Eigen::Matrix4d& matrix) {
  return text_of(matrix.reshaped<Eigen::RowMajor>());
}

/// Quaternion w, x, y, z, then the translation: a matrix would not give back the last bit.
template <class To, class From>
std::string text_of_transform(const Transform<To, From>& transform) {
  const auto& q = transform.rotation();
  const Eigen::Vector3d t = transform.translation_mm();
  return text_of(std::array{q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
}

template <std::size_t kCount>
std::optional<std::array<double, kCount>> numbers_from(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::array<double, kCount> numbers{};
  for (double& number : numbers) {
    if (!(stream >> number) || !std::isfinite(number)) return std::nullopt;
  }
  return numbers;
}

template <class To, class From>
std::optional<Transform<To, From>> transform_from(const std::string& text) {
  constexpr double kRounding = 1e-9;
  const auto n = numbers_from<7>(text);
  if (!n) return std::nullopt;
  const Eigen::Quaterniond rotation((*n)[0], (*n)[1], (*n)[2], (*n)[3]);
  if (std::abs(rotation.norm() - 1) > kRounding) return std::nullopt;
  return Transform<To, From>(rotation, {(*n)[4], (*n)[5], (*n)[6]});
}

}  // namespace

std::map<std::string, std::string> facts_of(const SessionSetup& setup) {
  Facts facts;
  if (setup.calibration) {
    facts[kProbeFromImage] = text_of_transform(setup.calibration->probe_from_image);
  }
  if (setup.probe_from_pixels) facts[kProbeFromPixels] = text_of_matrix(*setup.probe_from_pixels);
  if (setup.body_from_tip) facts[kBodyFromTip] = text_of_matrix(*setup.body_from_tip);
  if (setup.fixed_reference) facts[kFixedReference] = text_of_transform(*setup.fixed_reference);
  if (setup.image_watch) {
    facts[kScreenWatch] = "sector";
    if (const auto& d = setup.image_watch->depth_display) {
      facts[kScreenWatch] = text_of(std::array{d->left, d->top, d->width, d->height});
    }
  }
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
    if (key == kScreenWatch) {
      setup.image_watch.emplace();
      if (text == "sector") continue;
      const auto numbers = numbers_from<4>(text);
      const auto area = numbers ? screen_area({numbers->begin(), numbers->end()}) : std::nullopt;
      if (!area) {
        return bad(key, "expected 'sector' or left, top, width and height, found '" + text + "'");
      }
      setup.image_watch->depth_display = area;
      continue;
    }
    const auto no_transform = [&] {
      return bad(key,
                 "expected a unit quaternion w, x, y, z and a translation, found '" + text + "'");
    };
    if (key == kProbeFromImage) {
      const auto found = transform_from<frames::Probe, frames::Image>(text);
      if (!found) return no_transform();
      setup.calibration = ProbeCalibration{*found};
    } else if (key == kFixedReference) {
      setup.fixed_reference = transform_from<frames::Reference, frames::Tracker>(text);
      if (!setup.fixed_reference) return no_transform();
    } else if (key == kProbeFromPixels || key == kBodyFromTip) {
      const auto numbers = numbers_from<16>(text);
      if (!numbers) return bad(key, "expected 16 finite numbers, found '" + text + "'");
      const Eigen::Matrix4d matrix =
          Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers->data());
      (key == kBodyFromTip ? setup.body_from_tip : setup.probe_from_pixels) = matrix;
    }
  }
  return setup;
}

}  // namespace nav::session
