// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/slices/slice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "nav/positions.hpp"
#include "render/parallel.hpp"
#include "render/spec/ray_spec_volume.hpp"

namespace nav::render {
namespace {

using Vec3 = Eigen::Vector3d;
constexpr float kOutside = std::numeric_limits<float>::quiet_NaN();
constexpr double kRounding = 5e-7;  // Rounding of positions, in pixels or voxels.

/// Trilinear values along a line of index space, for positions inside the box.
class Sampler {
 public:
  explicit Sampler(const StoredVolume& ct) : hu_(ct.values().data()) {
    const auto& size = ct.grid().size;
    for (std::size_t a = 0; a < 3; ++a) {
      last_[a] = static_cast<float>(size[a] - 1);
      cell_[a] = std::max(size[a] - 2, 0);
    }
    // An axis of one voxel has no second voxel, so its neighbour is itself.
    step_[0] = size[0] > 1 ? 1 : 0;
    row_ = size[0];
    slice_ = std::ptrdiff_t{size[0]} * size[1];
    step_[1] = size[1] > 1 ? row_ : 0;
    step_[2] = size[2] > 1 ? slice_ : 0;
  }

  [[nodiscard]] float at(float x, float y, float z) const {
    x = std::clamp(x, 0.0F, last_[0]);
    y = std::clamp(y, 0.0F, last_[1]);
    z = std::clamp(z, 0.0F, last_[2]);
    const int i = std::min(static_cast<int>(x), cell_[0]);
    const int j = std::min(static_cast<int>(y), cell_[1]);
    const int k = std::min(static_cast<int>(z), cell_[2]);
    const std::int16_t* p = hu_ + k * slice_ + j * row_ + i;
    const float u = x - static_cast<float>(i);
    const float v = y - static_cast<float>(j);
    const float near = face(p, u, v);
    return near + (z - static_cast<float>(k)) * (face(p + step_[2], u, v) - near);
  }

