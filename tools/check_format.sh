#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Fails when a C++ file differs from what clang-format 14 makes of it; --fix rewrites instead.
set -euo pipefail
cd "$(dirname "$0")/.."
mode=(--dry-run -Werror)
[ "${1:-}" = "--fix" ] && mode=(-i)
git ls-files -z '*.hpp' '*.cpp' | xargs -0 clang-format-14 --style=file "${mode[@]}"
echo "format: $(git ls-files '*.hpp' '*.cpp' | wc -l) files"
