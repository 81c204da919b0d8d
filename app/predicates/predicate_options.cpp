// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "nav/positions.hpp"

namespace nav::app {
namespace {

template <class Found>
Error rejected_option(const std::string& key, const std::string& expected, const Found& found) {
  std::ostringstream text;
  text.precision(12);
  text << "predicates." << key << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

Error option_error(const std::string& key, const std::string& text) {
  return {ErrorCode::kUsage, "predicates." + key + ": " + text};
}

Result<void> check_histogram(const std::vector<HistogramEdit>& edits) {
  const auto is_share = [](double value) { return value >= 0 && value <= 1; };
  for (const HistogramEdit& edit : edits) {
    if (edit.hue_deg && !std::isfinite(*edit.hue_deg)) {
      return rejected_option("histogram.hue_deg", "a finite number", *edit.hue_deg);
    }
    if (edit.importance && !is_share(*edit.importance)) {
      return rejected_option("histogram.importance", "0 to 1", *edit.importance);
    }
    if (edit.floor && !is_share(*edit.floor)) {
      return rejected_option("histogram.floor", "0 to 1", *edit.floor);
    }
    if (edit.saturation && !is_share(*edit.saturation)) {
      return rejected_option("histogram.saturation", "0 to 1", *edit.saturation);
    }
  }
  return {};
}

template <int Rows>
bool finite(const std::optional<Eigen::Matrix<double, Rows, 1>>& v) {
  return !v || v->allFinite();
}

template <int Rows>
bool near(const std::optional<Eigen::Matrix<double, Rows, 1>>& v) {
  return !v || is_place(*v);
}

/// Parses a name, '=' and numbers separated by colons. The last '=' counts, because names may
/// contain '=' themselves.
Result<std::vector<double>> numbers_after_name(const std::string& option, const std::string& form,
                                               const std::string& text, std::size_t count,
                                               std::string& name) {
  const Error reject{ErrorCode::kUsage, option + ": expected " + form + ", found '" + text + "'"};
  const auto equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) return reject;
  name = text.substr(0, equals);
  std::vector<double> numbers;
  const char* at = text.data() + equals + 1;
  const char* const end = text.data() + text.size();
  while (true) {
    double number = 0;
    const auto read = std::from_chars(at, end, number);
    if (read.ec != std::errc() || !std::isfinite(number)) return reject;
    numbers.push_back(number);
    at = read.ptr;
    if (at == end) break;
    if (*at++ != ':') return reject;
  }
  if (numbers.size() != count) return reject;
  return numbers;
}

}  // namespace

Result<void> validate(const PredicateOptions& o) {
  if (const auto ok = check_histogram(o.histogram); !ok) return ok;
  // If only one of the two is given, the other is that of 8 bits.
  constexpr double kWhiteOf8Bits = 255;
  const double white = o.white.value_or(kWhiteOf8Bits);
  if ((o.black || o.white) && !(o.black.value_or(0) < white)) {
    return rejected_option("white", "more than black", white);
  }
  if (o.smallest_radius_mm && o.largest_radius_mm && *o.smallest_radius_mm > *o.largest_radius_mm) {
    return rejected_option("smallest_radius_mm", "at most largest_radius_mm",
                           *o.smallest_radius_mm);
  }
  if (!o.scan_lines.empty() && (o.into_ct || o.apex_ct)) {
    return option_error("scan_lines", "excludes predicates.into and predicates.apex_mm");
  }
  if (!o.layers.empty() && !o.labels.empty())
    return option_error("layers", "excludes predicates.labels");
  if (o.face_ct && !o.into_ct) return option_error("face_mm", "requires predicates.into");
  if (!near(o.face_ct)) {
    return rejected_option("face_mm", "3 numbers within 1e7 mm", o.face_ct->transpose());
  }
  if (o.into_ct && o.apex_ct) return option_error("apex_mm", "excludes predicates.into");
  if (!finite(o.into_ct) || (o.into_ct && o.into_ct->isZero(0))) {
    return rejected_option("into", "3 finite numbers, not all 0", o.into_ct->transpose());
  }
  if (!near(o.apex_ct)) {
    return rejected_option("apex_mm", "3 numbers within 1e7 mm", o.apex_ct->transpose());
  }
  if (!o.from.allFinite() || o.from.isZero(0)) {
    return rejected_option("from", "3 finite numbers, not all 0", o.from.transpose());
  }
  if (!near(o.target) || (o.target && !(o.target->w() > 0))) {
    return rejected_option("target_mm", "x y z and a radius > 0, within 1e7 mm",
                           o.target->transpose());
  }
  if (!near(o.needle) || (o.needle && o.needle->head<3>() == o.needle->tail<3>())) {
    return rejected_option("needle_mm", "a tip and a hub apart from each other, within 1e7 mm",
                           o.needle->transpose());
  }
  return {};
}

Result<void> apply_edits(const std::vector<HistogramEdit>& edits, render::PredicateModel& model) {
  for (const HistogramEdit& edit : edits) {
    std::size_t at = 0;
    std::string known;
    while (at < model.entries.size() && model.entries[at].name != edit.entry) {
      known += (known.empty() ? "" : ", ") + model.entries[at++].name;
    }
    if (at == model.entries.size()) {
      return rejected_option("histogram", "one of " + known, "'" + edit.entry + "'");
    }
    if (edit.importance && model.entries.size() == 1 && *edit.importance != 1) {
      return rejected_option("histogram.importance", "1, because there is only one predicate",
                             *edit.importance);
    }
    if (edit.importance) model.histogram.drag(at, *edit.importance);
    model.entries[at].floor = edit.floor.value_or(model.entries[at].floor);
    const auto& bar = model.histogram.bars()[at];
    model.histogram.set_colour(at, edit.hue_deg.value_or(bar.hue_deg),
                               edit.saturation.value_or(bar.saturation));
  }
  return {};
}

Result<HistogramEdit> parse_importance(const std::string& text) {
  HistogramEdit edit;
  const auto numbers = numbers_after_name("--importance", "NAME=IMPORTANCE", text, 1, edit.entry);
  if (!numbers) return numbers.error();
  edit.importance = numbers->front();
  return edit;
}

Result<HistogramEdit> parse_floor(const std::string& text) {
  HistogramEdit edit;
  const auto numbers = numbers_after_name("--floor", "NAME=FLOOR", text, 1, edit.entry);
  if (!numbers) return numbers.error();
  edit.floor = numbers->front();
  return edit;
}

Result<HistogramEdit> parse_colour(const std::string& text) {
  HistogramEdit edit;
  const auto numbers = numbers_after_name("--colour", "NAME=HUE:SATURATION", text, 2, edit.entry);
  if (!numbers) return numbers.error();
  edit.hue_deg = numbers->front();
  edit.saturation = numbers->back();
  return edit;
}

}  // namespace nav::app
