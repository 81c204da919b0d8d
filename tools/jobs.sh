#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Prints the number of compilers that may run at once: one per core, limited by the memory. A batch
# of files that include Eigen and Ceres takes up to 3 GB.
set -euo pipefail
cores=$(nproc)
fit=$(awk '/^MemAvailable:/ { print int($2 / 3000000) }' /proc/meminfo)
jobs=$((fit < cores ? fit : cores))
echo $((jobs > 1 ? jobs : 1))
