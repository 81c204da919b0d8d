// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/layout.hpp"

#include "nav/check.hpp"
#include "sim/anatomy/abdomen_organs.hpp"

namespace nav::sim {
namespace {

class LayeredAnatomy final : public Anatomy {
 public:
  LayeredAnatomy(const std::string& family, const PatientOptions& options, Layout layout)
      : name_(family + " " + std::to_string(options.seed)),
        stack_(std::move(layout.organs), layout.box, layout.cell_mm, layout.blend, options.contrast,
               options.seed),
        skin_mm_(std::move(layout.skin_mm)),
        region_(layout.region),
        landmarks_(std::move(layout.landmarks)),
        targets_(std::move(layout.targets)) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] Tissue tissue(const Point<frames::Ct>& p) const override {
    return stack_.tissue(p.mm);
  }
  [[nodiscard]] double hu(const Point<frames::Ct>& p) const override { return stack_.hu(p.mm); }
  [[nodiscard]] ValueAndGradient hu_with_gradient(const Point<frames::Ct>& p) const override {
    return stack_.hu_with_gradient(p.mm);
  }
  [[nodiscard]] Acoustics acoustics(const Point<frames::Ct>& p) const override {
    return stack_.acoustics(p.mm);
  }
  [[nodiscard]] double skin_distance_mm(const Point<frames::Ct>& p) const override {
    return skin_mm_(p.mm);
  }
  [[nodiscard]] Eigen::AlignedBox3d region_mm() const override { return region_; }
  [[nodiscard]] std::vector<NamedPoint> landmarks() const override { return landmarks_; }
  [[nodiscard]] std::vector<Point<frames::Ct>> targets() const override { return targets_; }

 private:
  std::string name_;
  OrganStack stack_;
  Field skin_mm_;
  Eigen::AlignedBox3d region_;
  std::vector<NamedPoint> landmarks_;
  std::vector<Point<frames::Ct>> targets_;
};

}  // namespace

void Layout::add(Tissue tissue, const shapes::Ellipsoid& e, const Grain& grain) {
  organs.push_back({tissue, e, box_around(e, 6), grain});
}
void Layout::add(Tissue tissue, const shapes::Capsule& c, const Grain& grain) {
  organs.push_back({tissue, c, box_around(c, 3), grain});
}
void Layout::add(Tissue tissue, Field distance_mm, const Grain& grain) {
  organs.push_back({tissue, std::move(distance_mm), box, grain});
}
void Layout::add(Tissue tissue, Field distance_mm, const Eigen::AlignedBox3d& bounds,
                 const Grain& grain) {
  organs.push_back({tissue, std::move(distance_mm), bounds, grain});
}

void Layout::mark(std::string name, const Vec3d& p) { landmarks.push_back({std::move(name), {p}}); }

void Layout::place_targets(int count, const std::function<bool(const Vec3d&)>& accept) {
  constexpr int kTries = 200000;
  const auto wanted = static_cast<std::size_t>(count);
  for (int i = 1; i < kTries && targets.size() < wanted; ++i) {
    const Vec3d p = halton_in(region, i);
    if (accept(p)) targets.push_back({p});
  }
  NAV_CHECK(targets.size() == wanted, targets.size(), wanted);
}

Vec3d leave_skin(const Field& skin_mm, const Vec3d& inside, const Vec3d& along) {
  NAV_CHECK(skin_mm(inside) < 0, skin_mm(inside));
  double low = 0;
  double high = 1;
  while (skin_mm(Vec3d(inside + high * along)) < 0) {
    low = high;
    high *= 1.5;
    NAV_CHECK(high < 1e4, high);
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (skin_mm(Vec3d(inside + middle * along)) < 0 ? low : high) = middle;
  }
  return inside + low * along;
}

void Layout::view(std::string name, const ProbeModel& probe, const Vec3d& over,
                  const Vec3d& outward, const Vec3d& sideways) {
  const Vec3d into = -outward.normalized();
  // The face is pressed slightly into the skin.
  constexpr double kPressMm = 1.0;
  const Vec3d face = leave_skin(skin_mm, over, -into) + kPressMm * into;
  Eigen::Matrix3d axes;
  axes.col(0) = (sideways - sideways.dot(into) * into).normalized();
  axes.col(1) = into;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  views.push_back({std::move(name), probe,
                   Transform<frames::Ct, frames::Image>(Eigen::Quaterniond(axes), face)});
}

Patient finish(std::string family, const PatientOptions& options, Layout layout) {
  Patient patient{family, nullptr, layout.views};
  patient.anatomy = std::make_shared<const LayeredAnatomy>(family, options, std::move(layout));
  return patient;
}

Grain muscle_grain(const Vec3d& along) {
  return {.along = along.normalized(),
          .length_mm = 16,
          .spacing_mm = 1.5,
          .strength = 0.8,
          .between = 0.3,
          .septa_mm = 4.2};
}

}  // namespace nav::sim
