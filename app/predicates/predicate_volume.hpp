// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "app/console.hpp"
#include "app/predicates/predicate_file.hpp"
#include "app/predicates/predicate_options.hpp"
#include "render/features/derived_features.hpp"
#include "render/predicates/volume_scene.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// Source of the needle and target from which predicates measure distances.
enum class DistancesFrom {
  kOptions,     ///< Needle and target of the options.
  kLiveNeedle,  ///< Tracked needle of a session; target of the options.
  kNoNeedle,    ///< Session without a needle; target of the options.
};

/// Volume from which any predicate set can be prepared: with the features derived so far,
/// intensities as recorded, and `connected` not resolved yet.
struct PredicateSource {
  PredicateFile file;        ///< Predicate set, edits applied.
  PredicateOptions options;  ///< Options given; the value of unknown voxels completed.
  DistancesFrom distances = DistancesFrom::kOptions;
  /// Volume from which features are derived; the same object where every voxel is known.
  std::shared_ptr<const StoredVolume> as_read{};
  render::PredicateVolume volume;
};

/// Volume that is ready to be drawn by predicates.
struct PreparedPredicates {
  PredicateFile file;              ///< Predicate set, edits applied.
  render::PredicateVolume volume;  ///< With the scene part of the set and its features.
  /// The volume without floors and soft thresholds; the same object where there are none.
  std::shared_ptr<const StoredVolume> as_recorded;
  std::shared_ptr<const PredicateSource> source;  ///< For other sets of the same volume.
};

/// Option as a stored value of 16 bits. Precondition: its range was checked.
std::optional<std::int16_t> stored_value(const std::optional<int>& option);

/// Predicate set of the options, a preset or a file, with the options' edits and values. Rejects
/// (kUsage) names that are neither preset nor file, and values that contradict others of the
/// predicate set.
Result<PredicateFile> set_up_of(const PredicateOptions& options);
/// Sphere that shows a target. target: centre x y z and radius, LPS mm.
render::SphereShape target_sphere(const Eigen::Vector4d& target);

/// Reads the predicate set, the volume (or makes the phantom), its labels and scan lines, and
/// derives the features that the predicate set needs. Shows its progress; Ctrl-C ends it
/// (kCancelled). Before it computes features it rejects (kUsage) missing inputs that predicates
/// need and strokes that check_strokes() rejects.
Result<PreparedPredicates> prepare_predicates(
    const PredicateOptions& options, int threads, Console& console,
    DistancesFrom from = DistancesFrom::kOptions,
    const std::vector<render::features::Stroke>& strokes = {});

/// Prepares another predicate set for a volume. Features that it lacks are computed by \p make and
/// kept in \p source. A set without predicates shows nothing. Any thread. Errors: missing inputs
/// that predicates need (kUsage), and those of the features.
Result<render::PredicateVolume> prepare_model(PredicateSource& source,
                                              const render::PredicateModel& model,
                                              const render::MakeFeature& make);

}  // namespace nav::app
