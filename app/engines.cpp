// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/engines.hpp"

#include "nav/threads.hpp"

namespace nav::app {

Result<std::unique_ptr<render::Engine>> make_engine(const std::string& name, int threads,
                                                    Diagnostics& diagnostics) {
  threads = usable_threads(threads);
  if (name == "cpu") return render::make_cpu_engine({.threads = threads});
  if (name == "reference") return render::make_reference_engine({.threads = threads});
  if (name == "gl") return render::make_gl_engine(diagnostics);
  return Error{ErrorCode::kUsage, "--engine: expected cpu, gl or reference, found " + name};
}

}  // namespace nav::app
