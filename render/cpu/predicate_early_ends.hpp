// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "render/spec/predicate_spec.hpp"

namespace nav::render::spec {

/// Rules by which engines end rays early with an error of at most `error` in a pixel. A ray uses
/// only one of the two rules, so each may spend the whole error.
/// 1. Once 2 (1 - alpha) <= error, individual samples are left out: those that are no more
/// important than the state, or so little more that LeftOut can pay for it with the rest of the
/// error. The bound follows from 1 - beta = min(alpha_k / alpha_k+1, W_k / W_k+1). From the first
/// omitted sample on, the product of all first factors, that of the background included, is no less
/// than the alpha there, with and without omissions. So each march is within 1 - alpha of the march
/// with the second factors alone. In that march, the weight of a colour is the amount by which it
/// raised W. The omitted samples raise W of the full march by at most what was paid for; the later
/// samples then raise it by that much less. So the two marches differ by at most 2 (1 - alpha) plus
/// the payment, which LeftOut keeps within the error. In a single material, the share of w that W
/// lacks is the share of 1 that alpha lacks. A ray that may not spend this much marches on through
/// more of the material.
/// 2. The ray ends once remaining_change() <= error, if rule 1 has left out nothing visible.
/// Between surfaces, only the interval up to the next surface ends. This may happen more than once,
/// so the rule then uses 3/4 of the error.
template <class S>
struct EarlyEnds {
  S leave_out_from;  ///< Opacity from which rule 1 applies.
  S leave_out_for;   ///< Amount that LeftOut may spend: the error.
  S end_at;          ///< Least alpha · exp(-(greatest to come - I)+) for rule 2.
};
template <class S>
EarlyEnds<S> early_ends(double error, bool surfaces) {
  return {static_cast<S>(1 - error / 2), static_cast<S>(error),
          static_cast<S>(1 - (surfaces ? 0.75 : 1) * error)};
}

/// Samples that rule 1 of EarlyEnds has left out of a ray. Leaving out a sample of importance i
/// costs the amount of W that it could add beyond what was paid for: (exp(i) - exp(paid)) / exp(I).
/// The first one costs 2 (1 - alpha) more.
template <class S>
struct LeftOut {
  bool any = false;  ///< A sample with an importance > 0 was left out, so rule 2 no longer applies.
  S spent = S(0);
  S paid = S(0);  ///< Importance that was paid for; it counts while it exceeds the state's
                  ///< importance.

  /// True when samples of at most this importance may be left out; this also pays for them.
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
  /// Call it after a sample that raised the state's importance. Omitted samples could then raise it
  /// again, so earlier payments no longer count.
  void raised() { paid = S(0); }
};

}  // namespace nav::render::spec
