#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Runs everything under everything: all tests of the daily and the release build, benchmarks, and all
# tests that each sanitizer can run. It takes hours on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/install-dependencies.sh test lint tidy
for preset in dev release asan tsan; do
  printf '\n== %s (%s s)\n' "$preset" "$SECONDS"
  cmake --preset "$preset" -Wno-dev
  cmake --build --preset "$preset" --parallel "$(tools/jobs.sh)"
  ctest --preset "$preset"
done
