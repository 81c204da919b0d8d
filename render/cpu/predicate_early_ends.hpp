// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "render/spec/predicate_spec.hpp"

namespace nav::render::spec {

/// How engines end rays early with an error of at most `error` in a pixel. Two rules, of which a
/// ray uses one, so that each may spend the whole error:
/// 1. Once 2 (1 - alpha) <= error, samples are left out one by one that are not more important
///    than the state, or so little more that LeftOut can pay for it with the rest of the error.
///    With 1 - beta = min(alpha_k / alpha_k+1, W_k / W_k+1), all the first factors from the first
///    one left out on, the background's among them, multiply to no less than the alpha there, with
///    and without leaving out: each march is within 1 - alpha of the one by the second factors
///    alone. In that one a colour weighs by how far it raised W. What was left out raises the full
///    march's W by what was paid for at most; what follows then raises it by as much less. So the
///    two differ by at most 2 (1 - alpha) and what was paid, which LeftOut keeps within the error.
///    Of one material W misses w by the share that alpha misses 1 by: who may not spend as much as
///    that marches on through more of the same.
/// 2. The ray ends once remaining_change() <= error, if rule 1 has left out nothing visible of it.
///    Between surfaces only the stretch up to the next one ends, which may happen more than once:
///    then 3/4 error.
template <class S>
struct EarlyEnds {
  S leave_out_from;  ///< Opacity of rule 1.
  S leave_out_for;   ///< What LeftOut may spend: the error.
  S end_at;          ///< alpha · exp(-(greatest to come - I)+) of rule 2.
};
template <class S>
EarlyEnds<S> early_ends(double error, bool surfaces) {
  return {static_cast<S>(1 - error / 2), static_cast<S>(error),
          static_cast<S>(1 - (surfaces ? 0.75 : 1) * error)};
}

/// What rule 1 of EarlyEnds has left out of a ray. Leaving out a sample of importance i
/// costs how much of W it could add beyond what was paid for: (exp(i) - exp(paid)) / exp(I); the
/// first one 2 (1 - alpha) besides.
template <class S>
struct LeftOut {
  bool any = false;  ///< Something of some importance was left out: rule 2 is over.
  S spent = S(0);
  S paid = S(0);  ///< Importance; counts while it is more than the state's.

  /// Whether what has at most an importance may be left out; then it is paid for.
  bool pay(const ImportanceState<S>& state, S importance, S budget) {
    if (!(importance > S(0))) return true;
    const S from = std::max(paid, state.importance);
    const S before = any ? spent : S(2) * (S(1) - state.alpha);
    const S rise = std::max(S(0), importance - from);
    const S after = before + std::exp(from - state.importance) * std::expm1(rise);
    if (after > budget) return false;
    any = true;
    spent = after;
    paid = std::max(paid, importance);
    return true;
  }
  /// After a sample that raised the state's importance: what was paid for may be raised again.
  void raised() { paid = S(0); }
};

}  // namespace nav::render::spec
