"""Whether the pages say what the code does: limits, links, and the decision records' list.

    python3 tests/lint/check_docs.py [ROOT]
"""

import pathlib
import re
import sys

import source_tree

LIMITS_PAGE = "docs/limits.md"
SECTIONS = {"Of a scene": "render/scene/scene_limits.h", "Of a server": "server/limits.h"}
FIELD = re.compile(r"^  [\w:]+ (max_\w+)(?: = |\{)([^;]+?)\}?;", re.M)
ROW = re.compile(r"^\| `(\w+)` \| ([^|]+) \|", re.M)
OPERATIONS_PAGE = "docs/operations.md"
# Section of the page → which files of the server say the names, and how.
TOLD = {"Options": ("options.cc", r"add_(?:option|flag)\(\s*\"--([\w-]+)\""),
        "Log": ("**/*.cc", r"\b(?:(?:Debug|Info|Warning|Error)\(|Write(?:Line)?\([\w:]+,)\s*"
                           r"\"(\w+)\""),
        "Metrics": ("**/*[.]*", r"\"(penumbra_\w+)\"")}
NOT_IN_TABLE = {"config", "print-config",
                "penumbra_role"}  # a claim of tokens, no metric
TABLE_NAME = re.compile(r"^\| `([\w-]+)` \|", re.M)
LINK = re.compile(r"\[[^\]]*\]\(([^)#\s]+)(?:#[^)]*)?\)")


def number(text):
    """The value of a C++ literal or shift of literals."""
    text = re.sub(r"uint64_t\{(\d+)\}", r"\1", text.replace("'", "").replace("size_t", "uint64_t"))
    text = re.sub(r"(?<=\d)(ull|ul|u|f)\b", "", text, flags=re.I)
    base, _, shift = text.partition("<<")
    return float(base) * 2.0 ** float(shift or 0)


def limits_in_code(text):
    limits = {}
    for name, value in FIELD.findall(text):
        try:
            limits[name] = number(value)
        except ValueError:
            pass  # not a number: a struct of limits
    return limits


def check_limits(root):
    page = (root / LIMITS_PAGE).read_text()
    reported = set(re.findall(r"\b(max_\w+) = \d+;", (root / "proto/penumbra/v1/server_info.proto")
                              .read_text()))
    stated = set()
    for section, header in SECTIONS.items():
        part = page.split(f"## {section}\n", 1)[-1].split("\n## ", 1)[0]
        code = limits_in_code((root / header).read_text())
        for name in sorted(code.keys() - reported):
            yield f"{header}: {name} is not in v1.Limits, with which the server reports it"
        for name, value in ROW.findall(part):
            stated.add(name)
            if name not in code:
                yield f"{LIMITS_PAGE}: {name} is not in {header}"
            elif float(value) != code[name]:
                yield f"{LIMITS_PAGE}: {name} is {value.strip()}, {header} has {code[name]:.0f}"
    for name in sorted(reported - stated):
        yield f"{LIMITS_PAGE}: {name}, which the server reports, is missing"


def check_operations(root):
    page = (root / OPERATIONS_PAGE).read_text()
    for section, (sources, pattern) in TOLD.items():
        part = page.split(f"## {section}\n", 1)[-1].split("\n## ", 1)[0]
        stated = set(TABLE_NAME.findall(part))
        told = {name for source in (root / "server").glob(sources) if source.is_file()
                for name in re.findall(pattern, source.read_text())} - NOT_IN_TABLE
        for name in sorted(told - stated):
            yield f"{OPERATIONS_PAGE}: {section}: {name} is missing"
        for name in sorted(stated - told):
            yield f"{OPERATIONS_PAGE}: {section}: {name} is nowhere in server/"


def check_links(root):
    for path in source_tree.files(root, ".md"):
        for target in LINK.findall((root / path).read_text()):
            if "://" not in target and not (root / path.parent / target).exists():
                yield f"{path}: links to {target}, which does not exist"


def check_records(root):
    folder = root / "docs/adr"
    index = (folder / "README.md").read_text()
    for record in sorted(folder.glob("[0-9]*.md")):
        if f"({record.name})" not in index:
            yield f"docs/adr/README.md: {record.name} is missing"


def check(root):
    root = pathlib.Path(root)
    return [*check_limits(root), *check_operations(root), *check_links(root), *check_records(root)]


if __name__ == "__main__":
    tree = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
    sys.exit(source_tree.report("docs", check(tree)))
