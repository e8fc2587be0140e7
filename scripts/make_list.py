# SPDX-License-Identifier: MIT
"""The words that a target of make prints, such as list-examples, so that a list stands in one place."""
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[1]
# A make that runs the script must not pass its options on to the make that this function runs.
ENVIRONMENT = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}


def make_list(target):
    return subprocess.run(["make", "-s", "--no-print-directory", target], cwd=ROOT, env=ENVIRONMENT, stdout=subprocess.PIPE,
                          text=True, check=True).stdout.split()
