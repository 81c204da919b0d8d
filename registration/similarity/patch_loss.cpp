// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/patch_loss.hpp"

#include <cmath>

namespace nav::registration {

const char* to_string(PatchLoss loss) {
  switch (loss) {
    case PatchLoss::kNone:
      return "none";
    case PatchLoss::kCauchy:
      return "cauchy";
    case PatchLoss::kGemanMcClure:
      return "geman-mcclure";
  }
  return "none";
}

double RobustLoss::value(double s) const {
  switch (kind) {
    case PatchLoss::kCauchy:
      return std::log1p(s / scale) / std::log1p(1 / scale);
    case PatchLoss::kGemanMcClure:
      return s * (1 + scale) / (s + scale);
    case PatchLoss::kNone:
      break;
  }
  return s;
}

double RobustLoss::derivative(double s) const {
  switch (kind) {
    case PatchLoss::kCauchy:
      return 1 / ((s + scale) * std::log1p(1 / scale));
    case PatchLoss::kGemanMcClure:
      return scale * (1 + scale) / ((s + scale) * (s + scale));
    case PatchLoss::kNone:
      break;
  }
  return 1;
}

}  // namespace nav::registration
