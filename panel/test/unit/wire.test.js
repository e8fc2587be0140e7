// SPDX-License-Identifier: MIT
/* The wire at a controller that answers, does not answer, answers late, answers rubbish, and goes away. */

import assert from "node:assert/strict";
import test from "node:test";
import { INSTRUCTION, bulkRead, isPacket, packet, ping, read, syncRead, toHex, write } from "../../src/wire/packet.js";
import { LINE_MS, REPLY_MS, Wire } from "../../src/wire/wire.js";
import { FakeClock, settle } from "../support/fake_clock.js";
import { FakePort, damaged, status } from "../support/fake_port.js";

const isCtrlX = (bytes) => bytes.length === 1 && bytes[0] === 0x18;
const isFence = (bytes) => isPacket(bytes) && bytes[2] === 253 && bytes[4] === INSTRUCTION.READ && bytes[5] === 0;

/* An open wire. `port` answers PING of servos 1 to 9. */
async function rig({ open = true } = {}) {
    const clock = new FakeClock();
    const port = new FakePort();
    const wire = new Wire(port, { clock });
    const notices = [];
    const states = [];

    wire.addEventListener("notice", ({ detail }) => notices.push(detail.code));
    wire.addEventListener("state", ({ detail }) => states.push(detail));
    port.onPacket = (bytes) => {
        if (bytes[4] !== INSTRUCTION.PING || bytes[2] > 9) return false;
        port.answer(status(bytes[2]));
        return true;
    };
    if (open) await wire.open();
    return { clock, port, wire, notices, states };
}

const codeOf = (promise) => promise.then(() => "ok", (error) => error.code);

/* ---- first contact ---- */

test("open: a controller with console and device", async () => {
    const { wire, port } = await rig();

    assert.equal(wire.state, "ready");
    assert.ok(wire.hasConsole && wire.hasDevice);
    assert.deepEqual(port.lines, ["help id"]);
});

test("open: a firmware of the profile bridge has no console", async () => {
    const { wire, port, clock } = await rig({ open: false });

    port.hasConsole = false;
    const open = wire.open();

    await clock.advance(5000);
    await open;
    assert.equal(wire.state, "ready");
    assert.equal(wire.hasConsole, false);
});

test("open: the device is off", async () => {
    const { wire, port, clock } = await rig({ open: false });

    port.onPacket = () => true;
    const open = wire.open();

    await clock.advance(5000);
    await open;
    assert.equal(wire.hasDevice, false);
    assert.equal(wire.hasConsole, true);
});

test("open: nothing answers, the port is closed again", async () => {
    const { wire, port, clock } = await rig({ open: false });

    port.isMute = true;
    const open = codeOf(wire.open());

    await clock.advance(10000);
    assert.equal(await open, "silent");
    assert.equal(wire.state, "closed");
    assert.equal(port.isOpen, false);
});

test("open: a board that starts only after 3 s", async () => {
    const { wire, port, clock } = await rig({ open: false });

    port.isMute = true;
    const open = wire.open();

    await clock.advance(3000);
    port.isMute = false;
    await clock.advance(3000);
    await open;
    assert.equal(wire.state, "ready");
});

test("open: a prompt, an echo and a banner before the first reply", async () => {
    const { wire, port } = await rig({ open: false });

    port.onText = (line) => {
        if (!line.startsWith("help id")) return false;
        port.answer(new TextEncoder().encode("cds55xx 0.1.0 atmega128\r\n> help id\r\nid OLD NEW: give a servo\r\nok\r\n> "));
        return true;
    };
    await wire.open();
    assert.equal(wire.state, "ready");
});

/* ---- requests ---- */

test("request: resolves with the status packet", async () => {
    const { wire } = await rig();

    assert.deepEqual(await wire.request(ping(3)), { id: 3, error: 0, parameters: new Uint8Array() });
});

