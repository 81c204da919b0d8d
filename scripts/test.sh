#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and runs every test. Usage: scripts/test.sh [CTest options]
set -euo pipefail
cd "$(dirname "$0")/.."
tools/install-dependencies.sh test
# Reading the same headers takes half of the build time.
cmake --preset release -Wno-dev -DSONDE_PRECOMPILE=ON
cmake --build --preset release --parallel "$(tools/jobs.sh)"
ctest --preset release --label-exclude bench "$@"
