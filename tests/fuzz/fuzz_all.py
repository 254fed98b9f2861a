"""Runs every fuzz target of a build for some time each, two at a time.

    python3 tests/fuzz/fuzz_all.py build/fuzz/tests/fuzz 60

The targets are the programs fuzz_* of the folder, each with its corpus in tests/fuzz/corpus. Prints
a line a target and how many were without a finding; the status is 0 if all were. A finding is left
in FOLDER/findings, what was learned on the way in FOLDER/learned, where the next run goes on from
it.
"""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

CORPUS = pathlib.Path(__file__).parent / "corpus"
AT_A_TIME = 2
OPTIONS = ["-timeout=20", "-rss_limit_mb=2560", "-malloc_limit_mb=512", "-max_len=65536",
           "-print_final_stats=1"]
# What targets write need not reach a disk.
ENVIRONMENT = {"TMPDIR": "/dev/shm", "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1"}


def last(pattern, text):
    found = re.findall(pattern, text)
    return int(found[-1]) if found else 0


def run(folder, name, seconds):
    """(line, whether there was no finding, what it said) of one target."""
    learned = folder / "learned" / name
    findings = folder / "findings"
    learned.mkdir(parents=True, exist_ok=True)
    findings.mkdir(exist_ok=True)
    command = [folder / f"fuzz_{name}", f"-max_total_time={seconds}",
               f"-artifact_prefix={findings}/{name}-", *OPTIONS, learned, CORPUS / name]
    done = subprocess.run(command, env=os.environ | ENVIRONMENT, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True, errors="replace", check=False)
    runs = last(r"stat::number_of_executed_units:\s*(\d+)", done.stderr)
    coverage = last(r"\bcov: (\d+)", done.stderr)
    is_clean = done.returncode == 0 and runs > 0
    line = (f"{name:16} {runs:>9,} runs {runs // seconds:>6,} a second {coverage:>6,} places "
            f"reached  {'no finding' if is_clean else f'FINDING (status {done.returncode})'}")
    return line, is_clean, done.stderr


def targets(folder):
    """(names, what is wrong with them): a target that is not run has no finding either."""
    names = sorted(path.name.removeprefix("fuzz_") for path in folder.glob("fuzz_*")
                   if path.is_file() and os.access(path, os.X_OK))
    corpora = sorted(path.name for path in CORPUS.iterdir() if any(path.glob("*")))
    wrong = [f"fuzz_{name}: no corpus in {CORPUS}" for name in names if name not in corpora]
    wrong += [f"{CORPUS / name}: no program fuzz_{name}" for name in corpora if name not in names]
    if not names:
        wrong.append(f"no program fuzz_* in {folder}")
    return names, wrong


def main(folder, seconds):
    names, wrong = targets(folder)
    if wrong:
        print("\n".join(wrong))
        return 1
    clean = 0
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        for line, is_clean, said in pool.map(lambda name: run(folder, name, seconds), names):
            print(line, flush=True)
            clean += is_clean
            if not is_clean:
                print("\n".join("    " + text for text in said.splitlines()[-60:]), flush=True)
    print(f"{clean} of {len(names)} without a finding")
    return 0 if clean == len(names) else 1


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve(), int(sys.argv[2])))
