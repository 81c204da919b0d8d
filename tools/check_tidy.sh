#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Runs clang-tidy on .cpp files and the headers that they include; fails when it finds a problem.
# Usage: tools/check_tidy.sh [FILE.cpp...]         default: files changed since the last commit
#        tools/check_tidy.sh --since REV [MOST]    files of the commits after REV, at most MOST
#        tools/check_tidy.sh --all
# A file takes 10 to 30 s, so it is meant for the files of a change, before its commit.
set -euo pipefail
cd "$(dirname "$0")/.."
files=()
if [ "${1:-}" = --all ]; then
  mapfile -t files < <(git ls-files '*.cpp' ':!:tests/package')
elif [ "${1:-}" = --since ]; then
  most=${3:-100000}
  if ! git rev-parse --quiet --verify "$2^{commit}" >/dev/null; then
    echo "tidy: expected a commit of this clone, found '$2'; nothing was checked."
    exit 0
  fi
  mapfile -t files < <(git diff --name-only --diff-filter=d "$2" HEAD -- '*.cpp' ':!:tests/package')
  if [ ${#files[@]} -gt "$most" ]; then
    echo "tidy: the first $most of ${#files[@]} files that changed"
    files=("${files[@]:0:$most}")
  fi
elif [ $# -gt 0 ]; then
  files=("$@")
else
  mapfile -t files < <(git diff --name-only --diff-filter=d HEAD -- '*.cpp' ':!:tests/package')
fi
if [ ${#files[@]} -eq 0 ]; then
  echo "tidy: no .cpp file differs."
  exit 0
fi
# Compiles each file by itself: without batches and precompiled headers.
cmake --preset dev -B build/tidy -Wno-dev >/dev/null
# GCC's warning options that clang does not know are ignored.
printf '%s\0' "${files[@]}" |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy-14 -p build/tidy --quiet --warnings-as-errors='*' \
    --extra-arg=-Wno-unknown-warning-option
echo "tidy: ${#files[@]} files"