test("request: one packet is outstanding at a time", async () => {
    const { wire, port } = await rig();
    let answered = 0;

    port.onPacket = () => true;
    const before = port.packets.length;
    const requests = [1, 2, 3].map((id) => wire.request(ping(id)).then(() => answered++));

    for (let id = 1; id <= 3; id++) {
        await settle();
        assert.equal(port.packets.length, before + id);
        port.answer(status(id));
    }
    await Promise.all(requests);
    assert.equal(answered, 3);
});

test("request: bad bytes are refused", async () => {
    const { wire } = await rig();

    assert.throws(() => wire.request(damaged(ping(1))), RangeError);
});

test("request: a broadcast without reply resolves at once", async () => {
    const { wire } = await rig();

    assert.equal(await wire.request(write(254, 0x18, [0])), null);
});

test("request: a reply of another servo or length is not taken", async () => {
    const { wire, port } = await rig();

    port.onPacket = (bytes) => bytes[2] === 1;
    const request = wire.request(read(1, 0x24, 2));

    port.onBytes(status(2, 0, [1, 2]));
    port.onBytes(status(1, 0, [1]));
    port.onBytes(status(1, 0, [1, 2, 3]));
    port.onBytes(status(1, 0, [7, 8]));
    assert.deepEqual([...(await request).parameters], [7, 8]);
});

test("request: a refusal has no parameters", async () => {
    const { wire, port } = await rig();

    port.onPacket = (bytes) => bytes[2] === 1;
    const request = wire.request(read(1, 0x24, 2));

    port.onBytes(status(1, 0x08));
    assert.equal((await request).error, 0x08);
});

test("request: BULK READ has a reply of each servo", async () => {
    const { wire, port } = await rig();

    port.onPacket = (bytes) => bytes[4] === INSTRUCTION.BULK_READ;
    const request = wire.request(bulkRead([[2, 1, 0x24], [1, 2, 0x2a]]));

    port.onBytes(status(1, 0, [1, 2]));
    port.onBytes(status(2, 0, [3]));
    assert.deepEqual((await request).map(({ id }) => id), [1, 2]);
});

test("request: a timeout, then a fence, then the next packet", async () => {
    const { wire, port, clock } = await rig();
    const request = codeOf(wire.request(ping(200)));
    const next = wire.request(ping(1));

    await clock.advance(REPLY_MS - 1);
    assert.equal(port.packets.at(-1)[2], 200, "waits for its reply");
    await clock.advance(2);
    assert.equal(await request, "timeout");
    assert.equal((await next).id, 1);
    assert.ok(isFence(port.packets.at(-2)));
    assert.equal(port.packets.filter((bytes) => bytes[2] === 200).length, 1, "sent once");
});

test("request: no timeout for a reply that a blocked page holds", async () => {
    const { wire, port, clock } = await rig();
    const request = wire.request(ping(200));

    clock.stall(10 * REPLY_MS);
    await clock.advance(0); // the timers run before the bytes
    port.onBytes(status(200));
    assert.equal((await request).id, 200);
});

test("request: a reply in two parts survives a blocked page", async () => {
    const { wire, port, clock } = await rig();
    const request = wire.request(ping(200));

    port.onBytes(status(200).slice(0, 4));
    clock.stall(1000);
    await clock.advance(0);
    port.onBytes(status(200).slice(4));
    assert.equal((await request).id, 200);
});

test("request: a stale reply is not taken for the next one", async () => {
    const { wire, port, clock } = await rig();

    port.onPacket = (bytes) => bytes[2] === 1; // no answer yet
    const first = codeOf(wire.request(read(1, 0x24, 2)));
    const second = wire.request(read(1, 0x26, 2));

    port.onPacket = (bytes) => {
        if (isFence(bytes)) port.answer(status(1, 0, [1, 1])); // the stale reply stands before the fence
        if (bytes[2] === 1) port.answer(status(1, 0, [2, 2]));
        return bytes[2] === 1;
    };
    await clock.advance(REPLY_MS + 1);
    assert.equal(await first, "timeout");
    assert.deepEqual([...(await second).parameters], [2, 2]);
});

