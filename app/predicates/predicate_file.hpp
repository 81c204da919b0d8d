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
#include "render/predicates/shading_source.hpp"

namespace nav::app {

/// Tubes that vesselness looks for, when a predicate set uses it.
struct VesselScales {
  double smallest_radius_mm = 0.8;  ///< > 0.
  double largest_radius_mm = 3;     ///< At least the smallest.
  bool bright = false;              ///< Brighter than their surroundings.
};

/// Predicate set that can be stored and used with another data set: nothing in it belongs to one
/// volume. Values that are missing in the file keep their defaults.
struct PredicateFile {
  std::string name;
  render::PredicateModel model;
  double opacity_length_mm = render::PredicateScene{}.opacity_length_mm;
  double cutaway_importance = render::PredicateScene{}.cutaway_importance;
  double shading_mm = 0;  ///< Smoothing of the gradients that shade, mm; 0: no shading.
  double full_gradient_per_mm = render::kUsualFullGradientPerMm;  ///< shading_of_predicates().
  double soft_share = 0;  ///< Width of soft thresholds, as a share of each; 0: steps.
  render::spec::HueMean hue_mean = render::spec::HueMean::kCircular;
  VesselScales vessels{};
  double smoothing_mm = render::features::kUsualSmoothingMm;  ///< Smoothing of gradients.
  render::features::SnrOptions snr{};
  render::features::ConfidenceOptions confidence{};
};

/// Built-in predicate set with that name. The message of kNotFound lists all names.
Result<PredicateFile> preset_predicate_file(const std::string& name);

/// Reads Sonde's JSON of predicates, version 1:
///   {"sonde_predicates": 1, "name": "...",
///    "predicates": [{"name": "vessel", "importance": 0.7, "hue_deg": 0, "saturation": 0.8,
///                    "where": {"all": [{"vesselness": {"low": 0.15, "high": 1}},
///                                      {"not": {"entry": "skin"}}]}}, ..],
///    "opacity_length_mm": 2, "soft_thresholds": 0, "cutaway_importance": 1, "hue_mean":
///    "circular", "vessels": {"smallest_radius_mm": 0.8, "largest_radius_mm": 3, "bright": false},
///    "gradient": {"smoothing_mm": 0.4}, "snr": {"window_voxels": 7, "weights": "uniform"},
///    "confidence": {"alpha": 2, "beta": 90, "gamma": 0.05},
///    "shading": {"smoothing_mm": 1, "full_gradient_per_mm": 0.1}}
/// An expression has one member: "not" with an expression, "all" or "any" with a list of them,
/// "entry" with a name, "connected" with {"least_mm3": V, "of": expression}, or a predicate of the
/// library with its parameters, angles in degrees; missing parameters keep their initial values.
/// Importances are scaled to sum 1. Entries may have a "floor". Rejects files that are larger than
/// 1 MiB, broken or of a newer version, and everything that validate(PredicateModel) rejects. The
/// message names the file, the position, what was expected and what was found.
Result<PredicateFile> read_predicate_file(const std::filesystem::path& path);

/// Reads the same from a text. name: for messages.
Result<PredicateFile> parse_predicate_text(const std::string& name, const std::string& text);

/// Predicate set as JSON; read_predicate_file() returns the same values, except for rounding.
std::string to_json_text(const PredicateFile& file);
/// Writes the predicate set as JSON; the file appears only when it is complete.
Result<void> write_predicate_file(const std::filesystem::path& path, const PredicateFile& file);

}  // namespace nav::app
