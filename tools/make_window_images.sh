#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
#
# Draws the images of docs/window.md into docs/images, from the simulated procedure and a phantom. Needs no display.
#   tools/make_window_images.sh [SONDE]     default: build/dev/app/sonde
set -euo pipefail
cd "$(dirname "$0")/.."
sonde=${1:-build/dev/app/sonde}
shoot() {
  QT_QPA_PLATFORM=offscreen "$sonde" window --engine cpu --script "docs/$1" --shots docs/images "${@:2}"
}
shoot window-images.txt --simulated
shoot window-images-predicates.txt --phantom carotid
# The list of controls of the page.
controls=$(mktemp)
trap 'rm -f "$controls"' EXIT
echo "controls docs/window.md" >"$controls"
QT_QPA_PLATFORM=offscreen "$sonde" window --engine cpu --script "$controls"
