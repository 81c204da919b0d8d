#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and runs every test. Usage: scripts/test.sh [CTest options]
# SONDE_PRESET=NAME: builds and tests another preset than release.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/install-dependencies.sh test
preset=${SONDE_PRESET:-release}
# Reading the same headers takes half of the build time.
cmake --preset "$preset" -Wno-dev -DSONDE_PRECOMPILE=ON
cmake --build --preset "$preset" --parallel "$(tools/jobs.sh)"
ctest --preset "$preset" --label-exclude "bench|kernel" "$@"
