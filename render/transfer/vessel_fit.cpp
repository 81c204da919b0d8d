// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/vessel_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "nav/check.hpp"
#include "render/transfer/enclosed.hpp"

namespace nav::render {
namespace {

constexpr int kLeastBloodHu = 130;
constexpr int kMostBloodHu = 700;
constexpr int kLeastTissuePeakHu = 20;
constexpr int kMostTissuePeakHu = 140;
constexpr int kUsualTissueHu = 60;
/// Corticalis that surrounds marrow, HU; above most blood.
constexpr int kCorticalHu = 500;

/// Counts of values from kLowHu on, smoothed.
class ValueHistogram {
 public:
  static constexpr int kLowHu = -200;
  static constexpr int kHighHu = 900;

  void add(int hu) {
    if (hu >= kLowHu && hu < kHighHu) ++counts_[static_cast<std::size_t>(hu - kLowHu)];
  }
  /// Smooths by a Gaussian of 6 HU.
  void smooth() {
    constexpr int kReach = 18;
    constexpr double kSigma = 6;
    std::vector<double> smoothed(counts_.size(), 0.0);
    for (int i = 0; i < static_cast<int>(counts_.size()); ++i) {
      double sum = 0;
      double weights = 0;
      for (int d = -kReach; d <= kReach; ++d) {
        const int j = i + d;
        if (j < 0 || j >= static_cast<int>(counts_.size())) continue;
        const double w = std::exp(-0.5 * d * d / (kSigma * kSigma));
        sum += w * counts_[static_cast<std::size_t>(j)];
        weights += w;
      }
      smoothed[static_cast<std::size_t>(i)] = sum / weights;
    }
    counts_ = std::move(smoothed);
  }
  [[nodiscard]] double at(int hu) const {
    return hu < kLowHu || hu >= kHighHu ? 0 : counts_[static_cast<std::size_t>(hu - kLowHu)];
  }
  /// True for a maximum within 10 HU that is an eighth above the valley to either side, before
  /// values rise above it or 80 HU away.
  [[nodiscard]] bool is_peak(int hu) const {
    constexpr int kBeside = 10;
    constexpr int kFarthest = 80;
    constexpr double kProminence = 1.125;
    if (!(at(hu) > 0)) return false;
    for (const int side : {-1, 1}) {
      double valley = at(hu);
      for (int d = 1; d <= kFarthest; ++d) {
        const double here = at(hu + side * d);
        if (here > at(hu)) {
          if (d <= kBeside) return false;
          break;
        }
        valley = std::min(valley, here);
      }
      if (at(hu) < kProminence * valley) return false;
    }
    return true;
  }
  /// Number of voxels within 20 HU.
  [[nodiscard]] double around(int hu) const {
    double sum = 0;
    for (int d = -20; d <= 20; ++d) sum += at(hu + d);
    return sum;
  }
  [[nodiscard]] double between(double low, double high) const {
    double sum = 0;
    for (int hu = static_cast<int>(low); hu <= high; ++hu) sum += at(hu);
    return sum;
  }
  /// Half width at half of the height of a peak, as the sigma of a Gaussian.
  [[nodiscard]] double sigma(int hu) const {
    int d = 1;
    while (d < 100 && (at(hu - d) + at(hu + d)) > at(hu)) ++d;
    return d / 1.1774;
  }

