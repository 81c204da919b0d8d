// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "io/detail/text.hpp"
#include "io/sequence.hpp"

namespace nav::io {

namespace {

constexpr std::string_view kSuffix = "Transform";
constexpr std::string_view kStatusSuffix = "TransformStatus";

const char* status_text(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kOk:
      return "OK";
    case TrackingStatus::kOccluded:
      return "MISSING";
    case TrackingStatus::kOutOfVolume:
      return "OUT_OF_VOLUME";
    case TrackingStatus::kTimeout:
      return "REQ_TIMEOUT";
    case TrackingStatus::kUnknown:
    case TrackingStatus::kInvalid:
      break;
  }
  return "INVALID";
}

}  // namespace

TrackingStatus tracking_status_from_text(std::string_view text) {
  struct Name {
    std::string_view text;
    TrackingStatus status;
  };
  constexpr std::array kNames = {Name{"OK", TrackingStatus::kOk},
                                 Name{"", TrackingStatus::kUnknown},
                                 Name{"UNKNOWN", TrackingStatus::kUnknown},
                                 Name{"MISSING", TrackingStatus::kOccluded},
                                 Name{"OUT_OF_VIEW", TrackingStatus::kOccluded},
                                 Name{"OUT_OF_VOLUME", TrackingStatus::kOutOfVolume},
                                 Name{"REQ_TIMEOUT", TrackingStatus::kTimeout}};
  text = detail::trim(text);
  if (text.starts_with("TOOL_")) text.remove_prefix(5);
  for (const Name& name : kNames) {
    if (name.text == text) return name.status;
  }
  return TrackingStatus::kInvalid;
}

std::vector<std::string> transform_names(const SequenceImage& frame) {
  std::vector<std::string> names;
  for (const auto& [key, value] : frame.fields) {
    if (key.size() > kSuffix.size() && key.ends_with(kSuffix)) {
      names.push_back(key.substr(0, key.size() - kSuffix.size()));
    }
  }
  return names;
}

Result<NamedTransform> transform(const SequenceImage& frame, std::string_view name) {
  const std::string key = std::string(name) + std::string(kSuffix);
  const std::string where = "frame " + std::to_string(frame.index) + ": " + key + ": ";
  const auto found = frame.fields.find(key);
  if (found == frame.fields.end()) {
    std::string known;
    for (const std::string& other : transform_names(frame)) {
      known += (known.empty() ? "" : ", ") + other;
    }
    return Error{ErrorCode::kNotFound, where + "expected a transform of that name, found " +
                                           (known.empty() ? std::string("none") : "only " + known)};
  }
  NamedTransform out{std::string(name), Eigen::Matrix4d::Zero(), TrackingStatus::kUnknown};
  const auto status = frame.fields.find(std::string(name) + std::string(kStatusSuffix));
  if (status != frame.fields.end()) out.status = tracking_status_from_text(status->second);
  const auto malformed = [&](const std::string& found_text) {
    return Error{ErrorCode::kMalformedData,
                 where + "expected 16 finite numbers, found " + found_text};
  };
  const auto words = detail::split_words(found->second);
  if (words.size() != 16) return malformed(std::to_string(words.size()) + " words");
  // A pose whose status says that it is invalid may be written as NaN.
  const bool claimed = out.status == TrackingStatus::kOk || out.status == TrackingStatus::kUnknown;
  for (std::size_t i = 0; i < 16; ++i) {
    const auto number = detail::parse_double(words[i]);
    if (!number || (claimed && !std::isfinite(*number))) {
      return malformed("'" + detail::excerpt(words[i]) + "' as number " + std::to_string(i + 1));
    }
    out.to_from_from(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = *number;
  }
  return out;
}

void set_transform(SequenceImage& frame, const NamedTransform& transform) {
  std::string text;
  for (Eigen::Index row = 0; row < 4; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) {
      if (!text.empty()) text += ' ';
      text += detail::to_text(transform.to_from_from(row, column));
    }
  }
  frame.fields[transform.name + std::string(kSuffix)] = text;
  const std::string status_key = transform.name + std::string(kStatusSuffix);
  if (transform.status == TrackingStatus::kUnknown) {
    frame.fields.erase(status_key);
  } else {
    frame.fields[status_key] = status_text(transform.status);
  }
}

}  // namespace nav::io
