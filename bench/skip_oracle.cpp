// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/skip_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "render/parallel.hpp"
#include "render/skipping/brick_fold.hpp"
#include "render/spec/ray_spec_volume.hpp"
#include "render/transfer/transfer_table.hpp"

namespace nav::bench {
namespace {

using render::spec::Ray;

/// Tells which bricks of one edge length may show something.
class OracleBricks {
 public:
  OracleBricks(const StoredVolume& volume, const render::TransferTable& table, int edge,
               int threads)
      : edge_(edge) {
    using Limits = std::numeric_limits<std::int16_t>;
    std::vector<std::int16_t> low;
    std::vector<std::int16_t> high;
    count_ = render::fold_bricks(volume.values().data(), volume.grid().size, edge, threads,
                                 render::BrickFold{Limits::max(), render::kLeast, low},
                                 render::BrickFold{Limits::min(), render::kGreatest, high});
    shows_.resize(low.size());
    for (std::size_t b = 0; b < low.size(); ++b) {
      shows_[b] = static_cast<std::uint8_t>(table.visible(low[b], high[b]));
    }
  }
  [[nodiscard]] double occupied() const {
    const auto shows = std::count(shows_.begin(), shows_.end(), 1);
    return static_cast<double>(shows) / static_cast<double>(shows_.size());
  }
  /// index: voxel index within the volume.
  [[nodiscard]] bool show(const Eigen::Vector3d& index) const {
    const Eigen::Vector3i b = index.cast<int>() / edge_;
    return shows_[as_size((b.z() * count_.y() + b.y()) * count_.x() + b.x())] != 0;
  }

 private:
  int edge_;
  Eigen::Vector3i count_;
  std::vector<std::uint8_t> shows_;
};

/// Counts the samples at the ends of the cells that are added in order.
class OracleCount {
 public:
  void add(bool taken) {
    samples_ += taken ? (before_ ? 1 : 2) : 0;
    before_ = taken;
  }
  [[nodiscard]] std::uint64_t samples() const { return samples_; }

 private:
  std::uint64_t samples_ = 0;
  bool before_ = false;
};

class OracleMarch {
 public:
  OracleMarch(const render::Scene& scene, int threads)
      : scene_(scene),
        table_(scene.transfer),
        step_mm_(render::spec::step_mm(scene.quality, scene.ct->grid())),
        view_(render::spec::make_view<double>(scene.camera, scene.width, scene.height,
                                              scene.ct->grid())) {
    NAV_CHECK(table_.rows() == 1);
    for (const BrickOracle& one : SkipOracle{}.bricks) {
      bricks_.emplace_back(*scene.ct, table_, one.edge, threads);
    }
  }

  void shares(SkipOracle& found) const {
    for (std::size_t i = 0; i < bricks_.size(); ++i)
      found.bricks[i].occupied = bricks_[i].occupied();
  }

  void follow(int x, int y, SkipOracle& found) const {
    const VoxelGrid& grid = scene_.ct->grid();
    const Ray<double> ray = render::spec::index_ray(render::spec::ray_of(view_, x, y), grid);
    const auto in = render::spec::clip_to_box(ray, grid.size);
    if (!(in.end > in.begin)) return;
    const Eigen::Vector3d last(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
    const auto place = [&](double cell) -> Eigen::Vector3d {
      return (ray.origin + cell * step_mm_ * ray.direction).cwiseMax(0.0).cwiseMin(last);
    };
    OracleCount all;
    OracleCount showing;
    OracleCount front;
    std::array<OracleCount, SkipOracle{}.bricks.size()> left;
    double through = 1;
    Eigen::Vector3d a = place(std::floor(in.begin / step_mm_));
    double value = render::spec::value_at(*scene_.ct, a);
    for (double cell = std::floor(in.begin / step_mm_); cell * step_mm_ < in.end; ++cell) {
      const Eigen::Vector3d b = place(cell + 1);
      const double next = render::spec::value_at(*scene_.ct, b);
      all.add(true);
      const bool reached = 1 - through < scene_.quality.opaque_at;
      front.add(reached);
      if (reached) {
        const double tau = table_.mean(value, next).tau_per_mm;
        through *= std::exp(-tau * step_mm_);
        showing.add(tau > 0);
        for (std::size_t i = 0; i < left.size(); ++i) {
          left[i].add(bricks_[i].show(a) || bricks_[i].show(b));
        }
      }
      a = b;
      value = next;
    }
    found.all += all.samples();
    found.opaque += all.samples() - front.samples();
    found.showing += showing.samples();
    for (std::size_t i = 0; i < left.size(); ++i) found.bricks[i].samples += left[i].samples();
  }

 private:
  const render::Scene& scene_;
  render::TransferTable table_;
  double step_mm_;
  render::spec::View<double> view_;
  std::vector<OracleBricks> bricks_;
};

}  // namespace

SkipOracle skip_oracle(const render::Scene& scene, int threads) {
  const OracleMarch march(scene, threads);
  std::vector<SkipOracle> rows(as_size(scene.height));
  render::for_each_index(scene.height, threads, [&](int y) {
    for (int x = 0; x < scene.width; ++x) march.follow(x, y, rows[as_size(y)]);
  });
  SkipOracle found;
  march.shares(found);
  for (const SkipOracle& row : rows) {
    found.all += row.all;
    found.opaque += row.opaque;
    found.showing += row.showing;
    for (std::size_t i = 0; i < row.bricks.size(); ++i) {
      found.bricks[i].samples += row.bricks[i].samples;
    }
  }
  return found;
}

}  // namespace nav::bench
