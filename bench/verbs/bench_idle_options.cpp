// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_idle_options.hpp"

#include <algorithm>
#include <string_view>

#include "app/options/option_needs.hpp"

namespace nav::bench {

using app::reject_idle;

Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchRenderOptions& options) {
  const bool compares = asks_for(options.parts, "compare");
  const bool lives = asks_for(options.parts, "live");
  const bool skips = names_part(options.parts, "skipping");
  const bool costs = names_part(options.parts, "costs");
  return reject_idle(
      verb,
      {{{"--ct", "--scene"},
        compares || skips || costs,
        "--part compare, skipping or costs",
        "live"},
       {{"--costs"}, lives, "--part live", "others"},
       {{"--width", "--height"}, !options.quick, "no --quick, which has a size of its own", "both"},
       {{"--width", "--height"},
        compares || lives || costs,
        "--part compare, live or costs",
        "skipping"}});
}

Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchPredicatesOptions& options) {
  const std::string& volume = options.volume;
  const bool recorded = !volume.empty() && std::string_view("prostate phantom").starts_with(volume);
  const bool features = !volume.empty() && std::string_view("features").starts_with(volume);
  return reject_idle(
      verb,
      {{{"--side", "--width", "--height"},
        !options.quick,
        "no --quick, which has sizes of its own",
        "both"},
       {{"--side"}, !recorded, "a simulated --volume", volume},
       {{"--side", "--width", "--height"}, !features, "a --volume that is drawn", volume},
       {{"--engine"}, !features || options.engine != "gl", "--volume of another name", volume},
       {{"--look"},
        !features && !volume.empty() && !volume.starts_with("two"),
        "a --volume that has some",
        volume.empty() ? "none" : volume},
       {{"--threads"}, options.engine != "gl", "--engine cpu or both", options.engine},
       {{"--threads"},
        !volume.starts_with("two"),
        "a --volume that is not drawn by one thread",
        volume}});
}

Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchRegistrationOptions& options) {
  const bool cohort = asks_for(options.parts, "cohort");
  const bool faults = asks_for(options.parts, "faults");
  const bool levels = asks_for(options.parts, "levels");
  const bool starts = asks_for(options.parts, "starts");
  const bool only_curve =
      !options.parts.empty() && std::all_of(options.parts.begin(), options.parts.end(),
                                            [](const auto& part) { return part == "curve"; });
  return reject_idle(
      verb,
      {{{"--trials"}, cohort || levels, "--part cohort or levels", "others"},
       {{"--no-evaluation"}, cohort || faults, "--part cohort or faults", "others"},
       {{"--effort"}, cohort || faults || starts, "--part cohort, faults or starts", "others"},
       {{"--patients"}, !only_curve, "a --part other than curve", "curve alone"}});
}

Result<void> reject_idle_of_bench(const CLI::App& verb, const BenchDerivedOptions& options) {
  return reject_idle(
      verb, {{{"--side"}, !options.quick, "no --quick, which has a side of its own", "both"}});
}

}  // namespace nav::bench
