#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Runs everything under everything: all tests of the daily and the release build, benchmarks, and all
# tests that each sanitizer can run. It takes hours on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/install-dependencies.sh test lint tidy fuzz kernel
for preset in dev release asan tsan; do
  printf '\n== %s (%s s)\n' "$preset" "$SECONDS"
  cmake --preset "$preset" -Wno-dev
  cmake --build --preset "$preset" --parallel "$(tools/jobs.sh)"
  ctest --preset "$preset" --label-exclude kernel
done
printf '\n== real kernel (%s s)\n' "$SECONDS"
SONDE_KERNEL_TESTS=on ctest --preset release -L kernel --verbose
printf '\n== clang-tidy (%s s)\n' "$SECONDS"
tools/check_tidy.sh --all
printf '\n== damaged inputs (%s s)\n' "$SECONDS"
python3 tools/mutate.py --sonde build/release/app/sonde --runs 10000 --seed "$(date +%j)"
printf '\n== fuzzers (%s s)\n' "$SECONDS"
tools/fuzz.sh 600
tools/fuzz.sh 600 appearance options predicates session
