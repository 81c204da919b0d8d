// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/render/verification_engines.hpp"

namespace nav::test {

const std::vector<EngineCase>& verified_engines() { return engine_cases(); }

}  // namespace nav::test
