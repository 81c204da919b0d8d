// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/ct_patient.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "sim/anatomy/body_mask.hpp"
#include "sim/anatomy/dual.hpp"
#include "sim/blur.hpp"
#include "sim/speckle.hpp"

namespace nav::sim {
namespace {

/// Tissue class: pure at its own HU, mixed linearly with the next higher class.
struct HuClass {
  double hu;
  Tissue tissue;
};
constexpr std::array<HuClass, 11> kClasses = {{{-950, Tissue::kGas},
                                               {-830, Tissue::kLung},
                                               {-550, Tissue::kLung},
                                               {-130, Tissue::kFat},
                                               {-80, Tissue::kFat},
                                               {5, Tissue::kBile},
                                               {30, Tissue::kMuscle},
                                               {75, Tissue::kLiver},
                                               {150, Tissue::kVein},
                                               {330, Tissue::kMarrow},
                                               {650, Tissue::kBone}}};

Acoustics mixed(const Acoustics& a, const Acoustics& b, float share) {
  Acoustics out = a;
  out.impedance_mrayl += share * (b.impedance_mrayl - a.impedance_mrayl);
  out.attenuation_db_per_cm_mhz +=
      share * (b.attenuation_db_per_cm_mhz - a.attenuation_db_per_cm_mhz);
  out.scatter += share * (b.scatter - a.scatter);
  return out;
}

class CtPatient final : public Anatomy {
 public:
  CtPatient(const Volume& ct, const CtPatientOptions& o, std::vector<float> smooth,
            std::vector<float> skin_mm)
      : ct_(ct),
        options_(o),
        smooth_(std::move(smooth)),
        skin_mm_(std::move(skin_mm)),
        scatter_(hash_bits(o.seed, 0x736361, 1), o.hidden_mm),
        density_(hash_bits(o.seed, 0x696d70, 2), 0.7 * o.hidden_mm),
        absorption_(hash_bits(o.seed, 0x616273, 3), 1.6 * o.hidden_mm) {
    place_points();
  }

  [[nodiscard]] std::string name() const override { return "patient of " + ct_.name(); }
  [[nodiscard]] Tissue tissue(const Point<frames::Ct>& p) const override {
    if (skin_distance_mm(p) > 0) return Tissue::kAir;
    const auto [low, share] = class_at(value_of(smooth_, p));
    return kClasses[share < 0.5F ? low : low + 1].tissue;
  }
  [[nodiscard]] double hu(const Point<frames::Ct>& p) const override {
    return ct_.sample(p).value_or(-1000.0);
  }
  [[nodiscard]] ValueAndGradient hu_with_gradient(const Point<frames::Ct>& p) const override;
  [[nodiscard]] Acoustics acoustics(const Point<frames::Ct>& p) const override;
  [[nodiscard]] double skin_distance_mm(const Point<frames::Ct>& p) const override {
    return value_of(skin_mm_, p);
  }
  [[nodiscard]] Eigen::AlignedBox3d region_mm() const override {
    Eigen::AlignedBox3d box;
    const auto& size = ct_.grid().size;
    for (int c = 0; c < 8; ++c) {
      const Vec3d corner((c & 1) != 0 ? size[0] - 1 : 0, (c & 2) != 0 ? size[1] - 1 : 0,
                         (c & 4) != 0 ? size[2] - 1 : 0);
      box.extend(ct_.grid().at(corner).mm);
    }
    return box;
  }
  [[nodiscard]] std::vector<NamedPoint> landmarks() const override { return landmarks_; }
  [[nodiscard]] std::vector<Point<frames::Ct>> targets() const override { return targets_; }

