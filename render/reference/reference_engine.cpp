// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "nav/stopwatch.hpp"
#include "render/engine.hpp"
#include "render/interruptible.hpp"
#include "render/reference/reference_gradient.hpp"
#include "render/reference/reference_predicates.hpp"
#include "render/spec/ray_spec.hpp"
#include "render/surfaces.hpp"
#include "render/transfer/transfer_table.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

using Vec3 = spec::Vec3<double>;

struct Counts {
  std::uint64_t samples = 0;
  std::uint64_t gradients = 0;
};

/// The ultrasound volume of a scene that also has a CT.
struct SecondVolume {
  explicit SecondVolume(const Scene& s)
      : scene(ultrasound_scene(s)),
        predicates(scene),
        view(spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid())),
        ct_importance(std::min(s.ultrasound->ct_importance, predicates.greatest_impact())),
        slab(slab_mm(s)) {}

  Scene scene;
  ReferencePredicates predicates;
  spec::View<double> view;
  double ct_importance;
  double slab;  ///< mm.
};

/// Data that all rays of an image share.
struct Prepared {
  explicit Prepared(const Scene& s)
      : scene(s),
        surfaces(s),
        table(s.transfer),
        cutaway(spec::make_cutaway(s, true)),
        view(spec::make_view<double>(s.camera, s.width, s.height, s.ct->grid())),
        step_mm(spec::step_mm(s.quality, s.ct->grid())),
        pre_integrated(s.quality.classification == Classification::kPreIntegrated &&
                       table.rows() == 1) {
    if (s.predicates) predicates.emplace(s);
    if (has_two_volumes(s)) second.emplace(s);
  }

  const Scene& scene;
  Surfaces surfaces;
  TransferTable table;
  spec::CutawayObjects<double> cutaway;
  spec::View<double> view;
  double step_mm;
  bool pre_integrated;
  std::optional<ReferencePredicates> predicates{};
  std::optional<SecondVolume> second{};
};

/// Casts one ray at a time; keeps the state of the current one.
class Caster {
 public:
  explicit Caster(const Prepared& prepared) : p_(prepared), scene_(prepared.scene) {}

