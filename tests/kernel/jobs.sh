#!/bin/bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Runs every job in the machine that machine.py has booted: jobs.sh BUILD. Each job leaves its output in
# $OUT/JOB.log, and a line "JOB STATUS SECONDS" in $OUT/results. A job must not need what another left.
set -u
cd "$(dirname "$0")/../.." || exit 1
build=$1
export SONDE="$build/app/sonde"
module() { modprobe -d "$KERNEL_MODULES" "$@"; }

# Runs a function as a job, for at most 240 s: no job, however slow the machine, needs half of that.
job() {
  local name=$1 started=$SECONDS status
  timeout --kill-after=5 240 bash -c "$name" >"$OUT/$name.log" 2>&1
  status=$?
  echo "$name $status $((SECONDS - started))" >>"$OUT/results"
  echo "job $name: status $status, $((SECONDS - started)) s" >/dev/console
}
tests() { "$build/tests/kernel/$1" --gtest_color=no "--gtest_filter=$2"; }

can_socket() { tests kernel_can_test 'CanSocketKernelTest.*'; }
can_slcan() { tests kernel_can_test 'SlcanKernelTest.*'; }

# Witness of the bus: candump writes what it hears, which kernel_test.py gives to tshark.
can_arm() {
  candump -L any >"$OUT/can_arm.candump" &
  local witness=$! status
  tests kernel_can_test 'CanArmKernelTest.*'
  status=$?
  kill "$witness"
  return "$status"
}

usb_polhemus() { tests kernel_usb_test 'PolhemusKernelTest.*'; }
usb_interson() { tests kernel_usb_test 'IntersonKernelTest.*'; }

# Waits until a command succeeds.
until_true() {
  local tries
  for tries in $(seq 300); do
    "$@" >/dev/null 2>&1 && return
    sleep 0.2
  done
  echo "jobs: waited in vain ($tries times) for: $*"
  return 1
}

# The program on both sides: it emulates a tracker and a probe with faults, the kernel has them as USB
# devices, and the program records both as a user would.
usb_sonde() {
  local folder=$OUT/usb kind port emulators=() status
  mkdir -p "$folder"
  cp tests/kernel/usb_simulated.toml tests/kernel/usb_recorded.toml "$folder"
  for kind in polhemus:3240:18944 interson:3241:18945; do
    IFS=: read -r kind port igtl <<<"$kind"
    "$SONDE" emulate "$kind" --session "$folder/usb_simulated.toml" --line "tcp:$port" --port "$igtl" \
      --faults 0.05 >"$folder/$kind.log" 2>&1 &
    emulators+=($!)
    until_true usbip --tcp-port "$port" attach --remote=127.0.0.1 --busid=1-1 || return 1
  done
  until_true lsusb -d 1921:0090 || return 1
  lsusb
  "$SONDE" devices --json "$folder/inventory.json"
  "$SONDE" record --session "$folder/usb_recorded.toml" --out "$folder/usb.mcap" --seconds 20 \
    --json "$folder/report.json"
  status=$?
  "$SONDE" info "$folder/usb.mcap" --json "$folder/info.json" || status=1
  kill -INT "${emulators[@]}"
  wait
  return "$status"
}

export build
export -f can_socket can_slcan can_arm usb_polhemus usb_interson usb_sonde tests until_true
rm -f "$OUT/results"
for name in vcan can-raw slcan vhci-hcd; do module "$name" || exit 1; done
for name in can_socket can_slcan can_arm usb_polhemus usb_interson usb_sonde; do job "$name"; done
! grep -qv '^[a-z_]* 0 ' "$OUT/results"
