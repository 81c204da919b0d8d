// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/render/verification_engines.hpp"

namespace nav::test {
namespace {

std::unique_ptr<render::Engine> make_gl(bool compute) {
  static CollectingDiagnostics diagnostics;
  auto engine = render::make_gl_engine(diagnostics, {compute});
  NAV_CHECK(engine.has_value(), engine ? "" : engine.error().message);
  return std::move(engine).value();
}

}  // namespace

const std::vector<EngineCase>& verified_engines() {
  static const std::vector<EngineCase> cases{{"gl", [] { return make_gl(false); }},
                                             {"gl_compute", [] { return make_gl(true); }}};
  return cases;
}

}  // namespace nav::test
