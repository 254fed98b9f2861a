"""Lints the protocol with Buf.

    python3 tests/lint/check_protocol.py FOLDER [ROOT]

Buf comes from npm, pinned by buf/package-lock.json, and is fetched once into FOLDER; after that
nothing is fetched. Linting itself needs no network.
"""

import pathlib
import shutil
import subprocess
import sys

import source_tree

LOCK = pathlib.Path(__file__).parent / "buf"


def fetch(folder):
    """The path of Buf in `folder`, or what is wrong, as (path, error)."""
    folder = pathlib.Path(folder)
    buf = folder / "node_modules/.bin/buf"
    lock = (LOCK / "package-lock.json").read_text()
    stamp = folder / "fetched-lock.json"
    if buf.exists() and stamp.exists() and stamp.read_text() == lock:
        return buf, None
    if shutil.which("npm") is None:
        return None, "no npm: install the packages nodejs and npm"
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(LOCK / name, folder / name)
    run = subprocess.run(["npm", "install", "--no-save", "--no-audit", "--no-fund"], cwd=folder,
                         capture_output=True, text=True)
    if run.returncode != 0:
        return None, f"npm could not fetch @bufbuild/buf (no network?): {run.stderr.strip()[-500:]}"
    stamp.write_text(lock)
    return buf, None


def check(root, folder):
    buf, error = fetch(folder)
    if error:
        return [error]
    run = subprocess.run([buf.resolve(), "lint"], cwd=pathlib.Path(root) / "proto",
                         capture_output=True, text=True)
    output = (run.stdout + run.stderr).strip().splitlines()
    if run.returncode != 0 and not output:
        output = [f"buf lint ended with status {run.returncode}"]
    return output if run.returncode != 0 else []


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("check_protocol: name the folder that Buf is fetched into")
    tree = sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parents[2]
    sys.exit(source_tree.report("protocol", check(tree, sys.argv[1])))
