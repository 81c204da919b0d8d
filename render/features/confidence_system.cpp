// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "nav/index.hpp"
#include "render/features/confidence.hpp"
#include "render/features/graph_rows.hpp"

namespace nav::render::features {
namespace {

enum Kind : std::uint8_t { kNothing, kOpen, kSource, kSink };

/// Least and greatest depth of the known voxels, mm.
struct DepthRange {
  double least = INFINITY;
  double greatest = -INFINITY;
};

/// A voxel whose value is fixed.
struct Fixed {
  std::size_t node;
  int j, k;
  Kind kind;
};

/// Builds the system step by step, on the graph's layout.
class Assembly {
 public:
  Assembly(const ScalarVolume& volume, const ScanLines& lines, const ConfidenceOptions& options,
           const RunOptions& run)
      : volume_(volume),
        grid_(volume.grid()),
        lines_(lines),
        options_(options),
        run_(run),
        layout_(grid_.size),
        attenuated_(layout_.cells()),
        kind_(layout_.cells()) {
    const double smallest = grid_.spacing_mm.minCoeff();
    for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
      const auto& s = kEdgeSteps[e];
      const Eigen::Vector3d along =
          grid_.directions * grid_.spacing_mm.cwiseProduct(Eigen::Vector3d(s[0], s[1], s[2]));
      edge_[e] = along / smallest;
    }
  }

  /// Computes the attenuated intensities. False when no voxel is known or a stop was requested.
  bool attenuate() {
    if (run_.stop.stop_requested()) return false;
    forget_values();
    const ValueRange range = value_range(volume_, 0, 1, run_.threads);
    depth_ = depth_range();
    if (range.known == 0 || !(depth_.least <= depth_.greatest)) return false;
    const double width = range.greatest - range.least;
    const double per_value = width > 0 ? 1 / width : 0;
    for_each_row([&](int j, int k, Row& row) {
      const std::size_t first = layout_.at(0, j, k);
      for (std::size_t i = 0; i < row.value.size(); ++i) {
        // A voxel without a scan line is treated as unknown, like one without a value.
        if (std::isnan(row.value[i]) || std::isnan(row.depth[i])) {
          all_known_ = false;
          continue;
        }
        const double g = (static_cast<double>(row.value[i]) - range.least) * per_value;
        attenuated_[first + i] =
            static_cast<float>(-g * std::expm1(-options_.alpha * share_of_depth(row.depth[i])));
        kind_[first + i] = kOpen;
      }
    });
    return true;
  }

  void fix_ends() {
    std::vector<std::vector<Fixed>> planes(as_size(grid_.size[2]));
    const auto common = lines_.common();
    const Eigen::Vector3d common_step = common ? step_along(*common) : Eigen::Vector3d::Zero();
    const std::ptrdiff_t neighbour = common ? neighbour_along(common_step) : 0;
    for_each_plane(grid_.size[2], run_, [&](int k) {
      for (int j = 0; j < grid_.size[1]; ++j) {
        for (int i = 0; i < grid_.size[0]; ++i) {
          const std::size_t node = layout_.at(i, j, k);
          if (kind_[node] == kNothing) continue;
          if (neighbour != 0 && kind_[node + static_cast<std::size_t>(neighbour)] != kNothing &&
              kind_[node - static_cast<std::size_t>(neighbour)] != kNothing) {
            continue;
          }
          const Eigen::Vector3d step =
              common ? common_step : step_along(lines_.away(grid_, i, j, k));
          if (leads_out(i, j, k, -step, lines_.before_mm(grid_, i, j, k))) {
            planes[as_size(k)].push_back({node, j, k, kSource});
          } else if (leads_out(i, j, k, step, INFINITY)) {
            planes[as_size(k)].push_back({node, j, k, kSink});
          }
        }
      }
    });
    for (const auto& plane : planes) fixed_.insert(fixed_.end(), plane.begin(), plane.end());
    for (const Fixed& fixed : fixed_) kind_[fixed.node] = fixed.kind;
  }

