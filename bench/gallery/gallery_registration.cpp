// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery_registration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "app/report.hpp"
#include "app/verbs/register/registration_image.hpp"
#include "bench/registration/cohort.hpp"
#include "registration/acceptance.hpp"
#include "registration/image_registration.hpp"
#include "registration/landmarks/tre_map.hpp"
#include "render/slices/slice.hpp"

namespace nav::bench {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kStartMm = 40;
constexpr int kImages = 4;         // Along the sweep.
constexpr int kEmpty = 56;         // Rows of a registration image below its fans.
constexpr int kSlice = 520;        // Pixels of a side.
constexpr double kSliceMm = 0.65;  // Side of a pixel.
constexpr double kMapStepMm = 10;
constexpr double kMostMm = 1;  // Upper end of the colour scale.
constexpr double kOpacity = 0.35;
constexpr std::array<double, 4> kContoursMm = {0.25, 0.5, 0.75, 1};

/// A registration and what is known about it because the patient is simulated.
struct Run {
  Patient patient;
  RecordedSweep recorded;
  CtPose start;
  registration::ImageRegistrationResult result;
  registration::Decision decision;
  Point<frames::Ct> target;  ///< Mean of the targets.

  [[nodiscard]] double error_mm(const CtPose& pose) const {
    return target_error_mm(pose, patient.truth, recorded.targets);
  }
};

Result<Run> run_registration(app::Console& console) {
  console.begin("registration of a sweep from 40 mm");
  Patient patient = make_patient(kSeed);
  SweepRequest request;
  request.seed = kSeed;
  RecordedSweep recorded = record_sweep(patient, request);
  const CtPose start = start_at(kStartMm, patient.truth, recorded, kSeed);
  auto result = registration::register_sweep(*patient.ct, recorded.sweep, start, {}, console);
  if (!result) return result.error();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& target : recorded.targets) sum += target.mm;
  const Point<frames::Ct> middle{sum / static_cast<double>(recorded.targets.size())};
  auto decision = registration::decide(*result, {}, middle);
  console.end(decision.accepted ? "accepted" : "refused");
  return Run{.patient = std::move(patient),
             .recorded = std::move(recorded),
             .start = start,
             .result = std::move(*result),
             .decision = std::move(decision),
             .target = middle};
}

Result<void> draw_checkerboards(const Run& run, app::OutputFolder& folder) {
  const auto& frames = run.recorded.sweep.frames();
  std::vector<Image2d<Rgba8>> rows;
  for (int i = 0; i < kImages; ++i) {
    const std::size_t index = frames.size() * static_cast<std::size_t>(2 * i + 1) / (2 * kImages);
    rows.push_back(app::registration_image(*run.patient.ct, frames[index], run.start,
                                           run.result.ct_from_reference, run.decision.accepted,
                                           {}));
  }
  const int height = rows.front().height() - kEmpty;
  render::Canvas canvas(rows.front().width(), kImages * height + kEmpty, render::rgb8(0x101418));
  for (int i = 0; i < kImages; ++i) canvas.copy(rows[static_cast<std::size_t>(i)], 0, i * height);
  return folder.write_image("registration-sweep.png", canvas.image());
}

/// Blue where little error is expected, over green and yellow to red at kMostMm and beyond.
Rgba8 error_colour(double mm) {
  const double t = std::clamp(mm / kMostMm, 0.0, 1.0);
  const auto bump = [t](double middle) {
    return static_cast<std::uint8_t>(
        std::lround(255 * std::clamp(1.5 - std::abs(4 * t - middle), 0.0, 1.0)));
  };
  return {bump(3), bump(2), bump(1), 255};
}

/// A contour runs between a value and its neighbours.
bool crosses(double here, double right, double below) {
  return std::ranges::any_of(kContoursMm, [&](double level) {
    return (here < level) != (right < level) || (here < level) != (below < level);
  });
}

Result<void> draw_map(const Run& run, const render::SlicePlane& plane, int x, int y,
                      render::Canvas& canvas) {
  render::SliceOptions options;
  options.width = options.height = kSlice;
  options.mm_per_pixel = kSliceMm;
  const auto values = render::slice_values(*run.patient.ct, plane, options);
  if (!values) return values.error();
  canvas.copy(render::to_grey(*values, {}), x, y);
  const auto expected = [&](int column, int row) {
    const double across = kSliceMm * (column - 0.5 * (kSlice - 1));
    const double down = kSliceMm * (row - 0.5 * (kSlice - 1));
    return run.result.tre_rms_mm(
        {plane.centre_ct.mm + across * plane.right.v + down * plane.down.v});
  };
  for (int row = 0; row < kSlice; ++row) {
    for (int column = 0; column < kSlice; ++column) {
      if (std::isnan(values->at(column, row))) continue;
      const double mm = expected(column, row);
      const bool contour = crosses(mm, expected(column + 1, row), expected(column, row + 1));
      canvas.blend(x + column, y + row, contour ? render::rgb8(0xffffff) : error_colour(mm),
                   contour ? 0.9 : kOpacity);
    }
  }
  const render::SliceLabels labels = render::labels_of(plane);
  const Rgba8 ink = render::rgb8(0xffffff);
  canvas.text(x + 6, y + kSlice / 2, 16, labels.left, ink);
  canvas.text(x + kSlice - 20, y + kSlice / 2, 16, labels.right, ink);
  canvas.text(x + kSlice / 2, y + 20, 16, labels.top, ink);
  canvas.text(x + kSlice / 2, y + kSlice - 8, 16, labels.bottom, ink);
  return {};
}

