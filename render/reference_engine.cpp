// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "render/engine.hpp"
#include "render/parallel.hpp"
#include "render/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {
namespace {

using Vec3 = spec::Vec3<double>;

/// Trilinear HU at an index, clamped to the box of voxel centres.
double value_at(const Volume& ct, const Vec3& index) {
  const auto& size = ct.grid().size;
  const std::span<const std::int16_t> hu = ct.hu();
  std::array<std::size_t, 3> low{};
  std::array<std::size_t, 3> high{};
  Vec3 w;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double x = std::clamp(index[axis], 0.0, static_cast<double>(size[a] - 1));
    const int i = std::min(static_cast<int>(x), std::max(size[a] - 2, 0));
    low[a] = static_cast<std::size_t>(i);
    high[a] = static_cast<std::size_t>(std::min(i + 1, size[a] - 1));
    w[axis] = x - i;
  }
  const auto row = [&](std::size_t j, std::size_t k) {
    const std::size_t start =
        (k * static_cast<std::size_t>(size[1]) + j) * static_cast<std::size_t>(size[0]);
    const double a = hu[start + low[0]];
    return a + w.x() * (hu[start + high[0]] - a);
  };
  const auto slice = [&](std::size_t k) {
    const double a = row(low[1], k);
    return a + w.y() * (row(high[1], k) - a);
  };
  const double a = slice(low[2]);
  return a + w.z() * (slice(high[2]) - a);
}

/// HU/mm along the CT axes.
Vec3 gradient_at(const Volume& ct, const Vec3& index) {
  const VoxelGrid& grid = ct.grid();
  Vec3 g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 one = Vec3::Unit(axis);
    const double last = grid.size[static_cast<std::size_t>(axis)] - 1;
    Vec3 centre = index;
    centre[axis] = std::clamp(centre[axis], 0.0, last);
    g[axis] =
        (value_at(ct, centre + one) - value_at(ct, centre - one)) / (2 * grid.spacing_mm[axis]);
  }
  return grid.directions * g;
}

struct Counts {
  std::uint64_t samples = 0;
  std::uint64_t gradients = 0;
};

/// Casts one ray at a time; keeps the state of the current one.
class Caster {
 public:
  Caster(const Scene& scene, const Surfaces& surfaces)
      : scene_(scene),
        surfaces_(surfaces),
        view_(spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid())),
        step_(spec::step_mm(scene.quality, scene.ct->grid())) {}

  RgbaF cast(int x, int y) {
    rgb_ = Vec3::Zero();
    alpha_ = 0;
    ray_ = spec::ray_of(view_, x, y);
    index_ = spec::index_ray(ray_, scene_.ct->grid());
    const spec::Interval<double> in = spec::clip_to_box(index_, scene_.ct->grid().size);
    surfaces_.meet(ray_, hits_);
    double begin = in.begin;
    for (const auto& hit : hits_) {
      march(begin, std::min(in.end, hit.t));
      blend(hit.rgb, hit.alpha);
      begin = std::max(in.begin, hit.t);
    }
    if (hits_.empty() || hits_.back().alpha < 1) march(begin, in.end);
    const Vec3 pixel = rgb_ + (1 - alpha_) * scene_.background_rgb;
    return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
            static_cast<float>(pixel.z()), 1.0F};
  }
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  void blend(const Vec3& rgb, double alpha) {
    const double weight = (1 - alpha_) * alpha;
    rgb_ += weight * rgb;
    alpha_ += weight;
  }

  void march(double begin, double end) {
    if (!(end > begin)) return;
    for (double k = std::floor(begin / step_); k * step_ < end; k += 1) {
      const double length = std::min((k + 1) * step_, end) - std::max(k * step_, begin);
      if (!(length > 0)) continue;
      const Vec3 index = index_.origin + (k + 0.5) * step_ * index_.direction;
      const TransferSample sample = scene_.transfer.at(value_at(*scene_.ct, index));
      ++counts_.samples;
      if (!(sample.tau_per_mm > 0)) continue;
      Vec3 rgb = sample.rgb;
      if (scene_.shading.enabled) {
        ++counts_.gradients;
        rgb = spec::shade_sample<double>(rgb, gradient_at(*scene_.ct, index), ray_.direction,
                                         scene_.shading);
      }
      blend(rgb, -std::expm1(-sample.tau_per_mm * length));
    }
  }

  const Scene& scene_;
  const Surfaces& surfaces_;
  spec::View<double> view_;
  double step_;
  spec::Ray<double> ray_;
  spec::Ray<double> index_;
  std::vector<spec::Hit<double>> hits_;
  Vec3 rgb_;
  double alpha_ = 0;
  Counts counts_;
};

class ReferenceEngine final : public Engine {
 public:
  explicit ReferenceEngine(const ReferenceOptions& options) : options_(options) {}
  [[nodiscard]] std::string name() const override { return "reference"; }
  [[nodiscard]] std::string device() const override { return "double precision, brute force"; }

  Result<RenderedImage> render(const Scene& scene) override {
    if (const auto ok = validate(scene); !ok) return ok.error();
    const auto start = std::chrono::steady_clock::now();
    const Surfaces surfaces(scene);
    const auto width = static_cast<std::size_t>(scene.width);
    std::vector<RgbaF> pixels(width * static_cast<std::size_t>(scene.height));
    std::atomic<std::uint64_t> samples{0};
    std::atomic<std::uint64_t> gradients{0};
    for_each_index(scene.height, options_.threads, [&](int y) {
      Caster caster(scene, surfaces);
      for (int x = 0; x < scene.width; ++x) {
        pixels[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] =
            caster.cast(x, y);
      }
      samples += caster.counts().samples;
      gradients += caster.counts().gradients;
    });
    RenderedImage image{{scene.width, scene.height, std::move(pixels)}, {}};
    image.statistics.rays = image.pixels.pixels().size();
    image.statistics.volume_samples = samples;
    image.statistics.gradient_samples = gradients;
    image.statistics.cast_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return image;
  }

 private:
  ReferenceOptions options_;
};

}  // namespace

std::unique_ptr<Engine> make_reference_engine(const ReferenceOptions& options) {
  return std::make_unique<ReferenceEngine>(options);
}

}  // namespace nav::render
