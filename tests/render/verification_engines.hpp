// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/render/scene_support.hpp"

namespace nav::test {

/// The engines of this program that the verification tests compare with closed forms. Two programs
/// share these tests: reference and CPU engines (verification_cpu.cpp) and OpenGL
/// (verification_gl.cpp).
const std::vector<EngineCase>& verified_engines();

/// Runs with each engine of the program.
class VerificationTest : public ::testing::TestWithParam<EngineCase> {
 protected:
  std::unique_ptr<render::Engine> engine_ = GetParam().make();
};

}  // namespace nav::test
