// SPDX-License-Identifier: MIT
/* A recording: what it keeps, and that it can be played. */

import assert from "node:assert/strict";
import test from "node:test";
import { RecordingPort, ReplayPort, parseRecording } from "../../src/port/replay.js";
import { ping } from "../../src/wire/packet.js";
import { FakePort, status } from "../support/fake_port.js";

async function record(count) {
    const port = new FakePort();
    const recording = new RecordingPort(port);

    port.onPacket = () => true;
    await recording.open();
    for (let i = 0; i < count; i++) {
        recording.write(ping(i % 200));
        port.onBytes(status(i % 200));
    }
    return recording;
}

test("recording: a packet and its answer can be played", async () => {
    const recording = await record(3);
    const replay = new ReplayPort(recording.text, { later: (call) => call() });
    const heard = [];

    await replay.open();
    replay.onBytes = (bytes) => heard.push([...bytes]);
    replay.write(ping(2));
    assert.deepEqual(heard, [[...status(2)]]);
});

test("recording: a long one keeps its begin and its end, and can be read", async () => {
    const recording = await record(100000);
    const lines = recording.text.split("\n");

    assert.ok(lines.length < 41000, `${lines.length} lines`);
    assert.equal(lines[0], "out FF FF 00 02 01 FC");
    assert.match(lines.at(-2), /^in FF FF C7 /);
    const gap = lines.findIndex((line) => line.startsWith("#"));

    assert.ok(lines[gap + 1].startsWith("out "));
    assert.ok(parseRecording(recording.text).length > 10000);
});

test("recording: one with too many lines is refused", () => {
    assert.throws(() => parseRecording("out FF\n".repeat(50001)), { code: "bad-recording" });
});
