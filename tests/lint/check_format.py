"""Whether every source is as clang-format 14 would write it.

    python3 tests/lint/check_format.py [ROOT]

Mend what it finds with: clang-format -i FILE
"""

import pathlib
import re
import shutil
import subprocess
import sys

import source_tree

VERSION = "14"


def formatter():
    """The clang-format of Debian 12; another version breaks lines elsewhere."""
    for name in (f"clang-format-{VERSION}", "clang-format"):
        if shutil.which(name):
            told = subprocess.run([name, "--version"], capture_output=True, text=True, check=True)
            if re.search(rf"version {VERSION}\.", told.stdout):
                return name
    return None


def check(root):
    name = formatter()
    if name is None:
        return [f"no clang-format {VERSION}: install the package clang-format of Debian 12"]
    paths = [path.as_posix() for path in source_tree.sources(root)]
    run = subprocess.run([name, "--dry-run", *paths], cwd=root, capture_output=True, text=True)
    found = re.findall(r"^(\S+?):(\d+):\d+: \w+: code should be clang-formatted", run.stderr, re.M)
    first = {}
    for path, line in found:
        first.setdefault(path, line)
    violations = [f"{path}:{line}: not as clang-format writes it" for path, line in first.items()]
    if run.returncode != 0 and not violations:
        violations.append(f"clang-format failed: {run.stderr.strip()[:500]}")
    return violations


if __name__ == "__main__":
    tree = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
    sys.exit(source_tree.report("format", check(tree)))