 private:
  std::vector<double> counts_ = std::vector<double>(kHighHu - kLowHu, 0.0);
};

double brightest_tissue(const ValueHistogram& values, double voxel_ml, double below_hu) {
  constexpr double kLeastTissueMl = 5;
  for (int hu = std::min(kMostTissuePeakHu, static_cast<int>(below_hu) - 30);
       hu >= kLeastTissuePeakHu; --hu) {
    if (values.is_peak(hu) && values.around(hu) * voxel_ml >= kLeastTissueMl) return hu;
  }
  return std::min<double>(kUsualTissueHu, below_hu - 30);
}

ValueHistogram homogeneous_values(const Volume& ct) {
  const VoxelLattice lattice(ct.grid());
  const auto hu = ct.hu();
  std::vector<std::uint8_t> cortical(hu.size());
  std::ranges::transform(hu, cortical.begin(),
                         [](int v) { return static_cast<std::uint8_t>(v >= kCorticalHu); });
  const auto enclosed = enclosed_voxels(lattice, cortical);
  const auto homogeneous = homogeneous_voxels(lattice, hu);
  ValueHistogram values;
  for (std::size_t i = 0; i < hu.size(); ++i) {
    // Blood may be brighter than a corticalis.
    const bool counts = enclosed[i] == 0 || cortical[i] != 0;
    if (counts && homogeneous[i] != 0) values.add(hu[i]);
  }
  values.smooth();
  return values;
}

double ml_of_voxel(const VoxelGrid& grid) { return grid.spacing_mm.prod() / 1000; }

}  // namespace

Result<BloodPool> find_blood_pool(const Volume& ct) {
  constexpr double kLeastBloodMl = 2;
  constexpr double kMostBloodMl = 2500;
  const double voxel_ml = ml_of_voxel(ct.grid());
  const ValueHistogram values = homogeneous_values(ct);
  for (int hu = kMostBloodHu; hu >= kLeastBloodHu; --hu) {
    if (!values.is_peak(hu) || values.around(hu) * voxel_ml < kLeastBloodMl) continue;
    const BloodPool pool{static_cast<double>(hu), std::max(values.sigma(hu), kLeastBloodSigmaHu),
                         brightest_tissue(values, voxel_ml, hu)};
    const VesselWindow window = vessel_window(pool);
    if (values.between(window.full_from, window.full_to) * voxel_ml <= kMostBloodMl) return pool;
  }
  return Error{ErrorCode::kNotFound, ct.name() + ": expected contrast-filled blood, a peak of " +
                                         "homogeneous voxels from 130 to 700 HU of 2 ml to 2.5 l, "
                                         "found none"};
}

Result<BloodPool> blood_pool_at(const Volume& ct, const Point<frames::Ct>& at) {
  constexpr double kRadiusMm = 3;
  constexpr double kMostAtPointHu = 1500;
  const auto reject = [&](const std::string& expected, auto found) {
    std::ostringstream text;
    text << "blood at (" << at.mm.transpose() << ") mm: expected " << expected << ", found "
         << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  if (!at.mm.allFinite() || !ct.sample(at)) return reject("a point inside the CT", "none");
  std::vector<double> values;
  for (int k = -2; k <= 2; ++k) {
    for (int j = -2; j <= 2; ++j) {
      for (int i = -2; i <= 2; ++i) {
        const Eigen::Vector3d off = 0.5 * kRadiusMm * Eigen::Vector3d(i, j, k);
        if (off.norm() > kRadiusMm) continue;
        if (const auto hu = ct.sample({at.mm + off})) values.push_back(*hu);
      }
    }
  }
  const auto median = [](std::vector<double>& of) {
    const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
    std::ranges::nth_element(of, middle);
    return *middle;
  };
  const double mean = median(values);
  if (!(mean >= kLeastBloodHu && mean <= kMostAtPointHu)) {
    return reject("contrast-filled blood of 130 to 1500 HU", mean);
  }
  for (double& v : values) v = std::abs(v - mean);
  const double sigma = std::max(1.4826 * median(values), kLeastBloodSigmaHu);
  return BloodPool{mean, sigma,
                   brightest_tissue(homogeneous_values(ct), ml_of_voxel(ct.grid()), mean)};
}

VesselWindow vessel_window(const BloodPool& pool) {
  constexpr double kZeroShare = 0.2;
  constexpr double kFullShare = 0.36;
  const double above_tissue = pool.mean_hu - pool.tissue_hu;
  const double full_to = pool.mean_hu + std::max(5 * pool.sigma_hu, 0.3 * above_tissue);
  const double zero_below =
      pool.tissue_hu + std::max(kZeroShare * above_tissue, std::min(25.0, 0.5 * above_tissue));
  return {std::round(zero_below),
          std::round(std::max(pool.tissue_hu + kFullShare * above_tissue, zero_below + 2)),
          std::round(full_to), std::round(full_to + std::max(20.0, pool.sigma_hu))};
}

VesselWindow window_of(const TransferComponent& component) {
  const auto& nodes = component.nodes;
  const double first = nodes.front().hu;
  const double last = nodes.back().hu;
  double most = 0;
  for (const TransferNode& node : nodes) most = std::max(most, node.opacity);
  double from = last;
  double to = first;
  for (const TransferNode& node : nodes) {
    if (node.opacity < 0.9 * most) continue;
    from = std::min(from, node.hu);
    to = std::max(to, node.hu);
  }
  return {first, from, to, last};
}

Result<TransferFunction> with_vessel_window(const TransferFunction& transfer,
                                            const VesselWindow& window, const std::string& vessels,
                                            const std::string& organs) {
  std::vector<TransferComponent> components = transfer.components();
  for (TransferComponent& component : components) {
    auto& nodes = component.nodes;
    const std::size_t count = nodes.size();
    if (component.name == vessels) {
      component.gradient.reset();
      double most = 0;
      for (const TransferNode& node : nodes) most = std::max(most, node.opacity);
      const TransferNode low = nodes.front();
      const TransferNode high = nodes[count / 2];
      nodes = {{window.zero_below, low.rgb, 0, low.importance},
               {window.full_from, high.rgb, most, high.importance},
               {window.full_to, high.rgb, most, high.importance},
               {window.zero_above, high.rgb, 0, high.importance}};
    }
    if (component.name == organs && count == 4) {
      // Between organs and blood lies no value that nothing draws.
      nodes[3].hu = std::max(window.full_from, nodes[1].hu + 2);
      nodes[2].hu = std::clamp(window.zero_below, nodes[1].hu + 1, nodes[3].hu - 1);
    }
  }
  return TransferFunction::blend(transfer.name(), std::move(components));
}

VesselClasses classify_vessels(const Volume& ct, const VesselWindow& window, double least_ml) {
  constexpr double kLeastCoreMl = 1;
  constexpr double kBoneReachMm = 3;
  constexpr int kFallsOffHu = 30;  // A rise that noise explains.
  const VoxelLattice lattice(ct.grid());
  const auto hu = ct.hu();
  const double voxel_ml = ml_of_voxel(ct.grid());
  std::vector<std::uint8_t> dense(hu.size());
  std::ranges::transform(hu, dense.begin(),
                         [&](int v) { return static_cast<std::uint8_t>(v >= window.zero_above); });
  auto enclosed = enclosed_voxels(lattice, dense);
  std::vector<std::uint8_t> core = homogeneous_voxels(lattice, hu);
  for (std::size_t i = 0; i < hu.size(); ++i) {
    const bool full = hu[i] >= window.full_from && hu[i] < window.zero_above;
    core[i] &= static_cast<std::uint8_t>(full);
  }
  for (const auto& part : components_of(lattice, core)) {
    const auto inside = std::ranges::count_if(part, [&](auto i) { return enclosed[i] != 0; });
    const bool marrow = 2 * inside > static_cast<std::ptrdiff_t>(part.size());
    const bool small = static_cast<double>(part.size()) * voxel_ml < kLeastCoreMl;
    for (const std::uint32_t i : part) {
      if (marrow || small) core[i] = 0;
    }
  }
  // Stents enclose blood as bone encloses marrow.
  for (const auto& part : components_of(lattice, enclosed)) {
    const auto blood = std::ranges::count_if(part, [&](auto i) { return core[i] != 0; });
    if (8 * blood < static_cast<std::ptrdiff_t>(part.size())) continue;
    for (const std::uint32_t i : part) enclosed[i] = 0;
  }
  VesselClasses classes;
  classes.voxels.assign(hu.size(), VesselClass::kRest);
  auto& kind = classes.voxels;
  // Noise leaves few homogeneous voxels: blood first grows through values that are surely blood.
  constexpr int kHeadStart = 3;
  for (int step = 0; step < kHeadStart; ++step) {
    const auto wider = within_voxels(lattice, core, 1);
    for (std::size_t i = 0; i < core.size(); ++i) {
      const bool full = hu[i] >= window.full_from && hu[i] < window.zero_above;
      if (full && enclosed[i] == 0) core[i] |= wider[i];
    }
  }
  const auto near_blood = within_voxels(lattice, core, 2);
  for (const auto& part : components_of(lattice, dense)) {
    const auto beside = std::ranges::count_if(part, [&](auto i) { return near_blood[i] != 0; });
    const bool implant = 3 * beside >= static_cast<std::ptrdiff_t>(part.size());
    for (const std::uint32_t i : part) {
      kind[i] = implant ? VesselClass::kImplant : VesselClass::kBone;
    }
  }
  std::vector<std::uint32_t> front;
  for (std::size_t i = 0; i < hu.size(); ++i) {
    if (enclosed[i] != 0) kind[i] = VesselClass::kBone;
    if (core[i] != 0) kind[i] = VesselClass::kVessel;
    if (kind[i] == VesselClass::kBone || kind[i] == VesselClass::kVessel) {
      front.push_back(static_cast<std::uint32_t>(i));
    }
  }
  // Both grow by one voxel at a time through the values of vessels; blood first.
  const int reach = static_cast<int>(std::ceil(kBoneReachMm / ct.grid().spacing_mm.minCoeff()));
  for (int step = 0; !front.empty(); ++step) {
    std::vector<std::uint32_t> next;
    for (const VesselClass grows : {VesselClass::kVessel, VesselClass::kBone}) {
      if (grows == VesselClass::kBone && step >= reach) continue;
      for (const std::uint32_t i : front) {
        if (kind[i] != grows) continue;
        lattice.for_each_neighbour(i, [&](std::size_t n) {
          if (kind[n] != VesselClass::kRest || hu[n] < window.zero_below) return;
          if (grows == VesselClass::kBone && hu[n] > hu[i] + kFallsOffHu) return;
          kind[n] = grows;
          next.push_back(static_cast<std::uint32_t>(n));
        });
      }
    }
    front = std::move(next);
  }
  // Parts that neither has reached belong to bone, are vessels of their own, or are fragments.
  std::vector<std::uint8_t> left(hu.size());
  for (std::size_t i = 0; i < hu.size(); ++i) {
    left[i] =
        static_cast<std::uint8_t>(kind[i] == VesselClass::kRest && hu[i] >= window.zero_below);
  }
  constexpr double kBesideBone = 0.1;  // Share of a part's voxels that touch bone.
  for (const auto& part : components_of(lattice, left)) {
    std::size_t beside = 0;
    for (const std::uint32_t i : part) {
      bool touches = false;
      lattice.for_each_neighbour(
          i, [&](std::size_t n) { touches = touches || kind[n] == VesselClass::kBone; });
      if (touches) ++beside;
    }
    const auto count = static_cast<double>(part.size());
    VesselClass is = VesselClass::kVessel;
    if (count * voxel_ml < least_ml) is = VesselClass::kFragment;
    if (static_cast<double>(beside) > kBesideBone * count) is = VesselClass::kBone;
    for (const std::uint32_t i : part) kind[i] = is;
  }
  for (const VesselClass one : kind) {
    if (one == VesselClass::kVessel) classes.vessel_ml += voxel_ml;
    if (one == VesselClass::kBone) classes.bone_ml += voxel_ml;
    if (one == VesselClass::kFragment) classes.fragment_ml += voxel_ml;
  }
  return classes;
}

Result<SeparatedVessels> separate_vessels(const Volume& ct, const VesselClasses& classes,
                                          const VesselWindow& window,
                                          const TransferFunction& transfer,
                                          const std::string& vessels) {
  constexpr int kRimVoxels = 2;
  constexpr std::int16_t kHighestHu = 3071;
  const auto& kind = classes.voxels;
  NAV_CHECK(kind.size() == ct.hu().size(), kind.size(), ct.hu().size());
  const VoxelLattice lattice(ct.grid());
  std::vector<std::uint8_t> near_vessel(kind.size(), 0);
  std::vector<std::uint8_t> moved(kind.size(), 0);
  std::vector<std::uint32_t> front;
  for (std::size_t i = 0; i < kind.size(); ++i) {
    if (kind[i] == VesselClass::kVessel) {
      near_vessel[i] = 1;
      lattice.for_each_neighbour(i, [&](std::size_t n) { near_vessel[n] = 1; });
    } else if (kind[i] == VesselClass::kBone || kind[i] == VesselClass::kImplant) {
      moved[i] = 1;
      if (kind[i] != VesselClass::kImplant) front.push_back(static_cast<std::uint32_t>(i));
    }
  }
  for (int step = 0; step < kRimVoxels; ++step) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t i : front) {
      lattice.for_each_neighbour(i, [&](std::size_t n) {
        if (moved[n] != 0 || near_vessel[n] != 0) return;
        moved[n] = 1;
        next.push_back(static_cast<std::uint32_t>(n));
      });
    }
    front = std::move(next);
  }
  std::vector<std::int16_t> values(ct.hu().begin(), ct.hu().end());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = std::clamp(values[i], kAirHu, kHighestHu);
    if (kind[i] == VesselClass::kFragment && moved[i] == 0) {
      values[i] = std::min(values[i], static_cast<std::int16_t>(std::floor(window.zero_below)));
    }
    if (moved[i] != 0) values[i] = static_cast<std::int16_t>(values[i] + kSeparationHu);
  }
  std::vector<TransferComponent> components;
  for (const TransferComponent& component : transfer.components()) {
    const bool is_vessels = component.name == vessels;
    // A component without an end is denser than vessels, and all of it was moved.
    const bool endless = component.nodes.back().opacity > 0;
    if (is_vessels || !endless) components.push_back(component);
    if (is_vessels) continue;
    TransferComponent high = component;
    for (TransferNode& node : high.nodes) node.hu += kSeparationHu;
    if (high.nodes.front().opacity > 0) {
      TransferNode end = high.nodes.front();
      end.hu = std::min(end.hu - 1, kSeparationHu + 1.0 * kAirHu - 1);
      end.opacity = 0;
      high.nodes.insert(high.nodes.begin(), end);
    }
    components.push_back(std::move(high));
  }
  auto separated = TransferFunction::blend(transfer.name(), std::move(components));
  if (!separated) return separated.error();
  auto made = Volume::create(ct.grid(), std::move(values), ct.name());
  if (!made) return made.error();
  return SeparatedVessels{std::make_shared<const Volume>(*std::move(made)), *std::move(separated)};
}

}  // namespace nav::render
