"""The files of the project, for the lints: what is built, generated or fetched is left out."""

import pathlib

LEFT_OUT = {".git", ".cache", "build", "out", "node_modules", "__pycache__"}


def files(root, *suffixes):
    """Paths relative to `root` of the files with one of `suffixes`, or of all files, sorted."""
    root = pathlib.Path(root)
    found = []
    pending = [root]
    while pending:
        for entry in pending.pop().iterdir():
            if entry.is_symlink():
                continue
            if entry.is_dir():
                if entry.name not in LEFT_OUT:
                    pending.append(entry)
            elif not suffixes or entry.suffix in suffixes:
                found.append(entry.relative_to(root))
    return sorted(found)


def sources(root):
    """C++ sources and headers."""
    return files(root, ".cc", ".h")


def report(name, violations):
    """Prints `violations`, one a line, and returns the exit status."""
    for violation in violations:
        print(violation)
    print(f"{name}: {len(violations)} violations")
    return 1 if violations else 0
