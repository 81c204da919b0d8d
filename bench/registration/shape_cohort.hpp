// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "registration/shape/shape_acceptance.hpp"

/// Registration of touched points to bones made by code: right ones, and every way to take the
/// wrong bone or the wrong way round.
namespace nav::bench {

enum class BoneKind { kLongBone, kRib, kVertebra, kSkullCap, kPelvis, kHemipelvis };
inline constexpr int kBoneKinds = 6;
const char* to_string(BoneKind kind);

/// A bone: its surface over a rectangle of two parameters, and one of seeded form.
class BoneModel {
 public:
  BoneModel(BoneKind kind, std::uint64_t seed);
  /// The neighbour of a bone: another level or a relative, up to about 8 % larger or smaller.
  [[nodiscard]] BoneModel neighbour(std::uint64_t seed) const;
  [[nodiscard]] BoneModel scaled(double factor) const;
  /// The other side of the body.
  [[nodiscard]] BoneModel mirrored() const;

  [[nodiscard]] BoneKind kind() const { return kind_; }
  /// Point of the surface; u and v in [0, 1]. Ct, mm.
  [[nodiscard]] Eigen::Vector3d at(double u, double v) const;
  /// The surface with its smooth errors of segmentation, of sigma_mm.
  [[nodiscard]] TriangleMesh mesh(double sigma_mm, std::uint64_t seed) const;
  /// False for bones of the midline, which have no other side.
  [[nodiscard]] bool has_sides() const;

 private:
  [[nodiscard]] double form(std::size_t i) const { return form_[i % form_.size()]; }
  [[nodiscard]] Eigen::Vector3d tube(double u, double v) const;
  [[nodiscard]] Eigen::Vector3d ball(double u, double v) const;

  BoneKind kind_;
  std::array<double, 64> form_{};  ///< Uniform, [-1, 1].
  Eigen::Vector3d scale_ = Eigen::Vector3d::Ones();
};

/// How the registration is wrong from the outset.
enum class BoneCase {
  kRight,
  kRightShaft,
  kOtherSide,
  kTurned,
  kOtherLevel,
  kOtherPatient,
  kScaled
};
inline constexpr int kBoneCases = 7;
const char* to_string(BoneCase bone_case);

struct BoneTrial {
  BoneKind kind;
  BoneCase bone_case;
  std::uint64_t seed;
  double error_mm;  ///< RMS of the points from where they belong on the surface.
  bool accepted;
  bool undetermined;  ///< Sliding, a rival that fits as well, or no size.
  bool false_accept;  ///< Accepted, and wrong: kOtherPatient, or error_mm > 3.
  std::string reasons;
  double seconds;
  registration::ShapeRegistration result;
};

struct BoneCohortOptions {
  std::uint64_t first_seed = 1;
  int bones = 42;  ///< Shapes; their kinds take turns.
  int runs = 1;    ///< Runs of each case and shape.
};

/// Runs one case of one bone.
Result<BoneTrial> run_bone(BoneKind kind, BoneCase bone_case, std::uint64_t bone_seed,
                           std::uint64_t run_seed);

Result<std::vector<BoneTrial>> run_bones(const BoneCohortOptions& options,
                                         const std::function<void(double)>& progress);

/// Runs of one case and kind.
struct BoneCount {
  BoneCase bone_case;
  BoneKind kind;
  int runs = 0;
  int accepted = 0;
  int undetermined = 0;  ///< See BoneTrial.
  int false_accepts = 0;
  double seconds = 0;  ///< Sum over the runs, the registration alone.
};
std::vector<BoneCount> count_bones(const std::vector<BoneTrial>& trials);

/// Table: runs, accepted ones and false accepts by case and by kind.
std::string to_text(const std::vector<BoneTrial>& trials);

}  // namespace nav::bench
