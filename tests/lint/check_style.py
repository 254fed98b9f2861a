"""Lengths, and words that do not belong into a finished tree.

    python3 tests/lint/check_style.py [ROOT]

A source has at most 300 lines, a header 150, a function 40, a line 100 columns. What is longer for a reason is named,
with the reason, in long_on_purpose.toml.
"""

import pathlib
import re
import sys
import tomllib

import source_tree

MAX_LINES = {".cc": 300, ".h": 150}
MAX_FUNCTION = 40
MAX_COLUMNS = 100
MAX_GLSL_COLUMNS = 120  # shaders in raw strings, which clang-format leaves alone
UNFINISHED = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b")
TEXT = {".cc", ".h", ".py", ".sh", ".proto", ".txt", ".md", ".toml", ".yaml", ".json", ".glsl",
        ".service"}

# clang-format leaves a function's head at the start of a line and its closing brace alone there.
HEAD = re.compile(r"^(?!namespace|class|struct|enum|union|extern|#|\}|//)\S.*")


def functions(lines):
    """(name, first line, number of lines) of the functions at namespace scope."""
    start, head = None, ""
    for number, line in enumerate(lines, 1):
        if start is None:
            if HEAD.match(line):
                start, head = number, line
            if start is not None and line.rstrip().endswith(";"):
                start = None
        elif line.startswith("}"):
            name = re.search(r"([\w:~]+)\s*\(", head)
            if name:
                yield name.group(1), start, number - start + 1
            start = None
        elif line.endswith(";") and not line.startswith(" "):
            start = None
        elif not line.strip():
            # A blank line inside a head: it was a declaration that went on over several lines.
            start = start if any(l.rstrip().endswith("{") for l in lines[start - 1:number]) else None


def check_file(path, text, excused):
    lines = text.splitlines()
    limit = MAX_LINES.get(path.suffix)
    name = path.as_posix()
    if limit and len(lines) > limit and not excused(name):
        yield f"{name}: {len(lines)} lines, at most {limit}"
    if path.suffix == ".h" and not lines[0].startswith("//"):
        yield f"{name}: a header opens by saying what it is for"
    # Highway's *-inl.h are read once for each instruction set.
    if path.suffix == ".h" and "#pragma once" not in text and not path.stem.endswith("-inl"):
        yield f"{name}: no #pragma once"
    columns = MAX_GLSL_COLUMNS if path.stem.endswith("_glsl") else MAX_COLUMNS
    for number, line in enumerate(lines, 1):
        if len(line) > columns and "://" not in line:
            yield f"{name}:{number}: {len(line)} columns, at most {columns}"
    if path.suffix in (".cc", ".h"):
        for function, start, length in functions(lines):
            if length > MAX_FUNCTION and not excused(f"{name}:{function}"):
                yield f"{name}:{start}: {function} has {length} lines, at most {MAX_FUNCTION}"


def check(root, long_on_purpose=None):
    root = pathlib.Path(root)
    if long_on_purpose is None:
        table = pathlib.Path(__file__).with_name("long_on_purpose.toml")
        long_on_purpose = tomllib.loads(table.read_text())
    unused = set(long_on_purpose)

    def excused(name):
        unused.discard(name)
        return name in long_on_purpose

    found = []
    for path in source_tree.files(root, *TEXT):
        text = (root / path).read_text(errors="replace")
        if path.suffix in MAX_LINES and text:
            found.extend(check_file(path, text, excused))
        if path.parts[:2] != ("tests", "lint"):
            for number, line in enumerate(text.splitlines(), 1):
                if UNFINISHED.search(line):
                    found.append(f"{path}:{number}: {UNFINISHED.search(line).group()}")
    found.extend(f"long_on_purpose.toml: {name} is not too long" for name in sorted(unused))
    return found


if __name__ == "__main__":
    tree = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
    sys.exit(source_tree.report("style", check(tree)))