  void weigh() {
    const double largest = largest_difference();
    difference_ = largest > 0 ? largest : 1;
    // Instead of dividing every difference by D, the penalties are multiplied by D and beta is
    // divided by D.
    const double beta = options_.beta / ((1 + options_.gamma) * difference_);
    const EdgeConstants constants{static_cast<float>(beta), 1e-5F};
    if (const auto common = lines_.common()) {
      EdgeRule rule{std::move(attenuated_), {}, constants};
      for (int e = 0; e < kGraphEdges; ++e) {
        rule.penalties[as_size(e)] = static_cast<float>(penalty(e, *common));
      }
      graph_.emplace(grid_.size, std::move(rule));
      return;
    }
    graph_.emplace(grid_.size);
    const auto directions = directions_of_nodes();
    const auto from = [&](std::size_t node) {
      return std::array<const float*, 3>{&directions[0][node], &directions[1][node],
                                         &directions[2][node]};
    };
    for_each_plane(grid_.size[2], run_, [&](int k) {
      std::vector<float> penalty(as_size(layout_.row_length()));
      for (int j = 0; j < grid_.size[1]; ++j) {
        const std::size_t here = layout_.at(0, j, k);
        for (int e = 0; e < kGraphEdges; ++e) {
          const std::size_t there = here + static_cast<std::size_t>(layout_.offset(e));
          const Eigen::Vector3f edge = edge_[as_size(e)].cast<float>();
          kernels().edge_penalties(from(here).data(), from(there).data(), edge.data(),
                                   static_cast<float>(options_.gamma * difference_), penalty.data(),
                                   layout_.row_length());
          kernels().edge_weights(&attenuated_[here], &attenuated_[there], penalty.data(), constants,
                                 &graph_->kept(e)[here], layout_.row_length());
        }
      }
    });
    attenuated_ = {};
  }

  /// Moves the edges to fixed voxels into the leaks and the right-hand side of the open voxels.
  FewRows eliminate() {
    FewRows b(layout_);
    for (const Fixed& fixed : fixed_) {
      for (int e = 0; e < kGraphEdges; ++e) {
        const auto offset = static_cast<std::size_t>(layout_.offset(e));
        for (const int sign : {1, -1}) {
          const std::size_t other = sign == 1 ? fixed.node + offset : fixed.node - offset;
          if (kind_[other] != kOpen) continue;
          const float weight = graph_->weight(e, sign == 1 ? fixed.node : other);
          const auto& s = kEdgeSteps[as_size(e)];
          const int j = fixed.j + sign * s[1], k = fixed.k + sign * s[2];
          const std::size_t i = other - layout_.at(0, j, k);
          graph_->leak.writable(j, k)[i] += weight;
          if (fixed.kind == kSource) b.writable(j, k)[i] += weight;
        }
      }
    }
    for (const Fixed& fixed : fixed_) graph_->isolate(fixed.node);
    return b;
  }

  /// Open voxels that are not connected to a fixed voxel lose their edges and become unknown.
  void drop_islands() {
    if (all_known_) return;  // All voxels are connected, and at least one is the first of a line.
    std::vector<std::size_t> queue;
    std::vector<bool> reached(layout_.cells());
    for (const Fixed& fixed : fixed_) {
      queue.push_back(fixed.node);
      reached[fixed.node] = true;
    }
    while (!queue.empty() && !run_.stop.stop_requested()) {
      const std::size_t node = queue.back();
      queue.pop_back();
      for (int e = 0; e < kGraphEdges; ++e) {
        // No edge between known voxels has the weight 0.
        const auto step = static_cast<std::size_t>(layout_.offset(e));
        for (const std::size_t other : {node + step, node - step}) {
          if (kind_[other] != kOpen || reached[other]) continue;
          reached[other] = true;
          queue.push_back(other);
        }
      }
    }
    for (std::size_t node = 0; node < layout_.cells(); ++node) {
      if (kind_[node] != kOpen || reached[node]) continue;
      kind_[node] = kNothing;
      graph_->isolate(node);
    }
  }

