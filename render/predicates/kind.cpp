// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/kind.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

namespace nav::render {
namespace {

double distance_to_axis(const Segment& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d axis = s.b - s.a;
  const double square = axis.squaredNorm();
  const double foot = square > 0 ? std::clamp((p - s.a).dot(axis) / square, 0.0, 1.0) : 0;
  return (p - s.a - foot * axis).norm();
}

/// Wanted distances from the axis; empty (low > high) when there are none.
Range axis_range(const Segment& s, const Range& wanted) {
  return {std::max(0.0, wanted.low + s.radius_mm), wanted.high + s.radius_mm};
}

std::vector<double> numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

Result<void> check_order(const PredicateKind& kind, std::span<const double> p, std::size_t low,
                         std::size_t high) {
  if (p[low] <= p[high]) return {};
  const auto parameters = kind.parameters();
  // Users enter angles in degrees.
  const std::string radians = "_rad";
  const bool angle = parameters[low].name.ends_with(radians);
  const auto name_of = [&](const std::string& name) {
    return angle ? name.substr(0, name.size() - radians.size()) + "_deg" : name;
  };
  const double per_unit = angle ? 180 / std::numbers::pi : 1;
  std::ostringstream text;
  text.precision(12);
  text << kind.name() << ": expected " << name_of(parameters[low].name)
       << " <= " << name_of(parameters[high].name) << ", found " << p[low] * per_unit << " and "
       << p[high] * per_unit;
  return Error{ErrorCode::kMalformedData, text.str()};
}

RangePredicate::RangePredicate(std::string name, std::string description, std::string channel,
                               std::vector<PredicateParameter> parameters)
    : name_(std::move(name)),
      description_(std::move(description)),
      channel_(std::move(channel)),
      parameters_(std::move(parameters)) {}

PredicateNeeds RangePredicate::needs(const PredicatePosition&) const {
  return PredicateNeeds{{channel_}};
}

Result<void> RangePredicate::check(std::span<const double> p) const {
  return check_order(*this, p, 0, 1);
}

bool RangePredicate::test(const PredicateSample& sample, const PredicatePosition&,
                          std::span<const double> p) const {
  const double slack = 0.5 * sample.quantum[0];
  return sample.value[0] >= p[0] - slack && sample.value[0] <= p[1] + slack;
}

Truth RangePredicate::bounds(const PredicateBounds& brick, const PredicatePosition&,
                             std::span<const double> p) const {
  const double slack = 0.5 * brick.quantum[0];
  const Truth found = within(brick.value[0], {p[0] - slack, p[1] + slack});
  return brick.undefined[0] ? and_of(found, Truth::kUnknown) : found;
}

PredicateForm RangePredicate::form(const PredicatePosition&, std::span<const double> p) const {
  PredicateForm form;
  form.kind = PredicateForm::Kind::kRange;
  form.low = p[0];
  form.high = p[1];
  return form;
}

PredicateGlsl RangePredicate::glsl(const std::string& prefix, const PredicatePosition&,
                                   std::span<const double> p) const {
  const std::string range = prefix + "_range";
  return {"uniform vec2 " + range + ";\n",
          "(VALUE0 >= " + range + ".x && VALUE0 <= " + range + ".y)",
          {{range, {p[0], p[1]}}}};
}

bool test_distance(const Segment& segment, const Eigen::Vector3d& position_mm,
                   const Range& wanted) {
  const double d = distance_to_axis(segment, position_mm) - segment.radius_mm;
  return d >= wanted.low && d <= wanted.high;
}

// Moving by a length changes the distance by at most that length.
Truth bound_distance(const Segment& segment, const Eigen::Vector3d& low_mm,
                     const Eigen::Vector3d& high_mm, const Range& wanted) {
  if (!segment.a.allFinite()) return Truth::kFalse;
  const double middle = distance_to_axis(segment, 0.5 * (low_mm + high_mm)) - segment.radius_mm;
  const double reach = 0.5 * (high_mm - low_mm).norm();
  return within({middle - reach, middle + reach}, wanted);
}

PredicateForm distance_form(const Segment& segment, const Range& wanted) {
  const Range axis = axis_range(segment, wanted);
  PredicateForm form;
  if (axis.high < axis.low || !segment.a.allFinite()) return form;
  form.kind = PredicateForm::Kind::kSegment;
  form.low = axis.low;
  form.high = axis.high;
  form.a = segment.a;
  form.b = segment.b;
  return form;
}

PredicateGlsl distance_glsl(const std::string& prefix, const Segment& segment,
                            const Range& wanted) {
  // A lost needle is in no range. The GLSL text stays the same.
  const bool known = segment.a.allFinite() && segment.b.allFinite();
  const Range axis = known ? axis_range(segment, wanted) : Range{1, -1};
  const Eigen::Vector3d a = known ? segment.a : Eigen::Vector3d::Zero();
  const Eigen::Vector3d along = known ? Eigen::Vector3d(segment.b - segment.a) : a;
  const double square = along.squaredNorm();
  const std::string p = prefix;
  return {"uniform vec3 " + p + "_a;\nuniform vec3 " + p + "_axis;\nuniform vec3 " + p +
              "_foot;\nuniform vec2 " + p + "_range;\nfloat " + p +
              "_distance(vec3 at) {\n  vec3 d = at - " + p +
              "_a;\n  return length(d - clamp(dot(d, " + p + "_foot), 0.0, 1.0) * " + p +
              "_axis);\n}\n",
          "(" + p + "_distance(POSITION) >= " + p + "_range.x && " + p +
              "_distance(POSITION) <= " + p + "_range.y)",
          {{p + "_a", numbers(a)},
           {p + "_axis", numbers(along)},
           {p + "_foot", numbers(square > 0 ? Eigen::Vector3d(along / square) : along)},
           {p + "_range", {axis.low, axis.high}}}};
}

}  // namespace nav::render
