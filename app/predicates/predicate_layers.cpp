// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_layers.hpp"

#include "io/json_member.hpp"
#include "render/features/labels.hpp"

namespace nav::app {
namespace {

using render::features::LayerModel;
using render::features::LayerSurface;

constexpr int kLayersVersion = 1;

struct LayerFile {
  int axis = 0;
  std::array<int, 2> control{};
  std::vector<std::vector<double>> heights_mm;
};

/// Reads an integer in a range; 0 for anything else.
int whole(io::JsonMember& member, const char* key, int low, int high) {
  double value = low - 1;
  member.number(key, value);
  if (value >= low && value <= high && value == std::floor(value)) return static_cast<int>(value);
  member.fail(key, "a whole number, " + std::to_string(low) + " to " + std::to_string(high), value);
  return 0;
}

Result<LayerFile> read_file(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = 64 << 20;
  const auto root = io::read_json(path, kMostBytes);
  if (!root) return root.error();
  const std::string name = path.string();
  std::optional<Error> error;
  io::JsonMember member(*root, name, error);
  member.version("sonde_layers", kLayersVersion);
  constexpr int kMostControl = 4096;
  LayerFile file;
  file.axis = whole(member, "axis", 0, 2);
  file.control = {whole(member, "columns", 4, kMostControl),
                  whole(member, "rows", 4, kMostControl)};
  const auto count =
      static_cast<std::size_t>(file.control[0]) * static_cast<std::size_t>(file.control[1]);
  member.list("surfaces", [&](const io::Json& json, const std::string& at) {
    io::JsonMember surface(json, at, error);
    std::vector<double> heights;
    surface.numbers("heights_mm", count, heights);
    if (heights.empty()) {
      surface.fail("heights_mm", std::to_string(count) + " numbers", io::Json());
    }
    surface.finish();
    constexpr double kMostHeightMm = 1e6;
    for (const double h : heights) {
      if (!(std::abs(h) <= kMostHeightMm)) surface.fail("heights_mm", "numbers within 1e6 mm", h);
    }
    file.heights_mm.push_back(std::move(heights));
  });
  member.finish();
  if (error) return *error;
  return file;
}

}  // namespace

Result<render::LabelVolume> read_layers(const std::filesystem::path& path, const VoxelGrid& grid) {
  auto file = read_file(path);
  if (!file) return file.error();
  const auto named = [&](const Error& error) {
    return Error{error.code, path.string() + ": " + error.message};
  };
  std::vector<LayerSurface> surfaces;
  for (auto& heights : file->heights_mm) {
    for (double& h : heights) h /= grid.spacing_mm[file->axis];
    auto surface = LayerSurface::create(file->axis, grid.size, file->control, std::move(heights));
    if (!surface) return named(surface.error());
    surfaces.push_back(*std::move(surface));
  }
  const auto model = LayerModel::create(std::move(surfaces));
  if (!model) return named(model.error());
  const auto raster = model->rasterise(grid);
  if (!raster) return named(raster.error());
  auto labels = render::LabelVolume::create(grid, raster->masks(), path.string());
  if (!labels) return labels;
  return labels->with_layers(std::make_shared<const LayerModel>(*model));
}

}  // namespace nav::app
