#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Checks that docs/hazards.md has a row for each hazard, with tests that exist."""
import pathlib
import re
import sys

HAZARDS = [f"H{n}" for n in range(1, 20)]


def problems_in(root: pathlib.Path) -> list[str]:
    """One sentence for each problem; empty: there is none."""
    known = set()
    for path in (root / "tests").rglob("*.cpp"):
        for suite, name in re.findall(r"TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", path.read_text()):
            known.add(f"{suite}.{name}")
    rows = {}
    for line in (root / "docs/hazards.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 4 and re.fullmatch(r"H\d+", cells[0]):
            rows[cells[0]] = cells
    problems = []
    for hazard in HAZARDS:
        if hazard not in rows:
            problems.append(f"docs/hazards.md: {hazard}: expected a row, found none")
            continue
        _, _, control, tests = rows[hazard]
        names = re.findall(r"`(\w+\.\w+)`", tests)
        if not control:
            problems.append(f"docs/hazards.md: {hazard}: expected a control, found none")
        if not names:
            problems.append(f"docs/hazards.md: {hazard}: expected a test, found none")
        for name in names:
            if name not in known:
                problems.append(f"docs/hazards.md: {hazard}: no test {name}")
    return problems


def main() -> int:
    problems = problems_in(pathlib.Path(__file__).resolve().parent.parent)
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
