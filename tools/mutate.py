#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Runs every verb that reads files over damaged inputs and counts what goes wrong.

  tools/mutate.py --sonde build/dev/app/sonde [--runs 300] [--seed 1] [--only TEXT] [--json FILE]

The seeds, one small valid file of each kind, are made here. Each run damages one input in one to
three ways and is judged against the run of the undamaged input:

  signal, bug      the program was ended by a signal, or its exit code is not documented
  hang             longer than --most-seconds
  memory           more than three times what the undamaged run took, and 256 MiB more
  left behind      a run that failed left a result, an unfinished file or a lock
  words            no error line, several, or control characters in one
  silent change    exit code 0, other results than the undamaged input, no message that is new, and
                   the same counts of frames and poses that cannot be used

Silent changes are listed by kind of file and by what was damaged; docs/robustness.md says which
remain and why. Exit code 1 if there is any of the others, or a silent change of a kind that is not
in the table of that page (column "kind").
"""
import argparse
import collections
import concurrent.futures
import gzip
import hashlib
import json
import math
import os
import random
import re
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SIDE = 16


# ---------------------------------------------------------------- seeds


def step_mm():
    """Spacing of the CT, whose sides are 32 mm."""
    return 32 // SIDE


def ct_values():
    """HU of a ball of bone in flesh, x fastest."""
    values = []
    for z in range(SIDE):
        for y in range(SIDE):
            for x in range(SIDE):
                r = math.dist((x, y, z), (0.45 * SIDE, SIDE // 2, 0.4 * SIDE))
                values.append(700 - 20 * int(r) if r < 4 else 40 + (3 * x + 5 * y + 7 * z) % 11)
    values[0] = -1000
    return values


def meta_ct(compressed):
    raw = struct.pack("<%dh" % SIDE**3, *ct_values())
    data = zlib.compress(raw) if compressed else raw
    head = ("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
            "CompressedData = %s\n%sTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -16 -16 -16\n"
            "CenterOfRotation = 0 0 0\nAnatomicalOrientation = RAI\nElementSpacing = %d %d %d\n"
            "DimSize = %d %d %d\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
            % ((compressed, "CompressedDataSize = %d\n" % len(data) if compressed else "")
               + 3 * (step_mm(),) + 3 * (SIDE,)))
    return head.encode() + data


def nrrd_ct(encoding):
    raw = struct.pack("<%dh" % SIDE**3, *ct_values())
    head = ("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\n"
            "sizes: %d %d %d\nspace directions: (%d,0,0) (0,%d,0) (0,0,%d)\n"
            "kinds: domain domain domain\nendian: little\nencoding: %s\n"
            "space origin: (-16,-16,-16)\n\n"
            % (3 * (SIDE,) + 3 * (step_mm(),) + (encoding,)))
    return head.encode() + (gzip.compress(raw, mtime=0) if encoding == "gzip" else raw)


def nifti_ct():
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, SIDE, SIDE, SIDE, 1, 1, 1, 1)
    struct.pack_into("<2h", head, 70, 4, 16)
    struct.pack_into("<8f", head, 76, 1, *[step_mm()] * 3, 1, 1, 1, 1)
    struct.pack_into("<f", head, 108, 352)
    struct.pack_into("<2f", head, 112, 1, 0)
    head[123] = 2
    struct.pack_into("<2h", head, 252, 1, 1)
    struct.pack_into("<3f", head, 256, 0, 0, 0)
    struct.pack_into("<3f", head, 268, -16, -16, -16)
    for row, at in enumerate((280, 296, 312)):
        line = [0.0, 0.0, 0.0, -16.0]
        line[row] = float(step_mm())
        struct.pack_into("<4f", head, at, *line)
    head[344:348] = b"n+1\0"
    return bytes(head) + struct.pack("<%dh" % SIDE**3, *ct_values())


def element(group, number, kind, value):
    if isinstance(value, str):
        value = value.encode()
    if len(value) % 2:
        value += b"\0" if kind == "UI" else b" "
    if kind in ("OB", "OW", "SQ", "UN", "UT"):
        return struct.pack("<HH2sHI", group, number, kind.encode(), 0, len(value)) + value
    return struct.pack("<HH2sH", group, number, kind.encode(), len(value)) + value


def dicom_slice(k):
    uid = "1.2.826.0.1.3680043.2.1125.1"
    image = ct_values()[k * SIDE * SIDE:(k + 1) * SIDE * SIDE]
    body = b"".join([
        element(8, 0x08, "CS", "ORIGINAL\\PRIMARY\\AXIAL"),
        element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2"),
        element(8, 0x18, "UI", "%s.%d" % (uid, k + 1)),
        element(8, 0x60, "CS", "CT"),
        element(0x18, 0x50, "DS", str(step_mm())),
        element(0x20, 0x0d, "UI", uid + ".100"),
        element(0x20, 0x0e, "UI", uid + ".101"),
        element(0x20, 0x13, "IS", str(k + 1)),
        element(0x20, 0x32, "DS", "-16\\-16\\%d" % (step_mm() * k - 16)),
        element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"),
        element(0x20, 0x52, "UI", uid + ".102"),
        element(0x28, 0x02, "US", struct.pack("<H", 1)),
        element(0x28, 0x04, "CS", "MONOCHROME2"),
        element(0x28, 0x10, "US", struct.pack("<H", SIDE)),
        element(0x28, 0x11, "US", struct.pack("<H", SIDE)),
        element(0x28, 0x30, "DS", "%d\\%d" % (step_mm(), step_mm())),
        element(0x28, 0x100, "US", struct.pack("<H", 16)),
        element(0x28, 0x101, "US", struct.pack("<H", 16)),
        element(0x28, 0x102, "US", struct.pack("<H", 15)),
        element(0x28, 0x103, "US", struct.pack("<H", 1)),
        element(0x28, 0x1052, "DS", "0"),
        element(0x28, 0x1053, "DS", "1"),
        element(0x28, 0x1054, "LO", "HU"),
        element(0x7fe0, 0x10, "OW", struct.pack("<%dh" % len(image), *image)),
    ])
    meta = b"".join([
        element(2, 0x01, "OB", b"\0\1"),
        element(2, 0x02, "UI", "1.2.840.10008.5.1.4.1.1.2"),
        element(2, 0x03, "UI", "%s.%d" % (uid, k + 1)),
        element(2, 0x10, "UI", "1.2.840.10008.1.2.1"),
        element(2, 0x12, "UI", uid + ".9"),
    ])
    group = element(2, 0, "UL", struct.pack("<I", len(meta)))
    return bytes(128) + b"DICM" + group + meta + body


FRAMES = 6
WIDTH, HEIGHT = 32, 24


def recording_pixels():
    return bytes((40 + 3 * x + 5 * y + 11 * f + (x * y) % 7) % 200 + 20
                 for f in range(FRAMES) for y in range(HEIGHT) for x in range(WIDTH))


def frame_fields():
    lines = []
    for f in range(FRAMES):
        angle = 0.02 * f
        c, s = math.cos(angle), math.sin(angle)
        probe = "1 0 0 %.9g 0 %.9g %.9g 0 0 %.9g %.9g -6 0 0 0 1" % (0.5 * f, c, -s, s, c)
        for key, value in (("ProbeToTrackerTransform", probe),
                           ("ProbeToTrackerTransformStatus", "OK"),
                           ("ReferenceToTrackerTransform",
                            "1 0 0 0.00%d 0 1 0 0 0 0 1 0 0 0 0 1" % f),
                           ("ReferenceToTrackerTransformStatus", "OK"),
                           ("ImageToProbeTransform",
                            "0.5 0 0 -8 0 0.5 0 0 0 0 0.5 0 0 0 0 1"),
                           ("ImageToProbeTransformStatus", "OK"),
                           ("Timestamp", "%.6f" % (100 + 0.05 * f)),
                           ("ImageStatus", "OK")):
            lines.append(("Seq_Frame%04d_%s" % (f, key), value))
    return lines


def meta_recording(compressed=False, data="LOCAL", bare=False):
    raw = recording_pixels()
    packed = zlib.compress(raw) if compressed else raw
    fields = [l for l in frame_fields() if not (bare and "ImageToProbe" in l[0])]
    head = ("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
            "CompressedData = %s\n%sDimSize = %d %d %d\nElementSpacing = 1 1 1\n"
            "ElementType = MET_UCHAR\nKinds = domain domain list\n"
            "UltrasoundImageOrientation = MF\nUltrasoundImageType = BRIGHTNESS\n"
            % (compressed, "CompressedDataSize = %d\n" % len(packed) if compressed else "", WIDTH,
               HEIGHT, FRAMES))
    head += "".join("%s = %s\n" % l for l in fields) + "ElementDataFile = %s\n" % data
    return head.encode() + (packed if data == "LOCAL" else b"")


def nrrd_recording():
    head = ("NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: %d %d %d\n"
            "kinds: domain domain list\nencoding: raw\nultrasound image orientation:=MF\n"
            "ultrasound image type:=BRIGHTNESS\n" % (WIDTH, HEIGHT, FRAMES))
    head += "".join("%s:=%s\n" % (k.replace("ImageStatus", "Status"), v)
                    for k, v in frame_fields()) + "\n"
    return head.encode() + recording_pixels()


CALIBRATION = """<?xml version="1.0"?>
<PlusConfiguration version="2.3">
  <CoordinateDefinitions>
    <Transform From="Image" To="Probe" Matrix="0.5 0 0 -8 0 0.5 0 0 0 0 0.5 0 0 0 0 1" Error="0.5"/>
  </CoordinateDefinitions>
