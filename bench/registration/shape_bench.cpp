// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <optional>

#include "io/surface_file.hpp"
#include "registration/shape/shape_registration.hpp"
#include "registration/twist.hpp"

/// Run time against error of points on the pelvis phantom (UCL MPHY0026, CC BY), by number of
/// points and spacing of the field. Needs SONDE_DATA_DIR.
namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;

constexpr double kFineMm = 1;
constexpr int kStarts = 4;
constexpr double kStartMm = 30;
constexpr double kStartRad = 20 * std::numbers::pi / 180;

struct Pelvis {
  Shape shape;
  std::vector<Point<frames::Reference>> points;
  ShapeField fine;  ///< Field that errors are measured on.
  Pose best;        ///< Pose of all points on the fine field.

  [[nodiscard]] double mean_mm(const Pose& pose) const {
    double sum = 0;
    for (const auto& p : points) sum += fine.distance_mm((pose * p).mm);
    return sum / static_cast<double>(points.size());
  }
  [[nodiscard]] double from_best_mm(const Pose& pose) const {
    double sum = 0;
    for (const auto& p : points) sum += ((pose * p).mm - (best * p).mm).squaredNorm();
    return std::sqrt(sum / static_cast<double>(points.size()));
  }
};

std::optional<Pelvis> read_pelvis() {
  const char* data = std::getenv("SONDE_DATA_DIR");
  if (data == nullptr) return {};
  const std::filesystem::path folder = std::filesystem::path(data) / "ucl-pelvis";
  const auto mesh = io::read_surface(folder / "pelvis_cropped_decimated.vtk");
  const auto scan = io::read_point_groups(folder / "Tracker_Surface_Scan.txt");
  if (!mesh || !scan) return {};
  const auto shape = surface_shape(*mesh, 3);
  const auto fine = ShapeField::create(*shape, {.spacing_mm = kFineMm, .margin_mm = 30});
  if (!fine) return {};
  std::vector<Point<frames::Reference>> points;
  for (const auto& p : scan->front()) points.push_back({p});
  // The authors' point registration, Tracker_to_pelvis_cropped.txt.
  Eigen::Matrix4d matrix;
  matrix << 0.274539, -0.860860, 0.428426, 683.802415, -0.906133, -0.082510, 0.414867, 762.750631,
      -0.321793, -0.502108, -0.802706, -632.830640, 0, 0, 0, 1;
  const auto start = rigid_from_matrix<frames::Ct, frames::Reference>(matrix);
  if (!start) return {};
  const auto best = register_points(points, *fine, *start);
  if (!best) return {};
  return Pelvis{*shape, points, *fine, best->ct_from_reference};
}

const std::optional<Pelvis>& pelvis() {
  static const std::optional<Pelvis> instance = read_pelvis();
  return instance;
}

Pose start_of(const Pelvis& pelvis, int index) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& p : pelvis.points) {
    centre += (pelvis.best * p).mm / static_cast<double>(pelvis.points.size());
  }
  const double a = 2.4 * index;  // Directions are spread by the golden angle.
  const double z = 1 - (2.0 * index + 1) / kStarts;
  const double r = std::sqrt(1 - z * z);
  Vector6d twist;
  twist << kStartRad * r * std::cos(a), kStartRad * r * std::sin(a), kStartRad * z, kStartMm * z,
      kStartMm * r * std::sin(a), kStartMm * r * std::cos(a);
  return moved(pelvis.best, centre, twist);
}

/// Arguments: points used, spacing of the field in quarters of a millimetre.
void pelvis_from_30_mm(benchmark::State& state) {
  if (!pelvis()) {
    state.SkipWithError("third-party data missing (set SONDE_DATA_DIR)");
    return;
  }
  const double spacing = 0.25 * static_cast<double>(state.range(1));
  const auto field = ShapeField::create(pelvis()->shape, {.spacing_mm = spacing, .margin_mm = 30});
  ShapeRegistrationOptions options;
  options.max_points = static_cast<int>(state.range(0));
  double mean = 0;
  double worst = 0;
  int runs = 0;
  for (auto _ : state) {
    const auto result =
        register_points(pelvis()->points, *field, start_of(*pelvis(), runs % kStarts), options);
    state.PauseTiming();
    mean += pelvis()->mean_mm(result->ct_from_reference);
    worst = std::max(worst, pelvis()->from_best_mm(result->ct_from_reference));
    ++runs;
    state.ResumeTiming();
  }
  state.counters["mean_mm"] = mean / runs;
  state.counters["worst_from_best_mm"] = worst;
}
BENCHMARK(pelvis_from_30_mm)
    ->ArgsProduct({{100, 300, 1000, 2000}, {4, 8, 16, 32}})
    ->Iterations(kStarts)
    ->Unit(benchmark::kMillisecond);

void pelvis_field(benchmark::State& state) {
  if (!pelvis()) {
    state.SkipWithError("third-party data missing (set SONDE_DATA_DIR)");
    return;
  }
  const double spacing = 0.25 * static_cast<double>(state.range(0));
  for (auto _ : state) {
    const auto field =
        ShapeField::create(pelvis()->shape, {.spacing_mm = spacing, .margin_mm = 30});
    benchmark::DoNotOptimize(field->node_count());
  }
}
BENCHMARK(pelvis_field)
    ->Arg(4)
    ->Arg(8)
    ->Arg(16)
    ->Arg(32)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace nav::registration
