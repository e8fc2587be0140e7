#!/usr/bin/env python3
"""The console's texts, packed, as a header: they take half the flash that way. In one array of bytes
stands text after text, each behind its length. A byte is a character, a mark for a value, or a pair:
two others, which may be such bytes again.

usage: texts.py > texts.h     from the root of the project
"""
import collections
import re

import console

DEPTH = 6  # pairs within pairs: WRITER_DEPTH of writer.h
MARKS = ["#", "$", "<long>", "<deg>", "<rpm>", "<V>", "<C>", "<bps>"]  # enum mark of writer.c


def by_number(*tables):
    """The texts of tables of numbered ones, in their order from 0 on; a number that none has: ""."""
    found = {number: f"{text}; {remedy}" for table in tables
             for number, text, remedy in console.numbered(*table)}
    return [found.get(number, "") for number in range(max(found) + 1)]


def headings():
    """(name, heading, number of the first command) of each group."""
    groups = [group for group, *_ in console.commands()]
    names = console.HEADING.findall(console.table("src/controller/console/command.h", "COMMAND_GROUPS"))
    if list(dict.fromkeys(groups)) != [name for name, _ in names] or groups != sorted(
            groups, key=groups.index):
        raise SystemExit("commands.h: the rows do not stand in the order of COMMAND_GROUPS")
    return [(name, console.texts(text), groups.index(name)) for name, text in names]


def tables():
    """(name of the first one, texts) of each table."""
    rows = list(console.commands())
    yield "USAGE", [f"{name}{arguments}: {what}" for _, name, arguments, what, _, _ in rows]
    yield "DETAILS", [details for *_, details, _ in rows]
    yield "EXAMPLE", [example for *_, example in rows]
    yield "HEADING", [f"{heading}:" for _, heading, _ in headings()]
    yield "ERROR", by_number(("include/cds55xx/result.h", "CDS_RESULTS"),
                             ("src/controller/console/errors.h", "CONSOLE_ERRORS"))
    yield "FINDING", by_number(("include/cds55xx/diagnose.h", "CDS_FINDINGS"))
    for name, text in console.HEADING.findall(console.table("src/controller/console/messages.h",
                                                            "SENTENCES")):
        yield name, [console.texts(text)]


def symbols(text):
    """The marks and characters of a text."""
    return re.findall("|".join(map(re.escape, MARKS)) + "|.", text)


def best_pair(packed, depth):
    """The pair that occurs most often; of two, the first one. None: it is not worth it."""
    count = collections.Counter()
    for codes in packed:
        last = None
        for pair in zip(codes, codes[1:]):
            if pair != last:  # "aaa" holds the pair once
                count[pair] += 1
            last = pair if pair != last else None
    worth = [(-n, pair) for pair, n in count.items()
             if n > 3 and not {*pair} & {*MARKS}  # a mark stands alone: writer.c
             and 1 + max(depth[code] for code in pair) <= DEPTH]
    return min(worth)[1] if worth else None


def replace(codes, pair):
    out, at = [], 0
    while at < len(codes):
        if tuple(codes[at:at + 2]) == pair:
            out.append("".join(pair))
            at += 2
        else:
            out.append(codes[at])
            at += 1
    return out


def shortest(codes, words):
    """A text as the fewest of `words`, each a tuple of its symbols."""
    best = [(0, None)]  # how many for so many symbols, and the last of them
    for end in range(1, len(codes) + 1):
        best.append(min((best[end - len(word)][0] + 1, word) for word in words
                        if tuple(codes[max(end - len(word), 0):end]) == word))
    out, end = [], len(codes)
    while end:
        out.insert(0, "".join(best[end][1]))
        end -= len(best[end][1])
    return out


def pack(texts):
    """(plain characters, pairs, packed texts): what stands for more than a symbol is its string."""
    split = [symbols(text) for text in texts]
    plain = sorted({code for codes in split for code in codes} - {*MARKS})
    packed, pairs, depth = split, [], collections.Counter()  # of the depth of a character: 0
    while len(plain) + len(MARKS) + len(pairs) < 256:
        pair = best_pair(packed, depth)
        if pair is None:
            break
        pairs.append(pair)
        depth["".join(pair)] = 1 + max(depth[part] for part in pair)
        packed = [replace(codes, pair) for codes in packed]
    words = [(code,) for code in plain + MARKS] + [tuple("".join(pair)) for pair in pairs]
    return plain, pairs, [shortest(codes, words) for codes in split]


def main():
    named = list(tables())
    plain, pairs, packed = pack([text for _, texts in named for text in texts])
    codes = [*plain, *MARKS, *("".join(pair) for pair in pairs)]
    code = {word: number for number, word in enumerate(codes)}
    print("/* Written by scripts/texts.py. */")
    print('#define TEXT_PLAIN "' + re.sub(r'(["\\])', r"\\\1", "".join(plain)) + '"')
    print(f"#define TEXT_MARK {len(plain)}")
    print(f"#define TEXT_PAIR {len(plain) + len(MARKS)}")
    print("#define TEXT_PAIRS {" + ", ".join(f"{{{code[a]}, {code[b]}}}" for a, b in pairs) + "}")
    print("#define TEXT_FIRST_OF_GROUP {" + ", ".join(str(first) for *_, first in headings()) + "}")
    written = []
    for name, texts in named:
        print(f"#define TEXT_{name} {len(written)}")
        for _ in texts:
            text = [code[word] for word in packed.pop(0)]
            written += [len(text), *text]
    print("#define TEXTS {" + ", ".join(map(str, written)) + "}")


if __name__ == "__main__":
    main()
