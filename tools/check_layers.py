#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Fails when an include breaks the layers of the folders (docs/STYLE.md).

Includes point down only. Siblings do not include each other (only exception: sim -> io). Types of
a third-party library appear only in the folders that may use it, and never in a header that other
folders include. A constant local to a .cpp file must not have the name of a constant in a header
that the file could include: when several files are compiled together, one would be used for the
other. The top folder contains only the listed files.

Usage: check_layers.py [--print] [ROOT]
--print shows what is there instead of what is wrong: which folders each folder includes, with the
number of includes, and the lines of code of each folder.
"""
import argparse
import collections
import pathlib
import re
import sys

ALLOWED = {
    "nav": {"nav"},
    "shaders": {"shaders"},
    "io": {"nav", "io"},
    "tracking": {"nav", "tracking"},
    "registration": {"nav", "registration"},
    "render": {"nav", "render", "shaders"},
    "devices": {"nav", "devices"},
    "sim": {"nav", "sim", "io"},
    "session": {"nav", "io", "tracking", "registration", "devices", "sim", "session"},
    "app": {"nav", "io", "tracking", "registration", "render", "shaders", "devices", "sim",
            "session", "app"},
    "bench": {"nav", "io", "tracking", "registration", "render", "shaders", "devices", "sim",
              "session", "app", "bench"},
    "tests": {"nav", "io", "tracking", "registration", "render", "shaders", "devices", "sim",
              "session", "bench", "app", "tests"},
}

SOURCES = {".hpp", ".cpp", ".h"}
SHADERS = {".glsl", ".frag", ".vert", ".comp"}

# Folders that lie above the rest of their top folder: nothing beside them includes them, and only
# they (and tests of the same name) include a toolkit.
ABOVE = {"app/window": re.compile(r"^Q[A-Z]")}

# Libraries of a trade, and the folders whose .cpp files may include them.
TRADES = {
    "VTK": (re.compile(r"^vtk"), {"render", "io", "bench", "tests"}),
    "OpenCV": (re.compile(r"^opencv"), {"registration", "devices", "tests"}),
    "Ceres": (re.compile(r"^ceres/"), {"registration", "tests"}),
    "GLM": (re.compile(r"^glm/"), {"render", "tests"}),
    "libusb": (re.compile(r"^libusb"), {"devices", "tests"}),
    "SocketCAN": (re.compile(r"^linux/can"), {"devices", "tests"}),
    "pugixml": (re.compile(r"^pugixml"), {"io", "tests"}),
    "JSON": (re.compile(r"^nlohmann/"), {"io", "app", "tests"}),
    "TOML": (re.compile(r"^toml\+\+"), {"app", "tests"}),
    "CLI11": (re.compile(r"^CLI/"), {"app", "bench"}),
    "TBB": (re.compile(r"^(oneapi/)?tbb/"),
            {"render", "sim", "registration", "tracking", "tests", "bench"}),
}
# Private headers (used only by their own folder, tests and benchmarks) may contain types of these
# libraries.
PRIVATE_HEADER = re.compile(
    r"^(render/(vtk/|gl/|cpu/|window/vtk_|parallel)|registration/(ceres_|cv_|detail/)|devices/camera/cv_|io/(vtk_|detail/)|app/"
    r"|bench/)")
# Public headers that show a trade type on purpose: JSON is the language of several folders.
SHOWS_TRADE = {"io/json.hpp"}
# Files at the top of the project.
TOP = {"ARCHITECTURE.md", "CHANGELOG.md", "CMakeLists.txt", "CMakePresets.json",
       "CMakeUserPresets.json", "CONTRIBUTING.md", "LICENSE", "README.md"}
# Constants at the left margin belong to a namespace, not to a class or function.
CONSTANT = re.compile(r"^(?:inline |static )*constexpr [^=;{(]*?\b(k[A-Z]\w*)\s*[={\[]")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def problems_in(root: pathlib.Path) -> list[str]:
    found = []
    for folder, allowed in ALLOWED.items():
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in SOURCES:
                continue
            name = path.relative_to(root).as_posix()
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = INCLUDE.match(line)
                if not match:
                    continue
                target = match.group(2)
                top = target.split("/")[0]
                where = f"{name}:{number}: includes {target}"
                for upper, toolkit in ABOVE.items():
                    inside = name.startswith(f"{upper}/")
                    of_tests = name.startswith(f"tests/{upper.split('/')[1]}/")
                    if inside or of_tests:
                        continue
                    if target.startswith(f"{upper}/"):
                        found.append(f"{where}: {upper}/ lies above {folder}/")
                    elif toolkit.match(target):
                        found.append(f"{where}: the toolkit belongs to {upper}/")
                if match.group(1) == '"':
                    if top not in ALLOWED:
                        found.append(f"{where}: expected a path from the root of the project")
                    elif top not in allowed:
                        found.append(f"{where}: {folder}/ may see only {', '.join(sorted(allowed))}")
                    elif (top != folder and folder not in {"tests", "bench"}
                          and PRIVATE_HEADER.match(target)):
                        found.append(f"{where}: a private header of {top}/")
                for trade, (pattern, homes) in TRADES.items():
                    if not pattern.match(target):
                        continue
                    if folder not in homes:
                        found.append(f"{where}: {trade} belongs to {', '.join(sorted(homes))}")
                    elif (path.suffix == ".hpp" and folder != "tests"
                          and not PRIVATE_HEADER.match(name) and name not in SHOWS_TRADE):
                        found.append(f"{where}: {trade} type in a public header")
    return found


def constants_in(path: pathlib.Path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        match = CONSTANT.match(line)
        if match:
            yield number, match.group(1)


def shadowed_in(root: pathlib.Path) -> list[str]:
    declared = {}
    for folder in ALLOWED:
        for path in sorted((root / folder).rglob("*.hpp")):
            for _, constant in constants_in(path):
                declared.setdefault(constant, []).append(path.relative_to(root).as_posix())
    found = []
    for folder, allowed in ALLOWED.items():
        for path in sorted((root / folder).rglob("*.cpp")):
            for number, constant in constants_in(path):
                headers = [h for h in declared.get(constant, []) if h.split("/")[0] in allowed]
                if headers:
                    found.append(f"{path.relative_to(root).as_posix()}:{number}: {constant} is "
                                 f"also a constant of {headers[0]}")
    return found


def strays_in(root: pathlib.Path) -> list[str]:
    return [f"{path.name}: does not belong at the top of the project (output of a run?)"
            for path in sorted(root.iterdir())
            if path.is_file() and not path.name.startswith(".") and path.name not in TOP]


def includes_in(root: pathlib.Path, folder: str) -> collections.Counter:
    """Number of includes of a folder by the other folder that they name."""
    seen = collections.Counter()
    for path in (root / folder).rglob("*"):
        if path.suffix not in SOURCES:
            continue
        for line in path.read_text().splitlines():
            match = INCLUDE.match(line)
            if match and match.group(1) == '"':
                seen[match.group(2).split("/")[0]] += 1
    del seen[folder]
    return seen


def lines_in(root: pathlib.Path, folder: str) -> tuple[int, int]:
    """Files of a folder, and their lines of code: neither blank nor comments alone."""
    files = lines = 0
    for path in (root / folder).rglob("*"):
        if path.suffix not in SOURCES | SHADERS:
            continue
        files += 1
        lines += sum(1 for line in path.read_text().splitlines()
                     if line.strip() and not line.lstrip().startswith("//"))
    return files, lines


def overview_of(root: pathlib.Path) -> list[str]:
    """Lines of text: who includes whom, then lines of code by folder."""
    text = []
    for folder in ALLOWED:
        seen = includes_in(root, folder)
        others = ", ".join(f"{other} ({count})" for other, count in sorted(seen.items()))
        text.append(f"{folder} -> {others or 'nothing'}")
    text.append("")
    text.append(f"{'folder':<14}{'files':>7}{'lines of code':>15}")
    total = [0, 0]
    for folder in ALLOWED:
        files, lines = lines_in(root, folder)
        total = [total[0] + files, total[1] + lines]
        text.append(f"{folder:<14}{files:>7}{lines:>15}")
    text.append(f"{'all':<14}{total[0]:>7}{total[1]:>15}")
    return text


def main() -> int:
    parser = argparse.ArgumentParser(description="Check the layers of the folders.")
    parser.add_argument("--print", action="store_true", dest="show",
                        help="show includes and lines of code by folder, check nothing")
    parser.add_argument("root", nargs="?", default=".", help="top folder of the project")
    arguments = parser.parse_args()
    root = pathlib.Path(arguments.root).resolve()
    if arguments.show:
        print("\n".join(overview_of(root)))
        return 0
    found = problems_in(root) + shadowed_in(root) + strays_in(root)
    for problem in found:
        print(problem)
    print(f"layers: {len(found)} problem(s)")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
