"""Whether docs/techniques/NAME.md has the parameters that the program tells of.

    python3 tests/lint/check_techniques.py PENUMBRA [ROOT]

The page of a technique has a table headed "parameter", with the columns type, default, range and
more: | `samples` | uint | 64 | 1 to 1024 | …
"""

import json
import pathlib
import re
import subprocess
import sys

import source_tree

FOLDER = "docs/techniques"


def rows(page):
    """Name → (type, default, range) of the table that is headed "parameter"."""
    found = {}
    table = re.search(r"^\| parameter \|.*\n\| ---.*\n((?:\|.*\n)*)", page, re.M)
    for line in table.group(1).splitlines() if table else []:
        cells = [cell.strip().strip("`") for cell in line.strip().strip("|").split("|")]
        if len(cells) >= 4:
            found[cells[0]] = tuple(cells[1:4])
    return found


def check_page(technique, path, text):
    stated = rows(text)
    for parameter in technique["parameters"]:
        name = parameter["name"]
        told = tuple(parameter[key] for key in ("type", "default_value", "range"))
        if name not in stated:
            yield f"{path}: parameter {name} is missing"
        elif stated[name] != told:
            yield f"{path}: {name} is {' | '.join(stated[name])}, the program says {' | '.join(told)}"
        stated.pop(name, None)
    for name in stated:
        yield f"{path}: {name} is no parameter of {technique['name']}"


def check(root, program):
    run = subprocess.run([program, "techniques", "--json"], capture_output=True, text=True)
    if run.returncode != 0:
        return [f"{program} techniques --json: {run.stderr.strip()}"]
    found = []
    known = set()
    for technique in json.loads(run.stdout)["techniques"]:
        path = f"{FOLDER}/{technique['name']}.md"
        known.add(path)
        page = pathlib.Path(root) / path
        if page.exists():
            found.extend(check_page(technique, path, page.read_text()))
        else:
            found.append(f"{path}: missing; the program has a technique of that name")
    for page in sorted((pathlib.Path(root) / FOLDER).glob("*.md")):
        if page.name != "README.md" and f"{FOLDER}/{page.name}" not in known:
            found.append(f"{FOLDER}/{page.name}: the program has no technique of that name")
    return found


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("check_techniques: name the program penumbra")
    tree = sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parents[2]
    sys.exit(source_tree.report("techniques", check(tree, sys.argv[1])))
