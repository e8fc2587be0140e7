// SPDX-License-Identifier: MIT
/* The codec against all packets that the manual prints. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import * as p from "../../src/wire/packet.js";
import { ROOT } from "../support/simulator.js";

const manual = readFileSync(join(ROOT, "test/runs/manual_packets.tsv"), "utf8")
    .split("\n")
    .filter((line) => line && !line.startsWith("#"))
    .map((line) => line.split("\t"))
    .map(([example, sender, bytes]) => ({ example, sender, bytes: p.fromHex(bytes) }));

/* Builds the packet again from its fields. */
function rebuilt(bytes) {
    const parameters = [...bytes.slice(p.AT_PARAMETERS, -1)];

    return p.packet(bytes[p.AT_ID], bytes[p.AT_ERROR], parameters);
}

test("packet: the manual has 41 packets", () => assert.equal(manual.length, 41));

for (const { example, bytes } of manual)
    test(`packet: example ${example}, ${p.toHex(bytes).slice(0, 30)}`, () => {
        assert.ok(p.isPacket(bytes));
        assert.deepEqual(rebuilt(bytes), bytes);
    });

test("packet: builders give the packets of the manual", () => {
    const hex = (bytes) => p.toHex(bytes);

    assert.equal(hex(p.ping(1)), "FF FF 01 02 01 FB");
    assert.equal(hex(p.read(1, 0x2b, 1)), "FF FF 01 04 02 2B 01 CC");
    assert.equal(hex(p.write(0, 0x1e, [...p.word(0x200), ...p.word(0x200)])), "FF FF 00 07 03 1E 00 02 00 02 D3");
    assert.equal(hex(p.packet(1, p.INSTRUCTION.REG_WRITE, [0x1e, ...p.word(0x3ff)])), "FF FF 01 05 04 1E FF 03 D5");
    assert.equal(hex(p.action()), "FF FF FE 02 05 FA");
    assert.equal(hex(p.reset(0)), "FF FF 00 02 06 F7");
    const goals = [[0, 0x010, 0x150], [1, 0x220, 0x360], [2, 0x030, 0x170], [3, 0x220, 0x380]];
    const blocks = goals.map(([id, goal, speed]) => [id, [...p.word(goal), ...p.word(speed)]]);

    assert.deepEqual(p.syncWrite(0x1e, 4, blocks), manual.find(({ example }) => example === "5").bytes);
});

test("packet: out of range is refused", () => {
    assert.throws(() => p.ping(255), RangeError);
    assert.throws(() => p.write(1, 0x18, [256]), RangeError);
    assert.throws(() => p.write(1, 0x18, [-1]), RangeError);
    assert.throws(() => p.write(1, 0x18, [0.5]), RangeError);
    assert.throws(() => p.packet(1, 3, new Array(253).fill(0)), RangeError);
    assert.throws(() => p.syncRead(0x24, 8, new Array(32).fill(1)), RangeError);
    assert.throws(() => p.syncWrite(0x1e, 4, [[1, [1, 2]]]), RangeError);
    assert.throws(() => p.fromHex("FF F"), RangeError);
    assert.throws(() => p.fromHex("GG"), RangeError);
});

test("packet: the longest packet is one", () => {
    assert.ok(p.isPacket(p.packet(1, 3, new Array(252).fill(7))));
});

test("packet: a changed byte makes it none", () => {
    const bytes = p.syncRead(0x24, 8, [1, 2, 3]);

    for (let at = 0; at < bytes.length; at++) {
        const other = Uint8Array.from(bytes);

        other[at] ^= 1;
        assert.ok(!p.isPacket(other), `byte ${at}`);
    }
});

test("packet: number of replies", () => {
    assert.equal(p.repliesDue(p.read(1, 0, 1)), 1);
    assert.equal(p.repliesDue(p.ping(254)), 1);
    assert.equal(p.repliesDue(p.write(254, 0x18, [0])), 0);
    assert.equal(p.repliesDue(p.action()), 0);
    assert.equal(p.repliesDue(p.syncRead(0x24, 8, [1, 2])), 1);
    assert.equal(p.repliesDue(p.bulkRead([[2, 1, 0x24], [1, 2, 0x2a]])), 2);
});
