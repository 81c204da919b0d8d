#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Makes the committed corpora of the fuzzers, tests/fuzz/corpus: small valid inputs of each kind.

  tools/fuzz_corpus.py --sonde build/dev/app/sonde

The files are those of tools/mutate.py, smaller; messages of OpenIGTLink and replies of NDI are made
here after their specifications.
"""
import argparse
import os
import shutil
import struct
import subprocess
import tempfile

import mutate

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CORPUS = os.path.join(ROOT, "tests", "fuzz", "corpus")

FILES = {
    "sequence": ["r.igs.mha", "rc.igs.mha", "rb.igs.mha", "r.igs.nrrd"],
    "ct": ["ct.mha", "ctc.mha", "ct.nrrd", "ctg.nrrd", "ct.nii", "ct.nii.gz"],
    "dicom": ["dcm/i01.dcm"],
    "surface": ["m.stl", "ma.stl", "m.ply", "m.vtk", "pts.txt"],
    "config": ["cal.xml"],
    "json": ["reg.json", "look.json", "scr.json", "p.json"],
    "mcap": ["live.mcap"],
    "landmarks": ["lm.csv"],
    "appearance": ["look.json", "x.vp.json"],
    "predicates": ["p.json", "scr.json"],
    "session": ["s.toml", "live.toml"],
}

OPTIONS = {
    "replay": ["replay", "r.igs.mha", "--ct", "ct.mha", "--out", "out", "--width", "320",
               "--transfer-function", "ct-bone", "--azimuth", "30", "--elevation", "20", "--fov", "25",
               "--threads", "2", "--frames", "5", "--needle-frame", "NeedleTip",
               "--ct-from-reference", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"],
    "register": ["register", "r.igs.mha", "--ct", "ct.mha", "--landmarks", "lm.csv",
                 "--effort", "quick", "--reference-frame", "Reference"],
    "slices": ["slices", "ct.mha", "--out", "s", "--at", "10", "20", "30", "--slab", "4"],
    "simulate": ["simulate", "--out", "a.igs.mha", "--family", "neck", "--columns", "64",
                 "--seed", "7", "--faults", "flip=0.02"],
    "predicates": ["predicates", "us.mha", "--predicates", "p.json", "--out", "x.png",
                   "--black", "10", "--white", "200", "--floor", "bright=0.5"],
}

LIVE = """[source]
kind = "live"
[[devices]]
id = "patient"
kind = "recording"
address = "r.igs.mha"
"""


def crc64(data):
    """ECMA-182, as OpenIGTLink uses it."""
    table = []
    for i in range(256):
        value = i << 56
        for _ in range(8):
            value = (value << 1 ^ 0x42F0E1EBA9EA3693 if value >> 63 else value << 1) & (1 << 64) - 1
        table.append(value)
    crc = 0
    for byte in data:
        crc = table[(crc >> 56 ^ byte) & 255] ^ (crc << 8) & (1 << 64) - 1
    return crc


def igtl(kind, body):
    head = struct.pack(">H12s20sQQ", 1, kind, b"Device", 100 << 32, len(body))
    return head + struct.pack(">Q", crc64(body)) + body


def igtl_messages():
    matrix = struct.pack(">12f", 1, 0, 0, 0, 1, 0, 0, 0, 1, 10, 20, 30)
    element = struct.pack(">20sBB12f", b"Probe", 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 2, 3)
    image = struct.pack(">HBBBB3H12f6H", 1, 1, 3, 1, 1, 4, 3, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0,
                        0, 0, 0, 0, 4, 3, 1) + bytes(range(12))
    return {
        "transform": igtl(b"TRANSFORM", matrix),
        "position": igtl(b"POSITION", struct.pack(">7f", 1, 2, 3, 0, 0, 0, 1)),
        "tdata": igtl(b"TDATA", element * 2),
        "image": igtl(b"IMAGE", image),
        "status": igtl(b"STATUS", struct.pack(">HQ20s", 1, 0, b"none") + b"fine\0"),
        "string": igtl(b"STRING", struct.pack(">HH", 3, 5) + b"hello"),
        "capability": igtl(b"CAPABILITY", b"TRANSFORM\0\0\0IMAGE\0\0\0\0\0\0\0"),
    }


def ndi_crc(data):
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc


def button_events():
    def event(kind, code, value):
        return struct.pack("<qqHHi", 1, 500000, kind, code, value)

    press = event(4, 4, 0x90001) + event(1, 0x100, 1) + event(0, 0, 0) + event(1, 0x100, 0)
    frame = struct.pack("<IB3x8s", 0x18A, 2, b"\1\x80")
    return {"press": press, "lost": event(0, 3, 0) + press, "frame": frame * 2}


def usb_messages():
    def record(station, frame):
        head = b"LY" + struct.pack("<BcBBH", station, b"C", 0x20, 0, 40)
        return head + struct.pack("<IIi3f4f", 4 * frame, frame, 0, 1, 2, 3, 1, 0, 0, 0)

    error = b"LY" + struct.pack("<BcBBH", 0, b"u", 4, 0, 0)
    submit = struct.pack(">12I", 1, 13, 2, 1, 8, 0, 512, 0, 0, 0, 0, 0)
    unlink = struct.pack(">6I24x", 2, 14, 2, 0, 0, 13)
    return {
        "records": record(1, 7) + record(2, 7) + error + record(1, 8)[:30] + record(1, 9),
        "commands": b"\rp\rf1\ru1\rO*,8,9,11,3,7\rh*,1,0,0\rc\rp",
        "lines": bytes([0, 1, 2, 3, 220, 245, 4, 5, 6]),
        "usbip": submit + unlink,
    }


def ndi_replies():
    def text(words):
        return words + b"%04X\r" % ndi_crc(words)

    tool = struct.pack("<BB8fII", 1, 1, 1, 0, 0, 0, 10, 20, -1500, 0.1, 0x31, 77)
    body = tool + struct.pack("<H", 0)
    head = struct.pack("<HH", 0xA5C4, len(body))
    binary = head + struct.pack("<H", ndi_crc(head)) + body + struct.pack("<H", ndi_crc(body))
    return {
        "okay": text(b"OKAY"), "error": text(b"ERROR01"),
        "handles": text(b"020A00010B0012"),
        "tx": text(b"0101+10000+00000+00000+00000+001000-002000-150000+00010000000310000004D\n0000"),
        "bx": binary,
    }


def main():
    parser = argparse.ArgumentParser(description="Makes the corpora of the fuzzers.")
    parser.add_argument("--sonde", required=True)
    options = parser.parse_args()
    sonde = os.path.abspath(options.sonde)
    mutate.SIDE, mutate.FRAMES, mutate.WIDTH, mutate.HEIGHT = 4, 2, 6, 4
    shutil.rmtree(CORPUS, ignore_errors=True)
    with tempfile.TemporaryDirectory() as folder:
        mutate.make_seeds(folder, sonde)
        with open(os.path.join(folder, "live.toml"), "w", encoding="utf-8") as file:
            file.write(LIVE)
        subprocess.run([sonde, "record", "--session", "live.toml", "--out", "live.mcap",
                        "--seconds", "1.5"], cwd=folder, check=True, capture_output=True)
        for name, files in FILES.items():
            os.makedirs(os.path.join(CORPUS, name))
            for file in files:
                shutil.copy(os.path.join(folder, file), os.path.join(CORPUS, name))
    lines = {name: "\n".join(words).encode() for name, words in OPTIONS.items()}
    tables = {"bare.csv": b"\xef\xbb\xbfA;0,5;0;0;1;2;3\nB;9;0;0;10;2;3\nC;0;9;0;1;11;3\n",
              "quoted.csv": b'"A, left","1,5",2,3,4,5,6,0.5\n'}
    quotes = b'[source]\nkind = """"\n[[devices]]\nid = "patient"\nkind = """"\n'
    for name, inputs in (("igtl", igtl_messages()), ("ndi", ndi_replies()),
                         ("buttons", button_events()), ("usb", usb_messages()), ("options", lines),
                         ("landmarks", tables), ("session", {"quotes.toml": quotes})):
        os.makedirs(os.path.join(CORPUS, name), exist_ok=True)
        for kind, content in inputs.items():
            with open(os.path.join(CORPUS, name, kind), "wb") as file:
                file.write(content)


if __name__ == "__main__":
    main()
