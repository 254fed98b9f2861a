"""Holds includes and link lists against layers.toml.

    python3 tests/lint/check_layers.py [ROOT]
"""

import pathlib
import re
import sys
import tomllib

import cmake_targets
import source_tree

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.M)
PROJECT = ("render/", "proto/", "server/", "client/", "tests/", "deploy/")
COMMENT = re.compile(r"//[^\n]*")


class Layers:
    def __init__(self, root, table):
        self.root = pathlib.Path(root)
        self.table = table
        self.sources = source_tree.sources(root)
        self.text = {path.as_posix(): (self.root / path).read_text() for path in self.sources}
        self.includes = {path: INCLUDE.findall(text) for path, text in self.text.items()}

    def group_of(self, header):
        """The foreign group that `header` belongs to, "std", or None."""
        for group, patterns in self.table["groups"].items():
            if any(header == p or (p.endswith("/") and header.startswith(p)) for p in patterns):
                return group
        is_standard = re.fullmatch(r"[a-z0-9_]+", header) or re.fullmatch(r"std\w+\.h", header)
        return "std" if is_standard else None

    def row_of(self, path):
        """The longest folder of the table that holds `path`, or None."""
        rows = [row for row in self.table["folders"] if path.startswith(row + "/")]
        return max(rows, key=len, default=None)

    def allows(self, row, header):
        """Whether files of `row` may include the project's own `header`."""
        if header.startswith(row + "/"):
            return True
        return any(header == use or (use.endswith("/") and header.startswith(use))
                   for use in self.table["folders"][row])

    def check_includes(self):
        for path, headers in self.includes.items():
            row = self.row_of(path)
            if row is None:
                yield f"{path}: its folder is not in layers.toml"
                continue
            for header in headers:
                if header.startswith(PROJECT):
                    if not self.allows(row, header):
                        yield f"{path}: {row} must not include {header}"
                    continue
                group = self.group_of(header)
                if group is None and (self.root / path).parent.joinpath(header).exists():
                    yield f"{path}: write {header} with its path from the root"
                elif group is None:
                    yield f"{path}: {header} is in no group of layers.toml"
                elif group != "std" and group not in self.table["folders"][row]:
                    yield f"{path}: {row} must not include {header} ({group})"

    def check_only(self):
        for group, homes in self.table["only"].items():
            for path, headers in self.includes.items():
                if path not in homes and any(self.group_of(h) == group for h in headers):
                    yield f"{path}: {group} headers are for {', '.join(homes)} alone"

    def reached(self, path):
        """The foreign groups that the translation unit `path` includes, through headers of ours."""
        groups, seen, pending = set(), set(), [path]
        while pending:
            current = pending.pop()
            if current in seen:
                continue
            seen.add(current)
            for header in self.includes.get(current, ()):
                if header.startswith(PROJECT):
                    pending.append(header)
                else:
                    groups.add(self.group_of(header))
        return groups

    def check_apart(self):
        for path in self.includes:
            if not path.endswith(".cc"):
                continue
            groups = self.reached(path)
            for group, others in self.table["apart"].items():
                for other in others:
                    if group in groups and other in groups:
                        yield f"{path}: {group} and {other} headers in one translation unit"

    def impurities(self, path):
        pure = self.table["pure"]
        for header in self.includes[path]:
            if header in pure["headers"]:
                yield f"includes <{header}>"
        code = COMMENT.sub("", self.text[path])
        for word in pure["words"]:
            if re.search(rf"(?<![\w:]){re.escape(word)}\b", code):
                yield f"uses {word}"

    def check_pure(self):
        pure = self.table["pure"]
        excused = set(pure.get("excused", {}))
        for path in self.includes:
            if not path.startswith(tuple(folder + "/" for folder in pure["folders"])):
                continue
            found = list(self.impurities(path))
            if path in excused:
                excused.discard(path)
                if not found:
                    yield f"{path}: excused in layers.toml and needs no excuse"
                continue
            for what in found:
                yield f"{path}: {what}; render/ knows no files, environment, log or clock"
        for path in sorted(excused):
            yield f"{path}: excused in layers.toml and does not exist"

    def check_links(self):
        targets = cmake_targets.read_targets(self.root)
        owner = {s.as_posix(): t.name for t in targets.values() for s in t.sources}
        for path in self.includes:
            if path.endswith(".cc") and path not in owner:
                yield f"{path}: in no target's SOURCES"
        for target in targets.values():
            yield from self.check_target(target, targets, owner)

    def check_target(self, target, targets, owner):
        if not target.sources or target.folder.parts[:1] == ("tests",):
            return
        row = self.row_of(f"{target.folder.as_posix()}/x")
        for link in sorted(target.links):
            provided = [s.with_suffix(".h").as_posix()
                        for s in targets[link].sources] if link in targets else []
            if provided and not any(self.allows(row, header) for header in provided):
                yield f"{target.folder}: {target.name} must not link {link}"
        linked = cmake_targets.closure(targets, target.name)
        for source in target.sources:
            path = source.as_posix()
            for file in (path, path[:-3] + ".h"):
                for header in self.includes.get(file, ()):
                    needed = owner.get(re.sub(r"\.h$", ".cc", header))
                    if needed and needed not in linked:
                        yield f"{file}: includes {header}, but {target.name} does not link {needed}"

    def check(self):
        found = []
        for part in (self.check_includes, self.check_only, self.check_apart, self.check_pure,
                     self.check_links):
            found.extend(part())
        return sorted(set(found))


def check(root):
    table = pathlib.Path(__file__).with_name("layers.toml")
    return Layers(root, tomllib.loads(table.read_text())).check()


if __name__ == "__main__":
    tree = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
    sys.exit(source_tree.report("layers", check(tree)))
