# SPDX-License-Identifier: MIT
"""What documents quote: a block behind a line `<!-- COMMAND -->`, up to `<!-- end -->`."""
import re


def renewed(text, command, block):
    """The document with another block."""
    begin, end = f"<!-- {command} -->", "<!-- end -->"
    return re.sub(f"{begin}.*?{end}", lambda found: f"{begin}\n{block}\n{end}", text, flags=re.S)
