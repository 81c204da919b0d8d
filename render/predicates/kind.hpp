// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "render/predicates/kleene.hpp"
#include "render/predicates/place.hpp"

namespace nav::render {

struct PredicateParameter {
  std::string name;
  std::string unit;  ///< "1" for a number without a unit.
  double low;        ///< Allowed values are low to high, both included.
  double high;
  double initial;
};

/// Inputs that a predicate reads.
struct PredicateNeeds {
  std::vector<std::string> channels;  ///< Names as in feature.hpp; at most two.
  bool labels = false;
  bool position = false;
  bool scan = false;    ///< Reject a scene without a scan geometry.
  bool needle = false;  ///< Reject a scene without a needle.
  bool target = false;
};

/// A sample, as predicates read it.
struct PredicateSample {
  double value[2];              ///< Values of the predicate's channels, trilinear; NaN: undefined.
  double quantum[2];            ///< Values closer than this count as equal, >= 0.
  std::uint32_t labels;         ///< Bits of the nearest voxel.
  Eigen::Vector3d position_mm;  ///< Grid mm.
};

/// Bounds of all samples in a brick of the volume.
struct PredicateBounds {
  Range value[2];
  double quantum[2];
  bool undefined[2];  ///< At least one voxel has no value.
  std::uint32_t labels_any;
  std::uint32_t labels_all;
  Eigen::Vector3d low_mm;  ///< Box of the positions, grid mm.
  Eigen::Vector3d high_mm;
};

/// The CPU form: one of the tests that the vectorised march supports, on the predicate's channels.
struct PredicateForm {
  enum class Kind {
    kRange,  ///< low <= value0 <= high.
    /// Three linear forms of (value0, value1) are >= 0, each within the change that half a quantum
    /// of either value causes (wedge_slack()), and value0² + value1² >= low².
    kWedge,
    kBits,     ///< At least one bit of the mask is set.
    kSegment,  ///< low <= distance from a segment <= high, mm.
    kSlab,     ///< low <= normal · position <= high, mm.
    kNever,
  };
  Kind kind = Kind::kNever;
  double low = 0;
  double high = 0;
  double wedge[3][2] = {};  ///< Coefficients of value0 and value1; zeros mean no condition.
  std::uint32_t mask = 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero();  ///< Segment: one end. Slab: normal.
  Eigen::Vector3d b = Eigen::Vector3d::Zero();  ///< Segment: the other end.
};

/// Tolerance below 0 within which a linear form of two values counts as >= 0: the effect of half a
/// quantum of each value, as for ranges.
inline double wedge_slack(const double (&form)[2], const double (&quantum)[2]) {
  return 0.5 * (std::abs(form[0]) * quantum[0] + std::abs(form[1]) * quantum[1]);
}

/// The GLSL block (§5.1): a header with the uniforms, a closed expression, and the values to set.
/// In the expression VALUE0 and VALUE1 stand for the channels (never NaN), LABELS for the bits
/// (uint) and POSITION for the grid position in mm. If a predicate reads one channel, each of its
/// uniforms of two numbers is a range of the channel's values; the range and VALUE0 are then both
/// replaced by codes. A uniform <prefix>_slack of three numbers receives the wedge_slack() of each
/// form of the wedge. No parameter may change the header or the expression, because a new text is a
/// new program.
struct PredicateGlsl {
  struct Uniform {
    std::string name;
    std::vector<double> value;  ///< 1 to 4 numbers.
  };
  std::string header;
  std::string expression;
  std::vector<Uniform> uniforms;  ///< Values to set before drawing.
  std::uint32_t mask = 0;         ///< Value of the uniform uint <prefix>_mask; 0: there is no such
                                  ///< uniform.
};

/// One kind of point predicate (Schulte zu Berge et al. 2014 §3.1). The parameters p are checked
/// and in the order of parameters(). Stateless, thread-safe.
class PredicateKind {
 public:
  virtual ~PredicateKind() = default;
  /// Stable lower-case name, as used in files.
  [[nodiscard]] virtual std::string name() const = 0;
  /// A description of one sentence.
  [[nodiscard]] virtual std::string description() const = 0;
  [[nodiscard]] virtual std::vector<PredicateParameter> parameters() const = 0;
  [[nodiscard]] virtual PredicateNeeds needs(const PredicatePosition& place) const = 0;
  /// Rejects what the limits of single parameters cannot express, such as inverted ranges.
  [[nodiscard]] virtual Result<void> check(std::span<const double> p) const = 0;
  /// Defines the predicate, in double. False for undefined values.
  [[nodiscard]] virtual bool test(const PredicateSample& sample, const PredicatePosition& place,
                                  std::span<const double> p) const = 0;
  /// The truth over all samples of a brick. It is never wrong, but may be kUnknown.
  [[nodiscard]] virtual Truth bounds(const PredicateBounds& brick, const PredicatePosition& place,
                                     std::span<const double> p) const = 0;
  [[nodiscard]] virtual PredicateForm form(const PredicatePosition& place,
                                           std::span<const double> p) const = 0;
  /// The GLSL block. \p prefix begins every name that the block declares.
  [[nodiscard]] virtual PredicateGlsl glsl(const std::string& prefix,
                                           const PredicatePosition& place,
                                           std::span<const double> p) const = 0;
};

/// Rejects parameters with low > high and names both.
Result<void> check_order(const PredicateKind& kind, std::span<const double> p, std::size_t low,
                         std::size_t high);

/// Tests that one channel is within the closed range [p[0], p[1]].
class RangePredicate : public PredicateKind {
 public:
  RangePredicate(std::string name, std::string description, std::string channel,
                 std::vector<PredicateParameter> parameters);
  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] std::string description() const override { return description_; }
  [[nodiscard]] std::vector<PredicateParameter> parameters() const override { return parameters_; }
  [[nodiscard]] PredicateNeeds needs(const PredicatePosition& place) const override;
  [[nodiscard]] Result<void> check(std::span<const double> p) const override;
  [[nodiscard]] bool test(const PredicateSample& sample, const PredicatePosition& place,
                          std::span<const double> p) const override;
  [[nodiscard]] Truth bounds(const PredicateBounds& brick, const PredicatePosition& place,
                             std::span<const double> p) const override;
  [[nodiscard]] PredicateForm form(const PredicatePosition& place,
                                   std::span<const double> p) const override;
  [[nodiscard]] PredicateGlsl glsl(const std::string& prefix, const PredicatePosition& place,
                                   std::span<const double> p) const override;

 private:
  std::string name_;
  std::string description_;
  std::string channel_;
  std::vector<PredicateParameter> parameters_;
};

/// Parameters 0 and 1 as a range.
inline Range wanted_range(std::span<const double> p) { return {p[0], p[1]}; }

/// Tests of the distance from a segment, mm, with a wanted range. Distances are negative inside the
/// segment's radius.
bool test_distance(const Segment& segment, const Eigen::Vector3d& position_mm, const Range& wanted);
Truth bound_distance(const Segment& segment, const Eigen::Vector3d& low_mm,
                     const Eigen::Vector3d& high_mm, const Range& wanted);
PredicateForm distance_form(const Segment& segment, const Range& wanted);
PredicateGlsl distance_glsl(const std::string& prefix, const Segment& segment, const Range& wanted);

}  // namespace nav::render
