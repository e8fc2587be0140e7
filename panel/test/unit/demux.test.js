// SPDX-License-Identifier: MIT
/* The demux with text, packets and garbage in any order, cut at each byte. */

import assert from "node:assert/strict";
import test from "node:test";
import { Demux } from "../../src/wire/demux.js";
import { packet, toHex } from "../../src/wire/packet.js";

const text = (string) => [...new TextEncoder().encode(string)];
const STATUS = [...packet(1, 0, [0x20])];
const OTHER = [...packet(253, 0x80, [0xff, 0xff, 0xff, 0x01])];

/* What the demux hears: packets as hexadecimal, lines as text, noise as "noise HEX". */
function heard(chunks, { silence = false } = {}) {
    const all = [];
    const demux = new Demux({
        onPacket: (_, bytes) => all.push(toHex(bytes)),
        onLine: (line) => all.push(line),
        onNoise: (bytes) => all.push(`noise ${toHex(bytes)}`),
    });

    for (const chunk of chunks) demux.take(chunk);
    if (silence) demux.silence();
    return { all, demux };
}

const wanted = (all) => all.filter((entry) => !entry.startsWith("noise"));

test("demux: status has id, error, parameters", () => {
    let status;
    const demux = new Demux({ onPacket: (one) => (status = one), onLine: () => {} });

    demux.take(OTHER);
    assert.deepEqual(status, { id: 253, error: 0x80, parameters: Uint8Array.of(0xff, 0xff, 0xff, 1) });
});

test("demux: lines and packets in turn", () => {
    const { all } = heard([[...text("ok\r\n"), ...STATUS, ...text("id 1 model 1\r\n"), ...OTHER]]);

    assert.deepEqual(all, ["ok", toHex(STATUS), "id 1 model 1", toHex(OTHER)]);
});

test("demux: a packet within a line", () => {
    const { all } = heard([[...text("3 fou"), ...STATUS, ...text("nd, 254 asked\r\n")]]);

    assert.deepEqual(all, [toHex(STATUS), "3 found, 254 asked"]);
});

test("demux: the same however the bytes are cut in two", () => {
    const bytes = [...text("servo 1: "), ...STATUS, 0xff, ...OTHER, ...text("ok\r\n"), ...STATUS];
    const { all } = heard([bytes]);

    for (let cut = 0; cut <= bytes.length; cut++)
        assert.deepEqual(wanted(heard([bytes.slice(0, cut), bytes.slice(cut)]).all), wanted(all), `cut at ${cut}`);
    assert.deepEqual(wanted(heard(bytes.map((byte) => [byte])).all), wanted(all));
    assert.deepEqual(wanted(all), [toHex(STATUS), toHex(OTHER), "servo 1: ok", toHex(STATUS)]);
});

test("demux: a damaged packet costs none of those behind it", () => {
    for (let at = 0; at < STATUS.length; at++) {
        const bad = STATUS.map((byte, index) => (index === at ? byte ^ 0x41 : byte));
        const { all } = heard([[...bad, ...OTHER, ...text("\r\nok\r\n")]], { silence: true });

        assert.ok(all.includes(toHex(OTHER)), `byte ${at}: ${all}`);
        assert.equal(all.at(-1), "ok", `byte ${at}`);
    }
});

test("demux: garbage before a packet of any kind", () => {
    for (const garbage of [[0xff], [0xff, 0xff, 0xff], [0x00, 0x80, 0xfe], [0xff, 0xff, 1, 0], [0xff, 0xff, 1, 255], [0xff, 0x41]]) {
        const { all } = heard([[...garbage, ...STATUS]]);

        assert.ok(all.includes(toHex(STATUS)), toHex(garbage));
    }
});

test("demux: a cut packet ends with silence, and its text is found", () => {
    const cut = [0xff, 0xff, 1, 200, ...text("ok\r\n")];
    const { all, demux } = heard([cut]);

    assert.deepEqual(all, []);
    assert.ok(demux.isWithinPacket);
    demux.silence();
    assert.ok(all.includes("ok"));
    assert.ok(!demux.isWithinPacket);
});

test("demux: control characters are no text", () => {
    const { all } = heard([[...text("o\x07k"), 0xc3, ...text("\r\n")]]);

    assert.deepEqual(all, ["ok", "noise 07 C3"]);
});

test("demux: empty lines are no lines", () => {
    assert.deepEqual(heard([text("\r\n\r\nok\r\n")]).all, ["ok"]);
});

test("demux: a line without end stays bounded", () => {
    const { demux } = heard([new Array(100000).fill(0x41)]);

    assert.ok(demux.text.length <= 4096);
});

test("demux: random bytes never hide a packet for good", () => {
    let seed = 1;
    const random = () => (seed = (seed * 1103515245 + 12345) & 0x7fffffff) >> 8;

    for (let run = 0; run < 300; run++) {
        const garbage = Array.from({ length: random() % 40 }, () => (random() % 3 ? random() & 0xff : 0xff));
        const { all } = heard([garbage, STATUS, text("\r\nok\r\n")], { silence: true });

        assert.ok(all.some((entry) => entry.includes("ok") && !entry.startsWith("noise")), toHex(garbage));
    }
});
