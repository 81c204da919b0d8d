#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# How many compilers may run at once: one a core, and no more than memory holds. A batch of files
# with Eigen and Ceres in it takes up to 3 GB.
set -euo pipefail
cores=$(nproc)
fit=$(awk '/^MemAvailable:/ { print int($2 / 3000000) }' /proc/meminfo)
jobs=$((fit < cores ? fit : cores))
echo $((jobs > 1 ? jobs : 1))
