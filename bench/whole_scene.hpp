// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene.hpp"

namespace nav::bench {

/// The scene with all elements that a session may add to a CT, in its middle and in proportion to
/// its smallest extent: an ultrasound image with a cutaway, a needle, a target with its margin, the
/// entry point, and two lines.
render::Scene with_everything(render::Scene scene);

}  // namespace nav::bench
