#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# clang-tidy over .cpp files and the headers that they include; fails when it finds something.
# Usage: tools/check_tidy.sh [FILE.cpp...]    default: what differs from the last commit
# A file takes 10 to 30 s, so that this is for the files of a change, before its commit.
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
# The flags of every file by itself: neither batches nor precompiled headers.
cmake --preset dev -B build/tidy -Wno-dev >/dev/null
# What GCC is told not to warn of, clang does not know.
printf '%s\0' "${files[@]}" |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy-14 -p build/tidy --quiet --warnings-as-errors='*' \
    --extra-arg=-Wno-unknown-warning-option
echo "tidy: ${#files[@]} files"
