// SPDX-License-Identifier: MIT
/* Web Serial with a fake of navigator.serial that is made of real streams. */

import assert from "node:assert/strict";
import test from "node:test";
import { Decoder } from "../../src/model/decode.js";
import { Traffic } from "../../src/model/traffic.js";
import { CapturePort, parseCapture } from "../../src/port/replay.js";
import { WebSerialPort } from "../../src/port/web_serial.js";
import { CTRL_X, Wire } from "../../src/wire/wire.js";
import { ping, toHex } from "../../src/wire/packet.js";
import { FakeClock } from "../support/fake_clock.js";
import { status } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const named = (name, message = name) => Object.assign(new Error(message), { name });

/* A serial port as of the Web Serial API. */
class FakeSerial {
    constructor() {
        this.written = [];
        this.isOpen = false;
        this.readable = null;
        this.writable = null;
    }

    async open(options) {
        if (this.openError) throw this.openError;
        this.options = options;
        this.isOpen = true;
        this.newStream();
        this.writable = new WritableStream({ write: (bytes) => this.take(bytes), close: () => this.drain?.() });
    }

    take(bytes) {
        if (this.writeError) throw this.writeError;
        this.written.push(...bytes);
    }

    newStream() {
        this.readable = new ReadableStream({ start: (controller) => (this.input = controller) });
    }

    /* As a framing error: the stream ends, the port goes on. */
    framingError() {
        const { input } = this;

        this.newStream();
        input.error(named("FramingError"));
    }

    unplug() {
        const { input } = this;

        this.readable = null;
        input.error(named("NetworkError", "The device has been lost."));
    }

    async close() {
        if (this.readable?.locked || this.writable?.locked) throw new TypeError("locked");
        this.isOpen = false;
    }
}

function rig(chosen = new FakeSerial()) {
    const serial = { requestPort: async () => (chosen instanceof Error ? Promise.reject(chosen) : chosen) };
    const port = new WebSerialPort({ serial, baudRate: 57600 });
    const bytes = [];
    const reasons = [];

    port.onBytes = (some) => bytes.push(...some);
    port.onClose = (reason) => reasons.push(reason);
    return { port, fake: chosen, bytes, reasons };
}

const tick = () => new Promise((resolve) => setImmediate(resolve));
const codeOf = (promise) => promise.then(() => "ok", (error) => error.code);

test("web serial: opens at the rate, writes, reads", async () => {
    const { port, fake, bytes } = rig();

    await port.open();
    assert.equal(fake.options.baudRate, 57600);
    port.write(Uint8Array.of(1, 2));
    port.write(Uint8Array.of(3));
    fake.input.enqueue(Uint8Array.of(9, 8));
    await tick();
    assert.deepEqual(fake.written, [1, 2, 3]);
    assert.deepEqual(bytes, [9, 8]);
});

test("web serial: the browser has none", async () => {
    const port = new WebSerialPort({ serial: undefined });

    assert.equal(WebSerialPort.isSupported(undefined), false);
    assert.equal(await codeOf(port.open()), "unsupported");
});

test("web serial: no port is chosen, or none is allowed", async () => {
    assert.equal(await codeOf(rig(named("NotFoundError")).port.open()), "not-chosen");
    assert.equal(await codeOf(rig(named("SecurityError")).port.open()), "denied");
});

test("web serial: another program or tab has the port", async () => {
    const fake = new FakeSerial();

    fake.openError = named("InvalidStateError");
    assert.equal(await codeOf(rig(fake).port.open()), "in-use");
    fake.openError = named("NetworkError");
    assert.equal(await codeOf(rig(fake).port.open()), "in-use");
});

test("web serial: a framing error does not end the port", async () => {
    const { port, fake, bytes, reasons } = rig();

    await port.open();
    fake.framingError();
    await tick();
    fake.input.enqueue(Uint8Array.of(5));
    await tick();
    assert.deepEqual(bytes, [5]);
    assert.deepEqual(reasons, []);
});

test("web serial: unplugged, said once", async () => {
    const { port, fake, reasons } = rig();

    await port.open();
    fake.unplug();
    await tick();
    await tick();
    assert.deepEqual(reasons, ["The device has been lost."]);
    assert.throws(() => port.write(Uint8Array.of(1)));
});

test("web serial: a write fails", async () => {
    const { port, fake, reasons } = rig();

    await port.open();
    fake.writeError = named("NetworkError", "gone");
    port.write(Uint8Array.of(1));
    await tick();
    await tick();
    assert.deepEqual(reasons, ["gone"]);
});

test("web serial: close releases the streams and is no loss", async () => {
    const { port, fake, reasons } = rig();

    await port.open();
    port.write(Uint8Array.of(0x18));
    await port.close();
    assert.equal(fake.isOpen, false);
    assert.deepEqual(fake.written, [0x18]);
    assert.deepEqual(reasons, []);
    await port.close();
});