test("request: the reply to an older fence is not taken", async () => {
    const { wire, port, clock, states } = await rig();
    let fences = 0;
    let first;

    port.onPacket = (bytes) => {
        if (!isFence(bytes)) return true;
        if (fences++ === 0) {
            first = status(253, 0, [...port.device.slice(0, bytes[6])]);
            return true;
        }
        port.answer(first);
        first = status(253, 0, [...port.device.slice(0, bytes[6])]);
        return fences < 3;
    };
    const request = codeOf(wire.request(ping(1)));

    await clock.advance(REPLY_MS + 1);
    assert.equal(await request, "timeout");
    await clock.advance(REPLY_MS + 1);
    assert.equal(states.at(-1), "synchronising");
    await clock.advance(REPLY_MS + 1);
    assert.equal(states.at(-1), "ready");
    assert.equal(fences, 3);
});

test("request: not sent after notAfter", async () => {
    const { wire, port, clock } = await rig();

    port.onPacket = (bytes) => bytes[2] === 1;
    const slow = codeOf(wire.request(ping(1)));
    const late = codeOf(wire.request(write(2, 0x1e, [0, 2]), { notAfter: clock.now() + 100 }));

    await clock.advance(150);
    port.answer(status(1));
    assert.equal(await slow, "ok");
    assert.equal(await late, "late");
    assert.ok(!port.packets.some((bytes) => bytes[4] === INSTRUCTION.WRITE));
});

test("request: taken back before it is sent", async () => {
    const { wire, port } = await rig();
    const controller = new AbortController();

    port.onPacket = (bytes) => bytes[2] < 10;
    wire.request(ping(1));
    const waiting = codeOf(wire.request(ping(2), { signal: controller.signal }));

    controller.abort();
    assert.equal(await waiting, "cancelled");
    assert.ok(!port.packets.some((bytes) => bytes[2] === 2));
});

test("request: garbage and a damaged reply end as a timeout", async () => {
    const { wire, port, clock } = await rig();

    port.onPacket = (bytes) => {
        if (bytes[2] !== 1) return false;
        port.answer(Uint8Array.of(0xff, 0xff, 1, 250, 7, 7, 7));
        port.answer(damaged(status(1)));
        return true;
    };
    const request = codeOf(wire.request(ping(1)));

    await clock.advance(REPLY_MS + 1);
    assert.equal(await request, "timeout");
    port.onPacket = (bytes) => (port.answer(status(bytes[2])), true);
    assert.equal((await wire.request(ping(2))).id, 2);
});

/* ---- commands ---- */

test("command: lines of a user are passed on and not kept", async () => {
    const { wire, port } = await rig();
    const taken = [];
    const linesOf = async (source) => (await wire.command("servos", { source, onLine: (text) => taken.push(text) })).lines;

    port.addServo(1);
    assert.deepEqual([await linesOf("hand"), await linesOf("page"), taken.length], [[], ["servo 1: online"], 2]);
});

test("command: lines, then ok", async () => {
    const { wire, port } = await rig();
    const lines = [];

    port.onText = (line) => line === "scan" && (port.say("id 1 model 1", "1 found, 254 asked", "ok"), true);
    const reply = await wire.command("scan", { onLine: (line) => lines.push(line) });

    assert.deepEqual(reply, { lines: ["id 1 model 1", "1 found, 254 asked"], error: null });
    assert.deepEqual(lines, reply.lines);
});

test("command: an error with its number and text", async () => {
    const { wire, port } = await rig();

    port.onText = (line) => line.startsWith("move") && (port.say("error 12: the servo may not be driven; release it"), true);
    assert.deepEqual((await wire.command("move 1 90")).error, { number: 12, text: "the servo may not be driven; release it" });
});

test("command: a status packet within a line is no part of it", async () => {
    const { wire, port } = await rig();

    port.onText = (line) => {
        if (line !== "version") return false;
        const bytes = new TextEncoder().encode("cds55xx 0.1.0\r\nok\r\n");

        port.answer(Uint8Array.of(...bytes.slice(0, 4), ...status(9), ...bytes.slice(4)));
        return true;
    };
    assert.deepEqual((await wire.command("version")).lines, ["cds55xx 0.1.0"]);
});

