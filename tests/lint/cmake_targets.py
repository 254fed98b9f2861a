"""The project's CMake targets, read from the CMakeLists.txt files: sources and link lists."""

import dataclasses
import pathlib
import re

from source_tree import files

CALL = re.compile(r"\b([A-Za-z_]\w*)\s*\(([^()]*)\)")
KEYWORDS = {"PUBLIC", "PRIVATE", "INTERFACE"}
FROM_ROOT = "//"
LISTS = {"SOURCES", "LINKS", "PRIVATE_LINKS", "LABELS", "TIMEOUT", "MUTANTS"}


@dataclasses.dataclass
class Target:
    name: str
    folder: pathlib.PurePath
    sources: list = dataclasses.field(default_factory=list)  # relative to the root
    links: set = dataclasses.field(default_factory=set)


def _split_lists(words):
    lists, current = {}, None
    for word in words:
        if word in LISTS:
            current = lists.setdefault(word, [])
        elif current is not None:
            current.append(word)
    return lists


def _read_call(targets, folder, command, words):
    if not words or "$" in words[0]:
        return
    name, rest = words[0], words[1:]
    if command == "penumbra_fuzz":
        name = f"fuzz_{name}"
    target = targets.setdefault(name, Target(name, folder))
    if command in ("penumbra_library", "penumbra_test", "penumbra_fuzz"):
        lists = _split_lists(rest)
        sources = lists.get("SOURCES", [])
        target.links |= set(lists.get("LINKS", []) + lists.get("PRIVATE_LINKS", []))
    elif command in ("add_executable", "add_library"):
        sources = [word for word in rest if word.endswith(".cc")]
    else:
        target.links |= set(rest) - KEYWORDS
        sources = []
    for source in sources:
        if source.startswith(FROM_ROOT):
            target.sources.append(pathlib.PurePath(source[len(FROM_ROOT):]))
        elif "$" not in source:
            target.sources.append(folder / source)


def read_targets(root):
    """Name → Target for everything under `root`."""
    commands = {"penumbra_library", "penumbra_test", "penumbra_fuzz", "add_executable",
                "add_library", "target_link_libraries"}
    targets = {}
    for path in files(root, ".txt"):
        if path.name != "CMakeLists.txt":
            continue
        text = (pathlib.Path(root) / path).read_text()
        text = re.sub(r"#[^\n]*", "", text)
        text = re.sub(r"\bfunction\(.*?\bendfunction\(\)", "", text, flags=re.S)
        text = text.replace("${PROJECT_SOURCE_DIR}/", FROM_ROOT)
        text = re.sub(r"\$\{\w+\}", "$", text)
        for command, arguments in CALL.findall(text):
            if command in commands:
                _read_call(targets, path.parent, command, arguments.split())
    return {name: t for name, t in targets.items() if t.sources or t.links}


def closure(targets, name):
    """The names of all targets that `name` links, directly or through others, and itself."""
    seen, pending = set(), [name]
    while pending:
        current = pending.pop()
        if current not in seen:
            seen.add(current)
            pending.extend(targets[current].links if current in targets else ())
    return seen
