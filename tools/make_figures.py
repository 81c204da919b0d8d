#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the measurements of docs/figures.md and writes that page and its plots.

    tools/make_figures.py [--build build/release] [--only render ...] [--seeds 8] [--quick]

Results are stored in build/figures/, one JSON file for each part, with date and processor. --only
measures some parts; the others are read from there or kept as they are on the page. On two idle
cores render takes forty minutes, live ten, skipping two, scaling two, and registration (the whole
cohort, twice) an hour. --quick takes six minutes in all and shows fewer scenes and trials. Volumes
other than the simulated patient are read from SONDE_DATA_DIR. The whole page is generated.
"""
import argparse
import datetime
import json
import math
import pathlib
import platform
import statistics
import subprocess
import tempfile
from collections.abc import Callable

import registration_figure

COLOURS = {"cpu": "#f5b183", "cpu, fewer rays": "#d95f02", "gl": "#bdbade", "gl, fewer rays": "#7570b3",
           "gl-fragment": "#e78ac3", "vtk-gpu": "#1b9e77", "vtk-gpu-half": "#99d8c9",
           "vtk-fixedpoint": "#666666"}


def run(*command: object, check: bool = True) -> str:
    return subprocess.run([str(c) for c in command], check=check, capture_output=True,
                          text=True).stdout


def table(header: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)


def demo_rows(sonde: pathlib.Path, seeds: int) -> list[list[str]]:
    rows = []
    for seed in range(1, seeds + 1):
        with tempfile.TemporaryDirectory() as folder:
            run(sonde, "demo", "--out", folder, "--seed", seed, "--frames", 2, "--width", 160,
                "--height", 120, "--step", 2, check=False)
            report = json.loads(pathlib.Path(folder, "report.json").read_text())
        fit = report["registration"]
        predicted = fit["predicted_target_error_rms_mm"]
        rows.append([str(seed), f"{report['start_error_mm']:.1f}",
                     "yes" if fit["accepted"] else "no", f"{report['target_error_mm']:.2f}",
                     "–" if predicted is None else f"{predicted:.2f}", f"{fit['seconds']:.1f}"])
    return rows


PANEL_WIDTH, PANEL_HEIGHT = 430, 320


def decades(values: list[float]) -> tuple[int, int]:
    low = math.floor(math.log10(min(values)))
    return low, max(math.ceil(math.log10(max(values))), low + 1)


def panel(lines: dict[str, tuple[str, list[tuple[float, float]]]], title: str, x_label: str,
          y_label: str) -> str:
    """Plot of named lines (colour, points) with two logarithmic axes, as one group of an SVG."""
    left, right, top, bottom = 62, PANEL_WIDTH - 16, 34, PANEL_HEIGHT - 46
    points = [p for _, line in lines.values() for p in line]
    low_x, high_x = decades([p[0] for p in points])
    low_y, high_y = decades([p[1] for p in points])

    def x(value: float) -> float:
        return left + (math.log10(value) - low_x) / (high_x - low_x) * (right - left)

    def y(value: float) -> float:
        return bottom - (math.log10(value) - low_y) / (high_y - low_y) * (bottom - top)

    out = [f'<text x="{left}" y="20" font-size="13">{title}</text>']
    for decade in range(low_x, high_x + 1):
        at = x(10.0 ** decade)
        out.append(f'<line x1="{at:.1f}" y1="{top}" x2="{at:.1f}" y2="{bottom}" stroke="#ddd"/>'
                   f'<text x="{at:.1f}" y="{bottom + 16}" text-anchor="middle">'
                   f'{10.0 ** decade:g}</text>')
    for decade in range(low_y, high_y + 1):
        at = y(10.0 ** decade)
        out.append(f'<line x1="{left}" y1="{at:.1f}" x2="{right}" y2="{at:.1f}" stroke="#ddd"/>'
                   f'<text x="{left - 5}" y="{at + 4:.1f}" text-anchor="end">'
                   f'{10.0 ** decade:g}</text>')
    out.append(f'<text x="{(left + right) / 2}" y="{PANEL_HEIGHT - 10}" text-anchor="middle">'
               f'{x_label}</text><text x="14" y="{(top + bottom) / 2}" text-anchor="middle" '
               f'transform="rotate(-90 14 {(top + bottom) / 2})">{y_label}</text>')
    for number, (name, (colour, line)) in enumerate(lines.items()):
        path = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in line)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x(a):.1f}" cy="{y(b):.1f}" r="3" fill="{colour}"/>'
                for a, b in line]
        out.append(f'<text x="{right - 4}" y="{top + 14 + 15 * number}" text-anchor="end" '
                   f'fill="{colour}">{name}</text>')
    return "\n".join(out)


def sheet(panels: list[str]) -> str:
    """Puts panels side by side, two in a row."""
    rows = (len(panels) + 1) // 2
    columns = min(len(panels), 2)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {columns * PANEL_WIDTH} '
           f'{rows * PANEL_HEIGHT}" font-family="sans-serif" font-size="11">'
           '<rect width="100%" height="100%" fill="white"/>']
    for number, one in enumerate(panels):
        out.append(f'<g transform="translate({number % 2 * PANEL_WIDTH} '
                   f'{number // 2 * PANEL_HEIGHT})">{one}</g>')
    return "\n".join(out) + "\n</svg>\n"


def front(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The Pareto front: points that no other point beats in both coordinates."""
    kept: list[tuple[float, float]] = []
    for point in sorted(points):
        if not kept or point[1] < kept[-1][1]:
            kept.append(point)
    return kept


