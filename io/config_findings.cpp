// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/config_findings.hpp"

#include <cmath>
#include <set>
#include <sstream>
#include <utility>

#include "io/recorded_calibration.hpp"
#include "io/transform_loops.hpp"
#include "io/transform_tree.hpp"

namespace nav::io {
namespace {

constexpr int kAnySize = 512;  // Size of images, which a configuration does not say.

std::string name_of(const CoordinateDefinition& definition) {
  return definition.from + "To" + definition.to;
}

/// True for a transform of pixels, which scales.
bool scales(const CoordinateDefinition& definition) {
  for (const std::string& name : {definition.from, definition.to}) {
    if (name.starts_with("Image") || name.find("Pixel") != std::string::npos) return true;
  }
  return false;
}

/// The finding about a transform alone, if there is one.
std::optional<Finding> finding_of(const CoordinateDefinition& definition) {
  if (scales(definition)) return std::nullopt;
  const auto rigid = rigid_from_matrix<frames::Tracker, frames::Probe>(definition.to_from_from);
  if (!rigid) {
    return Finding{.subject = "",
                   .key = name_of(definition),
                   .values = {rigid.error().message},
                   .used = "nothing: what needs it is rejected"};
  }
  if (!definition.from.ends_with("Tip")) return std::nullopt;
  return tip_of_another_unit(definition.to_from_from, definition.from + " on " + definition.to);
}

/// Reports a size of pixels that differs from the one to which scan lines are converted.
std::optional<Finding> other_pixels(const PlusConfig& config, const PixelGrid& grid) {
  constexpr double kShare = 0.05;
  if (!config.scan_conversion || !config.scan_conversion->output_spacing_mm) return std::nullopt;
  const Eigen::Vector2d& stated = *config.scan_conversion->output_spacing_mm;
  const Eigen::Vector2d found(grid.mm_per_pixel.col(0).norm(), grid.mm_per_pixel.col(1).norm());
  if (((found - stated).cwiseAbs().array() <= kShare * stated.array()).all()) return std::nullopt;
  std::ostringstream conversion, calibration;
  conversion << "ScanConversion: " << stated.x() << " x " << stated.y() << " mm";
  calibration << "ImageToProbe: " << found.x() << " x " << found.y() << " mm";
  return Finding{.subject = "",
                 .key = "size of the pixels",
                 .values = {calibration.str(), conversion.str()},
                 .used = "ImageToProbe"};
}

}  // namespace

std::vector<Finding> findings_of(const PlusConfig& config) {
  std::vector<Finding> findings;
  const auto add = [&](std::optional<Finding> finding) {
    if (!finding) return;
    finding->subject = config.path.string();
    findings.push_back(*std::move(finding));
  };
  const auto unusable = [&](const std::string& key, const Error& error) {
    add(Finding{.subject = "",
                .key = key,
                .values = {error.message},
                .used = "nothing: what needs it is rejected"});
  };
  for (const CoordinateDefinition& definition : config.transforms) add(finding_of(definition));
  const auto tree = TransformTree::create({}, config.transforms);
  if (!tree) {
    unusable("CoordinateDefinitions", tree.error());
    return findings;
  }
  std::set<std::string> used;
  for (const CoordinateDefinition& definition : config.transforms) used.insert(name_of(definition));
  const TransformLoops loops(*tree, used, "Image", "Probe", kAnySize, kAnySize,
                             config.path.string());
  for (const Finding& finding : loops.findings({})) findings.push_back(finding);
  const auto chain = tree->find("Image", "Probe");
  if (!chain) return findings;  // Not every configuration has a calibration.
  const auto matrix = chain->evaluate({});
  if (!matrix) return findings;
  const auto calibration = calibration_from_matrix(matrix->to_from_from, kAnySize, kAnySize);
  if (!calibration) {
    unusable("ImageToProbe", calibration.error());
    return findings;
  }
  add(placeholder_calibration(*calibration));
  add(other_pixels(config, calibration->grid));
  return findings;
}

}  // namespace nav::io
