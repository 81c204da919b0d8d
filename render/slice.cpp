// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/slice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "nav/places.hpp"
#include "render/parallel.hpp"
#include "render/ray_spec_volume.hpp"

namespace nav::render {
namespace {

using Vec3 = Eigen::Vector3d;
constexpr float kOutside = std::numeric_limits<float>::quiet_NaN();

/// Trilinear values along a line of index space, for places inside the box.
class Sampler {
 public:
  explicit Sampler(const Volume& ct) : hu_(ct.hu().data()) {
    const auto& size = ct.grid().size;
    for (std::size_t a = 0; a < 3; ++a) {
      last_[a] = static_cast<float>(size[a] - 1);
      cell_[a] = std::max(size[a] - 2, 0);
    }
    // An axis of one voxel has no second one: its neighbour is itself.
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

/// Columns [begin, end) of a row of pixels that lie inside the CT's box.
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
    // Steps this small do not cross the box within any picture.
    constexpr double kNoStep = 1e-12;
    if (std::abs(d) < kNoStep) {
      if (low > 0 || high < 0) return {0, 0};
      continue;
    }
    begin = std::max(begin, std::min(low / d, high / d));
    end = std::min(end, std::max(low / d, high / d));
  }
  // Pixel centres on a face belong to the box though they round: half a millionth of a pixel.
  constexpr double kRounding = 5e-7;
  if (!(end >= begin - kRounding)) return {0, 0};
  return {static_cast<int>(std::ceil(begin - kRounding)),
          std::min(static_cast<int>(std::floor(end + kRounding)) + 1, width)};
}

/// Index of a pixel centre: origin + column · right + row · down + depth_mm · across.
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
    // In double: index · column stays exact for the largest pictures.
    const Vec3 p = first + x * step;
    row[x] =
        sampler.at(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
}

void combine(SlabMode mode, const std::vector<float>& layer, const Columns& columns,
             std::vector<float>& row, std::vector<int>& counts) {
  for (int x = columns.begin; x < columns.end; ++x) {
    const auto i = static_cast<std::size_t>(x);
    const float v = layer[i];
    if (counts[i]++ == 0) {
      row[i] = v;
    } else if (mode == SlabMode::kMean) {
      row[i] += v;
    } else {
      row[i] = mode == SlabMode::kMaximum ? std::max(row[i], v) : std::min(row[i], v);
    }
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

Result<Image2d<float>> slice_values(const Volume& ct, const SlicePlane& plane,
                                    const SliceOptions& options) {
  if (const auto ok = validate(plane, options); !ok) return ok.error();
  const VoxelGrid& grid = ct.grid();
  const Lattice lattice = lattice_of(grid, plane, options);
  const Sampler sampler(ct);
  const double layers_mm = 0.5 * grid.spacing_mm.minCoeff();
  const int layers = std::max(1, static_cast<int>(std::ceil(options.slab_mm / layers_mm)));
  const auto width = static_cast<std::size_t>(options.width);
  std::vector<float> values(width * static_cast<std::size_t>(options.height), kOutside);
  for_each_index(options.height, options.threads, [&](int y) {
    float* row = values.data() + static_cast<std::size_t>(y) * width;
    const Vec3 first = lattice.origin + y * lattice.down;
    if (layers == 1) {
      thin_row(sampler, first, lattice.right,
               columns_inside(first, lattice.right, grid.size, options.width), row);
      return;
    }
    std::vector<float> sum(width, kOutside);
    std::vector<float> layer(width);
    std::vector<int> counts(width, 0);
    for (int i = 0; i < layers; ++i) {
      const Vec3 from = first + ((i + 0.5) / layers - 0.5) * options.slab_mm * lattice.across;
      const Columns columns = columns_inside(from, lattice.right, grid.size, options.width);
      thin_row(sampler, from, lattice.right, columns, layer.data());
      combine(options.slab, layer, columns, sum, counts);
    }
    for (std::size_t x = 0; x < width; ++x) {
      const bool mean = options.slab == SlabMode::kMean && counts[x] > 0;
      row[x] = mean ? sum[x] / static_cast<float>(counts[x]) : sum[x];
    }
  });
  return Image2d<float>(options.width, options.height, std::move(values));
}

Image2d<Rgba8> slice_along_image(const Volume& ct,
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
