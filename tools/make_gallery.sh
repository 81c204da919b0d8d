#!/bin/sh
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Draws the images of docs/gallery.md: tools/make_gallery.sh [path of sonde]
# Needs ImageMagick with WebP; figures 2 and 3, prostate and spine need SONDE_DATA_DIR.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
sonde=${1:-$root/build/release/app/sonde}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$sonde" gallery --out "$folder"
"$sonde" demo --out "$folder/demo" --start-error-mm 40 --start-error-deg 20
for picture in sweep_015 approach_029; do
  cp "$folder/demo/$picture.png" "$folder/registration-demo-$picture.png"
done
mkdir -p "$root/docs/gallery"
for picture in "$folder"/*.png; do
  convert "$picture" -quality 88 "$root/docs/gallery/$(basename "$picture" .png).webp"
done