 private:
  /// Class below a value and share of the next one, limited at both ends.
  static std::pair<std::size_t, float> class_at(double hu) {
    std::size_t low = 0;
    while (low + 2 < kClasses.size() && hu > kClasses[low + 1].hu) ++low;
    const double width = kClasses[low + 1].hu - kClasses[low].hu;
    const double share = std::clamp((hu - kClasses[low].hu) / width, 0.0, 1.0);
    return {low, static_cast<float>(share * share * (3 - 2 * share))};
  }
  [[nodiscard]] double value_of(const std::vector<float>& field, const Point<frames::Ct>& p) const;
  void place_points();

  Volume ct_;
  CtPatientOptions options_;
  std::vector<float> smooth_;   ///< HU after the blur.
  std::vector<float> skin_mm_;  ///< Distance to the skin, mm.
  SmoothField scatter_, density_, absorption_;
  std::vector<NamedPoint> landmarks_;
  std::vector<Point<frames::Ct>> targets_;
};

/// Trilinear value; the border is repeated.
double CtPatient::value_of(const std::vector<float>& field, const Point<frames::Ct>& p) const {
  const VoxelGrid& grid = ct_.grid();
  const Vec3d q = grid.index_of(p);
  std::array<std::size_t, 3> low{};
  std::array<double, 3> share{};
  for (int a = 0; a < 3; ++a) {
    const auto n = static_cast<std::size_t>(a);
    const double last = grid.size[n] - 1;
    const double at = std::clamp(q[a], 0.0, last);
    low[n] = static_cast<std::size_t>(std::min(std::floor(at), std::max(0.0, last - 1)));
    share[n] = at - static_cast<double>(low[n]);
  }
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const auto ny = static_cast<std::size_t>(grid.size[1]);
  double sum = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    double weight = 1;
    std::array<std::size_t, 3> i = low;
    for (std::size_t a = 0; a < 3; ++a) {
      const bool high = ((c >> a) & 1) != 0;
      weight *= high ? share[a] : 1 - share[a];
      i[a] += high && i[a] + 1 < static_cast<std::size_t>(grid.size[a]) ? 1 : 0;
    }
    if (weight > 0) sum += weight * static_cast<double>(field[(i[2] * ny + i[1]) * nx + i[0]]);
  }
  return sum;
}

ValueAndGradient CtPatient::hu_with_gradient(const Point<frames::Ct>& p) const {
  const VoxelGrid& grid = ct_.grid();
  const Vec3d q = grid.index_of(p);
  ValueAndGradient out{hu(p), {Vec3d::Zero()}};
  std::array<int, 3> low{};
  Vec3d share;
  for (int a = 0; a < 3; ++a) {
    const auto n = static_cast<std::size_t>(a);
    if (!(q[a] >= 0 && q[a] <= grid.size[n] - 1) || grid.size[n] < 2) return out;
    low[n] = std::min(static_cast<int>(q[a]), grid.size[n] - 2);
    share[a] = q[a] - low[n];
  }
  Vec3d slope = Vec3d::Zero();  // Slope per voxel.
  for (int c = 0; c < 8; ++c) {
    Vec3d side;
    std::array<int, 3> i = low;
    for (int a = 0; a < 3; ++a) {
      side[a] = (c >> a) & 1;
      i[static_cast<std::size_t>(a)] += (c >> a) & 1;
    }
    const double value = ct_.at(i[0], i[1], i[2]);
    const Vec3d w = side.cwiseProduct(share) +
                    (1 - side.array()).matrix().cwiseProduct((1 - share.array()).matrix());
    const Vec3d sign = 2 * side.array() - 1;
    slope +=
        value * Vec3d(sign.x() * w.y() * w.z(), w.x() * sign.y() * w.z(), w.x() * w.y() * sign.z());
  }
  out.gradient_per_mm.v = grid.directions * slope.cwiseQuotient(grid.spacing_mm);
  return out;
}

Acoustics CtPatient::acoustics(const Point<frames::Ct>& p) const {
  const double outside = skin_distance_mm(p);
  constexpr double kBlendMm = 0.8;
  const auto air = static_cast<float>(std::clamp(0.5 + outside / kBlendMm, 0.0, 1.0));
  if (air >= 1) return tissue_acoustics(Tissue::kAir);
  const auto [low, share] = class_at(value_of(smooth_, p));
  Acoustics own = mixed(tissue_acoustics(kClasses[low].tissue),
                        tissue_acoustics(kClasses[low + 1].tissue), share);
  const auto hidden = static_cast<float>(options_.hidden_share);
  own.scatter *= std::exp(2 * hidden * scatter_.at(p.mm));
  own.impedance_mrayl *= 1 + 0.02F * hidden * density_.at(p.mm);
  own.attenuation_db_per_cm_mhz *= 1 + hidden * absorption_.at(p.mm);
  return air > 0 ? mixed(own, tissue_acoustics(Tissue::kAir), air) : own;
}

/// Places targets on a regular pattern of voxels where soft tissue is deep enough; eight of them
/// are landmarks.
void CtPatient::place_points() {
  const auto& size = ct_.grid().size;
  const int step = std::max(2, std::min({size[0], size[1], size[2]}) / 12);
  constexpr double kDepthMm = 5;
  for (int k = step / 2; k < size[2]; k += step) {
    for (int j = step / 2; j < size[1]; j += step) {
      for (int i = step / 2; i < size[0]; i += step) {
        const auto p = ct_.grid().at(Vec3d(i, j, k));
        const int hu = ct_.at(i, j, k);
        if (options_.about && (p - *options_.about).v.norm() > kAboutMm) continue;
        if (hu > -200 && hu < 250 && skin_distance_mm(p) < -kDepthMm) targets_.push_back(p);
      }
    }
  }
  constexpr std::size_t kLandmarks = 8;
  for (std::size_t n = 0; n < kLandmarks && n < targets_.size(); ++n) {
    landmarks_.push_back({"point " + std::to_string(n + 1),
                          targets_[n * targets_.size() / std::min(kLandmarks, targets_.size())]});
  }
}

Error rejected_patient(const char* name, double low, double high, double found) {
  std::ostringstream text;
  text << "patient of a CT: expected " << name << " in [" << low << ", " << high << "], found "
       << found;
  return {ErrorCode::kUsage, text.str()};
}

}  // namespace