def error_panel(rows: list[dict], scene: str, time: str = "cpu_s") -> str:
    """Plots error over process time (or wall_s), one line for each engine."""
    lines = {}
    on_card = time == "wall_s"
    for name, colour in COLOURS.items():
        engine, _, fewer = name.partition(",")
        if on_card and fewer:  # On a card every pixel has a ray.
            continue
        mine = sorted((r for r in rows if r["scene"] == scene and r["engine"] == engine
                       and (fewer or not r["pixel_error"])), key=lambda r: -r["step"])
        points = [(r[time], r["error"]) for r in mine if r[time] > 0 and r["error"] > 0]
        if fewer:
            points = front(points)
        if points:
            lines[name] = (colour, points)
    title = scene if on_card else scene.split("/", 1)[1]
    seconds = "seconds" if on_card else "process seconds"
    return panel(lines, title, f"{seconds} per frame", "rms colour error")


def number(value: float | None, digits: int = 1) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def error_sheets(report: dict, docs: pathlib.Path) -> list[str]:
    """Writes one sheet for each volume and shading; returns the links to them."""
    scenes = list(dict.fromkeys(r["scene"] for r in report["results"]))
    sheets: dict[str, list[str]] = {}
    for scene in scenes:
        shading = scene.rsplit("/", 1)[1]
        sheets.setdefault(f"{scene.split('/', 1)[0]}-{shading}", []).append(scene)
    links = []
    for name, of in sheets.items():
        file = docs / "benchmarks" / f"render-{name}.svg"
        file.write_text(sheet([error_panel(report["results"], s) for s in of]))
        links.append(f"![{name}](benchmarks/{file.name})")
    return links


def ratio_tables(report: dict) -> str:
    ratios = report["ratios"]
    names = {"cpu_vs_vtk_gpu_unshaded": 10, "cpu_vs_vtk_gpu_shaded": 15, "gl_vs_vtk_gpu": 4,
             "cpu_vs_vtk_gpu_any_unshaded": None, "cpu_vs_vtk_gpu_any_shaded": None,
             "gl_vs_vtk_gpu_any": None, "cpu_dense_vs_vtk_gpu_unshaded": None,
             "cpu_dense_vs_vtk_gpu_shaded": None, "gl_dense_vs_vtk_gpu": None,
             "cpu_vs_vtk_fixedpoint": None}
    summary = []
    for name, goal in names.items():
        found = ratios[name]["scenes"].values()
        reached = "" if goal is None else f"{sum(r is not None and r >= goal for r in found)} of {len(found)} reach {goal}"
        summary.append([name, number(ratios[name]["median"]), number(ratios[name]["worst"]), reached])
    columns = ["cpu_vs_vtk_gpu", "cpu_vs_vtk_gpu_any", "gl_vs_vtk_gpu", "gl_vs_vtk_gpu_any",
               "cpu_vs_vtk_fixedpoint"]
    shown = [0.02, 0.01, 0.005, 0.002]
    levels = {(r["scene"], r["name"]): {level["rms"]: level["ratio"] for level in r["levels"]}
              for r in report["equal_error"]}

    def cell(scene: str, name: str) -> str:
        mine = levels.get((scene, name), {})
        return " ".join(number(mine[rms]) if rms in mine else "·" for rms in shown)

    scenes = [[scene] + [cell(scene, name) for name in columns]
              for scene in dict.fromkeys(r["scene"] for r in report["equal_error"])]
    within = [q for q in report["default_quality"] if q["rms_whole"] <= 2e-3]
    quick = [q for q in report["default_quality"] if q["vtk_over_ours"] >= 7]
    chosen = statistics.median(q["vtk_over_ours"] for q in report["default_quality"])
    quality = [[q["scene"], f"{q['step_voxels']:.2f}", f"{q.get('pixel_error', 0):g}", f"{q['estimated_rms']:.4f}",
                f"{1e3 * q['search_cpu_s']:.0f}", f"{q['rms']:.4f}", f"{q['rms_whole']:.4f}",
                f"{1e3 * q['cpu_s']:.0f}", f"{q['vtk_rms']:.4f}",
                f"{1e3 * q['vtk_cpu_s']:.0f}", f"{q['vtk_over_ours']:.1f}",
                number(q["vtk_over_ours_at_2e-3"])]
               for q in report["default_quality"]]
    return f"""CPU time of VTK's mapper over that of Sonde's engine at equal error, along the curves (straight lines in
the logarithms between measured points, no extrapolation): the worst over the errors of a scene from 0.02
to 0.002 rms, or over all if VTK has none there, then median and worst over the scenes. 0: Sonde does not
reach the error. Sonde may interpolate pixels (`quality.pixel_error`). VTK: a ray for every pixel; *any*: or
for a quarter of them, whichever is faster; *dense*: both cast a ray for every pixel.

{table(["comparison", "median of scenes", "worst scene", "scenes"], summary)}

At errors of 0.02, 0.01, 0.005 and 0.002 rms (·: not on VTK's curve; –: Sonde's curve ends before):

{table(["scene"] + columns, scenes)}

Default quality (the step and pixel error that are chosen for an rms of 0.002; 0: a ray for every pixel) beside VTK's GPU
mapper at its default (one voxel). rms: as above, of few pixels; whole: of all pixels, against the engine's own
image at an eighth of the step. Of {len(report["default_quality"])} scenes {len(within)} err no more than 0.002 as a whole,
{len(quick)} take at most a seventh of VTK's time; median {chosen:.1f}:

{table(["scene", "step", "pixel error", "estimated rms", "search ms", "rms", "whole", "cpu ms", "VTK rms", "VTK cpu ms",
        "VTK / Sonde", "VTK / Sonde at 0.002"], quality)}

The last column is VTK's default over Sonde's fastest image of at most 0.002 rms.
"""


