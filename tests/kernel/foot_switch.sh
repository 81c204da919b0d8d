#!/bin/bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# A foot switch with three pedals as the kernel's own USB gadget, in the machine of machine.py:
#   foot_switch.sh add VENDOR PRODUCT | unplug | plug | remove
# Its reports of one byte, a bit for each pedal, are written to /dev/hidg0.
set -eu
gadget=/sys/kernel/config/usb_gadget/pedal
case "$1" in
  add)
    mkdir "$gadget"
    cd "$gadget"
    echo "0x$2" >idVendor
    echo "0x$3" >idProduct
    mkdir strings/0x409 configs/c.1 functions/hid.0
    echo Pedal >strings/0x409/product
    echo 1 >functions/hid.0/report_length
    # Generic desktop, undefined; buttons 1 to 3, one bit each, and five bits that fill the byte.
    printf '\x05\x01\x09\x00\xA1\x01\x05\x09\x19\x01\x29\x03\x15\x00\x25\x01\x75\x01\x95\x03\x81\x02\x95\x01\x75\x05\x81\x03\xC0' \
      >functions/hid.0/report_desc
    ln -s functions/hid.0 configs/c.1
    echo dummy_udc.0 >UDC
    ;;
  unplug) echo >"$gadget/UDC" ;;
  plug) echo dummy_udc.0 >"$gadget/UDC" ;;
  remove)
    cd "$gadget"
    [ -z "$(cat UDC)" ] || echo >UDC
    rm configs/c.1/hid.0
    rmdir configs/c.1 functions/hid.0 strings/0x409
    cd /
    rmdir "$gadget"
    exit
    ;;
esac
# The kernel asks for the descriptors a moment later.
vendor=$(cut -c 3- "$gadget/idVendor")
for _ in $(seq 100); do
  present=no
  if grep -qs "^$vendor\$" /sys/class/input/event*/device/id/vendor; then present=yes; fi
  if [ "$1" = unplug ] && [ "$present" = no ]; then exit; fi
  if [ "$1" != unplug ] && [ "$present" = yes ]; then exit; fi
  sleep 0.1
done
echo "foot_switch: waited in vain after: $*" >&2
exit 1