Result<std::shared_ptr<const Anatomy>> make_ct_patient(const Volume& ct,
                                                       const CtPatientOptions& o) {
  if (!(o.smooth_mm >= 0 && o.smooth_mm <= 5))
    return rejected_patient("smooth_mm", 0, 5, o.smooth_mm);
  if (!(o.hidden_mm >= 2 && o.hidden_mm <= 100))
    return rejected_patient("hidden_mm", 2, 100, o.hidden_mm);
  if (!(o.hidden_share >= 0 && o.hidden_share <= 0.9)) {
    return rejected_patient("hidden_share", 0, 0.9, o.hidden_share);
  }
  const auto skin = skin_distance_of(ct);
  if (!skin) return skin.error();
  std::vector<float> smooth(ct.hu().begin(), ct.hu().end());
  for (std::size_t a = 0; a < 3; ++a) {
    blur_axis(smooth, ct.grid(), a, o.smooth_mm / ct.grid().spacing_mm[static_cast<int>(a)]);
  }
  auto patient = std::make_shared<const CtPatient>(ct, o, std::move(smooth), *skin);
  if (o.about && patient->targets().empty()) {
    const Eigen::AlignedBox3d box = patient->region_mm();
    const Eigen::IOFormat row(4, Eigen::DontAlignCols, ", ", ", ", "", "", "(", ")");
    std::ostringstream text;
    text << "patient of a CT: expected soft tissue within " << kAboutMm
         << " mm of a point in the CT, from " << box.min().format(row) << " to "
         << box.max().format(row) << " mm, found none about " << o.about->mm.format(row);
    return Error{ErrorCode::kUsage, text.str()};
  }
  return std::shared_ptr<const Anatomy>(std::move(patient));
}

}  // namespace nav::sim
