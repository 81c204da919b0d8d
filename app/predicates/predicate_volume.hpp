// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "app/console.hpp"
#include "app/predicates/predicate_file.hpp"
#include "app/predicates/predicate_options.hpp"
#include "render/predicates/volume_scene.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// A volume that predicates can draw.
struct PreparedPredicates {
  PredicateFile file;              ///< The set-up, edits applied.
  render::PredicateVolume volume;  ///< With the scene part that the set-up and its features give.
};

/// An option of a stored value, which its own checks hold within 16 bits.
std::optional<std::int16_t> stored_value(const std::optional<int>& option);

/// A 3D ultrasound volume of a file as io::read_ct reads it, but also of one slice.
Result<Volume> read_ultrasound(const std::filesystem::path& path, Diagnostics& diagnostics);

/// The set-up, a preset by its name or a file, with the edits and values of the options. Refuses
/// (kUsage) names that are neither, and values that the set-up's others rule out.
Result<PredicateFile> set_up_of(const PredicateOptions& options);
/// How a target is drawn: x y z and radius, LPS mm.
render::SphereShape target_sphere(const Eigen::Vector4d& target);

/// Whose needle and target predicates measure distances from.
enum class DistancesFrom {
  kOptions,     ///< Those of the options.
  kLiveNeedle,  ///< The needle of a session, wherever it is; the target of the options.
  kNoNeedle,    ///< Of a session that has none; the target of the options.
};

/// Reads the set-up, the volume (or makes the phantom), its labels and scan lines, and derives the
/// features that the set-up asks for, showing how far it is; Ctrl-C then ends it (kCancelled).
/// Before anything is computed it refuses (kUsage) what
/// predicates ask for and nobody gave, and what check_strokes() does.
Result<PreparedPredicates> prepare_predicates(
    const PredicateOptions& options, int threads, Console& console,
    DistancesFrom from = DistancesFrom::kOptions,
    const std::vector<render::features::Stroke>& strokes = {});

}  // namespace nav::app
