#!/usr/bin/env python3
"""The console's texts, packed, as a header: they take half the flash that way. A byte of 0x80 and
above, or below 0x20, stands for two others, which may be such bytes again: the pairs that are worth most, found one
after the other in all texts of the tables.

usage: texts.py > texts.h     from the root of the project
"""
import collections

import console

CODES = [*range(0x80, 0x100), *range(0x01, 0x20)]  # 0x00 ends a text
DEPTH = 6  # pairs within pairs: WRITER_DEPTH of writer.h


def tables():
    """(name of the text, text) of each."""
    for _, name, arguments, what, details, example in console.commands():
        yield f"usage_{name}", f"{name}{arguments}: {what}"
        yield f"details_{name}", details
        yield f"example_{name}", example
    for path, table, kind, end in [("src/controller/command.h", "COMMAND_GROUPS", "heading", ":"),
                                   ("src/controller/sentences.h", "SENTENCES", "sentence", "")]:
        for name, text in console.HEADING.findall(console.table(path, table)):
            yield f"{kind}_{name}", console.texts(text) + end
    for path, table, kind in [("include/cds55xx/result.h", "CDS_RESULTS", "error"),
                              ("src/controller/errors.h", "CONSOLE_ERRORS", "error"),
                              ("include/cds55xx/diagnose.h", "CDS_FINDINGS", "finding")]:
        for name, text, remedy in console.numbered(path, table):
            yield f"{kind}_{name}", f"{text}; {remedy}"


def best_pair(packed, depth):
    """The pair that occurs most often; of two, the one of lower codes. None: it is not worth it."""
    count = collections.Counter()
    for codes in packed:
        last = None
        for pair in zip(codes, codes[1:]):
            if pair != last:  # "aaa" holds the pair once
                count[pair] += 1
            last = pair if pair != last else None
    worth = [(-n, pair) for pair, n in count.items()
             if n > 3 and 1 + max(depth[code] for code in pair) <= DEPTH]
    return min(worth)[1] if worth else None


def replace(codes, pair, code):
    out, at = [], 0
    while at < len(codes):
        if tuple(codes[at:at + 2]) == pair:
            out.append(code)
            at += 2
        else:
            out.append(codes[at])
            at += 1
    return out


def pack(texts):
    """(pairs, packed texts)"""
    packed = [list(text.encode("ascii")) for text in texts]
    depth = collections.Counter()  # plain characters: 0
    pairs = []
    for code in CODES:
        pair = best_pair(packed, depth)
        if pair is None:
            break
        pairs.append(pair)
        depth[code] = 1 + max(depth[part] for part in pair)
        packed = [replace(codes, pair, code) for codes in packed]
    return pairs, packed


def literal(codes):
    return '"' + "".join(f"\\{code:03o}" if code < 0x20 or code > 0x7E or chr(code) in '"\\?'
                         else chr(code) for code in codes) + '"'


def main():
    named = list(tables())
    pairs, packed = pack([text for _, text in named])
    print("/* Written by scripts/texts.py. */")
    print("#define PACKED_PAIRS {" + ", ".join(f"{{{a}, {b}}}" for a, b in pairs) + "}")
    for (name, _), codes in zip(named, packed):
        print(f"#define PACKED_{name} {literal(codes)}")


if __name__ == "__main__":
    main()
