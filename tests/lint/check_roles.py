"""Whether docs/security.md shows the table of roles that the server decides by.

    python3 tests/lint/check_roles.py CHECK_RPC_ROLES
"""

import pathlib
import subprocess
import sys

PAGE = pathlib.Path(__file__).parents[2] / "docs/security.md"


def main(program):
    table = subprocess.run([program, "--markdown"], check=True, capture_output=True, text=True)
    if table.stdout in PAGE.read_text():
        return 0
    print(f"roles: docs/security.md shows another table than {program} --markdown:\n{table.stdout}")
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
