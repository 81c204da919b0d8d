// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/predicate_atoms.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "nav/index.hpp"

namespace nav::render {
namespace {

/// Converts to single precision, limited to its range.
float single(double x) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(x, -kMost, kMost));
}

void set_range(const PredicateForm& form, const PredicateSet::Channel& channel,
               PredicateAtom& atom) {
  const double slack = 0.5 * channel.quantum;
  atom.kind = PredicateAtom::kRange;
  atom.low = single((form.low - slack - channel.offset) / channel.scale);
  atom.high = single((form.high + slack - channel.offset) / channel.scale);
}

void set_segment(const PredicateForm& form, PredicateAtom& atom) {
  const Eigen::Vector3d axis = form.b - form.a;
  const double square = axis.squaredNorm();
  atom.kind = PredicateAtom::kSegment;
  atom.low = single(form.low * form.low);
  atom.high = single(form.high * form.high);
  for (int i = 0; i < 3; ++i) {
    atom.a[i] = static_cast<float>(form.a[i]);
    atom.axis[i] = static_cast<float>(axis[i]);
    atom.foot[i] = square > 0 ? static_cast<float>(axis[i] / square) : 0.0F;
  }
}

void set_wedge(const PredicateForm& form, const PredicateSet& set, const PredicateSet::Leaf& leaf,
               PredicateAtom& atom) {
  atom.kind = PredicateAtom::kWedge;
  atom.low = single(form.low * form.low);
  double quantum[2] = {};
  for (std::size_t i = 0; i < 2; ++i) {
    const PredicateSet::Channel& channel = set.channels()[as_size(leaf.channels[i])];
    atom.offset[i] = static_cast<float>(channel.offset);
    atom.scale[i] = static_cast<float>(channel.scale);
    quantum[i] = channel.quantum;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 2; ++j) atom.wedge[i][j] = static_cast<float>(form.wedge[i][j]);
    atom.slack[i] = static_cast<float>(wedge_slack(form.wedge[i], quantum));
  }
}

}  // namespace

int rank_of_test(const PredicateAtom& atom) {
  switch (atom.kind) {
    case PredicateAtom::kRange:
      return atom.channel[0] == 0 ? 0 : 3;
    case PredicateAtom::kSlab:
    case PredicateAtom::kSegment:
    case PredicateAtom::kNever:
      return 1;
    case PredicateAtom::kBits:
      return 2;
    default:
      return 4;
  }
}

PredicateAtom atom_of(const PredicateSet& set, const PredicateSet::Leaf& leaf) {
  const PredicateForm form = leaf.kind->form(set.place(), leaf.values);
  PredicateAtom atom{};
  atom.kind = PredicateAtom::kNever;
  for (std::size_t i = 0; i < leaf.channels.size(); ++i) atom.channel[i] = leaf.channels[i];
  switch (form.kind) {
    case PredicateForm::Kind::kRange:
      set_range(form, set.channels()[as_size(leaf.channels[0])], atom);
      break;
    case PredicateForm::Kind::kWedge:
      set_wedge(form, set, leaf, atom);
      break;
    case PredicateForm::Kind::kBits:
      atom.kind = PredicateAtom::kBits;
      atom.mask = static_cast<std::int32_t>(form.mask);
      break;
    case PredicateForm::Kind::kSegment:
      set_segment(form, atom);
      break;
    case PredicateForm::Kind::kSlab:
      atom.kind = PredicateAtom::kSlab;
      atom.low = single(form.low);
      atom.high = single(form.high);
      for (int i = 0; i < 3; ++i) atom.a[i] = static_cast<float>(form.a[i]);
      break;
    case PredicateForm::Kind::kNever:
      break;
  }
  return atom;
}

}  // namespace nav::render