 private:
  [[nodiscard]] float edge(const std::int16_t* p, float u) const {
    const auto a = static_cast<float>(p[0]);
    return a + u * (static_cast<float>(p[step_[0]]) - a);
  }
  [[nodiscard]] float face(const std::int16_t* p, float u, float v) const {
    const float a = edge(p, u);
    return a + v * (edge(p + step_[1], u) - a);
  }
  const std::int16_t* hu_;
  std::array<float, 3> last_{};
  std::array<int, 3> cell_{};
  std::array<std::ptrdiff_t, 3> step_{};
  std::ptrdiff_t row_;
  std::ptrdiff_t slice_;
};

/// The columns [begin, end) of a row of pixels that lie inside the CT's box.
struct Columns {
  int begin;
  int end;
};

Columns columns_inside(const Vec3& first, const Vec3& step, const std::array<int, 3>& size,
                       int width) {
  double begin = 0;
  double end = width - 1;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = size[static_cast<std::size_t>(axis)];
    const double low = (n > 1 ? 0 : -0.5) - first[axis];
    const double high = (n > 1 ? n - 1 : 0.5) - first[axis];
    const double d = step[axis];
    // Steps this small do not cross the box within any image.
    constexpr double kNoStep = 1e-12;
    if (std::abs(d) < kNoStep) {
      if (low > kRounding || high < -kRounding) return {0, 0};
      continue;
    }
    begin = std::max(begin, std::min(low / d, high / d));
    end = std::min(end, std::max(low / d, high / d));
  }
  // Pixel centres on a face belong to the box, even if they round to the outside.
  if (!(end >= begin - kRounding)) return {0, 0};
  return {static_cast<int>(std::ceil(begin - kRounding)),
          std::min(static_cast<int>(std::floor(end + kRounding)) + 1, width)};
}

/// The index of a pixel centre is origin + column · right + row · down + depth_mm · across.
struct Lattice {
  Vec3 origin;
  Vec3 right;
  Vec3 down;
  Vec3 across;
};

Lattice lattice_of(const VoxelGrid& grid, const SlicePlane& plane, const SliceOptions& options) {
  const auto turned = [&](const Vec3& v) -> Vec3 {
    return (grid.directions.transpose() * v).cwiseQuotient(grid.spacing_mm);
  };
  const Vec3 right = turned(plane.right.v) * options.mm_per_pixel;
  const Vec3 down = turned(plane.down.v) * options.mm_per_pixel;
  const Vec3 centre = grid.index_of(plane.centre_ct);
  const double half_width = 0.5 * (options.width - 1);
  const double half_height = 0.5 * (options.height - 1);
  return {centre - half_width * right - half_height * down, right, down,
          turned(plane.right.v.cross(plane.down.v))};
}

void thin_row(const Sampler& sampler, const Vec3& first, const Vec3& step, const Columns& columns,
              float* row) {
  for (int x = columns.begin; x < columns.end; ++x) {
    // In double, index · column stays exact for the largest images.
    const Vec3 p = first + x * step;
    row[x] =
        sampler.at(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
}

/// A layer of a slab: its distance across from the slice's middle, and the thickness that it stands
/// for, mm.
struct Layer {
  double depth_mm;
  double weight;
};

/// Adds weights of the trapezoidal rule: means are exact if values are linear between layers.
std::vector<Layer> weighted(const std::vector<double>& depths_mm) {
  if (depths_mm.size() == 1) return {{depths_mm.front(), 1}};
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < depths_mm.size(); ++i) {
    const double before = depths_mm[i == 0 ? 0 : i - 1];
    const double after = depths_mm[std::min(i + 1, depths_mm.size() - 1)];
    layers.push_back({depths_mm[i], 0.5 * std::abs(after - before)});
  }
  return layers;
}

/// Layers of a slice along voxel planes: the voxel planes, and the ends of the slab or of the CT's
/// box. index: position of the slice's middle along the axis. per_mm: growth of the index across.
std::vector<Layer> along_planes(double index, double per_mm, double slab_mm, int size) {
  const double reach = 0.5 * slab_mm * std::abs(per_mm);
  const double low = std::max(index - reach, size > 1 ? 0 : -0.5);
  const double high = std::min(index + reach, size > 1 ? size - 1 : 0.5);
  if (low > high + kRounding) return {};
  std::vector<double> places{low};
  for (double k = std::floor(low + kRounding) + 1; k < high - kRounding; ++k) places.push_back(k);
  if (high > low + kRounding) places.push_back(high);
  for (double& place : places) place = (place - index) / per_mm;
  return weighted(places);
}

std::vector<Layer> layers_of(const VoxelGrid& grid, const Lattice& lattice, const Vec3& centre,
                             double slab_mm) {
  if (slab_mm == 0) return {{0, 1}};
  int axis = 0;
  lattice.across.cwiseAbs().maxCoeff(&axis);
  Vec3 aside = lattice.across.cwiseProduct(grid.spacing_mm);
  aside[axis] = 0;
  constexpr double kAlong = 1e-6;  // rad: no thousandth of a voxel over a CT.
  if (aside.norm() < kAlong) {
    return along_planes(centre[axis], lattice.across[axis], slab_mm,
                        grid.size[static_cast<std::size_t>(axis)]);
  }
  const double most_mm = 0.5 * grid.spacing_mm.minCoeff();
  const int parts = std::max(1, static_cast<int>(std::ceil(slab_mm / most_mm)));
  std::vector<double> depths_mm;
  for (int i = 0; i <= parts; ++i) {
    depths_mm.push_back((static_cast<double>(i) / parts - 0.5) * slab_mm);
  }
  return weighted(depths_mm);
}

void combine(SlabMode mode, const std::vector<float>& layer, float weight, const Columns& columns,
             float* row, std::vector<float>& weights) {
  for (int x = columns.begin; x < columns.end; ++x) {
    const auto i = static_cast<std::size_t>(x);
    const float v = mode == SlabMode::kMean ? weight * layer[i] : layer[i];
    if (weights[i] == 0) {
      row[i] = v;
    } else if (mode == SlabMode::kMean) {
      row[i] += v;
    } else {
      row[i] = mode == SlabMode::kMaximum ? std::max(row[i], v) : std::min(row[i], v);
    }
    weights[i] += weight;
  }
}

Error slice_refusal(const std::string& field, const std::string& expected, double found) {
  std::ostringstream text;
  text << "slice: " << field << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

}  // namespace

Result<void> validate(const SlicePlane& plane, const SliceOptions& options) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!within(options.width, 1, 16384)) return slice_refusal("width", "1 to 16384", options.width);
  if (!within(options.height, 1, 16384))
    return slice_refusal("height", "1 to 16384", options.height);
  if (!(options.mm_per_pixel > 0 && options.mm_per_pixel <= 100)) {
    return slice_refusal("mm_per_pixel", "a number in (0, 100]", options.mm_per_pixel);
  }
  if (!within(options.slab_mm, 0, 1000))
    return slice_refusal("slab_mm", "0 to 1000", options.slab_mm);
  if (!plane.centre_ct.mm.allFinite() || plane.centre_ct.mm.norm() > kFurthestMm) {
    return slice_refusal("centre_ct", "a point within 1e7 mm", plane.centre_ct.mm.norm());
  }
  constexpr double kTolerance = 1e-6;
  for (const Vec3& axis : {plane.right.v, plane.down.v}) {
    if (!(std::abs(axis.norm() - 1) < kTolerance)) {
      return slice_refusal("right, down", "unit vectors", axis.norm());
    }
  }
  const double cosine = plane.right.v.dot(plane.down.v);
  if (!(std::abs(cosine) < kTolerance))
    return slice_refusal("right, down", "a right angle", cosine);
  return {};
}