  RgbaF cast(int x, int y) {
    rgb_ = Vec3::Zero();
    alpha_ = 0;
    ray_ = spec::ray_of(p_.view, x, y);
    index_ = spec::index_ray(ray_, scene_.ct->grid());
    shift_ = scene_.quality.jitter ? spec::jitter_of(x, y) : 0;
    const spec::Interval<double> in = spec::clip_to_box(index_, scene_.ct->grid().size);
    p_.surfaces.meet(ray_, hits_);
    if (scene_.projection == Projection::kComposite) {
      if (p_.second) {
        composite_both(in, spec::ray_of(p_.second->view, x, y));
      } else {
        composite(in);
      }
    } else {
      for (const auto& hit : hits_) blend(hit.rgb, hit.alpha);
      if (in.end > in.begin) blend(Vec3::Constant(projected_grey(in)), 1);
    }
    const Vec3 pixel = rgb_ + (1 - alpha_) * scene_.background_rgb;
    return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
            static_cast<float>(pixel.z()), 1.0F};
  }
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  /// Part of a cell between two events of the ray.
  struct Cell {
    double t_a;
    double t_b;
    double v_a;
    double v_b;
    double k;        ///< Begin of the whole cell, in cells.
    double bow = 0;  ///< HU; spec::bow_of().
  };
  /// A classified cell. The importance is set only with emphasis.
  struct Classified {
    Vec3 rgb;
    double tau_per_mm;
    double importance;
  };

  void blend(const Vec3& rgb, double alpha) {
    const double weight = (1 - alpha_) * alpha;
    rgb_ += weight * rgb;
    alpha_ += weight;
  }

  double sample(const Vec3& index) {
    ++counts_.samples;
    return spec::value_at(*scene_.ct, index);
  }

  [[nodiscard]] Vec3 index_at(double cells) const {
    return index_.origin + (cells + shift_) * p_.step_mm * index_.direction;
  }

  void composite(const spec::Interval<double>& in) {
    span_ = spec::meet_cutaway(p_.cutaway, ray_);
    bow_from_ = std::floor(in.begin / p_.step_mm - shift_) + 2;
    if (p_.predicates) {
      const auto light = p_.predicates->cast(
          {.ray = ray_, .in = in, .shift = shift_, .span = span_, .hits = hits_}, counts_.samples);
      rgb_ = light.alpha * light.rgb;
      alpha_ = light.alpha;
      return;
    }
    double begin = in.begin;
    for (const auto& hit : hits_) {
      march(begin, std::min(in.end, hit.t));
      blend(hit.rgb, hit.alpha);
      begin = std::max(in.begin, hit.t);
    }
    if (hits_.empty() || hits_.back().alpha < 1) march(begin, in.end);
  }

  /// Composites two volumes: ray_spec.hpp. \p other: the ray in the ultrasound's local mm.
  void composite_both(const spec::Interval<double>& in, const spec::Ray<double>& other) {
    span_ = spec::meet_cutaway(p_.cutaway, ray_);
    bow_from_ = std::floor(in.begin / p_.step_mm - shift_) + 2;
    const SecondVolume& second = *p_.second;
    const VoxelGrid& grid = second.scene.ct->grid();
    const auto in_other = spec::clip_to_box(spec::index_ray(other, grid), grid.size);
    const ReferencePredicates::Ray ray{
        .ray = other, .in = in_other, .shift = shift_, .span = span_, .hits = hits_};
    spec::ImportanceState<double> light;
    double begin = std::min(in.begin, in_other.begin);
    for (const auto& hit : hits_) {
      march_both(in, ray, {begin, hit.t}, light);
      spec::composite_log(light, hit.rgb, hit.alpha, second.predicates.greatest_impact());
      begin = std::max(begin, hit.t);
    }
    march_both(in, ray, {begin, std::max(in.end, in_other.end)}, light);
    rgb_ = light.alpha * light.rgb;
    alpha_ = light.alpha;
  }

  using ImageScale = ReferencePredicates::ImageScale;

  void march_both(const spec::Interval<double>& in, const ReferencePredicates::Ray& ray,
                  ImageScale stretch, spec::ImportanceState<double>& light) {
    const double slab = p_.second->slab;
    const ImageScale both{std::max({stretch.begin, in.begin, ray.in.begin}),
                          std::min({stretch.end, in.end, ray.in.end})};
    if (!(both.end > both.begin)) {
      march_part(in, ray, stretch, in.begin < ray.in.begin, light);
      return;
    }
    march_part(in, ray, {stretch.begin, both.begin}, true, light);
    for (double m = std::floor(both.begin / slab); m * slab < both.end; m += 1) {
      const ImageScale part{std::max(m * slab, both.begin), std::min((m + 1) * slab, both.end)};
      march_part(in, ray, part, std::fmod(m, 2) == 0, light);
    }
    march_part(in, ray, {both.end, stretch.end}, true, light);
  }

  void march_part(const spec::Interval<double>& in, const ReferencePredicates::Ray& ray,
                  ImageScale part, bool ct_first, spec::ImportanceState<double>& light) {
    if (!ct_first) p_.second->predicates.march(ray, part, light, counts_.samples);
    rgb_ = Vec3::Zero();
    alpha_ = 0;
    march(std::max(part.begin, in.begin), std::min(part.end, in.end));
    if (alpha_ > 0) {
      spec::composite_log<double>(light, rgb_ / alpha_, alpha_, p_.second->ct_importance);
    }
    if (ct_first) p_.second->predicates.march(ray, part, light, counts_.samples);
  }

  /// Calls visit(k, part begin, part end) for every cell of a part of the ray; t in mm.
  template <class Visit>
  void for_each_cell(double begin, double end, const Visit& visit) {
    if (!(end > begin)) return;
    const double h = p_.step_mm;
    for (double k = std::floor(begin / h - shift_); (k + shift_) * h < end; k += 1) {
      const double t_a = std::max((k + shift_) * h, begin);
      const double t_b = std::min((k + 1 + shift_) * h, end);
      if (t_b > t_a) visit(k, t_a, t_b);
    }
  }

  void march(double begin, double end) {
    double last_k = std::numeric_limits<double>::quiet_NaN();
    double last_value = 0;
    double before_k = last_k;  // Begin of the previous cell.
    double before_value = 0;
    for_each_cell(begin, end, [&](double k, double t_a, double t_b) {
      Cell cell{.t_a = t_a, .t_b = t_b, .v_a = 0, .v_b = 0, .k = k};
      if (p_.pre_integrated) {
        const double v0 = k == last_k ? last_value : sample(index_at(k));
        const double v1 = sample(index_at(k + 1));
        last_k = k + 1;
        last_value = v1;
        const bool whole = t_a == (k + shift_) * p_.step_mm && t_b == (k + 1 + shift_) * p_.step_mm;
        if (whole && k >= bow_from_) {
          const double before = k - 1 == before_k ? before_value : sample(index_at(k - 1));
          cell.bow = spec::bow_of(before, v0, v1);
        }
        before_k = k;
        before_value = v0;
        const auto value = [&](double t) { return v0 + (t / p_.step_mm - k - shift_) * (v1 - v0); };
        cell.v_a = value(t_a);
        cell.v_b = value(t_b);
      } else {
        cell.v_a = cell.v_b = sample(place_in(cell, 0.5));
      }
      add(cell);
    });
  }

  void add(const Cell& cell) {
    const bool windows = p_.table.rows() > 1;
    Vec3 gradient = Vec3::Zero();
    if (windows) gradient = reference_gradient(gradient_source(), place_in(cell, 0.5));
    Classified c = classified(cell, gradient.norm());
    if (!(c.tau_per_mm > 0)) return;
    const double opacity = -std::expm1(-c.tau_per_mm * (cell.t_b - cell.t_a));
    const double share = spec::shaded_share(c.importance, scene_.shading);
    if (scene_.shading.enabled && share > 0) {
      const int n = p_.pre_integrated
                        ? spec::shades_of((1 - alpha_) * opacity, scene_.quality.step_voxels)
                        : 1;
      Vec3 sum = Vec3::Zero();
      for (int j = 0; j < n; ++j) {
        ++counts_.gradients;
        if (!windows)
          gradient = reference_gradient(gradient_source(), place_in(cell, (j + 0.5) / n));
        sum += spec::shade_sample<double>(c.rgb, gradient, ray_.direction,
                                          spec::gooch_light(p_.view), share, scene_.shading);
      }
      c.rgb = sum / n;
    }
    blend(c.rgb, opacity);
  }

  [[nodiscard]] const StoredVolume& gradient_source() const {
    return scene_.gradient_source ? *scene_.gradient_source : *scene_.ct;
  }

  /// Index of the position w in the whole cell, 0 at its begin and 1 at its end.
  [[nodiscard]] Vec3 place_in(const Cell& cell, double w) const { return index_at(cell.k + w); }

  [[nodiscard]] bool needs_importance() const {
    return scene_.shading.enabled && scene_.shading.emphasis > 0;
  }

  /// Sample of the whole cell without a cutaway.
  [[nodiscard]] TransferSample whole(const Cell& cell, double gradient) const {
    return p_.pre_integrated ? p_.table.mean(cell.v_a, cell.v_b, cell.bow)
                             : p_.table.at(cell.v_a, gradient);
  }

  [[nodiscard]] Classified classified(const Cell& cell, double gradient) const {
    const bool fading = cell.t_a < span_.t2;
    const TransferSample s = whole(cell, gradient);
    if (!fading && !needs_importance()) return {s.rgb, s.tau_per_mm, 1};
    const double i_a = p_.table.at(cell.v_a, gradient).importance;
    const double i_b = p_.table.at(cell.v_b, gradient).importance;
    double visible = 1;
    if (fading) {
      const double v_a = visibility(i_a, cell.t_a);
      const double v_b = visibility(i_b, cell.t_b);
      if (std::abs(v_a - v_b) > spec::kFadeVaries) return steps(cell, gradient, true);
      visible = (v_a + v_b) / 2;
    }
    double importance = 1;
    if (needs_importance()) {
      importance = std::abs(i_a - i_b) > spec::kFadeVaries ? steps(cell, gradient, false).importance
                                                           : (i_a + i_b) / 2;
    }
    return {s.rgb, spec::faded(s.tau_per_mm, visible), importance};
  }

  [[nodiscard]] double visibility(double importance, double t) const {
    const double omega = spec::occlusion(span_, p_.cutaway.overlay_mm, t);
    return scene_.cutaway ? spec::visibility(*scene_.cutaway, importance, omega)
                          : spec::visibility(importance, omega);
  }

  /// Mean of kFadeSteps midpoints, faded or not.
  [[nodiscard]] Classified steps(const Cell& cell, double gradient, bool fading) const {
    Vec3 rgb = Vec3::Zero();
    double sum = 0;
    double importance = 0;
    for (int j = 0; j < spec::kFadeSteps; ++j) {
      const double w = (j + 0.5) / spec::kFadeSteps;
      const TransferSample s = p_.table.at(cell.v_a + w * (cell.v_b - cell.v_a), gradient);
      double tau = s.tau_per_mm;
      if (fading) {
        const double t = cell.t_a + w * (cell.t_b - cell.t_a);
        tau = spec::faded(tau, visibility(s.importance, t));
      }
      sum += tau;
      rgb += tau * s.rgb;
      importance += tau * s.importance;
    }
    if (!(sum > 0)) return {rgb, 0, 1};
    return {rgb / sum, sum / spec::kFadeSteps, needs_importance() ? importance / sum : 1};
  }

  double projected_grey(const spec::Interval<double>& in) {
    double most = -std::numeric_limits<double>::infinity();
    double least = std::numeric_limits<double>::infinity();
    double sum = 0;
    for_each_cell(in.begin, in.end, [&](double k, double t_a, double t_b) {
      const double v = sample(index_at(k + 0.5));
      most = std::max(most, v);
      least = std::min(least, v);
      sum += v * (t_b - t_a);
    });
    const double mean = sum / (in.end - in.begin);
    const double value = scene_.projection == Projection::kMaximum   ? most
                         : scene_.projection == Projection::kMinimum ? least
                                                                     : mean;
    return std::clamp((value - scene_.grey.level_hu) / scene_.grey.width_hu + 0.5, 0.0, 1.0);
  }

  const Prepared& p_;
  const Scene& scene_;
  spec::Ray<double> ray_;
  spec::Ray<double> index_;
  spec::CutawaySpan<double> span_{};
  double shift_ = 0;
  double bow_from_ = 0;  ///< The first cell with a bow.
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

  Result<RenderedImage> render_image(const Scene& scene, const Interrupt& interrupt) override {
    if (const auto ok = validate(scene); !ok) return ok.error();
    const auto start = std::chrono::steady_clock::now();
    const Prepared prepared(scene);
    const auto width = static_cast<std::size_t>(scene.width);
    std::vector<RgbaF> pixels(width * static_cast<std::size_t>(scene.height));
    std::atomic<std::uint64_t> samples{0};
    std::atomic<std::uint64_t> gradients{0};
    const bool whole = for_each_index(scene.height, options_.threads, interrupt, [&](int y) {
      Caster caster(prepared);
      for (int x = 0; x < scene.width; ++x) {
        pixels[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] =
            caster.cast(x, y);
      }
      samples += caster.counts().samples;
      gradients += caster.counts().gradients;
    });
    if (!whole) return interrupted_error(name());
    RenderedImage image{{scene.width, scene.height, std::move(pixels)}, {}};
    image.statistics.rays = image.pixels.pixels().size();
    image.statistics.volume_samples = samples;
    image.statistics.gradient_samples = gradients;
    image.statistics.cast_s = seconds_since(start);
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
