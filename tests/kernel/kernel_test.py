#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Boots a real kernel once, runs the jobs of jobs.sh in it, and judges what they left.

    tests/kernel/kernel_test.py --build build/dev [--out DIR] [JOB…]

Environment: SONDE_KERNEL_TESTS=off skips; on: a machine that cannot be made or booted is a failure.
Otherwise it is skipped where a package or the network for the kernel is missing (exit status 77).
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys

import machine

SKIPPED = 77
SECONDS = 900  # For the whole machine; a quiet computer needs a fifth of it.

# Messages of CANopen by the names that tshark gives them, and the least number of each in the log: the
# jobs wait for 20 poses of six joints, set up each joint by four questions, and report one emergency.
CANOPEN = {"NMT: Start remote node": 6, "SYNC": 20, "PDO2 (tx)": 120, "Default-SDO (rx)": 24,
           "Default-SDO (tx)": 24, "NMT Error Control: Operational": 10, "EMCY": 2}


class Failures:
    """Claims that do not hold, by job."""

    def __init__(self):
        self.by_job = {}

    def expect(self, job: str, holds: bool, claim: str) -> None:
        if not holds:
            self.by_job.setdefault(job, []).append(claim)


def judge_canopen(out: pathlib.Path, failures: Failures) -> None:
    """The log of candump, decoded by a foreign program."""
    log = out / "can_arm.candump"
    if not shutil.which("tshark"):
        print("  tshark is missing: the log of the bus is not judged")
        return
    decoded = subprocess.run(["tshark", "-r", log, "-d", "can.subdissector,canopen", "-T", "fields",
                              "-e", "_ws.col.Info"],
                             capture_output=True, text=True).stdout.splitlines()
    print(f"  tshark decodes {len(decoded)} frames of the log of the bus")
    for name, least in CANOPEN.items():
        found = sum(line.startswith(name) for line in decoded)
        failures.expect("can_arm", found >= least, f"tshark: expected {least} of {name} or more, found {found}")


def load(path: pathlib.Path) -> dict:
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return {}


def judge_stream(failures: Failures, job: str, report: dict, device: str, names: list) -> None:
    """Each stream of a device has given samples, and its ledger holds."""
    found = {one["id"]: one for one in report.get("devices", [])}.get(device)
    if found is None:
        return failures.expect(job, False, f"the report has no device {device}")
    for stream in found["streams"]:
        lost = sum(stream["rejected"].values()) + sum(stream["dropped"].values())
        told = stream["delivered"] + stream["superseded"] + lost + stream["waiting"]
        failures.expect(job, stream["received"] == told, f"{device}.{stream['name']}: {stream}")
        # Images are received, but not shown: the session has no calibration.
        came = stream["received"] if stream["type"] == "image" else stream["delivered"]
        failures.expect(job, came > 0, f"{device}.{stream['name']}: nothing came: {stream}")
        names = [name for name in names if name != stream["name"]]
    failures.expect(job, not names, f"{device}: expected the streams {names}, found none")
    print(f"  {device}: " + ", ".join(f"{s['name']} {s['received']} received, {s['delivered']} delivered"
                                      for s in found["streams"])
          + f"; bad {found['bad_messages']}, {found['reconnects']} reconnects")


def judge_arm(out: pathlib.Path, failures: Failures) -> None:
    report = load(out / "arm_report.json")
    judge_stream(failures, "can_arm", report, "arm", ["Probe"])
    failures.expect("can_arm", report.get("ledger_balanced") is True, "ledger_balanced")
    can = load(out / "inventory.json").get("can", [])
    failures.expect("can_arm", {"name": "vcan0", "up": True} in can, f"sonde devices lists {can}")


def judge_usb(out: pathlib.Path, failures: Failures) -> None:
    report = load(out / "usb_report.json")
    judge_stream(failures, "usb_sonde", report, "tracker", ["Probe", "Reference"])
    judge_stream(failures, "usb_sonde", report, "probe", ["Image"])
    failures.expect("usb_sonde", report.get("ledger_balanced") is True, "ledger_balanced")
    recording = report.get("recording") or {}
    received = sum(stream["received"] for device in report.get("devices", []) for stream in device["streams"])
    failures.expect("usb_sonde", recording.get("lost") == 0 and recording.get("written") == received,
                    f"expected {received} recorded samples: {recording}")
    listed = {(one["vendor_id"], one["product_id"]) for one in load(out / "usb_inventory.json").get("usb", [])}
    failures.expect("usb_sonde", {(0x0F44, 0xFF20), (0x1921, 0x0090)} <= listed, f"sonde devices lists {listed}")


def print_job(out: pathlib.Path, name: str, status: str, seconds: str, claims: list) -> None:
    good = status == "0" and not claims
    print(f"{'passed' if good else 'FAILED'}  {name} ({seconds} s)")
    log = (out / f"{name}.log").read_text(errors="replace").splitlines()
    for line in log:
        if line.startswith(("[       OK ]", "[  FAILED  ]")) and line.endswith("ms)"):
            print(f"  {line[13:]}{'' if 'OK' in line[:12] else '  FAILED'}")
    for claim in claims:
        print(f"  FAILED  {claim}")
    if status != "0":
        print(f"  status {status}; the output:")
        print("\n".join(f"    {line}" for line in log[-120:]))


def judge(out: pathlib.Path) -> bool:
    """Prints the outcome of each job; true if all are good."""
    failures = Failures()
    rows = [line.split() for line in (out / "results").read_text().splitlines()]
    judges = {"can_arm": (judge_canopen, judge_arm), "usb_sonde": (judge_usb,)}
    for name, status, seconds in rows:
        for one in judges.get(name, ()):
            one(out, failures)
        print_job(out, name, status, seconds, failures.by_job.get(name, []))
    return bool(rows) and not failures.by_job and all(status == "0" for _, status, _ in rows)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, required=True, help="build folder of Sonde")
    parser.add_argument("--out", type=pathlib.Path, help="folder for logs; default: in the build folder")
    parser.add_argument("jobs", nargs="*", help="names of jobs; default: all")
    options = parser.parse_args()
    wanted = os.environ.get("SONDE_KERNEL_TESTS", "")
    if wanted == "off":
        print("skipped: SONDE_KERNEL_TESTS=off")
        return SKIPPED
    build = options.build.resolve()
    out = (options.out or build / "tests/kernel/out").resolve()
    shutil.rmtree(out, ignore_errors=True)
    jobs = pathlib.Path(__file__).resolve().parent / "jobs.sh"
    try:
        kernel = machine.prepare(build / "tests/kernel/cache")
    except machine.NoMachine as error:
        print(f"{'FAILED' if wanted == 'on' else 'skipped'}: {error}")
        return 1 if wanted == "on" else SKIPPED
    try:
        status = machine.boot(kernel, out, ["/bin/bash", jobs, build, *options.jobs], SECONDS)
    except machine.NoMachine as error:
        print(f"FAILED: {error}")
        return 1
    print(f"kernel {machine.version_of(kernel)}; logs in {out}")
    if not (out / "results").exists():
        print(f"FAILED: no job was run; status {status}\n{machine.last_lines(out)}")
        return 1
    return 0 if judge(out) and status == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