  ConfidenceSystem finish(FewRows b) {
    ZeroedArray<double> x(layout_.cells());
    for_each_row([&](int j, int k, Row& row) {
      const std::size_t first = layout_.at(0, j, k);
      for (std::size_t i = 0; i < row.depth.size(); ++i) {
        const Kind kind = kind_[first + i];
        x[first + i] = kind == kSource    ? 1
                       : kind == kSink    ? 0
                       : kind == kNothing ? std::nan("")
                                          : 1 - share_of_depth(row.depth[i]);
      }
    });
    return {std::move(*graph_), std::move(b), std::move(x)};
  }

 private:
  void forget_values() {
    constexpr std::size_t kPart = 1 << 18;
    const std::size_t parts = (attenuated_.size() - 1) / kPart + 1;
    for_each_plane(static_cast<int>(parts), run_, [&](int part) {
      const std::size_t first = as_size(part) * kPart;
      std::fill_n(&attenuated_[first], std::min(kPart, attenuated_.size() - first), kUnknown);
    });
  }
  /// Values and depths of a row; NaN at unknown voxels.
  struct Row {
    std::vector<float> value;
    std::vector<double> depth;
  };
  template <class Visit>
  void for_each_row(const Visit& visit) const {
    const auto count = as_size(grid_.size[0]);
    const auto common = lines_.common();
    const double per_voxel =
        common ? common->dot(grid_.directions.col(0)) * grid_.spacing_mm.x() : 0;
    for_each_plane(grid_.size[2], run_, [&](int k) {
      Row row{std::vector<float>(count), std::vector<double>(count)};
      for (int j = 0; j < grid_.size[1]; ++j) {
        volume_.read_row(j, k, row.value.data());
        const double start = lines_.depth_mm(grid_, 0, j, k);
        for (int i = 0; i < grid_.size[0]; ++i) {
          row.depth[as_size(i)] = common ? start + i * per_voxel : line_depth(i, j, k);
        }
        visit(j, k, row);
      }
    });
  }
  /// Depth of a voxel along its line, mm. NaN also if there is a depth but no direction.
  [[nodiscard]] double line_depth(int i, int j, int k) const {
    const bool has_line = lines_.away(grid_, i, j, k).allFinite();
    return has_line ? lines_.depth_mm(grid_, i, j, k) : std::nan("");
  }
  [[nodiscard]] double share_of_depth(double depth) const {
    const double span = depth_.greatest - depth_.least;
    return span > 0 ? (depth - depth_.least) / span : 0;
  }
  DepthRange depth_range() const {
    std::vector<DepthRange> planes(as_size(grid_.size[2]));
    for_each_row([&](int, int k, Row& row) {
      DepthRange& plane = planes[as_size(k)];
      for (std::size_t i = 0; i < row.depth.size(); ++i) {
        if (std::isnan(row.depth[i]) || std::isnan(row.value[i])) continue;
        plane.least = std::min(plane.least, row.depth[i]);
        plane.greatest = std::max(plane.greatest, row.depth[i]);
      }
    });
    DepthRange all;
    for (const DepthRange& plane : planes) {
      all.least = std::min(all.least, plane.least);
      all.greatest = std::max(all.greatest, plane.greatest);
    }
    return all;
  }
  /// Step of one voxel along the axis that the line follows most closely, in voxel indices.
  [[nodiscard]] Eigen::Vector3d step_along(const Eigen::Vector3d& away) const {
    const Eigen::Vector3d step =
        (grid_.directions.transpose() * away).cwiseQuotient(grid_.spacing_mm);
    return step / step.cwiseAbs().maxCoeff();
  }
  /// Offset to the next voxel of leads_out(). 0 if that voxel depends on the position, because
  /// halves are rounded away from 0. The border of the graph is unknown, so the result may also
  /// lead there.
  [[nodiscard]] std::ptrdiff_t neighbour_along(const Eigen::Vector3d& step) const {
    if ((step.array().abs() == 0.5).any()) return 0;
    return std::lround(step.x()) + std::lround(step.y()) * layout_.offset(1) +
           std::lround(step.z()) * layout_.offset(2);
  }
  /// True when no known voxel lies on the way out of the volume or to the end of the line.
  bool leads_out(int i, int j, int k, const Eigen::Vector3d& step, double length_mm) const {
    const double step_mm = step.cwiseProduct(grid_.spacing_mm).norm();
    Eigen::Vector3d p(i, j, k);
    for (int steps = 1; steps * step_mm <= length_mm; ++steps) {
      p += step;
      const int x = static_cast<int>(std::lround(p.x()));
      const int y = static_cast<int>(std::lround(p.y()));
      const int z = static_cast<int>(std::lround(p.z()));
      const bool inside =
          x >= 0 && y >= 0 && z >= 0 && x < grid_.size[0] && y < grid_.size[1] && z < grid_.size[2];
      if (!inside) return true;
      if (kind_[layout_.at(x, y, z)] != kNothing) return false;
    }
    return true;
  }
  /// Largest difference of attenuated intensities between the two ends of an edge.
  [[nodiscard]] double largest_difference() const {
    std::vector<float> planes(as_size(grid_.size[2]));
    for_each_plane(grid_.size[2], run_, [&](int k) {
      float largest = 0;
      for (int j = 0; j < grid_.size[1]; ++j) {
        const float* here = &attenuated_[layout_.at(0, j, k)];
        for (int e = 0; e < kGraphEdges; ++e) {
          const float* there = here + layout_.offset(e);
          for (int i = 0; i < grid_.size[0]; ++i) {
            const float apart = std::abs(here[i] - there[i]);
            largest = apart > largest ? apart : largest;  // Never NaN: such comparisons are false.
          }
        }
      }
      planes[as_size(k)] = largest;
    });
    return static_cast<double>(*std::ranges::max_element(planes));
  }
  [[nodiscard]] double penalty(int e, const Eigen::Vector3d& along_line) const {
    return options_.gamma * edge_[as_size(e)].cross(along_line).norm() * difference_;
  }
  /// Directions away from the transducer, by node; 0 outside the voxels.
  std::array<ZeroedArray<float>, 3> directions_of_nodes() const {
    std::array<ZeroedArray<float>, 3> out;
    for (auto& component : out) component = ZeroedArray<float>(layout_.cells());
    for_each_plane(grid_.size[2], run_, [&](int k) {
      for (int j = 0; j < grid_.size[1]; ++j) {
        for (int i = 0; i < grid_.size[0]; ++i) {
          const Eigen::Vector3f away = lines_.away(grid_, i, j, k).cast<float>();
          for (std::size_t a = 0; a < 3; ++a) {
            out[a][layout_.at(i, j, k)] = away[static_cast<Eigen::Index>(a)];
          }
        }
      }
    });
    return out;
  }

