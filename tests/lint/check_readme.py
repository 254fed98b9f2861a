"""Runs the commands of README.md.

    python3 tests/lint/check_readme.py BUILD_FOLDER [ROOT]

A fenced block counts when the line before it is "<!-- test -->". The blocks run in order, as
written, in one scratch folder where deploy/ is the project's and build/release is BUILD_FOLDER.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

import source_tree

BLOCK = re.compile(r"^<!-- test -->\n```sh\n(.*?)^```", re.M | re.S)
TIME_LIMIT_S = 300


def blocks(readme):
    return BLOCK.findall(readme)


def run_block(block, scratch):
    """What went wrong, or None."""
    try:
        run = subprocess.run(["sh", "-eu", "-c", block], cwd=scratch, capture_output=True, text=True,
                             timeout=TIME_LIMIT_S)
    except subprocess.TimeoutExpired:
        return f"took more than {TIME_LIMIT_S} s"
    if run.returncode != 0:
        return f"status {run.returncode}: {(run.stdout + run.stderr).strip()[-1500:]}"
    return None


def check(root, build):
    root, build = pathlib.Path(root).resolve(), pathlib.Path(build).resolve()
    found = blocks((root / "README.md").read_text())
    if not found:
        return ["README.md: no block is marked <!-- test -->"]
    violations = []
    with tempfile.TemporaryDirectory(prefix="penumbra-readme-") as scratch:
        scratch = pathlib.Path(scratch)
        (scratch / "build").mkdir()
        (scratch / "build/release").symlink_to(build)
        (scratch / "deploy").symlink_to(root / "deploy")
        for block in found:
            print(block, end="", flush=True)
            wrong = run_block(block, scratch)
            if wrong:
                violations.append(f"README.md: {block.strip()}\n  {wrong}")
    return violations


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("check_readme: name the folder that the programs were built in")
    tree = sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parents[2]
    sys.exit(source_tree.report("readme", check(tree, sys.argv[1])))