def live_section(kept: dict) -> str:
    report = kept["result"]
    ratios = report["ratios"]
    skip, cut, update = (ratios["samples_skip_off_over_on"], ratios["cutaway_plane_fraction"],
                         ratios["image_update_ms"])
    rows = [["time that skipping adds where nothing is empty",
             f"{100 * skip['full_volume_overhead']:.1f} %"],
            ["plane and cutaway, their own work, share of a frame", f"{100 * cut['fraction']:.1f} %"],
            ["an upper bound of it", f"{100 * cut['fraction_at_most']:.1f} %"],
            ["net share, with the samples that they save", f"{100 * cut['net_fraction']:.1f} %"],
            ["samples: CT; and plane; and cutaway",
             f"{cut['samples_ct']}; {cut['samples_without_cutaway']}; "
             f"{cut['samples_with_cutaway']}"],
            ["new ultrasound image, same pose, 800 × 600, wall ms", f"{update['wall_ms']:.2f}"],
            ["volume samples of it", str(update["volume_samples"])],
            ["it is the same bytes as a whole image", "yes" if update["bit_identical"] else "NO"]]
    edit = report.get("transfer_function_edit")
    if edit:
        rows.append([f"transfer function edited at {edit['side']}³: classified anew, ms",
                     f"{edit['prepare_ms']:.2f}"])
    motion = [[m["scene"], str(m["side"]), f"{m['step']:g}", f"{m['pixel_error']:g}",
               f"{m['rms']:.4f}", f"{m['cpu_ms']:.0f}", f"{m['wall_ms']:.0f}", f"{m['fps']:.1f}",
               f"{m['progressive_fps']:.1f}", number(m.get("refined_ms"), 0),
               f"{m['dense_fps']:.1f}"]
              for m in report["interaction"]]
    agreement = [[a["engine"], f"{100 * a['share_within_2_of_255']:.4f} %",
                  str(a["max_of_255"]), f"{a['rms_of_255']:.3f}"] for a in report["agreement"]]
    text = f"""## Rendering: a live session

{when(kept)}

`sonde bench render --part live --costs --json FILE`, CPU engine; the demo's scene with plane, needle,
target, path and cutaway.

{table(["what", "found"], rows)}

A camera that moves around the simulated patient in a cube, shaded, 800 × 600, at the fastest step and
pixel error whose rms is at most 0.01. Progressive: as the progressive renderer draws it, and the time from
the last movement to the whole image. All rays: at the coarsest step whose rms is at most 0.01 with a ray
for every pixel. Wall times are upper bounds.

{table(["scene", "side", "step", "pixel error", "rms", "cpu ms", "wall ms", "fps", "progressive fps",
        "whole after, ms", "fps, all rays"], motion)}
"""
    costs = report.get("costs")
    if costs:
        text += cost_tables(costs)
    return text + f"""
## Agreement of the engines

The same command, on the demo's scene (CT, live plane, needle, target, path, cutaway), against the
double-precision reference at the same step:

{table(["engine", "pixels within 2/255", "max /255", "rms /255"], agreement)}
"""


