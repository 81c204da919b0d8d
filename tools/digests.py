#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Prints a digest of every image, pose log and report that Sonde's verbs write.

Two runs of it, before and after a change, show by `diff` whether the change keeps every byte:

    tools/digests.py --sonde build/change/app/sonde > before.txt
    tools/digests.py --sonde build/change/app/sonde > after.txt; diff before.txt after.txt

It runs demo (three seeds), replay and register (recordings simulated by the program itself, or those
of --recording), slices and predicates. A report is digested without its times, its versions and the
paths of the run. Columns: verb, file, digest (SHA-256, first 16 digits).
"""
import argparse
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

SIZE = ("--width", "320", "--height", "240")
# Keys of reports that differ from run to run, or from version to version.
UNSTABLE = ("seconds", "_s", "_ms", "version", "path", "file", "out", "device", "threads", "fps", "bytes")


def stable(value, key=""):
    """A report without what differs between two runs of one program."""
    if isinstance(value, dict):
        return {k: stable(v, k) for k, v in value.items()}
    if isinstance(value, list):
        return [stable(v, key) for v in value]
    times = key.endswith(UNSTABLE) and not key.endswith("timestamp_s")
    return None if times else value


def digest(path):
    data = path.read_bytes()
    if path.suffix == ".json":
        data = json.dumps(stable(json.loads(data)), sort_keys=True).encode()
    return hashlib.sha256(data).hexdigest()[:16]


def run(sonde, name, arguments, folder):
    """Runs a verb with the folder as --out or as the parent of its outputs; prints its digests."""
    done = subprocess.run([sonde, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 5):  # 5: a registration was rejected; its report counts.
        print(f"{name} exit {done.returncode}: {done.stderr.strip().splitlines()[-1:]}")
        return
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix in (".png", ".webp", ".csv", ".json", ".mha"):
            print(name, path.relative_to(folder), digest(path))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sonde", required=True, help="the program")
    parser.add_argument("--ct", help="CT for --recording")
    parser.add_argument("--recording", action="append", default=[], help="recordings to replay on --ct")
    options = parser.parse_args()
    sonde = pathlib.Path(options.sonde).resolve()
    with tempfile.TemporaryDirectory() as top:
        top = pathlib.Path(top)
        for seed in (1, 2, 3):
            out = top / f"demo{seed}"
            run(sonde, f"demo-{seed}", ["demo", "--seed", seed, "--engine", "cpu", "--threads", 2,
                                        *SIZE, "--out", out], out)
        pairs = [(pathlib.Path(r).resolve(), pathlib.Path(options.ct).resolve()) for r in options.recording]
        if not pairs:
            for seed in (1, 2, 3):
                made = top / f"made{seed}"
                made.mkdir()
                subprocess.run([sonde, "simulate", "--seed", str(seed), "--level", "usual",
                                "--out", made / "s.igs.mha", "--ct", made / "ct.mha"], check=True, capture_output=True)
                pairs.append((made / "s.igs.mha", made / "ct.mha"))
        for number, (recording, ct) in enumerate(pairs, 1):
            out = top / f"replay{number}"
            run(sonde, f"replay-{number}", ["replay", recording, "--ct", ct, "--engine", "cpu",
                                            *SIZE, "--out", out], out)
            out = top / f"register{number}"
            out.mkdir()
            run(sonde, f"register-{number}", ["register", recording, "--ct", ct, "--json", out / "r.json"], out)
        out = top / "slices"
        run(sonde, "slices", ["slices", pairs[0][1], "--out", out], out)
        out = top / "predicates"
        out.mkdir()
        run(sonde, "predicates", ["predicates", "--phantom", "carotid", "--engine", "cpu", *SIZE,
                                  "--out", out / "p.png"], out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
