// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/structure_distances.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "nav/check.hpp"

namespace nav::session {
namespace {

/// Squared distance in place of infinity, mm²: sums of it stay finite.
constexpr float kNoSite = 1e12F;

/// Lower envelope of parabolas of one line: f(q) becomes the least f(p) + (h (q - p))².
class LineTransform {
 public:
  void run(std::vector<float>& values, double spacing_mm) {
    const auto count = static_cast<int>(values.size());
    sites_.assign(values.size(), 0);
    bounds_.assign(values.size() + 1, 0);
    const double square = spacing_mm * spacing_mm;
    const auto value = [&](int i) {
      return static_cast<double>(values[static_cast<std::size_t>(i)]);
    };
    const auto cut = [&](int p, int q) {
      return ((value(q) + square * q * q) - (value(p) + square * p * p)) / (2 * square * (q - p));
    };
    int last = 0;
    bounds_[0] = -std::numeric_limits<double>::infinity();
    bounds_[1] = std::numeric_limits<double>::infinity();
    for (int q = 1; q < count; ++q) {
      double at = cut(sites_[index(last)], q);
      while (at <= bounds_[index(last)]) at = cut(sites_[index(--last)], q);
      ++last;
      sites_[index(last)] = q;
      bounds_[index(last)] = at;
      bounds_[index(last) + 1] = std::numeric_limits<double>::infinity();
    }
    result_.resize(values.size());
    int site = 0;
    for (int q = 0; q < count; ++q) {
      while (bounds_[index(site) + 1] < q) ++site;
      const int p = sites_[index(site)];
      result_[index(q)] = static_cast<float>(value(p) + square * (q - p) * (q - p));
    }
    values = result_;
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  std::vector<int> sites_;
  std::vector<double> bounds_;
  std::vector<float> result_;
};

/// Squared distances from the voxels with zero, in place.
void transform(std::vector<float>& field, const VoxelGrid& grid) {
  LineTransform line;
  std::vector<float> values;
  const std::array<std::size_t, 3> size{static_cast<std::size_t>(grid.size[0]),
                                        static_cast<std::size_t>(grid.size[1]),
                                        static_cast<std::size_t>(grid.size[2])};
  const std::array<std::size_t, 3> step{1, size[0], size[0] * size[1]};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    values.resize(size[axis]);
    for (std::size_t j = 0; j < size[v]; ++j) {
      for (std::size_t i = 0; i < size[u]; ++i) {
        const std::size_t first = i * step[u] + j * step[v];
        for (std::size_t k = 0; k < size[axis]; ++k) values[k] = field[first + k * step[axis]];
        line.run(values, grid.spacing_mm[static_cast<Eigen::Index>(axis)]);
        for (std::size_t k = 0; k < size[axis]; ++k) field[first + k * step[axis]] = values[k];
      }
    }
  }
}

/// Part of the CT's grid around the path; absent: the path is nowhere near the CT.
std::optional<std::pair<std::array<int, 3>, VoxelGrid>> box_around(const NeedlePlan& plan,
                                                                   const VoxelGrid& grid) {
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d high = -low;
  for (const auto& point : {plan.entry_ct, plan.target_ct}) {
    const Eigen::Array3d at = grid.index_of(point).array();
    const Eigen::Array3d reach = kFarthestClearanceMm / grid.spacing_mm.array();
    low = low.min(at - reach);
    high = high.max(at + reach);
  }
  std::array<int, 3> first{};
  VoxelGrid box = grid;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double most = grid.size[i] - 1;
    if (high[axis] < 0 || low[axis] > most) return std::nullopt;
    first[i] = static_cast<int>(std::clamp(std::floor(low[axis]), 0.0, most));
    const int last = static_cast<int>(std::clamp(std::ceil(high[axis]), 0.0, most));
    box.size[i] = last - first[i] + 1;
  }
  box.origin_mm = grid.at(Eigen::Vector3d(first[0], first[1], first[2])).mm;
  return std::pair(first, box);
}

}  // namespace

StructureDistances StructureDistances::create(const NeedlePlan& plan,
                                              const std::vector<CriticalStructure>& structures,
                                              const Volume& ct) {
  StructureDistances made;
  const auto box = box_around(plan, ct.grid());
  for (const CriticalStructure& one : structures) {
    std::shared_ptr<const Field> kept;
    if (one.values && box) {
      const auto& [first, grid] = *box;
      std::vector<float> outside, inside;
      outside.reserve(grid.voxel_count());
      inside.reserve(grid.voxel_count());
      for (int k = 0; k < grid.size[2]; ++k) {
        for (int j = 0; j < grid.size[1]; ++j) {
          for (int i = 0; i < grid.size[0]; ++i) {
            const double hu = ct.at(first[0] + i, first[1] + j, first[2] + k);
            const bool in = hu >= one.values->low_hu && hu <= one.values->high_hu;
            outside.push_back(in ? 0 : kNoSite);
            inside.push_back(in ? kNoSite : 0);
          }
        }
      }
      transform(outside, grid);
      transform(inside, grid);
      const auto half = static_cast<float>(0.5 * grid.spacing_mm.maxCoeff());
      for (std::size_t i = 0; i < outside.size(); ++i) {
        outside[i] = outside[i] > 0 ? std::sqrt(outside[i]) - half : half - std::sqrt(inside[i]);
      }
      auto field = Field::create(grid, std::move(outside), one.name);
      NAV_CHECK(field.has_value(), grid.size[0], grid.size[1], grid.size[2]);
      kept = std::make_shared<const Field>(*std::move(field));
    }
    made.all_.push_back({one, std::move(kept)});
  }
  return made;
}

NearestStructure StructureDistances::nearest(const Point<frames::Ct>& point) const {
  using State = NearestStructure::State;
  NearestStructure found;
  if (all_.empty()) return found;
  found.state = State::kFar;
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [structure, field] : all_) {
    std::optional<double> distance;
    if (structure.sphere) {
      distance = (point.mm - structure.sphere->centre_ct.mm).norm() - structure.sphere->radius_mm;
    } else if (field) {
      distance = field->sample(point);
    }
    // Voxels beyond the box may be nearer than a far one in it.
    const bool is_far = field && distance && *distance > kFarthestClearanceMm;
    const bool may_be_near = is_far && structure.clearance_mm > kFarthestClearanceMm;
    // One that is not known may be the nearest.
    if (!distance || may_be_near) return {.state = State::kUnknown};
    if (is_far) continue;
    if (found.too_near.empty() && *distance < structure.clearance_mm) {
      found.too_near = structure.name;
    }
    if (*distance >= best) continue;
    best = *distance;
    found.state = State::kKnown;
    found.distance_mm = *distance;
    found.name = structure.name;
  }
  return found;
}

}  // namespace nav::session