def cost_tables(costs: dict) -> str:
    def spread(cost: dict, key: str) -> str:
        if cost.get(f"{key}ms") is None:
            return "–"
        return f"{cost[f'{key}ms']:.1f} ± {cost[f'{key}scatter_ms']:.1f}"

    elements = [[c["element"].strip(), spread(c, ""), str(c["samples"]), str(c["gradients"]),
                 spread(c, "idle_"), str(c.get("idle_samples", "–")),
                 str(c.get("idle_gradients", "–"))] for c in costs["elements"]]
    changes = [[c["change"], f"{c['ms']:.2f}", f"{c['wall_ms']:.2f}", f"{c['prepare_ms']:.2f}",
                str(c["samples"]), str(c["gradients"])] for c in costs["changes"]]
    return f"""
Cost of every element in this scene (`sonde bench render --costs`): CPU ms of the image with the element
minus the image without it. Idle: the element is in the scene but has no effect there. ±: how far such
differences lie apart in this run; counts are exact. `--part costs` has such a table for every scene of the set. Whole image:
{costs['frame_ms']:.1f} ms, {costs['frame_samples']} samples.

{table(["element", "ms", "samples", "gradients", "idle ms", "samples", "gradients"], elements)}

From one image to the next:

{table(["change", "cpu ms", "wall ms", "prepare ms", "samples", "gradients"], changes)}
"""


def measured(sonde: pathlib.Path, *arguments: object) -> dict:
    """Runs one verb of sonde and returns its JSON."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "report.json")
        run(sonde, *arguments, "--json", file)
        return json.loads(file.read_text())


def part(file: pathlib.Path, wanted: bool, measure: Callable[[], object]) -> dict | None:
    """Measures a part, or reads its stored date, processor and result; None when nothing is
    stored."""
    if wanted:
        kept = {
            "date": str(datetime.date.today()),
            "processor": processor(),
            "result": measure(),
        }
        file.write_text(json.dumps(kept))
        return kept
    return json.loads(file.read_text()) if file.exists() else None


def standing(page: str, first: str, after: str | None) -> str:
    """The existing sections of a page from one heading up to another."""
    begin = page.find(f"## {first}")
    end = len(page) if after is None else page.find(f"## {after}")
    if begin < 0 or end < 0:
        raise SystemExit(f"docs/figures.md: expected the section '{first}', found none; measure it")
    return page[begin:end]


def processor() -> str:
    """Name of the processor, on which ratios depend. A model number alone may stand for a whole
    series."""
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    found = {}
    for line in lines:
        key, _, value = line.partition(":")
        found.setdefault(key.strip(), value.strip())
    return f"{found.get('model name', platform.machine())}, family {found.get('cpu family', '?')}"


def when(kept: dict) -> str:
    on = f" ({kept['processor']})" if "processor" in kept else ""
    return f"Measured on {kept['date']}{on}."


def render_section(kept: dict, docs: pathlib.Path) -> str:
    report = kept["result"]
    (docs / "benchmarks").mkdir(exist_ok=True)
    for old in (docs / "benchmarks").glob("render-*.svg"):
        old.unlink()
    links = error_sheets(report, docs)
    converged = max(report["self_convergence"].values())
    return f"""## Rendering: run time against error, beside VTK

{when(kept)}

`sonde bench render --part compare --json FILE` at {report['width']} × {report['height']} pixels: every
engine in turn in one process, same camera, step, transfer function and shading; VTK without
automatic sampling distances and without jitter. Errors are those of
{report['reference']['width']} × {report['reference']['height']} pixels of the 8-bit images, evenly
spread, against the double-precision reference at 1/{1 / report['reference']['step']:.0f} voxel, which itself differs by at most
{converged:.1e} rms from one at twice that step. VTK is compared with the better of that and of itself at
that step, so that its different lights do not count. GL device: {report['gl_device']}.

{chr(10).join(links)}

{ratio_tables(report)}
"""


def card_section(kept: dict, docs: pathlib.Path) -> str:
    report = kept["result"]
    if report["time"] != "wall":
        raise SystemExit(f"--card-report: expected a graphics card, found {report['gl_device']}")
    ratios = report["ratios"]
    sheet_file = docs / "benchmarks" / "card.svg"
    shown = [r for r in ratios["gl_vs_vtk_gpu"]["scenes"] if r.startswith(("abdomen/", "aorta/"))
             and "/perspective/" in r]
    sheet_file.write_text(sheet([error_panel(report["results"], s, "wall_s") for s in shown]))
    looks: dict[str, list[str]] = {}
    for scene in ratios["gl_vs_vtk_gpu"]["scenes"]:
        volume, look, _, shading = scene.split("/")
        looks.setdefault(f"{volume}/{look}, {shading}", []).append(scene)

    def least(name: str, scenes: list[str]) -> str:
        return number(min(ratios[name]["scenes"][s] for s in scenes))

    compared = {"gl_vs_vtk_gpu": "a ray for every pixel",
                "gl_vs_vtk_gpu_any": "or for a quarter of them",
                "gl_fragment_vs_vtk_gpu": "by fragment shaders"}
    rows = [[look] + [least(name, of) for name in compared] for look, of in looks.items()]
    middle = ["median of the scenes"] + [number(ratios[name]["median"]) for name in compared]
    found = ratios["gl_vs_vtk_gpu"]["scenes"].values()
    return f"""## Rendering: on a graphics card

