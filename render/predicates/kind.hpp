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
  std::string unit;  ///< "1": a bare number.
  double low;        ///< Allowed, both included.
  double high;
  double initial;
};

/// What a predicate reads.
struct PredicateNeeds {
  std::vector<std::string> channels;  ///< Names as in feature.hpp; at most two.
  bool labels = false;
  bool position = false;
  bool scan = false;    ///< Refuse without a scan geometry.
  bool needle = false;  ///< Refuse without a needle.
  bool target = false;
};

/// A sample as a predicate sees it.
struct PredicateSample {
  double value[2];              ///< Of its channels, trilinear; NaN: undefined.
  double quantum[2];            ///< Values this close count as equal, >= 0.
  std::uint32_t labels;         ///< Of the nearest voxel.
  Eigen::Vector3d position_mm;  ///< Grid mm.
};

/// All samples in a brick of the volume.
struct PredicateBounds {
  Range value[2];
  double quantum[2];
  bool undefined[2];  ///< Some voxel has no value.
  std::uint32_t labels_any;
  std::uint32_t labels_all;
  Eigen::Vector3d low_mm;  ///< Box of the positions, grid mm.
  Eigen::Vector3d high_mm;
};

/// The CPU block: one of the tests that the vectorised march knows, on the predicate's channels.
struct PredicateForm {
  enum class Kind {
    kRange,  ///< low <= value0 <= high.
    /// Three linear forms of (value0, value1) >= 0, each within what half a quantum of either value
    /// moves it (wedge_slack()), and value0² + value1² >= low².
    kWedge,
    kBits,     ///< Some bit of the mask.
    kSegment,  ///< low <= distance from a segment <= high, mm.
    kSlab,     ///< low <= normal · position <= high, mm.
    kNever,
  };
  Kind kind = Kind::kNever;
  double low = 0;
  double high = 0;
  double wedge[3][2] = {};  ///< Coefficients of value0 and value1; zeros: no condition.
  std::uint32_t mask = 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero();  ///< Segment: one end. Slab: normal.
  Eigen::Vector3d b = Eigen::Vector3d::Zero();  ///< Segment: the other end.
};

/// How far below 0 a linear form of two values still counts as >= 0: by half a quantum of each, as
/// ranges do.
inline double wedge_slack(const double (&form)[2], const double (&quantum)[2]) {
  return 0.5 * (std::abs(form[0]) * quantum[0] + std::abs(form[1]) * quantum[1]);
}

/// The GLSL block (§5.1): a header with the uniforms, a closed expression, and what to set. In the
/// expression VALUE0 and VALUE1 stand for the channels (NaN never reaches it), LABELS for the bits
/// (uint) and POSITION for the grid position in mm. A uniform of two numbers of a predicate that
/// reads one channel is a range of its values: both are replaced by their codes together. A uniform
/// <prefix>_slack of three numbers is given the wedge_slack() of each form of the wedge. No
/// parameter may change header or expression: a new text is a new program.
struct PredicateGlsl {
  struct Uniform {
    std::string name;
    std::vector<double> value;  ///< 1 to 4 numbers.
  };
  std::string header;
  std::string expression;
  std::vector<Uniform> uniforms;  ///< The set-up.
  std::uint32_t mask = 0;         ///< Of a uniform uint named <prefix>_mask; 0: there is none.
};

/// One kind of point predicate (Schulte zu Berge et al. 2014 §3.1). Parameters come in the order of
/// parameters(), checked. Stateless, thread-safe.
class PredicateKind {
 public:
  virtual ~PredicateKind() = default;
  /// Stable lower-case name, as in files.
  [[nodiscard]] virtual std::string name() const = 0;
  /// One sentence.
  [[nodiscard]] virtual std::string description() const = 0;
  [[nodiscard]] virtual std::vector<PredicateParameter> parameters() const = 0;
  [[nodiscard]] virtual PredicateNeeds needs(const PredicatePlace& place) const = 0;
  /// Refuses what single ranges cannot say: inverted ranges.
  [[nodiscard]] virtual Result<void> check(std::span<const double> p) const = 0;
  /// The predicate itself, in double: the definition. False for undefined values.
  [[nodiscard]] virtual bool test(const PredicateSample& sample, const PredicatePlace& place,
                                  std::span<const double> p) const = 0;
  /// Never wrong, if at times unknown.
  [[nodiscard]] virtual Truth bounds(const PredicateBounds& brick, const PredicatePlace& place,
                                     std::span<const double> p) const = 0;
  [[nodiscard]] virtual PredicateForm form(const PredicatePlace& place,
                                           std::span<const double> p) const = 0;
  /// prefix: begins every name that the block declares.
  [[nodiscard]] virtual PredicateGlsl glsl(const std::string& prefix, const PredicatePlace& place,
                                           std::span<const double> p) const = 0;
};

/// Refuses parameters low > high, naming both.
Result<void> check_order(const PredicateKind& kind, std::span<const double> p, std::size_t low,
                         std::size_t high);

/// A closed range [p[0], p[1]] of one channel.
class RangePredicate : public PredicateKind {
 public:
  RangePredicate(std::string name, std::string description, std::string channel,
                 std::vector<PredicateParameter> parameters);
  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] std::string description() const override { return description_; }
  [[nodiscard]] std::vector<PredicateParameter> parameters() const override { return parameters_; }
  [[nodiscard]] PredicateNeeds needs(const PredicatePlace& place) const override;
  [[nodiscard]] Result<void> check(std::span<const double> p) const override;
  [[nodiscard]] bool test(const PredicateSample& sample, const PredicatePlace& place,
                          std::span<const double> p) const override;
  [[nodiscard]] Truth bounds(const PredicateBounds& brick, const PredicatePlace& place,
                             std::span<const double> p) const override;
  [[nodiscard]] PredicateForm form(const PredicatePlace& place,
                                   std::span<const double> p) const override;
  [[nodiscard]] PredicateGlsl glsl(const std::string& prefix, const PredicatePlace& place,
                                   std::span<const double> p) const override;

 private:
  std::string name_;
  std::string description_;
  std::string channel_;
  std::vector<PredicateParameter> parameters_;
};

/// Parameters 0 and 1 as what is wanted.
inline Range wanted_range(std::span<const double> p) { return {p[0], p[1]}; }

/// Distance from a segment, mm; parameters [low, high]. Distances are negative inside its radius.
bool test_distance(const Segment& segment, const Eigen::Vector3d& position_mm, const Range& wanted);
Truth bound_distance(const Segment& segment, const Eigen::Vector3d& low_mm,
                     const Eigen::Vector3d& high_mm, const Range& wanted);
PredicateForm distance_form(const Segment& segment, const Range& wanted);
PredicateGlsl distance_glsl(const std::string& prefix, const Segment& segment, const Range& wanted);

}  // namespace nav::render
