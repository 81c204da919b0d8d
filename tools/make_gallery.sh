#!/bin/sh
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Draws the pictures of docs/gallery.md anew: tools/make_gallery.sh [path of sonde]
# Needs ImageMagick with WebP; figures 2 and 3 and the prostate need SONDE_DATA_DIR.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
sonde=${1:-$root/build/release/app/sonde}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$sonde" gallery --out "$folder"
"$sonde" predicates --out "$folder/predicates-neck.png"
prostate=${SONDE_DATA_DIR:-$root/../shared/data}/us-predicate/prostatePhantom.mha
if [ -e "$prostate" ]; then
  "$sonde" predicates "$prostate" --out "$folder/predicates-prostate.png"
else
  echo "skipped: the prostate; expected $prostate, found nothing" >&2
fi
mkdir -p "$root/docs/gallery"
for picture in "$folder"/*.png; do
  convert "$picture" -quality 88 "$root/docs/gallery/$(basename "$picture" .png).webp"
done
