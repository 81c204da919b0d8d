// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/plus_config.hpp"
#include "nav/result.hpp"
#include "session/options.hpp"

namespace nav::session {

/// The calibrations of the file that options.plus_config names: a PLUS configuration (XML), or a
/// PLUS sequence (.mha, .mhd, .nrrd, .nhdr), of whose first frame those transforms are taken that
/// do not lead to the tracker or the patient. Errors are those of the file.
Result<io::PlusConfig> read_calibrations(const SourceOptions& options);

}  // namespace nav::session