test("command: an alarm told unasked belongs to no reply", async () => {
    const { wire, port } = await rig();
    const texts = [];

    wire.addEventListener("text", ({ detail }) => texts.push(detail));
    port.onText = (line) => line === "servos" && (port.say("alarm of servo 3: overheating", "servo 3: online, torque off", "ok"), true);
    assert.deepEqual((await wire.command("servos")).lines, ["servo 3: online, torque off"]);
    assert.deepEqual(texts, ["alarm of servo 3: overheating"]);
});

test("command: no packet leaves before its reply", async () => {
    const { wire, port } = await rig();

    port.onText = (line) => line === "save";
    const command = wire.command("save");
    const count = port.packets.length;
    const request = wire.request(ping(1));

    assert.ok(wire.isBusyWithText);
    await settle();
    assert.equal(port.packets.length, count);
    port.say("ok");
    await command;
    assert.equal((await request).id, 1);
});

test("command: each line of the reply renews the time", async () => {
    const { wire, port, clock } = await rig();

    port.onText = (line) => line === "scan";
    const command = codeOf(wire.command("scan"));

    for (let second = 0; second < 10; second++) {
        await clock.advance(LINE_MS - 1000);
        port.say(`id ${second} model 1`);
    }
    port.say("ok");
    await settle();
    assert.equal(await command, "ok");
});

test("command: no reply; a late ok is not taken for the next one", async () => {
    const { wire, port, clock } = await rig();

    port.onText = (line) => line === "slow";
    const slow = codeOf(wire.command("slow"));
    const next = wire.command("bad");

    port.onText = (line) => {
        if (line.startsWith("help")) port.say("ok"); // the late one
        if (line === "bad") port.say("error 30: unknown command");
        return line === "bad";
    };
    await clock.advance(LINE_MS + 1);
    assert.equal(await slow, "timeout");
    assert.equal((await next).error?.number, 30);
});

test("command: a key ends it, its reply comes", async () => {
    const { wire, port } = await rig();
    const controller = new AbortController();

    port.onText = (line) => line === "scan" || (line === "" && (port.say("error 49: ended by a key"), true));
    const scan = wire.command("scan", { signal: controller.signal });

    controller.abort();
    assert.equal((await scan).error.number, 49);
});

test("command: the key is sent again until the reply ends", async () => {
    const { wire, port, clock } = await rig();
    const controller = new AbortController();
    let keys = 0;

    port.onText = (line) => line.startsWith("scan") || (line === "" && (++keys === 2 && port.say("error 49: ended by a key"), true));
    const scan = wire.command("scan rescue", { signal: controller.signal, timeout: 30000 });

    await clock.advance(1000);
    controller.abort();
    await clock.advance(250);
    assert.equal(keys, 1);
    await clock.advance(100);
    assert.equal((await scan).error.number, 49);
    await clock.advance(2000);
    assert.equal(keys, 2);
    assert.equal(wire.state, "ready");
});

test("command: one that no key ends is given up", async () => {
    const { wire, port, clock } = await rig();
    const controller = new AbortController();

    port.onText = (line) => line.startsWith("scan") || line === "";
    const scan = codeOf(wire.command("scan rescue", { signal: controller.signal, timeout: 30000 }));
    const talk = (left) => left && clock.after(100, () => (port.say("254 of 64770 asked"), talk(left - 1)));

    talk(30);
    controller.abort();
    await clock.advance(1500);
    assert.equal(await scan, "ended");
    assert.equal(wire.state, "ready"); // the marker was answered
    assert.equal(await codeOf(wire.request(ping(1))), "ok");
});

test("command: empty lines resolve, other characters throw", async () => {
    const { wire } = await rig();

    assert.deepEqual(await wire.command("  "), { lines: [], error: null });
    assert.throws(() => wire.command("ping 1\rfactory 254 force"), RangeError);
    assert.throws(() => wire.command("\x18"), RangeError);
});

/* ---- a controller that goes silent ---- */