</PlusConfiguration>
"""
LANDMARKS = """name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm
p0,8,0,0,9,1,2
p1,-8,3,2,-7,4,4
p2,0,9,5,1,10,7
p3,2,-9,7,3,-8,9
p4,5,5,-8,6,6,-6
"""
SESSION = """[ct]
path = "ct.mha"
[source]
recording = "r.igs.mha"
[placement]
ct_from_reference_mm = [1,0,0,1, 0,1,0,1, 0,0,1,2, 0,0,0,1]
[plan]
entry_mm = [0.0, -12.0, 2.0]
target_mm = [0.0, 2.0, 2.0]
target_radius_mm = 4.0
margin_mm = 3.0
[look]
transfer_function = "ct-bone"
[output]
folder = "out"
width_px = 64
height_px = 48
frames = 1
"""
LOOK = json.dumps({
    "sonde_look": 1, "name": "l",
    "components": [{"name": "o", "nodes": [
        {"value": -100, "rgb": [0.6, 0.2, 0.2], "opacity_per_mm": 0, "importance": 0.5},
        {"value": 135, "rgb": [0.7, 0.3, 0.2], "opacity_per_mm": 0.3, "importance": 0.5},
        {"value": 1000, "rgb": [0.7, 0.3, 0.2], "opacity_per_mm": 0.4, "importance": 0.9}]}],
    "shading": {"enabled": True, "style": "gooch", "emphasis": 0.5}}, indent=1)
PREDICATES = json.dumps({
    "sonde_predicates": 1, "name": "v",
    "predicates": [{"name": "bright", "importance": 0.7, "hue_deg": 0, "saturation": 0.8,
                    "where": {"intensity": {"low": 0.4}}},
                   {"name": "rest", "importance": 0.3, "hue_deg": 35, "saturation": 0.2,
                    "where": {"not": {"entry": "bright"}}}],
    "opacity_length_mm": 2}, indent=1)
SCRIBBLES = json.dumps({
    "sonde_scribbles": 1,
    "strokes": [{"paint": "show", "points_mm": [[-8, 0, 0], [0, 0, 0], [8, 2, 0]],
                 "normal": [0, 0, 1], "radius_mm": 2, "thickness_mm": 4},
                {"paint": "hide", "points_mm": [[-8, 10, 0], [8, 10, 0]], "normal": [0, 0, 1],
                 "radius_mm": 2}]}, indent=1)
SLICER = json.dumps({"volumeProperties": [{
    "effectiveRange": [0, 1000], "isoSurfaceValues": [0], "independentComponents": True,
    "interpolationType": "linear", "components": [{
        "shade": True,
        "rgbTransferFunction": {"type": "colorTransferFunction", "points": [
            {"x": 0, "color": [0.1, 0, 0], "midpoint": 0.5, "sharpness": 0},
            {"x": 600, "color": [1, 0.9, 0.8], "midpoint": 0.5, "sharpness": 0}]},
        "scalarOpacity": {"type": "piecewiseFunction", "points": [
            {"x": 0, "y": 0, "midpoint": 0.5, "sharpness": 0},
            {"x": 600, "y": 0.8, "midpoint": 0.5, "sharpness": 0}]},
        "gradientOpacity": {"type": "piecewiseFunction", "points": [
            {"x": 0, "y": 1, "midpoint": 0.5, "sharpness": 0}]}}]}]}, indent=1)


def cube():
    """Corners and triangles of a box with a knob, which has no symmetry."""
    points, triangles = [], []
    for low, high in (((-5, -5, -5), (5, 5, 5)), ((1, 2, 5), (4, 5, 9)), ((5, -4, -3), (8, 0, 1))):
        base = len(points)
        points += [(low[0] if i & 1 == 0 else high[0], low[1] if i & 2 == 0 else high[1],
                    low[2] if i & 4 == 0 else high[2]) for i in range(8)]
        for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2),
                           (1, 3, 7, 5)):
            triangles += [(base + a, base + b, base + c), (base + a, base + c, base + d)]
    return points, triangles


def surfaces():
    points, triangles = cube()
    binary = bytes(80) + struct.pack("<I", len(triangles))
    text = "solid s\n"
    for t in triangles:
        corners = [points[i] for i in t]
        binary += struct.pack("<12fH", 0, 0, 0, *[v for c in corners for v in c], 0)
        text += "facet normal 0 0 0\nouter loop\n" + "".join(
            "vertex %g %g %g\n" % c for c in corners) + "endloop\nendfacet\n"
    ply = ("ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
           "property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n"
           % (len(points), len(triangles)))
    ply += "".join("%g %g %g\n" % p for p in points)
    ply += "".join("3 %d %d %d\n" % t for t in triangles)
    vtk = ("# vtk DataFile Version 3.0\ns\nASCII\nDATASET POLYDATA\nPOINTS %d float\n" %
           len(points))
    vtk += "".join("%g %g %g\n" % p for p in points)
    vtk += "POLYGONS %d %d\n" % (len(triangles), 4 * len(triangles))
    vtk += "".join("3 %d %d %d\n" % t for t in triangles)
    return {"m.stl": binary, "ma.stl": (text + "endsolid s\n").encode(), "m.ply": ply.encode(),
            "m.vtk": vtk.encode()}


def surface_points():
    rng = random.Random(7)
    points, triangles = cube()
    lines = []
    for _ in range(120):
        a, b, c = (points[i] for i in rng.choice(triangles))
        u, v = sorted((rng.random(), rng.random()))
        lines.append(" ".join("%.6g" % (a[i] * u + b[i] * (v - u) + c[i] * (1 - v))
                              for i in range(3)))
    return "\n".join(lines) + "\n"


def markups():
    """The landmarks as 3D Slicer saves them: touched in RAS, seen in LPS; and a transform."""
    rows = [line.split(",") for line in LANDMARKS.strip().splitlines()[1:]]
    points = [{"label": row[0], "position": [float(x) for x in row[1:4]],
               "positionStatus": "defined"} for row in rows]
    touched = {"@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/"
                          "Markups/Resources/Schema/markups-schema-v1.0.3.json#",
               "markups": [{"type": "Fiducial", "coordinateSystem": "RAS",
                            "coordinateUnits": "mm", "controlPoints": points}]}
    seen = ("# Markups fiducial file version = 5.4\n# CoordinateSystem = LPS\n"
            "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n")
    seen += "".join("%d,%s,0,0,0,1,1,1,0,%s,,,2,0\n" % (i + 1, ",".join(row[4:7]), row[0])
                    for i, row in enumerate(rows))
    transform = ("#Insight Transform File V1.0\n#Transform 0\n"
                 "Transform: AffineTransform_double_3_3\n"
                 "Parameters: -1 0 0 0 -1 0 0 0 1 0 0 0\nFixedParameters: 0 0 0\n")
    return {"lm.mrk.json": json.dumps(touched, indent=1).encode(), "lm.fcsv": seen.encode(),
            "pose.tfm": transform.encode()}


def make_seeds(folder, sonde):
    files = {
        "ct.mha": meta_ct(False), "ctc.mha": meta_ct(True), "ct.nrrd": nrrd_ct("raw"),
        "ctg.nrrd": nrrd_ct("gzip"), "ct.nii": nifti_ct(),
        "ct.nii.gz": gzip.compress(nifti_ct(), mtime=0),
        "r.igs.mha": meta_recording(), "rc.igs.mha": meta_recording(compressed=True),
        "rb.igs.mha": meta_recording(bare=True), "r.igs.nrrd": nrrd_recording(),
        "d.igs.mhd": meta_recording(data="d.raw"), "d.raw": recording_pixels(),
        "cal.xml": CALIBRATION.encode(), "lm.csv": LANDMARKS.encode(),
        "s.toml": SESSION.encode(), "look.json": LOOK.encode(), "p.json": PREDICATES.encode(),
        "scr.json": SCRIBBLES.encode(), "x.vp.json": SLICER.encode(),
        "pts.txt": surface_points().encode(),
    }
    files.update(surfaces())
    files.update(markups())
    for name, content in files.items():
        with open(os.path.join(folder, name), "wb") as file:
            file.write(content)
    os.mkdir(os.path.join(folder, "dcm"))
    for k in range(SIDE):
        with open(os.path.join(folder, "dcm", "i%02d.dcm" % k), "wb") as file:
            file.write(dicom_slice(k))
    made = subprocess.run([sonde, "register", "--landmarks", "lm.csv", "--ct", "ct.mha",
                           "--reference-frame", "Reference", "--json", "reg.json"], cwd=folder,
                          capture_output=True, text=True)
    if made.returncode != 0:
        sys.exit("mutate: the registration of the seeds failed: " + made.stderr)


# ---------------------------------------------------------------- cases

VIEW = ["--width", "64", "--height", "48", "--threads", "1", "--out", "out"]
DRAW = ["--transfer-function", "ct-bone"] + VIEW
REPLAY = ["--frames", "1"] + DRAW
IDENTITY = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"
SLICES = ["--size", "64", "--out", "out"]


def cases():
    """Name of the verb, kind of the file, the file that is damaged, and the words."""
    found = []
    volumes = {"MetaImage": "ct.mha", "MetaImage, compressed": "ctc.mha", "NRRD": "ct.nrrd",
               "NRRD, compressed": "ctg.nrrd", "NIfTI": "ct.nii", "NIfTI, compressed": "ct.nii.gz"}
    recordings = {"recording, MetaImage": "r.igs.mha",
                  "recording, MetaImage, compressed": "rc.igs.mha",
                  "recording, NRRD": "r.igs.nrrd"}
    for kind, file in volumes.items():
        found.append(("info", kind, file, ["info", file, "--json", "info.json"]))
        found.append(("slices", kind, file, ["slices", file] + SLICES))
    found.append(("replay", "MetaImage", "ct.mha",
                  ["replay", "r.igs.mha", "--ct", "ct.mha"] + REPLAY))
    found.append(("predicates", "MetaImage", "ct.mha",
                  ["predicates", "ct.mha", "--predicates", "p.json", "--width", "200", "--height",
                   "200", "--threads", "1", "--out", "p.png"]))
    found.append(("derive", "MetaImage", "ct.mha",
                  ["derive", "ct.mha", "--out", "out", "--feature", "gradient-magnitude"]))
    for verb, words in (("info", ["info", "dcm", "--json", "info.json"]),
                        ("slices", ["slices", "dcm"] + SLICES)):
        found.append((verb, "DICOM", "dcm/i07.dcm", words))
    for kind, file in recordings.items():
        found.append(("info", kind, file, ["info", file, "--json", "info.json"]))
        found.append(("replay", kind, file, ["replay", file, "--ct", "ct.mha"] + REPLAY))
    for file in ("d.igs.mhd", "d.raw"):
        found.append(("replay", "recording, two files", file,
                      ["replay", "d.igs.mhd", "--ct", "ct.mha"] + REPLAY))
    found.append(("reconstruct", "recording, MetaImage", "r.igs.mha",
                  ["reconstruct", "r.igs.mha", "--out", "v.mha", "--threads", "1"]))
    replay = ["replay", "r.igs.mha", "--ct", "ct.mha"]
    found.append(("replay", "calibration", "cal.xml",
                  ["replay", "rb.igs.mha", "--config", "cal.xml", "--ct", "ct.mha"] + REPLAY))
    found.append(("replay", "registration", "reg.json",
                  replay + ["--registration", "reg.json"] + REPLAY))
    found.append(("replay", "session file", "s.toml", ["replay", "--session", "s.toml"]))
    found.append(("replay", "appearance", "look.json",
                  replay + ["--appearance", "look.json", "--frames", "1"] + VIEW))
    found.append(("replay", "Slicer preset", "x.vp.json",
                  replay + ["--appearance", "x.vp.json", "--frames", "1"] + VIEW))
    found.append(("predicates", "predicate set", "p.json",
                  ["predicates", "ct.mha", "--predicates", "p.json", "--width", "200", "--height",
                   "200", "--threads", "1", "--out", "p.png"]))
    found.append(("predicates", "scribbles", "scr.json",
                  ["predicates", "ct.mha", "--predicates", "p.json", "--scribbles", "scr.json",
                   "--width", "200", "--height", "200", "--threads", "1", "--out", "p.png"]))
    found.append(("register", "landmarks", "lm.csv",
                  ["register", "--landmarks", "lm.csv", "--ct", "ct.mha", "--json", "reg2.json"]))
    for file in ("lm.mrk.json", "lm.fcsv"):
        found.append(("register", "Markups", file,
                      ["register", "--landmarks", "lm.mrk.json", "--ct-landmarks", "lm.fcsv",
                       "--ct", "ct.mha", "--json", "reg2.json"]))
    found.append(("replay", "transform", "pose.tfm",
                  replay + ["--ct-from-reference", "pose.tfm"] + REPLAY))
    for kind, file in (("STL, binary", "m.stl"), ("STL, text", "ma.stl"), ("PLY", "m.ply"),
                       ("VTK", "m.vtk")):
        found.append(("register", kind, file,
                      ["register", "--points", "pts.txt", "--surface", file, "--ct-from-reference",
                       IDENTITY, "--json", "reg2.json"]))
    found.append(("register", "points", "pts.txt",
                  ["register", "--points", "pts.txt", "--surface", "m.stl", "--ct-from-reference", IDENTITY,
                   "--json", "reg2.json"]))
    found.append(("replay", "STL, binary", "m.stl",
                  replay + ["--cutaway-mesh", "m.stl"] + REPLAY))
    return found


# ---------------------------------------------------------------- damage

NUMBERS = [b"-1", b"0", b"1", b"2", b"3", b"0.001", b"1000", b"4294967297",
           b"9223372036854775807", b"nan", b"1e999", b"1e300", b"-0", b"%s", b"\x1b[2J"]
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def text_end(content):
    """Number of bytes at the beginning that are text: the header of a file with data."""
    for mark in (b"ElementDataFile = LOCAL\n", b"encoding: raw\nspace", b"\n\n"):
        at = content.find(mark)
        if at >= 0 and content[:4] in (b"Obje", b"NRRD"):
            if content[:4] == b"NRRD":
                return content.find(b"\n\n") + 2
            return at + len(mark)
    if content[:4] == b"\x5c\x01\0\0":
        return 0
    return 0 if b"\0" in content[:4096] or content[:2] == b"\x1f\x8b" else len(content)


def key_at(content, at, end):
    """Name of the part of a file at a byte: the key of a line of a header, or a word."""
    if content[:4] == b"\x5c\x01\0\0":
        return "header" if at < 352 else "voxels"
    if at >= end:
        return "data"
    begin = content.rfind(b"\n", 0, at) + 1
    line = content[begin:content.find(b"\n", begin)]
    line = re.sub(rb"Seq_Frame\d+_", b"frame: ", line)
    key = re.split(rb"[=:,{\[<>]| \d| -\d", line.strip(b' "\t'))[0] if b"frame" not in line else (
        re.split(rb"=|:=", line)[0])
    return key.decode("latin1").strip(' "\t,}]')[:40] or "structure"


def damage(content, rng):
    """Returns the damaged bytes and what was damaged, in words."""
    end = text_end(content)
    where = set()
    for _ in range(rng.choice((1, 1, 2, 3))):
        if not content:
            break
        in_text = end > 0 and rng.random() < 0.8
        at = rng.randrange(min(end, len(content)) if in_text else len(content))
        where.add(key_at(content, at, end))
        kind = rng.randrange(10)
        size = rng.randint(1, 20)
        if kind == 0:
            content = content[:at] + bytes([rng.randrange(256)]) + content[at + 1:]
        elif kind == 1:
            content = content[:at] + bytes([content[at] ^ 1 << rng.randrange(8)]) + content[at + 1:]
        elif kind == 2:
            content = content[:at] + content[at + size:]
        elif kind == 3:
            content = content[:at] + content[at:at + size] + content[at:]
        elif kind == 4:
            content = content[:at] + rng.choice(NUMBERS) + content[at + size:]
        elif kind == 5:
            content = content[:at]
            where.add("end")
        elif kind == 6:
            content += bytes(rng.randrange(256) for _ in range(size))
            where = where - {key_at(content, at, end)} | {"end"}
        elif end == 0:
            block = bytes(rng.randrange(256) for _ in range(size))
            content = content[:at] + block + content[at + size:]
        elif kind == 7:  # A line twice, or not at all.
            begin = content.rfind(b"\n", 0, at) + 1
            stop = content.find(b"\n", at) + 1 or len(content)
            line = content[begin:stop]
            content = content[:begin] + (line * 2 if rng.random() < 0.5 else b"") + content[stop:]
        else:  # Another number.
            numbers = [m for m in NUMBER.finditer(content[:end])]
            if numbers:
                number = rng.choice(numbers)
                where.add(key_at(content, number.start(), end))
                old = number.group()
                scaled = b"%g" % (float(old) * rng.choice((-1, 0.1, 10, 1.01)))
                new = rng.choice((scaled, scaled, rng.choice(NUMBERS)))
                content = content[:number.start()] + new + content[number.end():]
        end = text_end(content)
    return content, ", ".join(sorted(where))


# ---------------------------------------------------------------- runs

# Keys of a report that tell of frames, poses or words that are missing or not usable.
SAID = ("transforms", "ledger", "rejected_poses", "frames_without_image",
        "frames_without_timestamp", "orientation", "image_type")
VOLATILE = {"cast_seconds", "seconds", "device", "update_ms_median", "views_cast"}


def stable(value):
    if isinstance(value, dict):
        return {k: stable(v) for k, v in value.items() if k not in VOLATILE}
    if isinstance(value, list):
        return [stable(v) for v in value]
    return value


def messages_of(stderr):
    """Lines that tell of something: not times, and numbers do not make them new."""
    lines = []
    for line in stderr.splitlines():
        if line.startswith("sonde: ") and " more like this: " not in line:
            lines.append(line)
    return set(lines)


class Outcome:
    pass


def run(sonde, words, folder, most_seconds):
    before = set(os.listdir(folder))
    out = Outcome()
    begin = time.monotonic()
    with open(os.path.join(folder, ".stderr"), "wb") as err, open(
            os.path.join(folder, ".stdout"), "wb") as said:
        process = subprocess.Popen([sonde] + words, cwd=folder, stdout=said, stderr=err,
                                   stdin=subprocess.DEVNULL)
        out.hang = False
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - begin > most_seconds:
                out.hang = True
                process.kill()
                _, status, usage = os.wait4(process.pid, 0)
                break
            time.sleep(0.005)
        process.returncode = status
    out.code = os.waitstatus_to_exitcode(status)
    out.megabytes = usage.ru_maxrss / 1024
    out.seconds = time.monotonic() - begin
    with open(os.path.join(folder, ".stderr"), "rb") as err:
        out.stderr = err.read().decode("utf-8", "replace")
    out.results, out.files, out.said = {}, [], []
    places = [os.path.join(folder, f) for f in os.listdir(folder)
              if f not in before and not f.startswith(".std")]
    for place in places:
        for root, _, names in os.walk(place) if os.path.isdir(place) else [("", None, [place])]:
            for name in names:
                path = os.path.join(root, name)
                out.files.append(os.path.relpath(path, folder))
                if name.endswith((".html", ".toml", ".webp")):
                    continue
                with open(path, "rb") as file:
                    content = file.read()
                if name.endswith(".json"):
                    report = stable(json.loads(content))
                    report.pop("diagnostics", None)
                    report.pop("findings", None)
                    out.said += [report.pop(key, None) for key in SAID]
                    out.said.append((report.get("placement") or {}).get("warnings"))
                    content = json.dumps(report, sort_keys=True).encode()
                out.results[out.files[-1]] = hashlib.sha256(content).hexdigest()
    return out


def faults(damaged, base):
    found = []
    if damaged.hang:
        found.append("hang")
    elif damaged.code < 0:
        found.append("signal %d" % -damaged.code)
    elif damaged.code not in (0, 2, 3, 4, 5):
        found.append("undocumented exit code %d" % damaged.code)
    if damaged.megabytes > 3 * base.megabytes and damaged.megabytes > base.megabytes + 256:
        found.append("memory")
    if damaged.code in (2, 3, 4):
        left = [f for f in damaged.files if not re.search(r"_\d+\.png$", f)]
        if left:
            found.append("left behind: " + ", ".join(left))
    if any(f.endswith(".partial") or f.endswith("lock") for f in damaged.files):
        found.append("unfinished file or lock")
    errors = [l for l in damaged.stderr.splitlines() if l.startswith("sonde: error:")]
    if damaged.code > 0 and len(errors) != 1:
        found.append("words: %d error lines" % len(errors))
    if any(ord(c) < 32 and c != "\n" or ord(c) == 127 for c in damaged.stderr):
        found.append("words: control characters")
    if any(len(l) > 1500 for l in damaged.stderr.splitlines()):
        found.append("words: a line of more than 1500 characters")
    return found


def is_silent(damaged, base):
    if damaged.code != 0 or damaged.results == base.results:
        return False
    if damaged.said != base.said:
        return False
    return not messages_of(damaged.stderr) - messages_of(base.stderr)


def copy_inputs(seeds, folder):
    for name in os.listdir(seeds):
        source = os.path.join(seeds, name)
        if os.path.isdir(source):
            shutil.copytree(source, os.path.join(folder, name))
        else:
            os.link(source, os.path.join(folder, name))


def one(options, seeds, bases, number):
    everything = options.cases
    verb, kind, file, words = everything[number % len(everything)]
    rng = random.Random("%d %d" % (options.seed, number))
    with open(os.path.join(seeds, file), "rb") as source:
        content, where = damage(source.read(), rng)
    with tempfile.TemporaryDirectory(dir=options.work) as folder:
        copy_inputs(seeds, folder)
        os.remove(os.path.join(folder, file))
        with open(os.path.join(folder, file), "wb") as target:
            target.write(content)
        damaged = run(options.sonde, words, folder, options.most_seconds)
    base = bases[number % len(everything)]
    found = faults(damaged, base)
    silent = is_silent(damaged, base)
    if options.keep and (found or silent):
        name = "%06d-%s" % (number, os.path.basename(file))
        with open(os.path.join(options.keep, name), "wb") as target:
            target.write(content)
    return number, verb, kind, where, damaged, found, silent


def defended():
    """Kinds of the table of docs/robustness.md: pairs of kind and what was damaged."""
    pairs = set()
    with open(os.path.join(ROOT, "docs", "robustness.md"), encoding="utf-8") as page:
        for line in page:
            cells = [c.strip().strip("`") for c in line.strip().strip("|").split("|")]
            if line.startswith("| ") and len(cells) == 3:
                for kind in cells[0].split(";"):
                    for part in cells[1].split(";"):
                        pairs.add((kind.strip(), part.strip(" `")))
    return pairs


def is_defended(kind, where, pairs):
    parts = [p.strip() for p in where.split(",")]
    return any((kind, p) in pairs or (kind, "*") in pairs or ("*", p) in pairs for p in parts)


def main():
    parser = argparse.ArgumentParser(description="Runs every verb over damaged inputs.")
    parser.add_argument("--sonde", required=True)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="part of 'verb kind'")
    parser.add_argument("--most-seconds", type=float, default=20)
    parser.add_argument("--keep", help="folder for the damaged files that went wrong")
    parser.add_argument("--json", help="file for the counts")
    options = parser.parse_args()
    options.sonde = os.path.abspath(options.sonde)
    options.cases = [c for c in cases() if options.only in "%s %s" % c[:2]]
    memory = "/dev/shm" if os.path.isdir("/dev/shm") else None
    if options.keep:
        os.makedirs(options.keep, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="sonde-mutate-", dir=memory) as work:
        options.work = work
        seeds = os.path.join(work, "seeds")
        os.mkdir(seeds)
        make_seeds(seeds, options.sonde)
        bases = []
        for verb, kind, _, words in options.cases:
            with tempfile.TemporaryDirectory(dir=work) as folder:
                copy_inputs(seeds, folder)
                base = run(options.sonde, words, folder, 120)
            if base.code not in (0, 5):
                sys.exit("mutate: %s of an undamaged %s: exit code %d: %s"
                         % (verb, kind, base.code, base.stderr))
            bases.append(base)
        codes = collections.Counter()
        wrong = []
        silent = collections.Counter()
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            for number, verb, kind, where, damaged, found, quiet in pool.map(
                    lambda n: one(options, seeds, bases, n), range(options.runs)):
                codes[damaged.code] += 1
                for fault in found:
                    wrong.append("run %d, %s of %s, damaged: %s: %s: %s"
                                 % (number, verb, kind, where, fault,
                                    damaged.stderr.strip()[-300:]))
                if quiet:
                    silent[(kind, where)] += 1
    pairs = defended()
    print("%d runs, exit codes %s" % (options.runs, dict(sorted(codes.items()))))
    undefended = []
    by_kind = collections.Counter()
    for (kind, where), count in sorted(silent.items()):
        known = is_defended(kind, where, pairs)
        by_kind[(kind, "known" if known else "NEW")] += count
        if not known:
            undefended.append("silent change: %s, damaged: %s (%d)" % (kind, where, count))
    for (kind, state), count in sorted(by_kind.items()):
        print("silent changes, %s: %d (%s)" % (kind, count, state))
    for line in wrong + undefended:
        print(line)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({"runs": options.runs, "seed": options.seed, "codes": dict(codes),
                       "wrong": wrong, "silent": [[k, w, c] for (k, w), c in silent.items()]},
                      file, indent=1)
    return 1 if wrong or undefended else 0


if __name__ == "__main__":
    sys.exit(main())
