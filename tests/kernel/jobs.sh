#!/bin/bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Runs jobs in the machine that machine.py has booted: jobs.sh BUILD [JOB…], default: all. Each job leaves its output in
# $OUT/JOB.log, and a line "JOB STATUS SECONDS" in $OUT/results. A job must not need what another left.
set -u
cd "$(dirname "$0")/../.." || exit 1
build=$1
shift
all=(can_socket can_slcan can_arm foot_switch udev_rules usb_polhemus usb_interson usb_sonde)
export SONDE="$build/app/sonde"
module() { modprobe -d "$KERNEL_MODULES" "$@"; }

# Runs a function as a job, for at most 400 s. A quiet machine needs a tenth of that.
job() {
  local name=$1 started=$SECONDS status
  timeout --kill-after=5 400 bash -c "$name" >"$OUT/$name.log" 2>&1
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
  tests kernel_can_test 'CanControllerKernelTest.*:CanArmKernelTest.*'
  status=$?
  kill "$witness"
  return "$status"
}

# A pedal as the kernel's own USB gadget: USB, HID and evdev are real.
foot_switch() { tests kernel_usb_test 'FootSwitchKernelTest.*'; }

# udevd has run its rules over a device.
is_initialized() { udevadm info --query=property --path="$1" | grep -q ^USEC_INITIALIZED=; }

# The rules file under systemd's udevd: each device that Sonde knows is tagged for the user who sits at
# the machine, and another one is not.
udev_rules() {
  local id vendor product tag node path expected found status=0
  export SYSTEMD_IGNORE_CHROOT=1  # Otherwise udevadm does nothing in a root folder that is not the first.
  mkdir -p /run/udev/rules.d
  cp share/udev/70-sonde.rules /run/udev/rules.d
  /lib/systemd/systemd-udevd --daemon --resolve-names=never || return 1
  for id in 0f44:ff20:usb 1921:0090:usb 05f3:00ff:input 0c45:7403:input 0f44:ff21:none; do
    IFS=: read -r vendor product tag <<<"$id"
    tests/kernel/foot_switch.sh add "$vendor" "$product" || return 1
    for node in usb input; do
      if [ "$node" = usb ]; then
        path=$(dirname "$(grep -l "^$vendor" /sys/bus/usb/devices/*/idVendor)")
      else
        path=$(dirname "$(grep -l "^$vendor" /sys/class/input/event*/device/id/vendor)")
        path=${path%/device/id}
      fi
      until_true is_initialized "$path" || return 1
      found=$(udevadm info --query=property --path="$path" | grep -c '^TAGS=.*:uaccess:')
      expected=$([ "$tag" = "$node" ] && echo 1 || echo 0)
      echo "$id: $node $path: tagged $found, expected $expected"
      [ "$found" = "$expected" ] || status=1
    done
    tests/kernel/foot_switch.sh remove
  done
  udevadm control --exit
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

# The program records both at once, as a user would.
usb_sonde() { tests kernel_usb_test 'UsbSondeKernelTest.*'; }

export build
export -f "${all[@]}" tests until_true is_initialized
rm -f "$OUT/results"
for name in vcan can-raw kvaser_pci slcan vhci-hcd dummy_hcd usb_f_hid usbhid hid-generic evdev; do
  module "$name" || exit 1
done
mount -t configfs configfs /sys/kernel/config || exit 1
for name in "${@:-${all[@]}}"; do job "$name"; done
! grep -qv '^[a-z_]* 0 ' "$OUT/results"