test("silent: jobs fail at once; ready with the next answer", async () => {
    const { wire, port, clock, notices } = await rig();

    port.isMute = true;
    port.onPacket = null;
    const first = codeOf(wire.request(ping(1)));
    const waiting = codeOf(wire.command("version"));

    await clock.advance(5000);
    assert.equal(await first, "timeout");
    assert.equal(await waiting, "silent");
    assert.equal(wire.state, "silent");
    assert.equal(await codeOf(wire.request(ping(1))), "silent");
    await clock.advance(60000);
    assert.deepEqual(notices, ["silent"]);
    port.isMute = false;
    await clock.advance(5000);
    assert.equal(wire.state, "ready");
    assert.deepEqual(notices, ["silent", "back"]);
});

/* ---- stop ---- */

const SERVOS = [1, 2, 3];

async function stopRig() {
    const made = await rig();

    SERVOS.forEach((id) => made.port.addServo(id, 1));
    return made;
}

function assertCtrlXNext(port, count) {
    assert.ok(isCtrlX(port.written[count]), `after ${count} writes: ${toHex(port.written[count])}`);
}

test("stop: when nothing is under way", async () => {
    const { wire, port } = await stopRig();
    const count = port.written.length;
    const stop = wire.stop({ servos: SERVOS });

    assertCtrlXNext(port, count);
    assert.deepEqual(await stop, { inhibited: true, off: SERVOS, on: [], silent: [], verified: true });
    await settle();
    assert.equal(wire.state, "ready");
});

test("stop: while a packet is outstanding and others wait", async () => {
    const { wire, port, clock } = await stopRig();

    port.onPacket = (bytes) => bytes[4] === INSTRUCTION.WRITE;
    const jobs = [0, 1, 2].map(() => codeOf(wire.request(write(1, 0x1e, [0, 2]))));
    const command = codeOf(wire.command("move 1 90"));
    const count = port.written.length;
    const stop = wire.stop({ servos: SERVOS });

    assertCtrlXNext(port, count);
    assert.deepEqual(await Promise.all([...jobs, command]), ["stopped", "stopped", "stopped", "stopped"]);
    assert.equal((await stop).verified, true);
    await clock.advance(10000);
    assert.equal(port.packets.filter((bytes) => bytes[4] === INSTRUCTION.WRITE).length, 1);
    assert.ok(!port.lines.includes("move 1 90"));
});

test("stop: while a command runs", async () => {
    const { wire, port } = await stopRig();

    port.onText = (line) => line === "scan";
    const scan = codeOf(wire.command("scan"));
    const count = port.written.length;
    const stop = wire.stop({ servos: SERVOS });

    assertCtrlXNext(port, count);
    assert.equal(await scan, "stopped");
    assert.equal((await stop).verified, true);
});

test("stop: while the wire synchronises", async () => {
    const { wire, port, clock } = await stopRig();

    port.onPacket = (bytes) => bytes[2] === 200 || isFence(bytes);
    wire.request(ping(200)).catch(() => {});
    await clock.advance(REPLY_MS + 1);
    assert.equal(wire.state, "synchronising");
    port.onPacket = null;
    const count = port.written.length;
    const stop = wire.stop({ servos: SERVOS });

    assertCtrlXNext(port, count);
    assert.equal((await stop).verified, true);
    await clock.advance(5000);
    assert.equal(wire.state, "ready");
});

test("stop: while the controller is silent", async () => {
    const { wire, port, clock } = await stopRig();

    port.isMute = true;
    port.onPacket = null;
    wire.request(ping(1)).catch(() => {});
    await clock.advance(10000);
    assert.equal(wire.state, "silent");
    const count = port.written.length;
    const stop = wire.stop({ servos: SERVOS });

    assertCtrlXNext(port, count);
    await clock.advance(20000);
    const outcome = await stop;

    assert.equal(outcome.verified, false);
    assert.equal(outcome.inhibited, false);
    assert.deepEqual(outcome.silent, SERVOS);
    assert.ok(port.stops > 2, "Ctrl-X is sent again while nothing confirms it");
});