  const ScalarVolume& volume_;
  const VoxelGrid& grid_;
  const ScanLines& lines_;
  const ConfidenceOptions& options_;
  const RunOptions& run_;
  GraphLayout layout_;
  ZeroedArray<float> attenuated_;  ///< c; NaN at unknown voxels and at the border. Freed by
                                   ///< weigh().
  ZeroedArray<Kind> kind_;
  std::vector<Fixed> fixed_;
  std::optional<GridGraph> graph_;
  std::atomic<bool> all_known_ = true;
  std::array<Eigen::Vector3d, kGraphEdges> edge_;  ///< Vectors of the edges, in units of the
                                                   ///< smallest spacing.
  double difference_ = 1;                          ///< D, the largest difference of neighbours.
  DepthRange depth_;
};

}  // namespace

Result<ConfidenceSystem> confidence_system(const ScalarVolume& volume, const ScanLines& lines,
                                           const ConfidenceOptions& options,
                                           const RunOptions& run) {
  const std::string name = volume.name() + ": confidence";
  if (auto ok = lines.check(volume.grid(), name); !ok) return ok.error();
  Assembly assembly(volume, lines, options, run);
  const bool any = assembly.attenuate();
  if (run.stop.stop_requested()) return cancelled(name);
  if (!any) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected known voxels with a scan line, found none"};
  }
  assembly.fix_ends();
  assembly.weigh();
  if (run.stop.stop_requested()) return cancelled(name);
  FewRows b = assembly.eliminate();
  assembly.drop_islands();
  auto system = assembly.finish(std::move(b));
  if (run.stop.stop_requested()) return cancelled(name);
  return system;
}

}  // namespace nav::render::features
