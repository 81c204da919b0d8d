#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Measures the window by its own report, and writes the table of docs/window.md.

tools/window_numbers.py [SONDE] [--loaded]     default: build/release/app/sonde
"""
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/window.md"
BEGIN, END = "<!-- numbers -->", "<!-- end of numbers -->"
ORBIT = "drag view3d 60 0\npause 2\n" * 8
PROCEDURE = f"""resize 1600 900
wait numeral.tip shown 60
wait scene full 60
{ORBIT}wait numeral.tip shown 30
fault cover-marker 2
wait numeral.tip withdrawn 5
wait numeral.tip shown 30
pause 10
quit
"""
IDLE_S = 10
MOST_LOAD = 0.5


def run(sonde: str, words: list[str], script: str) -> tuple[dict, float, float]:
    """Report, wall time in s and processor time in s of a window that plays a script."""
    with tempfile.TemporaryDirectory() as folder:
        lines, report = pathlib.Path(folder) / "script.txt", pathlib.Path(folder) / "report.json"
        lines.write_text(script)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        start = time.monotonic()
        subprocess.run([sonde, "window", *words, "--engine", "cpu", "--script", lines, "--json",
                        report], check=True, env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
        wall = time.monotonic() - start
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return json.loads(report.read_text()), wall, used


def text_of(value, unit: str) -> str:
    return "not measured" if value is None else f"{value:.3g} {unit}"


def part(report: dict, key: str, which: str):
    return (report.get(key) or {}).get(which)


def cost(report: dict, element: str):
    return next((one["ms"] for one in report["costs"] if one["element"] == element), None)


def table(sonde: str, load: float) -> str:
    _, usable_s, once_s = run(sonde, [], "expect session none\nquit\n")
    _, _, idle_s = run(sonde, [], f"pause {IDLE_S}\nquit\n")
    report, _, _ = run(sonde, ["--simulated"], PROCEDURE)
    rows = [
        ("input to repaint, p95 (mouse in the 3D view)", "100 ms",
         text_of(part(report, "input_to_paint_ms", "p95"), "ms")),
        ("one full 3D image, mean", "600 ms", text_of(cost(report, "scene, full"), "ms")),
        ("one coarse 3D image, mean", "–", text_of(cost(report, "scene, coarse"), "ms")),
        ("ultrasound: acquisition to painted, p95", "100 ms",
         text_of(part(report, "latency_ms", "p95"), "ms")),
        ("numbers withdrawn after the marker is covered, most", "validity + 1 refresh",
         text_of(part(report, "withdrawn_after_ms", "max"), "ms")),
        ("view covered after it, most", "validity + 1 refresh",
         text_of(part(report, "covered_after_ms", "max"), "ms")),
        ("handler of the window's thread, p99", "5 ms",
         text_of(part(report, "handler_ms", "p99"), "ms")),
        ("painting of a view, mean", "–", text_of(part(report, "paint_cpu_ms", "mean"), "ms")),
        ("conversion of an image, mean", "–", text_of(report.get("convert_cpu_ms"), "ms")),
        ("start to the end of a first script line, no session", "1.5 s", text_of(usable_s, "s")),
        (f"idle window without a session, {IDLE_S} s, share of one core", "1 %",
         text_of(100 * max(0.0, idle_s - once_s) / IDLE_S, "%")),
    ]
    lines = [f"Measured with {os.cpu_count()} cores, CPU engine, 1600 × 900, load {load:.1f} before "
             "the run:", "",
             "| what | at most | measured |", "|---|---|---|"]
    return "\n".join(lines + [f"| {a} | {b} | {c} |" for a, b, c in rows])


def main() -> int:
    words = [word for word in sys.argv[1:] if word != "--loaded"]
    sonde = words[0] if words else str(ROOT / "build/release/app/sonde")
    page = PAGE.read_text()
    if BEGIN not in page or END not in page:
        print(f"{PAGE}: expected the lines {BEGIN} and {END}", file=sys.stderr)
        return 1
    load = os.getloadavg()[0]
    if load > MOST_LOAD and "--loaded" not in sys.argv:
        print(f"load {load:.1f}: expected at most {MOST_LOAD}, because others would be measured too; "
              "--loaded measures all the same", file=sys.stderr)
        return 1
    head, rest = page.split(BEGIN, 1)
    tail = rest.split(END, 1)[1]
    PAGE.write_text(f"{head}{BEGIN}\n\n{table(sonde, load)}\n\n{END}{tail}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