test("stop: during the first contact", async () => {
    const { wire, port, clock } = await rig({ open: false });

    port.onPacket = () => true;
    port.onText = () => true;
    const open = codeOf(wire.open());

    await clock.advance(100);
    port.onPacket = port.onText = null;
    const stop = wire.stop({ servos: [] });

    assert.equal(port.stops, 1);
    assert.equal((await stop).inhibited, true);
    await clock.advance(10000);
    assert.equal(await open, "ok");
    assert.equal(wire.state, "ready");
});

test("stop: again while a stop is under way", async () => {
    const { wire, port, clock } = await stopRig();

    port.loseStops = 1;
    const first = wire.stop({ servos: SERVOS });
    const second = wire.stop({ servos: SERVOS });

    assert.equal(first, second);
    assert.equal(port.stops, 2);
    await clock.advance(1000);
    assert.equal((await second).verified, true);
});

test("stop: a Ctrl-X that is lost is sent again", async () => {
    const { wire, port, clock } = await stopRig();

    port.loseStops = 2;
    port.onPacket = () => {
        clock.advance(20);
        return false;
    };
    const stop = wire.stop({ servos: SERVOS });

    await clock.advance(2000);
    assert.equal((await stop).verified, true);
    assert.equal(port.stops, 3);
});

for (const latency of [120, 250, 390])
    test(`stop: verified though each reply takes ${latency} ms`, async () => {
        const { wire, port, clock } = await stopRig();
        const { answer } = port;

        port.loseStops = 1;
        port.answer = (bytes) => clock.after(latency, () => answer.call(port, bytes));
        const stop = wire.stop({ servos: SERVOS });

        await clock.advance(6000);
        assert.equal((await stop).verified, true);
        assert.equal(wire.state, "ready");
    });

test("stop: sends a dropped fence again, and Ctrl-X each 150 ms", async () => {
    const { wire, port, clock } = await stopRig();
    const begun = clock.now();
    const fences = [];

    port.onPacket = (bytes) => isFence(bytes) && fences.push(clock.now() - begun);
    wire.stop({ servos: SERVOS });
    await clock.advance(1000);
    assert.deepEqual(fences.slice(0, 4), [0, 100, 200, 300]);
    assert.ok(port.stops >= 5, `${port.stops} times Ctrl-X`);
    port.onPacket = null;
    await clock.advance(1000);
    assert.equal(wire.state, "ready");
});

test("stop: not verified with torque or a silent servo", async () => {
    const { wire, port, clock } = await stopRig();

    port.onPacket = (bytes) => {
        clock.advance(20);
        if (bytes[4] !== INSTRUCTION.SYNC_READ) return false;
        port.answer(status(253, 0x80, [0, 0xff, 1]));
        return true;
    };
    const stop = wire.stop({ servos: SERVOS });

    await clock.advance(10000);
    assert.deepEqual(await stop, { inhibited: true, off: [1], on: [3], silent: [2], verified: false });
});

test("stop: jobs are refused until it is over", async () => {
    const { wire, port, clock } = await stopRig();

    port.isMute = true;
    const stop = wire.stop({ servos: SERVOS });

    assert.equal(await codeOf(wire.request(ping(1))), "stopped");
    assert.equal(await codeOf(wire.command("release")), "stopped");
    await clock.advance(20000);
    assert.equal((await stop).verified, false);
});

test("stop: a closed wire says so", async () => {
    const { wire } = await stopRig();

    await wire.close();
    assert.equal(await codeOf(wire.stop()), "closed");
});

/* ---- the port is lost ---- */

const STATES = {
    ready: async () => ({ job: Promise.resolve() }),
    "a packet is outstanding": async ({ wire, port }) => {
        port.onPacket = () => true;
        return { job: wire.request(ping(1)) };
    },
    "a packet waits": async ({ wire, port }) => {
        port.onPacket = () => true;
        wire.request(ping(1)).catch(() => {});
        return { job: wire.request(ping(2)) };
    },
    "a command runs": async ({ wire, port }) => {
        port.onText = () => true;
        return { job: wire.command("scan") };
    },
    synchronising: async ({ wire, port, clock }) => {
        port.onPacket = () => true;
        wire.request(ping(1)).catch(() => {});
        await clock.advance(REPLY_MS + 1);
        assert.equal(wire.state, "synchronising");
        return { job: wire.request(ping(2)) };
    },
    stopping: async ({ wire, port }) => {
        port.isMute = true;
        port.onPacket = () => true;
        return { job: wire.stop({ servos: [1] }) };
    },
};

