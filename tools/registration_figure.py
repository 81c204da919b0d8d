#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/benchmarks/registration-success.svg from the results of 'sonde bench registration
--json FILE': the share of correct results (< 2 mm) against the error of the start, for Sonde and
elastix side by side. tools/make_figures.py draws it too.

    tools/registration_figure.py FILE... [--out docs/benchmarks/registration-success.svg]

With several files, each adds the parts that the files before it lack, so that parts may be
measured separately.
"""
import argparse
import json
import pathlib

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 460, 340, 56, 150, 34, 46
COLOURS = ["#d95f02", "#1b9e77", "#7570b3", "#666666", "#e7298a", "#66a61e", "#e6ab02",
           "#a6761d", "#1f78b4", "#000000"]


class Panel:
    """One plot with linear axes from zero."""

    def __init__(self, title: str, x_label: str, y_label: str, x_max: float, y_max: float) -> None:
        self.x_max, self.y_max, self.lines = x_max, y_max, 0
        right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
        self.out = [f'<text x="{LEFT}" y="20" font-size="13">{title}</text>',
                    f'<text x="{(LEFT + right) / 2}" y="{HEIGHT - 10}" text-anchor="middle">'
                    f'{x_label}</text>',
                    f'<text transform="translate(14 {(TOP + bottom) / 2}) rotate(-90)" '
                    f'text-anchor="middle">{y_label}</text>']
        for i in range(6):
            x, y = self.at(i / 5 * x_max, i / 5 * y_max)
            self.out.append(
                f'<path d="M{x:.1f} {TOP}V{bottom}M{LEFT} {y:.1f}H{right}" stroke="#ddd"/>'
                f'<text x="{x:.1f}" y="{bottom + 16}" text-anchor="middle">{i / 5 * x_max:.3g}'
                f'</text><text x="{LEFT - 5}" y="{y + 4:.1f}" text-anchor="end">'
                f'{i / 5 * y_max:.3g}</text>')

    def at(self, x: float, y: float) -> tuple[float, float]:
        right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
        return (LEFT + min(x / self.x_max, 1) * (right - LEFT),
                bottom - min(y / self.y_max, 1) * (bottom - TOP))

    def line(self, name: str, points: list[tuple[float, float]]) -> None:
        colour = COLOURS[self.lines % len(COLOURS)]
        placed = [self.at(*p) for p in sorted(points)]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in placed)
        self.out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" '
                        'stroke-width="1.6"/>')
        self.out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>'
                     for x, y in placed]
        y = TOP + 14 + 18 * self.lines
        self.out.append(f'<text x="{WIDTH - RIGHT + 12}" y="{y}" fill="{colour}">{name}</text>')
        self.lines += 1

    def svg(self, x: int) -> str:
        return f'<g transform="translate({x} 0)">' + "\n".join(self.out) + "</g>"


def success(report: dict) -> Panel:
    rows = report["summary"].get("distances", [])
    peers = [r for r in report.get("peer", [])
             if r["name"].startswith("elastix") or r["name"] == "sonde quick"]
    farthest = max([r["start_mm"] for r in rows + peers], default=60)
    panel = Panel("Right results (target error below 2 mm)", "target error of the start, mm",
                  "share", farthest, 1)
    for mode in (False, True):
        points = [(r["start_mm"], r["right"] / r["trials"]) for r in rows if r["global"] == mode]
        if points:
            panel.line("Sonde, seeded starts" if mode else "Sonde, plain", points)
    for name in sorted({r["name"] for r in peers}):
        points = [(r["start_mm"], r["right"] / r["trials"]) for r in peers if r["name"] == name]
        panel.line(name, points)
    return panel


def drawing(report: dict) -> str:
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
            f'font-family="sans-serif" font-size="11"><rect width="100%" height="100%" '
            f'fill="white"/>\n{success(report).svg(0)}\n</svg>\n')


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("reports", nargs="+", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path,
                        default=pathlib.Path("docs/benchmarks/registration-success.svg"))
    options = parser.parse_args()
    merged: dict = {}
    for path in options.reports:
        for key, value in json.loads(path.read_text()).items():
            if not merged.get(key) or (key == "summary" and "distances" not in merged[key]):
                merged[key] = value
    options.out.write_text(drawing(merged))


if __name__ == "__main__":
    main()
