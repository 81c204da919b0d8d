// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/render/scene_support.hpp"

namespace nav::test {

/// The engines of this program that the verification tests hold to closed forms. One source of
/// tests, two programs: reference and CPU (verification_cpu.cpp), OpenGL (verification_gl.cpp).
const std::vector<EngineCase>& verified_engines();

/// For every engine of the program.
class VerificationTest : public ::testing::TestWithParam<EngineCase> {
 protected:
  std::unique_ptr<render::Engine> engine_ = GetParam().make();
};

}  // namespace nav::test
