// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "nav/result.hpp"
#include "render/features/confidence.hpp"
#include "render/features/gradient.hpp"
#include "render/features/snr.hpp"
#include "render/predicates/predicate_scene.hpp"

namespace nav::app {

/// Which tubes vesselness looks for, where the set-up asks for it.
struct VesselScales {
  double smallest_radius_mm = 0.8;  ///< > 0.
  double largest_radius_mm = 3;     ///< At least the smallest.
  bool bright = false;              ///< Brighter than what surrounds them.
};

/// A predicate set-up that can be stored and carried to another data set: nothing in it belongs to
/// a volume. What the file does not say keeps its default.
struct PredicateFile {
  std::string name;
  render::PredicateModel model;
  double opacity_length_mm = render::PredicateScene{}.opacity_length_mm;
  double cutaway_importance = render::PredicateScene{}.cutaway_importance;
  render::spec::HueMean hue_mean = render::spec::HueMean::kCircular;
  VesselScales vessels{};
  double smoothing_mm = render::features::kUsualSmoothingMm;  ///< Of gradients.
  render::features::SnrOptions snr{};
  render::features::ConfidenceOptions confidence{};
};

/// A built-in set-up by its name; kNotFound lists them.
Result<PredicateFile> preset_predicate_file(const std::string& name);

/// Reads Sonde's JSON of predicates, version 1:
///   {"sonde_predicates": 1, "name": "...",
///    "predicates": [{"name": "vessel", "importance": 0.7, "hue_deg": 0, "saturation": 0.8,
///                    "where": {"all": [{"vesselness": {"low": 0.15, "high": 1}},
///                                      {"not": {"entry": "skin"}}]}}, ..],
///    "opacity_length_mm": 2, "cutaway_importance": 1, "hue_mean": "circular",
///    "vessels": {"smallest_radius_mm": 0.8, "largest_radius_mm": 3, "bright": false},
///    "gradient": {"smoothing_mm": 0.4}, "snr": {"window_voxels": 7, "weights": "uniform"},
///    "confidence": {"alpha": 2, "beta": 90, "gamma": 0.05}}
/// An expression has one member: "not" with an expression, "all" or "any" with a list of them,
/// "entry" with a name, or a predicate of the library with its parameters, angles in degrees;
/// parameters left out keep their initial values. Importances are scaled to sum 1. Refuses files
/// above 1 MiB, broken, of a newer version, and whatever validate(PredicateModel) does; the message
/// names file, place, what was expected and what was found.
Result<PredicateFile> read_predicate_file(const std::filesystem::path& path);

/// The JSON of a set-up; read_predicate_file() gives back the same values but for rounding.
std::string to_json_text(const PredicateFile& file);
/// Writes it; the file appears when it is complete.
Result<void> write_predicate_file(const std::filesystem::path& path, const PredicateFile& file);

}  // namespace nav::app