void draw_legend(render::Canvas& canvas, int x, int y) {
  constexpr int kLength = 320;
  const Rgba8 ink = render::rgb8(0xd8dee4);
  for (int i = 0; i <= kLength; ++i) {
    canvas.fill(x + i, y, 1, 12, error_colour(kMostMm * i / kLength));
  }
  for (const double mm : kContoursMm) {
    const int at = x + static_cast<int>(std::lround(kLength * mm / kMostMm));
    canvas.fill(at, y, 1, 16, ink);
    const std::string words = app::quantity(mm, 2, "");
    canvas.text(at - canvas.text_width(13, words) / 2, y + 30, 13, words, ink);
  }
  canvas.text(x + kLength + 40, y + 12, 14, "expected target error, RMS, mm; contours at the ticks",
              ink);
}

Result<void> draw_tre_map(const Run& run, app::OutputFolder& folder) {
  constexpr int kTop = 28, kFoot = 48;
  render::Canvas canvas(2 * kSlice, kTop + kSlice + kFoot, render::rgb8(0x101418));
  const Rgba8 ink = render::rgb8(0xd8dee4);
  canvas.text(8, 20, 15, "Axial, through the middle of the targets", ink);
  canvas.text(kSlice + 8, 20, 15, "Coronal", ink);
  // Through the targets, with the whole CT in the middle of the image.
  const Eigen::Vector3d ct = run.patient.ct->grid().centre().mm, target = run.target.mm;
  const Point<frames::Ct> axial{{ct.x(), ct.y(), target.z()}};
  const Point<frames::Ct> coronal{{ct.x(), target.y(), ct.z()}};
  if (auto ok = draw_map(run, render::axial_slice(axial), 0, kTop, canvas); !ok) return ok;
  if (auto ok = draw_map(run, render::coronal_slice(coronal), kSlice, kTop, canvas); !ok) return ok;
  draw_legend(canvas, 12, kTop + kSlice + 8);
  return folder.write_image("registration-tre-map.png", canvas.image());
}

void say_numbers(const Run& run, app::Console& console) {
  double expected = 0;
  for (const auto& target : run.recorded.targets) {
    expected += std::pow(run.result.tre_rms_mm(target), 2);
  }
  expected = std::sqrt(expected / static_cast<double>(run.recorded.targets.size()));
  const auto map =
      registration::tre_map(run.result.uncertainty, run.patient.ct->grid(), kMapStepMm);
  console.say("registration: target error " + app::quantity(run.error_mm(run.start), 1, "mm") +
              " before, " + app::quantity(run.error_mm(run.result.ct_from_reference), 2, "mm") +
              " after; expected " + app::quantity(expected, 2, "mm") + " RMS over " +
              std::to_string(run.recorded.targets.size()) + " targets; " +
              (run.decision.accepted ? "accepted" : "refused"));
  for (const std::string& reason : run.decision.reasons) console.say("  " + reason);
  console.say("registration: over the whole CT at most " + app::quantity(map.worst_mm(), 2, "mm") +
              " expected; within 0.5 mm in " +
              app::quantity(100 * map.fraction_within(0.5), 0, "%") + ", within 1 mm in " +
              app::quantity(100 * map.fraction_within(1), 0, "%"));
}

}  // namespace

std::vector<std::string> registration_gallery_names() {
  return {"registration-sweep", "registration-tre-map"};
}

Result<void> draw_registration_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                       app::Console& console) {
  const auto wanted = [&](std::string_view name) {
    return name.find(options.only) != std::string_view::npos;
  };
  if (!wanted("registration-sweep") && !wanted("registration-tre-map")) return {};
  const auto run = run_registration(console);
  if (!run) return run.error();
  if (wanted("registration-sweep")) {
    if (auto ok = draw_checkerboards(*run, folder); !ok) return ok;
  }
  if (wanted("registration-tre-map") && run->result.covariance_valid) {
    if (auto ok = draw_tre_map(*run, folder); !ok) return ok;
  }
  say_numbers(*run, console);
  return {};
}

}  // namespace nav::bench
