// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates.hpp"

#include <algorithm>
#include <cmath>

#include "app/predicate_file.hpp"
#include "bench/predicate_phantom.hpp"
#include "io/ct.hpp"
#include "io/picture.hpp"
#include "render/canvas.hpp"
#include "render/derived_features.hpp"
#include "render/engine.hpp"
#include "render/predicates/gradient_features.hpp"

namespace nav::app {
namespace {

constexpr int kTitleHeight = 28;  // Pixels above the pictures.
constexpr int kBarsHeight = 150;  // And below.

/// A preset by its name, otherwise a file.
Result<PredicateFile> set_up(const std::string& name) {
  if (std::filesystem::exists(name)) return read_predicate_file(name);
  auto model = render::preset_predicates(name);
  if (!model) return Error{model.error().code, "--predicates: " + model.error().message};
  return PredicateFile{name, *std::move(model)};
}

/// Where the scan lines come from: as asked for, else along j from the first row.
render::ScanGeometry scan_of(const PredicatesOptions& options, const VoxelGrid& grid) {
  if (options.apex_ct) return render::FanScan{{*options.apex_ct}, options.face_radius_mm};
  const Eigen::Vector3d into = options.into_ct.value_or(grid.directions.col(1));
  return render::ParallelScan{{grid.origin_mm}, {into}};
}

Result<bench::PredicateVolume> volume_of(const PredicatesOptions& options, Console& console) {
  constexpr int kPhantomSide = 192;
  if (options.volume.empty()) {
    auto phantom = bench::neck_phantom(kPhantomSide);
    // Vessels are to be found, as in any other volume, not taken from the phantom's truth.
    if (phantom) phantom->predicates.features.volumes.erase(render::feature::kVesselness);
    return phantom;
  }
  auto read = io::read_ct(options.volume, console);
  if (!read) return read.error();
  bench::PredicateVolume out{
      options.volume.stem().string(), std::make_shared<const Volume>(*std::move(read)), {}, {}};
  out.predicates.intensity = {options.black, options.white};
  out.predicates.scan = scan_of(options, out.ultrasound->grid());
  return out;
}

Result<Image2d<Rgba8>> draw(render::Engine& engine, const render::Scene& scene) {
  const auto image = engine.render(scene);
  if (!image) return image.error();
  return render::to_8bit(image->pixels);
}

/// The colour of a bar: its hue and saturation at half the luminance.
Rgba8 colour_of(const render::PredicateHistogram::Bar& bar) {
  const auto rgb = render::spec::hsl(render::spec::hsl_tint(bar.hue_deg, bar.saturation), 0.5);
  const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(255 * x)); };
  return {byte(rgb.x()), byte(rgb.y()), byte(rgb.z()), 255};
}

/// The predicate histogram (§3.3): heights are importances.
void draw_bars(const render::PredicateModel& model, int top, render::Canvas& canvas) {
  constexpr int kText = 15;
  constexpr int kMargin = 12;
  const int count = static_cast<int>(model.entries.size());
  const int pitch = (canvas.width() - 2 * kMargin) / count;
  const int most = kBarsHeight - 2 * kMargin - 2 * kText;
  const int base = top + kBarsHeight - kMargin - kText;
  for (int j = 0; j < count; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const auto& bar = model.histogram.bars()[at];
    const int height = std::max(1, static_cast<int>(std::lround(most * bar.importance)));
    const int x = kMargin + j * pitch;
    canvas.fill(x, base - height, std::max(pitch - kMargin, 1), height, colour_of(bar));
    if (canvas.text_width(kText, model.entries[at].name) < pitch) {
      canvas.text(x, base + kText + 2, kText, model.entries[at].name, render::rgb8(0xd0d0d0));
    }
  }
}

Image2d<Rgba8> side_by_side(const Image2d<Rgba8>& standard, const Image2d<Rgba8>& predicates,
                            const render::PredicateModel& model) {
  constexpr int kText = 16;
  constexpr int kMargin = 8;
  const int width = standard.width();
  render::Canvas canvas(2 * width, kTitleHeight + standard.height() + kBarsHeight,
                        render::rgb8(0x202020));
  canvas.copy(standard, 0, kTitleHeight);
  canvas.copy(predicates, width, kTitleHeight);
  const Rgba8 colour = render::rgb8(0xffd24a);
  canvas.text(kMargin, kTitleHeight - kMargin, kText, "standard transfer function", colour);
  canvas.text(width + kMargin, kTitleHeight - kMargin, kText, "predicates", colour);
  draw_bars(model, kTitleHeight + standard.height(), canvas);
  return canvas.picture();
}

}  // namespace

Result<void> run_predicates(const PredicatesOptions& options, Console& console) {
  const auto file = set_up(options.predicates);
  if (!file) return file.error();
  auto volume = volume_of(options, console);
  if (!volume) return volume.error();
  render::PredicateScene& predicates = volume->predicates;
  predicates.model = file->model;
  predicates.hue_mean = file->hue_mean;
  predicates.cutaway_importance = file->cutaway_importance;
  const auto added =
      render::add_gradient_features(*volume->ultrasound, options.smoothing_mm, predicates);
  if (!added) return added;
  render::DerivedFeatureOptions derive;
  derive.vesselness.smallest_radius_mm = options.smallest_radius_mm;
  derive.vesselness.largest_radius_mm = options.largest_radius_mm;
  if (options.bright_vessels) derive.vesselness.polarity = render::derived::Polarity::kBright;
  render::derived::DerivedVolumes service;
  if (const auto ok = render::add_derived_features(volume->ultrasound, derive, service, predicates);
      !ok) {
    return ok;
  }
  render::Scene scene =
      bench::predicate_scene(*volume, {file->name, file->model}, options.width, options.height);
  scene.predicates->opacity_length_mm = options.opacity_length_mm.value_or(file->opacity_length_mm);
  const auto engine = render::make_cpu_engine();
  const auto right = draw(*engine, scene);  // Says what is wrong with the options.
  if (!right) return right.error();
  const auto left = draw(*engine, bench::standard_scene(scene));
  if (!left) return left.error();
  if (const auto ok = io::write_png(side_by_side(*left, *right, file->model), options.out); !ok) {
    return ok;
  }
  console.say(volume->name + " by " + file->name + " in " + options.out.string());
  return {};
}

}  // namespace nav::app
