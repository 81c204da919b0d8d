// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/moment.hpp"

namespace nav::app {

PanelContext context_of(const Moment& moment) {
  return {.epoch = moment.epoch,
          .ct = *moment.ct,
          .plan = moment.plan,
          .window = moment.window,
          .banner = moment.kind,
          .needle_expected = moment.needle_expected,
          .needle_length_mm = moment.needle_length_mm};
}

}  // namespace nav::app