for (const [name, begin] of Object.entries(STATES))
    test(`lost: while ${name}`, async () => {
        const made = await rig();
        const { wire, port, clock, notices } = made;
        const { job } = await begin(made);
        const code = codeOf(job);

        await settle();
        const count = port.written.length;

        port.unplug();
        assert.equal(wire.state, "closed");
        if (name !== "ready") assert.equal(await code, "closed");
        assert.deepEqual(notices, [name === "stopping" ? "lost-stopping" : "lost"]);
        await clock.advance(60000);
        assert.equal(port.written.length, count, "nothing is written afterwards");
        assert.equal(await codeOf(wire.request(ping(1))), "closed");
    });

test("lost: at a write", async () => {
    const { wire, port, notices } = await rig();

    port.write = () => {
        throw new Error("device lost");
    };
    assert.equal(await codeOf(wire.request(ping(1))), "closed");
    assert.deepEqual(notices, ["lost"]);
});

test("lost: nothing is written after a silent controller", async () => {
    const { wire, port, clock } = await rig();

    port.isMute = true;
    port.onPacket = null;
    wire.request(ping(1)).catch(() => {});
    await clock.advance(10000);
    port.unplug();
    const count = port.written.length;

    await clock.advance(60000);
    assert.equal(port.written.length, count);
});

test("close: by the page is no notice", async () => {
    const { wire, notices } = await rig();

    await wire.close();
    assert.deepEqual(notices, []);
    assert.equal(wire.state, "closed");
});

test("traffic: both directions, packets and lines", async () => {
    const { wire, port } = await rig();
    const traffic = [];

    wire.addEventListener("traffic", ({ detail }) => traffic.push(`${detail.direction} ${detail.kind}`));
    await wire.request(ping(1));
    await wire.command("version");
    port.onBytes(Uint8Array.of(0x80));
    assert.deepEqual(traffic, ["out packet", "in packet", "out line", "in line", "in noise"]);
});

test("SYNC READ: only the device may answer", async () => {
    const { wire, port } = await rig();

    port.onPacket = (bytes) => bytes[4] === INSTRUCTION.SYNC_READ;
    const request = wire.request(syncRead(0x18, 1, [1, 2]));

    port.onBytes(packet(1, 0, [1, 1]));
    port.onBytes(packet(253, 0, [0, 1]));
    assert.deepEqual([...(await request).parameters], [0, 1]);
});

/* Another program at the port prints a line each 100 ms. */
function chat(clock, port) {
    const tick = () => {
        if (!port.isOpen) return;
        port.say("ax=0.1 ay=0.2");
        clock.after(100, tick);
    };

    clock.after(100, tick);
}

test("open: a port that talks and answers nothing is silent within 8 s", async () => {
    const { clock, port, wire } = await rig({ open: false });

    port.isMute = true;
    chat(clock, port);
    const opened = codeOf(wire.open());

    await clock.advance(8000);
    assert.equal(wire.state, "closed");
    assert.equal(await opened, "silent");
});

test("command: lines without an end do not hold the wire for ever", async () => {
    const { clock, port, wire } = await rig();

    port.onText = () => true;
    chat(clock, port);
    const sent = codeOf(wire.command("servos"));

    await clock.advance(31000);
    assert.equal(await sent, "timeout");
    await clock.advance(10000);
    assert.equal(wire.state, "silent");
});

test("command: one without a limit goes on while lines come", async () => {
    const { clock, port, wire } = await rig();

    port.onText = (line) => line === "monitor";
    chat(clock, port);
    const sent = codeOf(wire.command("monitor", { limit: Infinity }));

    await clock.advance(60000);
    assert.ok(wire.isBusyWithText);
    port.say("ok");
    await clock.advance(10);
    assert.equal(await sent, "ok");
});