test("web serial: close waits until all that was written has left", async () => {
    const { port, fake } = rig();
    const later = (call = () => {}) => new Promise((resolve) => setTimeout(() => resolve(call()), 20));
    const events = [];

    fake.take = (bytes) => later(() => events.push(bytes[0]));
    fake.drain = () => later(() => events.push("drained"));
    await port.open();
    for (const byte of [1, 2, 3]) port.write(Uint8Array.of(byte));
    await port.close();
    assert.deepEqual(events, [1, 2, 3, "drained"]);
    assert.equal(fake.isOpen, false);
});

test("web serial: a port that takes nothing is closed after a second", async () => {
    const { port, fake } = rig();

    fake.take = () => new Promise(() => {});
    await port.open();
    port.write(Uint8Array.of(1));
    await port.close();
    assert.equal(fake.isOpen, false);
});

test("web serial: opens again after a loss", async () => {
    const { port, fake, bytes } = rig();

    await port.open();
    fake.unplug();
    await tick();
    await tick();
    await port.open();
    fake.input.enqueue(Uint8Array.of(7));
    await tick();
    assert.deepEqual(bytes, [7]);
});

/* A wire at a serial port, as the session makes it. The port takes what `fake.taken` resolves. */
async function wireRig() {
    const { port, fake } = rig();
    const clock = new FakeClock();
    const capture = new CapturePort(port);
    const wire = new Wire(capture, { clock });
    const traffic = new Traffic(new Decoder(tables()));

    const memory = [0x55, 0xcd, ...new Array(0x15).fill(0), 1]; // of the device; 1: INHIBIT

    wire.addEventListener("traffic", ({ detail }) => traffic.take(detail));
    fake.packets = [];
    fake.taken = Promise.resolve();
    fake.take = (bytes) => {
        fake.packets.push([...bytes]);
        if (bytes[0] === 0xff && bytes[2] === 253) fake.input.enqueue(status(253, 0, memory.slice(bytes[5], bytes[5] + bytes[6])));
        return fake.taken;
    };
    const opened = wire.open();

    while (wire.state !== "ready") {
        await tick();
        await clock.advance(10);
    }
    await opened;
    fake.packets = [];
    return { wire, capture, traffic, fake, clock };
}

test("web serial: Ctrl-X follows the one packet that the port has, not those that wait", async () => {
    const { wire, fake, clock } = await wireRig();
    let take;

    fake.taken = new Promise((resolve) => (take = resolve));
    const job = codeOf(wire.request(ping(1)));

    for (let step = 0; step < 300; step++) { // no reply: the wire writes fences, then asks each second
        await clock.advance(10);
        await tick();
    }
    assert.equal(await job, "timeout");
    wire.stop({ servos: [1] }).catch(() => {});
    fake.taken = Promise.resolve();
    take();
    await tick();
    assert.deepEqual(fake.packets.slice(0, 2), [[...ping(1)], [CTRL_X]]);
    await wire.close();
});

test("web serial: what a stop drops is not in the capture, and not sent in the traffic", async () => {
    const { wire, capture, clock, fake, traffic } = await wireRig();

    fake.taken = new Promise(() => {}); // takes no more
    wire.request(ping(1)).catch(() => {});
    wire.request(ping(2)).catch(() => {});
    await clock.advance(500);
    assert.match(capture.text, /^out FF FF FD 04 02 00 .*\n$/m); // a fence
    const before = capture.text.split("\n").filter((line) => line.startsWith("out "));

    wire.stop({ servos: [1] }).catch(() => {});
    const after = capture.text.split("\n").filter((line) => line.startsWith("out "));

    assert.ok(parseCapture(capture.text));
    assert.deepEqual(after.slice(-3), [`out ${toHex(ping(1))}`, "out 18", "out FF FF FD 04 02 00 04 F8"]); // a fence of the stop
    assert.equal(after.length, before.length + 1); // the fence of before is left out
    const [fence] = traffic.select({ withPolling: true, text: "FD 04 02 00 03" }, Infinity);

    assert.ok(fence.isDropped && !fence.isError && !fence.isUnanswered);
    assert.match(traffic.describe(fence).name, /not sent/);
    await wire.close();
});

test("web serial: what waits leaves in order when the port takes it", async () => {
    const { port, fake } = rig();
    let take;
    const taken = new Promise((resolve) => (take = resolve));

    fake.take = (bytes) => (fake.written.push(...bytes), taken);
    await port.open();
    for (const byte of [1, 2, 3]) port.write(Uint8Array.of(byte));
    await tick();
    assert.deepEqual(fake.written, [1]);
    take();
    await tick();
    assert.deepEqual(fake.written, [1, 2, 3]);
    port.write(Uint8Array.of(4));
    await tick();
    assert.deepEqual(fake.written, [1, 2, 3, 4]);
});