`sonde bench render --part compare --json FILE` on {report['gl_device']}, {kept['date']}, at
{report['width']} × {report['height']} pixels; drawn by `tools/make_figures.py --only card --card-report FILE`. As above, but
in wall time, of images that stay on the card. The CPU engine and the fixed-point mapper run on the processor of the machine. Speed of the GL engine over VTK's GPU mapper at equal error, the
worst over the errors from 0.02 to 0.002 rms and over both cameras; {sum(r >= 3 for r in found)} of {len(found)} scenes reach 3:

{table(["appearance", *compared.values()], rows + [middle])}

![on a graphics card](benchmarks/card.svg)
"""


def skipping_section(kept: dict) -> str:
    scenes = kept["result"]["skip_bounds"]

    def row(name: str, some: list[dict]) -> list[str]:
        def times(key: str, over: str = "samples_off") -> str:
            return number(statistics.median(s[over] / s[key] for s in some), 2)

        def share(edge: int) -> str:
            of = [b["occupied"] for s in some for b in s["bricks"] if b["edge"] == edge]
            return f"{100 * statistics.median(of):.0f} %"

        def ideal(edge: int) -> str:
            left = [(s["oracle_all"] - s["oracle_opaque"]) / b["samples"]
                    for s in some for b in s["bricks"] if b["edge"] == edge]
            return number(statistics.median(left), 2)

        shows = statistics.median((s["oracle_all"] - s["oracle_opaque"]) / s["oracle_showing"]
                                  for s in some)

        return [name, times("samples_first"), times("samples_on"), times("samples_on", "samples_brute"),
                ideal(8), ideal(4), ideal(2), ideal(1), number(shows, 2),
                share(8), share(4), share(2), share(1)]

    looks: dict[str, list[dict]] = {}
    for scene in scenes:
        looks.setdefault("/".join(scene["scene"].split("/")[:2]), []).append(scene)
    of_set = [s for s in scenes if not s["scene"].startswith("patient-")]
    rows = [row(name, some) for name, some in looks.items()]
    rows.append(row("median of the scene set", of_set))
    header = ["appearance", "first image", "later ones", "and no early ends", "8³", "4³", "2³", "cells",
              "cells that show", "8³ occupied", "4³", "2³", "cells"]
    return f"""## Rendering: samples with skipping and without

{when(kept)}

