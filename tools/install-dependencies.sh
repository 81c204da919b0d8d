#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
#
# Installs the Debian 12 packages that Sonde needs; they are listed only here.
#   tools/install-dependencies.sh [build] [test] [lint] [tidy] [fuzz] [kernel]     default: build
# build  compile and run the program and its window
# test   also run the tests and benchmarks
# lint   also the formatter and the shader checker
# tidy   also clang-tidy, which is not needed to build
# fuzz   also Clang with libFuzzer, for tools/fuzz.sh
# kernel also QEMU, and what the tests in a real kernel use there (ctest -L kernel)
# Idempotent: installs only missing packages, without recommended ones, and prints what it does.
set -euo pipefail

build=(
  g++ cmake ninja-build
  libeigen3-dev libceres-dev libglm-dev libtbb-dev                  # mathematics, threads
  libvtk9-dev libvtk-dicom-dev libegl-dev libegl-mesa0 libgl1-mesa-dri # images
  libopencv-core-dev libopencv-imgproc-dev
  libopencv-videoio-dev libopencv-contrib-dev                       # cameras, printed markers
  libusb-1.0-0-dev                                                  # devices
  libcli11-dev libtomlplusplus-dev nlohmann-json3-dev libpugixml-dev # text formats
  zlib1g-dev libpng-dev libwebp-dev libssl-dev libspdlog-dev
  qt6-base-dev fonts-dejavu-core                                    # the window
)
test=(libgtest-dev libgmock-dev libbenchmark-dev xvfb xauth zstd python3)
lint=(clang-format-14 git glslang-tools python3)
tidy=(clang-tidy-14 git)
fuzz=(clang-14 libclang-rt-14-dev)
kernel=(qemu-system-x86 busybox-static cpio kmod iproute2 udev can-utils usbip usbutils tshark python3)

wanted=()
for group in "${@:-build}"; do
  case "$group" in
    build) wanted+=("${build[@]}") ;;
    test) wanted+=("${build[@]}" "${test[@]}") ;;
    lint) wanted+=("${lint[@]}") ;;
    tidy) wanted+=("${build[@]}" "${test[@]}" "${tidy[@]}") ;;
    fuzz) wanted+=("${build[@]}" "${fuzz[@]}") ;;
    kernel) wanted+=("${build[@]}" "${test[@]}" "${kernel[@]}") ;;
    *)
      echo "install-dependencies: expected build, test, lint, tidy, fuzz or kernel, found '$group'" >&2
      exit 2
      ;;
  esac
done

missing=()
for package in $(printf '%s\n' "${wanted[@]}" | sort -u); do
  if ! dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed'; then
    missing+=("$package")
  fi
done
if [ ${#missing[@]} -eq 0 ]; then
  echo "install-dependencies: everything is there."
  exit 0
fi

echo "install-dependencies: installing ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "install-dependencies: expected root or sudo to install packages, found neither" >&2
    exit 4
  fi
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get -q update
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get -q install -y --no-install-recommends "${missing[@]}"
