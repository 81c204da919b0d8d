#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Fails when a text that people read uses a retired word or begins as a fragment.

    tools/check_prose.py [--count] [root]

Four kinds of problem are reported, one a line, as `file:line: found …; write …`:

- fragment: a comment block that begins with Of, What, Whether, Where, As, By or The same. Such a
  block has no subject; it should begin with a noun phrase or a verb.
- word: a word that the project has replaced (RETIRED), in comments, in string literals that people
  read and in the pages of docs/, README.md, CONTRIBUTING.md and ARCHITECTURE.md. Identifiers are
  not checked: names with an underscore, names followed by a parenthesis, text in backquotes, and
  strings without a space.
- help: the help text of a command-line option that is missing, begins as a fragment or ends with
  an adverb that needs the context of another sentence. Rows of the tables of options are read, too
  (`.text = "…"`).

- name: a retired word in the name of a type, a test or a file of the sources.

--count prints the number of problems by folder and kind instead, and exits with 0.
"""
import argparse
import collections
import dataclasses
import io
import pathlib
import re
import sys
import tokenize
from collections.abc import Iterator

C_LIKE = {".hpp", ".cpp", ".h", ".inc", ".glsl", ".vert", ".frag", ".comp"}
HASH = {".py", ".sh", ".cmake", ".supp"}
HASH_NAMES = {"CMakeLists.txt", "run", "pre-commit", ".clang-format", ".clang-tidy"}
# Folders that are no part of the sources. Names that begin with a dot are left out as well.
NOT_SOURCES = {"build", "shared", "__pycache__"}
DOT_NAMES = {".ci", ".clang-format", ".clang-tidy"}
# Files and folders that are not checked, each with its reason.
EXCLUDED = {
    "CHANGELOG.md": "entries describe past releases in the words of their time",
    "docs/STYLE.md": "lists the retired words",
    "tools/check_prose.py": "names the retired words",
    "tools/check_prose_test.py": "tests the retired words",
}

FRAGMENT = re.compile(r"\s*(Of|What|Whether|Where|As|By|The same)\b")
FRAGMENT_ADVICE = "begin with a noun phrase or a verb"

# A pattern is a whole word or phrase; a space stands for any white space. A word with a legitimate
# use has patterns of its retired use only. A third item names files in which the word is allowed:
# "refused" is the verdict about a registration.
VERDICT = r"(?:docs|registration|bench|app|session|tests/(?:app|bench|integration|registration))/" \
          r"|tools/make_figures|README\.md"
RETIRED = [
    (r"pictures?", "image"),
    (r"for want of", "because there is no, or without"),
    (r"looks? (?:at|into) (?:the |a |every |each |several )?bricks?", "brick test"),
    (r"pixels? without (?:a |their )?rays?(?! of)", "interpolated pixels"),
    (r"set-ups?", "predicate set (or setup)"),
    (r"refus(?:e|es|ing|als?)", "reject, rejection", r"docs/|README\.md|tools/make_figures"),
    (r"refused", "rejected", VERDICT),
    (r"ultrasound frames?", "ultrasound image"),
    (r"(?:an?|the|another|each|every|same) look(?! at| into| file)", "appearance"),
    (r"(?:the|these|those) looks", "appearances (or brick tests)"),
    (r"look files?", "appearance file"),
    (r"the room", "folder (or operating room)"),
    (r"rooms (?:of|in) (?:a|the) (?:large )?folders?", "subfolders"),
    (r"lines? of words", "line of text"),
    (r"the words'? (?:beside|below|above|over|on|middle)", "overlay text"),
    (r"(?:a|each|every|the same|another) places?(?! where)", "position"),
    (r"depth stretch|stretch(?:es)? (?:above|below|factors?)", "scale"),
    (r"as the (?:options?|sets?|set-up|session|look|caller) (?:says?|asks?)",
     "depends on the …, or from the …"),
]
HELP = [
    (r"^(?:how|what|whether|where|of|as|by|that|which|the same)\b",
     "begin with a noun phrase or a verb"),
    (r"\b(?:too|so|alone|anew|likewise)(?= *(?:$|[;:.)]))",
     "say what the adverb stands for"),
    (r"\b(?:none|absent): as\b", "name the value that is used"),
]


# Words in names of types, tests and files, with the word to use. A refused registration is a verdict.
NAMES = [
    (re.compile(r"Picture|(?<![a-z])picture"), "image"),
    (re.compile(r"Refus(?!ed(?:Registration|[A-Z_]|\b))|(?<![a-z])refus(?!ed)"), "reject"),
    (re.compile(r"(?:Ultrasound|Tracked|Paired|Recorded|Sequence)Frame"), "image"),
]
NAMED = re.compile(r"^\s*(?:class|struct|enum class)\s+(\w+)|^TEST(?:_[FP])?\((\w+),\s*(\w+)\)",
                   re.MULTILINE)


def compile_word(pattern: str) -> re.Pattern:
    spaced = pattern.replace(" ", r"\s+")
    return re.compile(rf"(?<![\w\-/$])(?<!::)(?:{spaced})(?![\w(]|-\w|\.\w|::| = )",
                      re.IGNORECASE)


WORDS = [(compile_word(pattern), advice, re.compile(allowed[0] if allowed else r"(?!)"))
         for pattern, advice, *allowed in RETIRED]
HELPS = [(re.compile(pattern, re.IGNORECASE), advice) for pattern, advice in HELP]


@dataclasses.dataclass(frozen=True)
class Piece:
    """A text that people read: a comment block, a string literal or a page."""

    kind: str  # "comment", "string" or "page".
    text: str
    line: int  # Of the first character, from 1.
    offset: int = 0  # Of the first character in the file; C-like files only.
    end: int = 0


@dataclasses.dataclass(frozen=True)
class Problem:
    file: str
    line: int
    kind: str  # "fragment", "word", "help" or "name".
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"


# Pieces of a C-like file.

C_TOKEN = re.compile(
    r'(?P<raw>R"(?P<mark>[^()\\\s"]{0,16})\((?P<body>.*?)\)(?P=mark)")'
    r"|(?P<line>//[^\n]*)"
    r"|(?P<block>/\*.*?\*/)"
    r'|(?P<string>"(?:\\.|[^"\\\n])*")'
    r"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'", re.DOTALL)


def blocks(comments: list[tuple[int, int, bool, str]]) -> Iterator[Piece]:
    """Joins comments of consecutive lines. Each comment: line, column, whether code stands before
    it, text without its marker. A comment after code begins a block; comments on lines of their
    own continue it where they begin at its column. Licence lines are left out."""
    group = []
    for comment in comments:
        line, column, after_code, text = comment
        if text.lstrip().startswith("SPDX-"):
            continue
        if group and (after_code or line != group[-1][0] + 1 or column != group[-1][1]):
            yield Piece("comment", "\n".join(c[3] for c in group), group[0][0])
            group = []
        group.append(comment)
    if group:
        yield Piece("comment", "\n".join(c[3] for c in group), group[0][0])


def c_pieces(text: str) -> list[Piece]:
    comments, strings = [], []
    line, at = 1, 0
    for match in C_TOKEN.finditer(text):
        line += text.count("\n", at, match.start())
        at = match.start()
        begin = text.rfind("\n", 0, at) + 1
        if match["line"]:
            body = re.sub(r"^//[/!]?<?", "", match["line"])
            comments.append((line, at - begin, bool(text[begin:at].strip()), body))
        elif match["block"]:
            lines = re.sub(r"^/\*+<?|\*+/$", "", match["block"]).split("\n")
            strings.append(Piece("comment", "\n".join(x.strip(" *") for x in lines), line))
        elif match["string"] or match["raw"]:
            body = match["body"] if match["raw"] else match["string"][1:-1]
            if not match["raw"]:
                body = re.sub(r"\\[ntr]", "  ", body)
            last = strings[-1] if strings else None
            if last and last.kind == "string" and not text[last.end:at].strip():
                gap = text.count("\n", last.end, at)
                strings[-1] = Piece("string", last.text + "\v" * gap + body, last.line,
                                    last.offset, match.end())
            else:
                strings.append(Piece("string", body, line, at, match.end()))
    return list(blocks(comments)) + strings


# Pieces of a file whose comments begin with #.

HASH_COMMENT = re.compile(r"""^((?:[^#"']|"(?:\\.|[^"\\])*"|'[^']*'|(?<=\S)\#)*?)(?<!\S)\#(.*)$""")


def hash_pieces(text: str) -> list[Piece]:
    comments = []
    for number, line in enumerate(text.split("\n"), 1):
        match = HASH_COMMENT.match(line)
        if match and not line.startswith("#!"):
            comments.append((number, match.end(1), bool(match[1].strip()), match[2]))
    strings = [Piece("string", match[1], text.count("\n", 0, match.start()) + 1)
               for match in re.finditer(r'(?<![\\\w])"((?:\\.|[^"\\\n])*)"', text)]
    return list(blocks(comments)) + strings


def python_pieces(text: str) -> list[Piece]:
    comments, strings = [], []
    previous = None
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        line, column = token.start
        if token.type == tokenize.COMMENT and not token.string.startswith("#!"):
            comments.append((line, column, bool(token.line[:column].strip()), token.string[1:]))
        elif token.type == tokenize.STRING:
            docstring = previous in (None, tokenize.NEWLINE, tokenize.INDENT, tokenize.NL)
            body = re.sub(r"^[a-zA-Z]*(\"\"\"|'''|\"|')|(\"\"\"|'''|\"|')$", "", token.string)
            if re.match(r"[a-zA-Z]*[fF]", token.string):
                body = re.sub(r"\{[^{}]*\}", lambda match: "`" * len(match[0]), body)
            strings.append(Piece("comment" if docstring and '"""' in token.string else "string",
                                 body, line))
        if token.type != tokenize.COMMENT:
            previous = token.type
    return list(blocks(comments)) + strings


def page_pieces(text: str) -> list[Piece]:
    blank = lambda match: re.sub(r"[^\n]", "`", match[0])
    text = re.sub(r"(?<!`)(`{1,2})(?!`).+?(?<!`)\1(?!`)", blank, text)  # Code.
    text = re.sub(r"\]\([^)\n]*\)", blank, text)  # Targets of links.
    return [Piece("page", text, 1)]


# Problems.


def is_for_people(text: str) -> bool:
    """A string literal with a space next to a letter that is not code of another language."""
    if not re.search(r"[A-Za-z,;:] |  ?[A-Za-z]", text):
        return False
    return not re.search(r"[;{}]\s*(?:\n|$)|^\s*#(?:version|define|include)|\w\(\w*\) ?[;{]", text)


def word_problems(name: str, piece: Piece) -> Iterator[Problem]:
    text = re.sub(r"`[^`\n]*`|[\\@](?:p|param|ref) \S+", lambda m: "`" * len(m[0]), piece.text)
    for pattern, advice, allowed in WORDS:
        if allowed.match(name):
            continue
        for match in pattern.finditer(text):
            line = piece.line + len(re.findall(r"[\n\v]", text[:match.start()]))
            found = " ".join(match[0].split())
            yield Problem(name, line, "word", f"found \"{found}\"; write {advice}")


def fragment_problems(name: str, piece: Piece) -> Iterator[Problem]:
    match = FRAGMENT.match(piece.text)
    if match:
        line = piece.line + piece.text.count("\n", 0, match.start(1))
        yield Problem(name, line, "fragment",
                      f"found a comment that begins with \"{match[1]}\"; {FRAGMENT_ADVICE}")


ROW = re.compile(r"\.text\s*=\s*(?=\0)")
ROW_NAME = re.compile(r"\.name = \"([^\"]*)\"")


def row_problems(name: str, text: str) -> Iterator[Problem]:
    """Texts of the rows of a table of options: the strings behind `.text =`."""
    strings = {p.offset: p for p in c_pieces(text) if p.kind == "string"}
    code = C_TOKEN.sub(lambda m: re.sub(r"[^\n]", "\0" if m["string"] or m["raw"] else " ", m[0]),
                       text)
    for match in ROW.finditer(code):
        piece = strings.get(match.end())
        if piece is None:
            continue
        names = ROW_NAME.findall(text, 0, match.start())
        of = names[-1] if names else "a row"
        text_of = re.sub(r"\s+", " ", piece.text).strip()
        for pattern, advice in HELPS:
            found = pattern.search(text_of)
            if found:
                yield Problem(name, piece.line, "help",
                              f"found \"{found[0]}\" in the text of {of}; {advice}")


ADD = re.compile(r"\b(add(?:_\w+)?)\s*(?:<[^;{}()]*>)?\(")


def arguments(text: str, begin: int) -> list[tuple[int, int]]:
    """The arguments of a call as ranges of text, whose strings and comments are blank; begin:
    behind its parenthesis."""
    out, depth, start = [], 0, begin
    for at in range(begin, len(text)):
        letter = text[at]
        if letter in "([{":
            depth += 1
        elif letter in ")]}":
            depth -= 1
        if depth < 0 or (depth == 0 and letter == ","):
            out.append((start, at))
            start = at + 1
        if depth < 0:
            return out
    return []


def help_problems(name: str, text: str) -> Iterator[Problem]:
    strings = {p.offset: p for p in c_pieces(text) if p.kind == "string"}
    code = C_TOKEN.sub(lambda m: re.sub(r"[^\n]", "\0" if m["string"] or m["raw"] else " ", m[0]),
                       text)
    for match in ADD.finditer(code):
        texts, plain = [], []
        for begin, end in arguments(code, match.end()):
            begin = end - len(code[begin:end].lstrip())
            plain.append(code[begin:end])
            if begin in strings:
                piece = strings[begin]
                texts.append((piece, not code[piece.end:end].strip()))
        if not texts:
            continue
        option = texts[0][0].text
        if not match[1].startswith(("add_option", "add_flag", "add_choice", "add_subcommand")):
            if not option.startswith("-"):
                continue
        line = code.count("\n", 0, match.start()) + 1
        after = code[arguments(code, match.end())[-1][1] + 1:].lstrip()
        if len(texts) == 1:
            if match[1] in ("add_option", "add_flag") and len(plain) == 2 \
                    and "description" not in after[:after.find(";")]:
                yield Problem(name, line, "help",
                              f"found no help text of {option}; write what the option sets")
            continue
        piece, whole = texts[-1]
        text_of = re.sub(r"\s+", " ", piece.text).strip() if whole else piece.text.lstrip() + "…"
        for pattern, advice in HELPS:
            found = pattern.search(text_of)
            if found:
                yield Problem(name, piece.line, "help",
                              f"found \"{found[0]}\" in the help text of {option}; {advice}")


def name_problems(file: str, text: str) -> Iterator[Problem]:
    """Problems of the names of types and tests, and of the file's own name."""
    named = [(1, pathlib.PurePosixPath(file).stem)]
    for match in NAMED.finditer(text):
        line = text.count("\n", 0, match.end()) + 1
        named += [(line, name) for name in match.groups() if name]
    for line, name in named:
        for pattern, advice in NAMES:
            if pattern.search(name):
                yield Problem(file, line, "name", f"found the name {name}; write {advice}")


def pieces_of(path: pathlib.Path, text: str) -> list[Piece]:
    if path.suffix in C_LIKE:
        return c_pieces(text)
    if path.suffix == ".py":
        return python_pieces(text)
    if path.suffix in HASH or path.name in HASH_NAMES:
        return hash_pieces(text)
    if path.suffix == ".md":
        return page_pieces(text)
    return []


def problems_of(path: pathlib.Path, name: str) -> list[Problem]:
    if path.suffix not in C_LIKE | HASH | {".md"} and path.name not in HASH_NAMES:
        return []
    text = path.read_text()
    found = []
    for piece in pieces_of(path, text):
        if piece.kind == "comment":
            found += fragment_problems(name, piece)
        if piece.kind != "string" or is_for_people(piece.text):
            found += word_problems(name, piece)
    if path.suffix in C_LIKE:
        found += help_problems(name, text)
        found += row_problems(name, text)
        found += name_problems(name, text)
    return sorted(found, key=lambda problem: problem.line)


def files_in(folder: pathlib.Path, root: pathlib.Path) -> Iterator[pathlib.Path]:
    for path in sorted(folder.iterdir()):
        hidden = path.name.startswith(".") and path.name not in DOT_NAMES
        if hidden or path.name in NOT_SOURCES or path.is_symlink():
            continue
        if path.relative_to(root).as_posix() in EXCLUDED:
            continue
        if path.is_dir():
            yield from files_in(path, root)
        else:
            yield path


def problems_in(root: pathlib.Path) -> list[Problem]:
    return [problem for path in files_in(root, root)
            for problem in problems_of(path, path.relative_to(root).as_posix())]


def count_table(found: list[Problem]) -> str:
    kinds = ("fragment", "word", "help", "name")
    counts = collections.Counter()
    for problem in found:
        folder = problem.file.split("/")[0] if "/" in problem.file else "(top)"
        counts[folder, problem.kind] += 1
        counts["total", problem.kind] += 1
    folders = sorted({folder for folder, _ in counts} - {"total"}) + ["total"]
    rows = [("folder", *kinds, "all")]
    rows += [(f, *(str(counts[f, k]) for k in kinds), str(sum(counts[f, k] for k in kinds)))
             for f in folders]
    return "\n".join(f"{row[0]:<14}" + "".join(f"{cell:>10}" for cell in row[1:]) for row in rows)


def main() -> int:
    parser = argparse.ArgumentParser(description="Checks the prose of comments, texts and pages.")
    parser.add_argument("root", nargs="?", default=".", help="folder of the project")
    parser.add_argument("--count", action="store_true",
                        help="print the number of problems by folder and kind, and exit with 0")
    options = parser.parse_args()
    found = problems_in(pathlib.Path(options.root).resolve())
    if options.count:
        print(count_table(found))
        return 0
    for problem in found:
        print(problem)
    print(f"prose: {len(found)} problem(s)")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
