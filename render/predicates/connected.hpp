// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "render/predicates/volume_scene.hpp"

namespace nav::render {

/// Replaces every `connected` of a volume's model by its operand and a bit of the labels: the parts
/// of the voxels where the operand is true, connected by faces, of at least the stated volume, and
/// the voxels around these parts (edges and corners included) that belong to no smaller part.
/// Labels are read at the nearest voxel, so the operand, and not the voxels, draws the border.
/// Evaluated in double precision at the voxels, on all cores; the bits do not depend on their
/// number. Takes a free bit of the labels for each different operand. Errors: kUsage for predicates
/// of a needle or a target inside (they move), labels that are surfaces (--layers), and more than
/// 32 bits.
Result<void> resolve_connected(PredicateVolume& volume);

/// True when a model has a `connected`.
bool has_connected(const PredicateModel& model);

/// An expression in which every reference is replaced by the expression of its entry. Precondition:
/// a valid model.
PredicateExpression without_references(const PredicateModel& model, const PredicateExpression& e);

/// True when an expression without references reads the needle or the target.
bool reads_distances(const PredicateExpression& e);

}  // namespace nav::render