Result<Image2d<float>> slice_values(const StoredVolume& ct, const SlicePlane& plane,
                                    const SliceOptions& options) {
  if (const auto ok = validate(plane, options); !ok) return ok.error();
  const VoxelGrid& grid = ct.grid();
  const Lattice lattice = lattice_of(grid, plane, options);
  const Sampler sampler(ct);
  const auto layers = layers_of(grid, lattice, grid.index_of(plane.centre_ct), options.slab_mm);
  const auto width = static_cast<std::size_t>(options.width);
  std::vector<float> values(width * static_cast<std::size_t>(options.height), kOutside);
  for_each_index(options.height, options.threads, [&](int y) {
    float* row = values.data() + static_cast<std::size_t>(y) * width;
    const Vec3 first = lattice.origin + y * lattice.down;
    const auto sample = [&](const Layer& one, float* into) {
      const Vec3 from = first + one.depth_mm * lattice.across;
      const Columns columns = columns_inside(from, lattice.right, grid.size, options.width);
      thin_row(sampler, from, lattice.right, columns, into);
      return columns;
    };
    if (layers.size() == 1) {
      sample(layers.front(), row);
      return;
    }
    std::vector<float> layer(width);
    std::vector<float> weights(width, 0);
    for (const Layer& one : layers) {
      const Columns columns = sample(one, layer.data());
      combine(options.slab, layer, static_cast<float>(one.weight), columns, row, weights);
    }
    if (options.slab != SlabMode::kMean) return;
    for (std::size_t x = 0; x < width; ++x) {
      if (weights[x] > 0) row[x] /= weights[x];
    }
  });
  return Image2d<float>(options.width, options.height, std::move(values));
}

Image2d<Rgba8> slice_along_image(const StoredVolume& ct,
                                 const Transform<frames::Ct, frames::Image>& ct_from_image,
                                 const Eigen::Vector2d& origin_mm, double mm_per_pixel, int width,
                                 int height, const HuWindow& window) {
  const SliceOptions options{.width = width, .height = height, .mm_per_pixel = mm_per_pixel};
  const Eigen::Vector2d centre_mm =
      origin_mm + 0.5 * mm_per_pixel * Eigen::Vector2d(width - 1, height - 1);
  const auto values = slice_values(ct, ultrasound_slice(ct_from_image, centre_mm), options);
  NAV_CHECK(values.has_value(), width, height, mm_per_pixel);
  return to_grey(*values, window);
}

Image2d<Rgba8> to_grey(const Image2d<float>& values, const HuWindow& window) {
  NAV_CHECK(window.width > 0, window.width);
  const auto scale = static_cast<float>(255 / window.width);
  const auto shift = static_cast<float>(255 * (0.5 - window.level / window.width));
  std::vector<Rgba8> pixels;
  pixels.reserve(values.pixels().size());
  for (const float v : values.pixels()) {
    if (std::isnan(v)) {
      pixels.push_back(kOutsideCt);
      continue;
    }
    const float grey = std::clamp(v * scale + shift, 0.0F, 255.0F);
    const auto byte = static_cast<std::uint8_t>(grey + 0.5F);
    pixels.push_back({byte, byte, byte, 255});
  }
  return {values.width(), values.height(), std::move(pixels)};
}

}  // namespace nav::render
