#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Fails when clang-format 14 would change a C++ file; --fix formats the files instead.
set -euo pipefail
cd "$(dirname "$0")/.."
mode=(--dry-run -Werror)
[ "${1:-}" = "--fix" ] && mode=(-i)
git ls-files -z '*.hpp' '*.cpp' | xargs -0 clang-format-14 --style=file "${mode[@]}"
echo "format: $(git ls-files '*.hpp' '*.cpp' | wc -l) files"
