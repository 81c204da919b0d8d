// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene.hpp"

namespace nav::bench {

/// The scene with all that a session may put into a CT, in its middle and in proportion to its
/// least extent: an ultrasound picture that is cut free, a needle, a target with its margin, the
/// entry, and two lines.
render::Scene with_everything(render::Scene scene);

}  // namespace nav::bench
