#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Runs clang-tidy on .cpp files and the headers that they include; fails when it finds a problem.
# Usage: tools/check_tidy.sh [FILE.cpp...]    default: files changed since the last commit
# A file takes 10 to 30 s, so it is meant for the files of a change, before its commit.
set -euo pipefail
cd "$(dirname "$0")/.."
files=("$@")
if [ ${#files[@]} -eq 0 ]; then
  mapfile -t files < <(git diff --name-only --diff-filter=d HEAD -- '*.cpp')
fi
if [ ${#files[@]} -eq 0 ]; then
  echo "tidy: no .cpp file differs from the last commit."
  exit 0
fi
# Compiles each file by itself: without batches and precompiled headers.
cmake --preset dev -B build/tidy -Wno-dev >/dev/null
# GCC's warning options that clang does not know are ignored.
printf '%s\0' "${files[@]}" |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy-14 -p build/tidy --quiet --warnings-as-errors='*' \
    --extra-arg=-Wno-unknown-warning-option
echo "tidy: ${#files[@]} files"
