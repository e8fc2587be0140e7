// SPDX-License-Identifier: MIT
/* A capture: what it keeps, and that it can be played. */

import assert from "node:assert/strict";
import test from "node:test";
import { CapturePort, ReplayPort, parseCapture } from "../../src/port/replay.js";
import { ping } from "../../src/wire/packet.js";
import { FakePort, status } from "../support/fake_port.js";

async function captured(count) {
    const port = new FakePort();
    const capture = new CapturePort(port);

    port.onPacket = () => true;
    capture.endStart();
    await capture.open();
    for (let i = 0; i < count; i++) {
        capture.write(ping(i % 200));
        port.onBytes(status(i % 200));
    }
    return capture;
}

test("capture: a packet and its answer can be played", async () => {
    const capture = await captured(3);
    const replay = new ReplayPort(capture.text, { later: (call) => call() });
    const heard = [];

    await replay.open();
    replay.onBytes = (bytes) => heard.push([...bytes]);
    replay.write(ping(1));
    assert.deepEqual(heard, [[...status(1)]]);
});

test("capture: a long one keeps start and end, is readable", async () => {
    const capture = await captured(100000);
    const lines = capture.text.split("\n");

    assert.ok(lines.length < 41000, `${lines.length} lines`);
    assert.equal(lines[0], "out FF FF 00 02 01 FC");
    assert.match(lines.at(-2), /^in FF FF C7 /);
    const gap = lines.findIndex((line) => line.startsWith("#"));

    assert.ok(lines[gap + 1].startsWith("out "));
    assert.ok(parseCapture(capture.text).length > 10000);
});

test("capture: the start is kept whole, and ends at the end of a reply", async () => {
    for (const count of [100, 1000]) {
        const capture = new CapturePort(new FakePort());

        capture.port.onPacket = () => true;
        await capture.open();
        capture.write(ping(1));
        for (let each = 0; each < count; each++) capture.port.onBytes(status(1));
        capture.endStart();
        for (let each = 0; each < 15000; each++) {
            capture.write(ping(2));
            for (const id of [3, 4, 5]) capture.port.onBytes(status(id)); // a reply of three pieces
        }
        const [start, end] = capture.text.split(/^# .*\n/m);
        const lines = start.trim().split("\n");

        assert.equal(lines.filter((line) => line.startsWith("in FF FF 01")).length, count);
        assert.match(lines.at(-1), count > 400 ? /^in FF FF 01/ : /^in FF FF 05/);
        assert.ok(lines.length >= Math.min(count, 396), `${lines.length} lines`);
        assert.match(end, /^out FF FF 02/);
    }
});

test("capture: one with too many lines is refused", () => {
    assert.throws(() => parseCapture("out FF\n".repeat(50001)), { code: "bad-capture" });
});

test("capture: half a byte is refused with its line", () => {
    for (const half of ["out 1", "in FF F FF", "out FFF"])
        assert.throws(() => parseCapture(`out FF\n${half}`), { code: "bad-capture", detail: "line 2" });
    assert.deepEqual([...parseCapture("out FF 01\nout ff01\nout 00")].map(({ bytes }) => [...bytes]), [[255, 1], [255, 1]]);
});

test("capture: a very long line is refused with its number, 64 KB are read", () => {
    assert.equal(parseCapture(`out FF\nin ${"41 ".repeat(65536)}`)[0].answers[0].length, 65536);
    assert.throws(() => parseCapture(`out FF\nin ${"41 ".repeat(6000000)}`), { code: "bad-capture", detail: "line 2" });
});

test("replay: a long capture is not searched in full for each write", async () => {
    const pieces = Array.from({ length: 20000 }, (_, index) => `out ${(index % 256).toString(16).padStart(2, "0")} 01\nin 55\n`).join("");
    const port = new ReplayPort(pieces, { later: (call) => call() });
    let compared = 0;
    const got = [];

    port.steps = port.steps.map((step) => Object.defineProperty({ ...step }, "bytes", { get: () => (compared++, step.bytes) }));
    port.onBytes = (bytes) => got.push(...bytes);
    await port.open();
    for (let count = 0; count < 100; count++) port.write(Uint8Array.of(0xee, 2)); // not in the capture
    port.write(Uint8Array.of(3, 1));
    assert.deepEqual([got, compared], [[0x55], 0]);
});

/* What a capture answers to each of `requests`, one byte each. */
async function answersOf(capture, requests) {
    const port = new ReplayPort(capture, { later: (call) => call() });
    const got = [];

    port.onBytes = ([byte]) => got.push(byte);
    await port.open();
    for (const request of requests) {
        const { length } = got;

        port.write(Uint8Array.of(request));
        if (got.length === length) got.push(null);
    }
    return got;
}

test("replay: a request that came once at the start does not begin the capture again", async () => {
    const feedback = Array.from({ length: 9 }, (_, index) => `out 01\nin 1${index}\n`).join("");

    assert.deepEqual(await answersOf(`out 02\nin 20\n${feedback}out 03`, [2, 1, 1, 2, 1]), [0x20, 0x10, 0x11, 0x20, 0x13]);
});

test("replay: a request that came only late does not move the capture to its end", async () => {
    const feedback = Array.from({ length: 99 }, (_, index) => `out 01\nin 1${index % 10}\n`).join("");

    assert.deepEqual(await answersOf(`${feedback}out 02\nin 20\nout 03`, [1, 2, 1]), [0x10, 0x20, 0x12]);
});

test("replay: at the end the last answers stay; an answer that was cut off counts for none", async () => {
    assert.deepEqual(await answersOf("out 01\nin 10\nout 01\nin 11\nout 01", [1, 1, 1, 1]), [0x10, 0x11, 0x11, 0x11]);
});
