#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Measures everything that docs/figures.md shows and writes that page and its plots anew.

    tools/make_figures.py [--build build/release] [--seeds 8]

Takes about ten minutes on two cores. Nothing in the page is written by hand.
"""
import argparse
import datetime
import json
import math
import pathlib
import platform
import subprocess
import tempfile

COLOURS = {"cpu": "#d95f02", "gl": "#7570b3", "vtk-gpu": "#1b9e77", "vtk-fixedpoint": "#666666"}


def run(*command: str, check: bool = True) -> str:
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


def plot(rows: list[dict], scene: str) -> str:
    """Error over process time, both logarithmic, one line for each engine."""
    width, height, left, bottom = 640, 400, 70, 50
    points = [r for r in rows if r["scene"] == scene and r["cpu_s"] > 0 and r["rms"] > 0]
    low_x = math.floor(math.log10(min(r["cpu_s"] for r in points)))
    high_x = math.ceil(math.log10(max(r["cpu_s"] for r in points)))
    low_y = math.floor(math.log10(min(r["rms"] for r in points)))
    high_y = math.ceil(math.log10(max(r["rms"] for r in points)))

    def x(value: float) -> float:
        return left + (math.log10(value) - low_x) / (high_x - low_x) * (width - left - 130)

    def y(value: float) -> float:
        return height - bottom - (math.log10(value) - low_y) / (high_y - low_y) * (
            height - bottom - 40)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
           'font-family="sans-serif" font-size="13"><rect width="100%" height="100%" '
           f'fill="white"/><text x="{left}" y="24" font-size="15">{scene}</text>']
    for decade in range(low_x, high_x + 1):
        at = x(10.0 ** decade)
        out.append(f'<line x1="{at:.1f}" y1="40" x2="{at:.1f}" y2="{height - bottom}" '
                   f'stroke="#ddd"/><text x="{at:.1f}" y="{height - bottom + 18}" '
                   f'text-anchor="middle">{10.0 ** decade:g}</text>')
    for decade in range(low_y, high_y + 1):
        at = y(10.0 ** decade)
        out.append(f'<line x1="{left}" y1="{at:.1f}" x2="{width - 130}" y2="{at:.1f}" '
                   f'stroke="#ddd"/><text x="{left - 6}" y="{at + 4:.1f}" '
                   f'text-anchor="end">{10.0 ** decade:g}</text>')
    out.append(f'<text x="{(left + width - 130) / 2}" y="{height - 10}" text-anchor="middle">'
               'process seconds per frame</text>'
               f'<text x="16" y="{height / 2}" text-anchor="middle" '
               f'transform="rotate(-90 16 {height / 2})">rms colour error</text>')
    for number, (engine, colour) in enumerate(COLOURS.items()):
        line = sorted((r for r in points if r["engine"] == engine), key=lambda r: -r["step"])
        if not line:
            continue
        path = " ".join(f"{x(r['cpu_s']):.1f},{y(r['rms']):.1f}" for r in line)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x(r["cpu_s"]):.1f}" cy="{y(r["rms"]):.1f}" r="4" fill="{colour}"/>'
                for r in line]
        out.append(f'<text x="{width - 120}" y="{60 + 20 * number}" fill="{colour}">{engine}'
                   '</text>')
    return "\n".join(out) + "\n</svg>\n"


def render_section(sonde: pathlib.Path, docs: pathlib.Path) -> str:
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "render.json")
        run(sonde, "bench", "render", "--width", 400, "--height", 300, "--json", file)
        report = json.loads(file.read_text())
    rows = [[r["scene"], r["engine"], f"{r['step']:g}", f"{1e3 * r['cpu_s']:.0f}",
             f"{1e3 * r['wall_s']:.0f}", f"{r['rms']:.5f}", f"{r['max']:.3f}"]
            for r in report["results"]]
    ratios = [[r["scene"], r["name"], f"{r['step']:g}",
               "–" if r["same_step"] is None else f"{r['same_step']:.1f}",
               "–" if r["equal_error"] is None else f"{r['equal_error']:.1f}"]
              for r in report["ratios"]]
    pictures = []
    (docs / "benchmarks").mkdir(exist_ok=True)
    for scene in dict.fromkeys(r["scene"] for r in report["results"]):
        name = "render-" + scene.split("/", 1)[1].replace("/", "-") + ".svg"
        (docs / "benchmarks" / name).write_text(plot(report["results"], scene))
        pictures.append(f"![{scene}](benchmarks/{name})")
    agreement = [[a["engine"], f"{100 * a['share_within_2_of_255']:.4f} %",
                  str(a["max_of_255"]), f"{a['rms_of_255']:.3f}"] for a in report["agreement"]]
    return f"""## Rendering: run time against error, beside VTK

`sonde bench render --width 400 --height 300 --json FILE` draws the simulated patient's CT at {report['width']} ×
{report['height']} pixels with every engine, interleaved in one process: same camera, step (voxels),
transfer function and shading; VTK without automatic sampling distances and without jitter. `cpu ms`
is process time of all threads per frame, `rms` and `max` the colour error against the converged
double-precision reference. GL device: {report['gl_device']}.

{chr(10).join(pictures)}

{table(["scene", "engine", "step", "cpu ms", "wall ms", "rms", "max"], rows)}

How many times the process time of Sonde's engine VTK's mapper takes: at the same step, and against
Sonde's cheapest picture of equal or lower error (–: none).

{table(["scene", "comparison", "step", "same step", "equal error"], ratios)}

## Agreement of the engines

The same command, on the demo's scene (CT, live plane, needle, target), against the double-precision
reference at the same step:

{table(["engine", "pixels within 2/255", "max /255", "rms /255"], agreement)}
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--seeds", type=int, default=8)
    options = parser.parse_args()
    sonde = options.build / "app" / "sonde"
    docs = pathlib.Path(__file__).resolve().parent.parent / "docs"
    curve = run(options.build / "bench/registration/registration_curve", 4, 5)
    poses = run(options.build / "bench/tracking/tracking_bench", "--benchmark_format=console")
    pose_lines = "\n".join(line for line in poses.splitlines() if line.startswith("BM_"))
    page = f"""# Figures, and how to repeat them

Written by `tools/make_figures.py` on {datetime.date.today()}, on {platform.machine()} with
{subprocess.run(["nproc"], capture_output=True, text=True).stdout.strip()} cores that others share.
Compare ratios, which are measured interleaved in one run, rather than seconds. All accuracy is that
of simulated patients, where the truth is known; it says nothing about real ones.

## Demo: from 10 mm and 8° to the target

`sonde demo --out DIR --seed N`

{table(["patient", "start error mm", "accepted", "target error mm", "predicted rms mm", "s"],
       demo_rows(sonde, options.seeds))}

## Registration: run time against error

`registration_curve 4 5` (four simulated patients, five starts each)

```
{curve.strip()}
```

{render_section(sonde, docs)}
## Poses between samples: rate against error

`tracking_bench`: a hand that sways 30 mm and 0.3 rad once a second, sampled at a rate in Hz.

```
{pose_lines}
```
"""
    (docs / "figures.md").write_text(page)
    print(f"wrote {docs / 'figures.md'}")


if __name__ == "__main__":
    main()
