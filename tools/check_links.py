#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Fails when a link of a Markdown page leads nowhere: to a file, a heading or an image that does
not exist. With --code also when a source file names a page of docs/ that does not exist. Links to
the web are not followed. Usage: tools/check_links.py [--code] [ROOT]
"""
import pathlib
import re
import sys

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]*`")
HEADING = re.compile(r"^#+ +(.*?)\s*$", re.MULTILINE)
NAMED = re.compile(r'<a name="([^"]+)">')
CITED = re.compile(r"\b(docs/[\w/.-]+\.md|docs/adr/\d{4})\b")
SOURCES = {".hpp", ".cpp", ".glsl", ".vert", ".frag", ".py", ".sh", ".cmake", ".txt"}


def anchors(text: str) -> set[str]:
    """Names of the headings of a page, as GitHub makes them."""
    found = set(NAMED.findall(text))
    for heading in HEADING.findall(FENCE.sub("", text)):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        found.add(name)
    return found


def problems_in(root: pathlib.Path, code: bool = False) -> list[str]:
    found = []
    for path in sorted(root.rglob("*")):
        name = path.relative_to(root)
        if {".git", "build"} & set(name.parts) or not path.is_file():
            continue
        if path.suffix == ".md":
            text = CODE.sub("", FENCE.sub("", path.read_text()))
            for link in LINK.findall(text):
                if re.match(r"\w+:", link):
                    continue
                file, _, anchor = link.partition("#")
                target = (path.parent / file).resolve() if file else path
                if not target.exists():
                    found.append(f"{name}: no file {link}")
                elif anchor and anchor not in anchors(target.read_text()):
                    found.append(f"{name}: no heading {link}")
        elif code and path.suffix in SOURCES and not path.name.endswith("_test.py"):
            for page in CITED.findall(path.read_text(errors="replace")):
                if not any(root.glob(page + "*")):
                    found.append(f"{name}: no page {page}")
    return found


if __name__ == "__main__":
    arguments = [a for a in sys.argv[1:] if a != "--code"]
    here = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).parent.parent)
    problems = problems_in(here.resolve(), "--code" in sys.argv)
    print("\n".join(problems), file=sys.stderr)
    sys.exit(1 if problems else 0)