`sonde bench render --part skipping --json FILE`: 200 × 150 pixels, half a voxel per step; medians of both
cameras; shading does not change them. Samples without skipping over samples with it: in the first image
with a transfer function, when only bricks are tested; in later images, by visible cells
([rendering performance](rendering-performance.md#skipping)); and the same without early termination, which
all others have. Beside it: what ideal bricks of these sizes would leave, if each ray tested every brick that
it enters and took no sample in vain, and a march that knew beforehand which cells contribute to a pixel. The
scene set excludes the patients in cubes.

{table(header, rows)}
"""


def scaling_section(kept: dict, docs: pathlib.Path) -> str:
    points = kept["result"]["points"]
    labels = {"side": "voxels a side", "pixels": "pixels", "threads": "threads",
              "occupied": "share of bricks occupied"}
    palette = ["#d95f02", "#7570b3", "#1b9e77"]
    panels = []
    for axis, label in labels.items():
        here = [p for p in points if p["axis"] == axis and p["x"] > 0]
        if not here:
            continue
        looks = ["all"] if axis == "occupied" else list(dict.fromkeys(p["look"] for p in here))
        lines = {}
        for colour, look in zip(palette, looks):
            mine = sorted((p for p in here if look in ("all", p["look"])), key=lambda p: p["x"])
            key = "wall_ms" if axis == "threads" else "cpu_ms"
            lines["tissue above a value" if look == "all" else look] = (
                colour, [(p["x"], p[key]) for p in mine])
        unit = "wall ms per frame" if axis == "threads" else "process ms per frame"
        panels.append(panel(lines, f"time against {label}", label, unit))
    (docs / "benchmarks" / "scaling.svg").write_text(sheet(panels))
    rows = [[p["axis"], p["look"], f"{p['x']:g}" if p["axis"] != "occupied" else f"{p['x']:.3f}",
             f"{p['cpu_ms']:.1f}", f"{p['wall_ms']:.1f}", f"{p['prepare_ms']:.1f}",
             str(p["samples"]), f"{p['occupied']:.3f}", number(p["bytes_per_voxel"], 2)]
            for p in points]
    return f"""## Rendering: scaling

{when(kept)}

`sonde bench scaling --json FILE`: the simulated patient in a cube of 300 mm, CPU engine, shaded,
800 × 600, half a voxel per step, unless the axis says otherwise. `prepare` is the time that a new volume
needs once. Bytes per voxel are the growth of the process when it first draws the volume, without the
volume's own 2 bytes and 16 bytes per pixel; other data per pixel weigh on small volumes.

![scaling](benchmarks/scaling.svg)

{table(["axis", "appearance", "x", "cpu ms", "wall ms", "prepare ms", "samples", "occupied",
        "bytes/voxel"], rows)}
"""


def success_lines(peer: list[dict]) -> str:
    names = list(dict.fromkeys(row["name"] for row in peer))
    starts = sorted({row["start_mm"] for row in peer})
    cell = {(row["name"], row["start_mm"]): row for row in peer}
    def times(c: dict) -> str:
        keys = ["cpu_s", "solve_cpu_s", "end_to_end_cpu_s"]
        return ", ".join(number(c[key], 3) for key in keys if c[key] is not None)

    return table(["right / trials (median mm; processor s)"] + [f"{s:g} mm" for s in starts],
                 [[name] + [f"{c['right']}/{c['trials']} ({number(c['error_median_mm'], 2)}; "
                            f"{times(c)})"
                            for c in (cell[name, s] for s in starts)] for name in names])


def fault_table(faults: list) -> str:
    """Table of the sweeps with faults, with the evaluation seeds beside the development seeds."""
    rows = {}
    for f in faults:
        none = f["fault"] == "none"
        size = f"× {f['size']:g}" if f["unit"] == "x" else f"{f['size']:g} {f['unit']}"
        right = f"{f['named']} named" if none else f"{f['named_right']}/{f['named']}"
        verdicts = f"{f['clear']}, {f['warned']}, {f['refused']} ({f['false_accepts']})"
        errors = f"{number(f['error_mean_mm'], 2)}, {number(f['error_max_mm'], 2)}"
        rows.setdefault((f["fault"].replace("_", " "), "" if none else size), {})[f["seeds"]] = [
            verdicts, errors, number(f["actual_over_predicted"], 2), right]
    seeds = [s for s in ["development", "evaluation"] if any(s in r for r in rows.values())]
    header = ["fault", "size"]
    for s in seeds:
        header += [f"{s}: clear, warned, refused (false)", "error mean, max", "actual / predicted",
                   "cause right"]
    return table(header, [[*key] + [c for s in seeds for c in row.get(s, ["–"] * 4)]
                          for key, row in rows.items()])


def fault_section(report: dict) -> str:
    """Section about faults; empty when they were not measured."""
    faults = report.get("faults")
    if not faults:
        return ""
    times = [f["misfits_cpu_ms"] for f in faults if f["misfits_cpu_ms"] is not None]
    return f"""
Faults: sweeps with an error that no pose explains. Number accepted without warnings, accepted with
warnings, and refused; in brackets: accepted with a target error above 3 mm. Mean and largest target error
of the accepted, mm, and the median of it over the predicted error. Runs in which the named cause is the
true one, of those that name a cause. Testing for causes takes
{number(statistics.median(times), 1) if times else "–"} CPU ms.

{fault_table(faults)}
"""


def slice_section(report: dict) -> str:
    """Section about slices; empty when they were not measured."""
    points = [p for p in report["curve"] if p["axis"] == "slices"]
    if not points:
        return ""
    rows = [[f"{p['x']:g} mm", f"{p['right']}/{p['trials']}", number(p["error_median_mm"], 2),
             number(p["error_p95_mm"], 2), number(p["cpu_s"], 3)] for p in points]
    return f"""
Slices of a CT averaged to thicker slices, local from 5 mm, one sweep for each patient:

{table(["slices", "right", "median mm", "p95 mm", "processor s"], rows)}
"""


def start_section(report: dict) -> str:
    """Section about starts; empty when they were not measured."""
    starts = report.get("starts")
    if not starts:
        return ""

    def hidden(p: dict) -> str:
        if not p["own_ct"]:
            return "–"
        return " to ".join("any" if p[key] is None else number(p[key], 1)
                           for key in ["hidden_least_mm", "hidden_most_mm"])

    rows = [[p["path"], "own" if p["own_ct"] else "other", str(p["sweeps"]),
             f"{p['same']}/{p['registrations']}", f"{p['accepted']} ({p['elsewhere']})", str(p["split"]),
             f"{number(p['apart_mm'], 2)}, {number(p['apart_max_mm'], 2)}",
             f"{number(p['predicted_ratio'], 2)}, {number(p['predicted_ratio_max'], 2)}",
             hidden(p)] for p in starts]
    header = ["sweep", "CT", "sweeps", "at the cheapest pose", "accepted (elsewhere)", "two verdicts",
              "apart, mm", "predicted, largest / smallest", "calibration hides, mm"]
    return f"""
One sweep from eight starts, 3 to 10 mm off. *At the cheapest pose*: runs that reach the pose of least cost
of the sweep. *Accepted*: how many of these are accepted; in brackets: accepted at another pose. *Two verdicts*:
sweeps in which one pose is accepted from some starts only. *Apart* and *predicted*: median and maximum over
sweeps of the largest distance from the cheapest pose, and of the largest over the smallest predicted error.
*Calibration hides*: calibration error without a warning, in the direction that the sweep shows least. –: no
prediction from some starts. A rock swings within one plane, which tells little.

{table(header, rows)}
"""


def registration_section(kept: dict, docs: pathlib.Path) -> str:
    """Section about cohort, curve, peer and faults; draws the curve."""
    report = kept["result"]
    panels = []
    for axis, label in [("patches", "share of the patches"), ("pictures", "images in the sweep"),
                        ("levels", "levels, coarse to fine"),
                        ("precision", "mm between the finest samples"),
                        ("quick", "share of a quick one's patches")]:
        rows = [p for p in report["curve"] if p["axis"] == axis and p["error_median_mm"]]
        if not rows:
            continue
        lines = {name: (colour, [(p[key], p["error_median_mm"]) for p in rows])
                 for name, colour, key in [("solve", "#d95f02", "solve_cpu_s"),
                                           ("with the sweep's preparation", "#7570b3", "cpu_s")]}
        panels.append(panel(lines, label + ": " + ", ".join(f"{p['x']:g}" for p in rows),
                            "process seconds", "median target error, mm"))
    (docs / "benchmarks" / "registration.svg").write_text(sheet(panels))
    (docs / "benchmarks" / "registration-success.svg").write_text(
        registration_figure.drawing(report))
    keys = ["trials", "tre_median_mm", "tre_p95_mm", "success_local_10mm", "success_from_40mm",
            "false_accepts", "false_accept_bound", "false_refusals", "right", "hopeless_refused",
            "coverage_95", "coverage_95_se", "local_cpu_s", "global_cpu_s", "ct_cpu_s"]
    counts = {"trials", "false_accepts", "false_refusals", "right"}
    last = report["summary"]
    summary = table(["", "development", "evaluation"],
                    [[key] + [number(report[seeds][key], 0 if key in counts else 3)
                              for seeds in ["development", "summary"]] for key in keys])
    return f"""## Registration: accuracy, success, refusals, time

{when(kept)}

`sonde bench registration --json FILE` ([keys](json.md#bench-registration)), simulated patients, one thread:

{summary}

![registration](benchmarks/registration.svg)

Correct results against the error of the start: Sonde's cohort on the evaluation seeds, and elastix and the
quick effort on the four patients of the table below:

![success](benchmarks/registration-success.svg)

Beside elastix (mutual information, rigid), same images and starts; {last["peer_theirs"] or "elastix"},
the cheapest of its settings that converges, over {last["peer_ours"] or "ours"} at the nearest start
([definition](json.md#bench-registration)):
{number(last["cpu_ratio_elastix"])} from images in memory to the pose, preparation included,
{number(last["solve_cpu_ratio_elastix"])} solving alone,
{number(last["end_to_end_cpu_ratio_elastix"])} of whole processes from files.

In brackets: median error in mm, and CPU s from images in memory, of solving alone, and of the process
from files if it was measured. Sonde quick: `--effort quick`; x0.5: half of the patches.

{success_lines(report["peer"])}
{slice_section(report)}{fault_section(report)}{start_section(report)}"""


PARTS = ["demo", "registration", "render", "skipping", "live", "scaling", "poses", "devices"]
CARD = "card"  # Measured if there is a graphics card.


def pose_lines(build: pathlib.Path) -> str:
    text = run(build / "bench/tracking/tracking_bench", "--benchmark_format=console")
    return "\n".join(line for line in text.splitlines() if line.startswith("BM_"))


def demo_section(kept: dict) -> str:
    header = ["patient", "start error mm", "accepted", "target error mm", "predicted rms mm", "s"]
    return f"""## Demo: from 10 mm and 8° to the target

`sonde demo --out DIR --seed N`. {when(kept)}

{table(header, kept["result"])}
"""


def poses_section(kept: dict) -> str:
    return f"""## Poses between samples: rate against error

`tracking_bench`: a hand that sways by 30 mm and 0.3 rad once per second, sampled at a rate in Hz.
{when(kept)}

```
{kept["result"]}
```
"""


def devices_section(kept: dict) -> str:
    faults = kept["result"]["faults"] + [kept["result"]["faults_all"]]
    counts = ["recordings", "images", "valid", "wrong"]
    rows = [[f["fault"], *(str(f[key]) for key in counts), f"{f['worst_mm']:.1f}",
             str(f["good"]), str(f["withheld"])] for f in faults]
    clock = [[f"{c['rate_hz']:g}", f"{c['stamp_ms']:g}", f"{c['error_p95_ms']:.3f}",
              f"{c['error_max_ms']:.2f}", f"{c['skew_ppm']:.1f}", str(c["rejected"]), str(c["false_steps"]),
              f"{c['steps_found']:.3f}", f"{c['ns_per_sample']:.0f}"] for c in kept["result"]["clock"]]
    codecs = [[c["codec"], str(c["bytes"]), f"{c['messages_per_s']:.2g}", f"{c['mb_per_s']:.0f}", c["goal"] or ""]
              for c in kept["result"]["codecs"]]
    recorder = kept["result"]["recorder"]
    where = "in memory" if recorder["memory_backed"] else "on a disk"
    return f"""## Live devices: faults, clocks, codecs, recorder

`sonde bench devices`. {when(kept)} Freehand paths with tremor, optical and electromagnetic trackers and
arms at 20 to 100 Hz with noise, delays of 5 to 60 ms and losses, images at 10 to 40 Hz; the fault of a
row comes again and again in one of the streams. `wrong`: images shown as valid with a corner more than
5 mm from the truth. `good`: images that no fault came near to; `withheld`: those of them that were rejected, or degraded
or lost when they were shown.

{table(["fault", "recordings", "images", "shown as valid", "wrong", "worst mm", "good", "withheld"],
       rows)}

The clock of a device that is 100 ppm fast, by a link with a least delay of 8 ms, a tail of 5 ms and
20 % losses, for an hour. Errors but for a constant, from 10 s on; a step of 150 ms is found if
no wrong time is believed after 200 ms.

{table(["rate Hz", "stamps ms", "error p95 ms", "max ms", "skew ppm", "rejected", "false steps",
        "steps found", "ns a sample"], clock)}

Messages found, checked and decoded on one core; replies of NDI hold three tools.

{table(["codec", "bytes", "messages/s", "MB/s", "goal"], codecs)}

The recorder takes 60 images of 820 x 616 and the poses of three bodies at 400 Hz a second, {where}:
{recorder["mb_per_s"]:.0f} MB of pixels a second at full speed (goal: 200); at the true pace for {recorder["seconds"]:.0f} s
{100 * recorder["core_share"]:.1f} % of a core, what makes the samples included (goal: 5 %);
{recorder["samples"]} samples, {recorder["lost"]} lost.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--only", nargs="+", choices=[*PARTS, CARD], default=PARTS)
    parser.add_argument("--card-report", type=pathlib.Path,
                        help="of sonde bench render --part compare on a graphics card")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    sonde = options.build / "app" / "sonde"
    root = pathlib.Path(__file__).resolve().parent.parent
    docs = root / "docs"
    folder = root / "build" / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    quick = ["--quick"] if options.quick else []
    measures = {
        "demo": lambda: demo_rows(sonde, options.seeds),
        "registration": lambda: measured(sonde, "bench", "registration", *quick),
        "render": lambda: measured(sonde, "bench", "render", "--part", "compare", *quick),
        "skipping": lambda: measured(sonde, "bench", "render", "--part", "skipping", *quick),
        "live": lambda: measured(sonde, "bench", "render", "--part", "live", "--costs", *quick),
        "scaling": lambda: measured(sonde, "bench", "scaling", "--largest",
                                    384 if options.quick else 768),
        "poses": lambda: pose_lines(options.build),
        "devices": lambda: measured(sonde, "bench", "devices", *quick),
        CARD: lambda: json.loads(options.card_report.read_text())}
    if CARD in options.only and not options.card_report:
        parser.error("--only card: expected --card-report, found none")
    kept = {name: part(folder / f"{name}.json", name in options.only, measure)
            for name, measure in measures.items()}
    page = (docs / "figures.md").read_text() if (docs / "figures.md").exists() else ""
    sections = [("Demo:", "Registration:", "demo", demo_section),
                ("Registration:", "Rendering: run time", "registration",
                 lambda part: registration_section(part, docs)),
                ("Rendering: run time", "Rendering: on a graphics card", "render",
                 lambda part: render_section(part, docs)),
                ("Rendering: on a graphics card", "Rendering: samples", CARD,
                 lambda part: card_section(part, docs)),
                ("Rendering: samples", "Rendering: a live session", "skipping", skipping_section),
                ("Rendering: a live session", "Rendering: scaling", "live", live_section),
                ("Rendering: scaling", "Poses between", "scaling",
                 lambda part: scaling_section(part, docs)),
                ("Poses between", "Live devices", "poses", poses_section),
                ("Live devices", None, "devices", devices_section)]
    texts = [draw(kept[name]) if kept[name] else standing(page, first, after)
             for first, after, name, draw in sections]
    head = f"""# Figures, and how to repeat them

Written by `tools/make_figures.py` on {datetime.date.today()}, on {platform.machine()} with
{subprocess.run(["nproc"], capture_output=True, text=True).stdout.strip()} cores of a shared machine: single figures scatter by a third.
Compare ratios, which are measured interleaved in one run, not seconds. All accuracy figures are from
simulated patients, whose truth is known; they say nothing about real patients.
"""
    (docs / "figures.md").write_text("\n".join([head] + [t.strip("\n") + "\n" for t in texts]))
    print(f"wrote {docs / 'figures.md'}")


if __name__ == "__main__":
    main()
