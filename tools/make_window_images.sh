#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
#
# Draws the images of docs/window.md into docs/images, from the simulated procedure. Needs no display.
#   tools/make_window_images.sh [SONDE]     default: build/dev/app/sonde
set -euo pipefail
cd "$(dirname "$0")/.."
QT_QPA_PLATFORM=offscreen "${1:-build/dev/app/sonde}" window --simulated --engine cpu \
  --script docs/window-images.txt --shots docs/images
