#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and runs the simulated procedure.
# Usage: scripts/demo.sh [options of 'sonde demo']
set -euo pipefail
cd "$(dirname "$0")/.."
tools/install-dependencies.sh build
# Reading the same headers takes half of the build time.
cmake --preset release -Wno-dev -DSONDE_PRECOMPILE=ON -DSONDE_BUILD_TESTS=OFF -DSONDE_BUILD_BENCH=OFF -B build/demo
cmake --build build/demo --parallel "$(tools/jobs.sh)" --target sonde
build/demo/app/sonde demo --out demo-output "$@"
