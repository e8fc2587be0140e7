# SPDX-License-Identifier: MIT
"""What documents quote: a block behind a line `<!-- COMMAND -->`, up to `<!-- end -->`."""
import os
import re
import sys


def renew(path, blocks, check=False):
    """Writes the blocks {command: text} into the document `path`. check: writes nothing. Returns 1 if `check` finds one
    out of date, else 0. Ends the program unless the document has each block once."""
    before = after = path.read_text()
    name = os.path.relpath(path)
    for command, block in blocks.items():
        begin, end = f"<!-- {command} -->\n", "<!-- end -->\n"
        # No mark may stand within a block: a block without end must not take what follows it.
        found = re.compile(f"^{re.escape(begin)}(?:(?!<!-- ).*\n)*?{end}", re.M)
        after, count = found.subn(lambda _: f"{begin}{block}\n{end}", after)
        if count != 1:
            sys.exit(f"{name} has {count or 'no'} block{'s' * (count > 1)} from a line {begin.strip()} to a line {end.strip()}")
    if after != before and not check:
        path.write_text(after)
    elif after != before:
        print(f"{name} quotes figures that are out of date: run make bench-docs")
    return int(check and after != before)
