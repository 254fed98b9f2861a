"""Whether every row of the catalogue of bad input has a test, and every test of a row is in it.

    python3 tests/lint/check_catalogue.py [ROOT]

tests/catalogue/rows.toml has for each row what it is about and its tests, or why it has none. A test is named
Suite.Name (C++), Suite/Parameter (a named case of a TEST_P), or Class.test_name (Python); * stands for any characters.
A test whose name begins with an id is a test of that row.
"""

import fnmatch
import pathlib
import re
import sys
import tomllib

import source_tree

TABLE = "tests/catalogue/rows.toml"
# Geometry and content; identity and revisions; transport, load and time; storage; security.
SECTIONS = {"A": 22, "B": 17, "C": 25, "D": 10, "E": 17}
CPP_TEST = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", re.M)
CPP_SUITE = re.compile(r"^INSTANTIATE_TEST_SUITE_P\(\s*\w+,\s*(\w+),", re.M)
CPP_PARAMETER = re.compile(r'"([A-Z]\d\d[A-Z]\w*)"')
PYTHON_CLASS_OR_TEST = re.compile(r"^class (\w+)|^    def (test_\w+)", re.M)
ID = re.compile(r"(?:test_)?([A-E]\d\d)(?=[A-Z_])")


def tests_in_cpp(text):
    for suite, name in CPP_TEST.findall(text):
        yield f"{suite}.{name}", name
    for suite in set(CPP_SUITE.findall(text)):
        for name in CPP_PARAMETER.findall(text):
            yield f"{suite}/{name}", name


def tests_in_python(text):
    suite = ""
    for found in PYTHON_CLASS_OR_TEST.finditer(text):
        suite = found.group(1) or suite
        if found.group(2):
            yield f"{suite}.{found.group(2)}", found.group(2)


def all_tests(root):
    """Test → the id that its name begins with, or None."""
    tests = {}
    for path in source_tree.files(root, ".cc", ".py"):
        if path.parts[0] != "tests" or path.parts[1] == "lint":
            continue
        find = tests_in_cpp if path.suffix == ".cc" else tests_in_python
        for test, name in find((pathlib.Path(root) / path).read_text()):
            found = ID.match(name)
            tests[test] = found.group(1) if found else None
    return tests


def check_row(row, entry, tests):
    if not entry.get("what"):
        yield f"{row}: does not say what it is about"
    if ("tests" in entry) == ("does_not_apply" in entry):
        yield f"{row}: needs either tests or a reason why it does not apply"
    if "does_not_apply" in entry and not entry["does_not_apply"]:
        yield f"{row}: does not say why it does not apply"
    for unknown in sorted(entry.keys() - {"what", "answer", "tests", "does_not_apply"}):
        yield f"{row}: {unknown} is nothing that a row has"
    matched = set()
    for pattern in entry.get("tests", []):
        named = fnmatch.filter(tests, pattern)
        if not named:
            yield f"{row}: there is no test {pattern}"
        matched.update(named)
    if "tests" in entry and row not in {tests[test] for test in matched}:
        yield f"{row}: no test has a name that begins with {row}"
    for test in sorted(test for test, named_row in tests.items() if named_row == row):
        if test not in matched:
            yield f"{row}: {test} is not in {TABLE}"


def check(root, sections=None):
    sections = sections or SECTIONS
    root = pathlib.Path(root)
    rows = tomllib.loads((root / TABLE).read_text())
    tests = all_tests(root)
    expected = {f"{section}{number:02}" for section, count in sections.items()
                for number in range(1, count + 1)}
    found = [f"{row}: missing in {TABLE}" for row in sorted(expected - rows.keys())]
    found += [f"{row}: is no row of the catalogue" for row in sorted(rows.keys() - expected)]
    found += [f"{test}: {row} is no row of the catalogue" for test, row in sorted(tests.items())
              if row and row not in expected]
    for row, entry in rows.items():
        found.extend(check_row(row, entry, tests))
    return found


def summary(root):
    rows = tomllib.loads((pathlib.Path(root) / TABLE).read_text())
    tests = all_tests(root)
    applying = {row: entry for row, entry in rows.items() if "does_not_apply" not in entry}
    tested = [row for row, entry in applying.items()
              if any(tests[test] == row for pattern in entry.get("tests", [])
                     for test in fnmatch.filter(tests, pattern))]
    return (f"catalogue: {len(tested)} of {len(applying)} rows that apply have tests, "
            f"{len(rows) - len(applying)} do not apply")


if __name__ == "__main__":
    tree = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]
    status = source_tree.report("catalogue", check(tree))
    print(summary(tree))
    sys.exit(status)
