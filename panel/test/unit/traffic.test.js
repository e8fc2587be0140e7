// SPDX-License-Identifier: MIT
/* Packets in words, the rows of the traffic, and their filter. */

import assert from "node:assert/strict";
import test from "node:test";
import { Decoder, idsOf } from "../../src/model/decode.js";
import { POLLS_MAX, ROWS_MAX, Traffic } from "../../src/model/traffic.js";
import { INSTRUCTION, action, bulkRead, packet, ping, read, reset, syncRead, syncWrite, write } from "../../src/wire/packet.js";
import { statusOf } from "../../src/wire/packet.js";
import { status } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const decoder = new Decoder(tables());
const POLL = syncRead(0x24, 8, [1, 2]);

/* Instruction packets, what the decoder makes of them, and of a reply to them. */
const PACKETS = [
    [ping(1), "PING", "", status(1), "ok", ""],
    [read(1, 0x1e, 2), "READ", "GOAL_POSITION", status(1, 0, [0, 2]), "ok", "GOAL_POSITION 150.1°"],
    [
        read(1, 0x24, 8),
        "READ",
        "PRESENT_POSITION to PRESENT_TEMPERATURE (8 bytes)",
        status(1, 0, [0xff, 3, 10, 4, 0, 0, 120, 32]),
        "ok",
        "PRESENT_POSITION 300.0°, PRESENT_SPEED -0.6 rpm, PRESENT_LOAD 0.0 %, PRESENT_VOLTAGE 12.0 V, PRESENT_TEMPERATURE 32 °C",
    ],
    [read(1, 0x04, 1), "READ", "BAUD_RATE", status(1, 0, [1]), "ok", "BAUD_RATE 1000000 bit/s"],
    [read(1, 0x13, 1), "READ", "1 byte from 0x13", status(1, 0, [7]), "ok", "0x13 = 0x07"],
    [read(1, 0x1f, 1), "READ", "1 byte from 0x1F", status(1, 0, [2]), "ok", "0x1F = 0x02"],
    [write(1, 0x1e, [0, 2, 0x4a, 1]), "WRITE", "GOAL_POSITION 150.1°, MOVING_SPEED 20.0 rpm", status(1, 0x22), /^error: goal beyond the angle limits; overload; not carried out$/, ""],
    [packet(1, INSTRUCTION.REG_WRITE, [0x18, 1]), "REG WRITE", "TORQUE_ENABLE 1", status(1, 0x20), "error: overload", ""],
    [action(), "ACTION", "", null],
    [reset(4), "RESET", "", status(4, 0x40), "error: unknown instruction; not carried out", ""],
    [syncWrite(0x1e, 2, [[1, [0, 2]], [2, [0, 0]]]), "SYNC WRITE", "1: GOAL_POSITION 150.1°; 2: GOAL_POSITION 0.0°", null],
    [
        syncRead(0x18, 1, [1, 2]),
        "SYNC READ",
        "TORQUE_ENABLE of 2 servos: 1, 2",
        status(253, 0x80, [1, 0xff]),
        "error: some servos did not answer",
        "1: TORQUE_ENABLE 1; 2: no reply",
    ],
    [bulkRead([[1, 1, 0x18], [2, 253, 0]]), "BULK READ", "1: TORQUE_ENABLE; device: MODEL", status(1, 0, [1]), "ok", "TORQUE_ENABLE 1"],
    [read(253, 0x17, 1), "READ", "INHIBIT", status(253, 0, [1]), "ok", "INHIBIT 1"],
    [write(253, 6, [1, 0]), "WRITE", "RETURN_DELAY 1 × 2 us, REPEATS 0", status(253), "ok", ""],
    [read(253, 0x50, 32), "READ", "FAILED_IDS", status(253, 0, new Array(32).fill(0)), "ok", /^FAILED_IDS 00 00 /],
    [packet(1, 0x55, [1, 2]), "instruction 0x55", "01 02", status(1, 0x40), /unknown instruction/, ""],
];

const fits = (text, wanted) => (wanted instanceof RegExp ? assert.match(text, wanted) : assert.equal(text, wanted));

test("decoder: every kind of packet, and a reply to it", () => {
    for (const [request, name, text, reply, replyName, replyText] of PACKETS) {
        assert.deepEqual(decoder.instruction(request), { name, text });
        if (!reply) continue;
        const described = decoder.status(reply, request);

        fits(described.name, replyName);
        fits(described.text, replyText);
    }
});

test("decoder: a BULK READ reply has its servo's registers", () => {
    const request = bulkRead([[1, 1, 0x18], [2, 2, 0x1e]]);

    assert.equal(decoder.status(status(2, 0, [0, 2]), request, 1).text, "GOAL_POSITION 150.1°");
});

test("decoder: a packet that lacks parameters, and its reply, are described", () => {
    const names = new Set();

    for (const instruction of [...Object.values(INSTRUCTION), 0x55])
        for (const value of [0, 1, 0x1e, 0xff])
            for (let count = 0; count < 9; count++) {
                const request = packet(1, instruction, new Array(count).fill(value));

                names.add(decoder.instruction(request).name);
                assert.ok(idsOf(request).length);
                for (const parameters of [[], [value], [value, 1, 2]]) assert.ok(decoder.status(status(1, 0, parameters), request, count).name);
            }
    assert.equal(names.size, Object.keys(INSTRUCTION).length + 1);
    assert.deepEqual(decoder.instruction(packet(1, INSTRUCTION.READ)), { name: "READ", text: "" });
    assert.deepEqual(decoder.instruction(packet(1, INSTRUCTION.READ, [0x1e])), { name: "READ", text: "1E" });
});

test("decoder: an unexpected status packet shows its bytes", () => {
    assert.match(decoder.status(status(1, 0, [1, 2]), null).text, /No request.*01 02/);
});

test("idsOf: all servos that a packet names", () => {
    assert.deepEqual(idsOf(syncWrite(0x18, 1, [[3, [0]], [5, [0]]])), [3, 5]);
    assert.deepEqual(idsOf(POLL), [1, 2]);
    assert.deepEqual(idsOf(action()), [254]);
});

/* ---- rows ---- */

const NO_FILTER = { withPolling: true };

function rig() {
    const traffic = new Traffic(decoder);
    let time = 0;
    const tell = (direction, kind, more) => traffic.take({ direction, kind, time: time++, ...more });

    return {
        traffic,
        out: (bytes, source = "page") => tell("out", "packet", { bytes, source }),
        in: (bytes, isExpected = true) => tell("in", "packet", { bytes, isExpected, status: statusOf(bytes) }),
        say: (text, source = "page") => tell("out", "line", { text, source }),
        hear: (text) => tell("in", "line", { text }),
        stop: () => tell("out", "stop", { bytes: Uint8Array.of(0x18), text: "Ctrl-X" }),
        noise: () => tell("in", "noise", { bytes: Uint8Array.of(1, 2), text: "01 02" }),
        shown: (filter = NO_FILTER, count = 200) =>
            traffic.select(filter, count).map((row) => {
                const { who, name, text } = traffic.describe(row);

                return `${who} ${name} ${text}`.trim();
            }),
    };
}

test("rows: a reply is described by its request", () => {
    const r = rig();

    r.out(read(1, 0x18, 1));
    r.in(status(1, 0, [1]));
    assert.deepEqual(r.shown(), ["1 READ TORQUE_ENABLE", "1 ok TORQUE_ENABLE 1"]);
});

test("rows: replies to BULK READ are counted", () => {
    const r = rig();

    r.out(bulkRead([[1, 1, 0x18], [1, 2, 0x19]]));
    r.in(status(1, 0, [1]));
    r.in(status(2, 0, [0]));
    assert.deepEqual(r.shown().slice(1), ["1 ok TORQUE_ENABLE 1", "2 ok LED 0"]);
});

test("rows: a request whose reply is missing is an error", () => {
    const r = rig();

    r.out(ping(9));
    r.out(ping(1));
    r.in(status(1));
    const [lost, good, reply] = r.traffic.select(NO_FILTER, 3);

    assert.ok(lost.isUnanswered && lost.isError);
    assert.ok(!good.isUnanswered && !reply.isError);
});

test("rows: a stop does not make the packet before it an error", () => {
    const r = rig();

    r.out(ping(9));
    r.stop();
    r.out(ping(1));
    assert.ok(r.traffic.select(NO_FILTER, 3).every((row) => !row.isError));
    assert.equal(r.shown()[1], "Ctrl-X");
});

test("rows: lines behind one that begins with ok belong to the same reply, and a key ends none", () => {
    const traffic = new Traffic(decoder);
    const take = (direction, kind, more) => traffic.take({ direction, kind, time: 0, ...more });
    const request = take("out", "line", { text: "counters", bytes: [], source: "hand" });

    take("in", "line", { text: "ok 1517, of these 4 by scan and diagnose" });
    const key = take("out", "key", { bytes: [0x0d] });

    assert.equal(take("in", "line", { text: "timeouts 3" }).request, request);
    assert.equal(take("in", "line", { text: "ok" }).request, request);
    assert.equal(take("in", "line", { text: "alarm of servo 3: overload" }).request, null);
    assert.ok(!request.isUnanswered);
    assert.match(traffic.describe(key).name, /key/);
});

test("filter: hides polling, not the same requests by hand", () => {
    const r = rig();

    r.out(POLL);
    r.in(status(253, 0, new Array(16).fill(0)));
    r.out(read(253, 0x09, 15));
    r.in(status(253, 0, new Array(15).fill(0)));
    r.say("servos");
    r.hear("servo 1: online");
    r.hear("ok");
    assert.deepEqual(r.shown({}), []);
    assert.equal(r.shown().length, 7);
    r.out(POLL, "hand");
    r.in(status(253, 0, new Array(16).fill(0)));
    r.say("servos", "hand");
    r.hear("ok");
    assert.equal(r.shown({}).length, 4);
});

test("filter: by servo, instruction, errors, text", () => {
    const r = rig();

    r.out(syncWrite(0x18, 1, [[3, [0]], [5, [0]]]));
    r.out(write(3, 0x18, [1]));
    r.in(status(3, 0x08));
    r.say("torque 5 on");
    r.hear("error 2: no reply");
    r.noise();
    assert.deepEqual(r.shown({ id: 5 }), ["SYNC WRITE 3: TORQUE_ENABLE 0; 5: TORQUE_ENABLE 0", "line torque 5 on", "line error 2: no reply"].map((text, i) => (i ? text : "all " + text)));
    assert.equal(r.shown({ id: 3 }).length, 3);
    assert.equal(r.shown({ group: "WRITE" }).length, 2);
    assert.equal(r.shown({ group: "line" }).length, 2);
    assert.equal(r.shown({ group: "noise" }).length, 1);
    assert.deepEqual(r.shown({ errorsOnly: true }).map((text) => text.slice(0, 7)), ["3 error", "line er", "noise 2"]);
    assert.equal(r.shown({ text: "torque_enable 1" }).length, 1);
    assert.equal(r.shown({ text: "ff ff 03" }).length, 2);
    assert.equal(r.shown({ id: 3, group: "SYNC WRITE" }).length, 1);
});

test("filter: a line of the console is of a servo if its ID stands where an ID is due", () => {
    const lines = { "ping 3": true, "torque 3 on": true, "group 1 2 3": true, "teach off 3": true, "monitor 1 3 every 3": true, "sync LED 1 1:0 3:1": true,
        "ping 13": false, "move 1 3": false, "pose 3 90": false, "cycle 3": false, "play wave times 3": false, "sync LED 3 1:0": false,
        "settings autostart nod 3s": false };
    const replies = { "servo 3: online": true, "id 3 model 1": true, "servo 13: online": false, "3 found": false, "timeouts 3": false,
        "error 3: reply damaged": false, "motion: wave: step 3 of 3, run 3": false };

    for (const [line, isShown] of Object.entries(lines)) {
        const r = rig();

        r.say(line);
        r.hear("ok");
        assert.equal(r.shown({ id: 3 }).length, isShown ? 2 : 0, line); // the line and its reply
    }
    for (const [line, isShown] of Object.entries(replies)) {
        const r = rig();

        r.say("version");
        r.hear(line);
        assert.equal(r.shown({ id: 3 }).length, isShown ? 1 : 0, line);
    }
});

test("filter: an ID without servo is no error of a search, an error of other reads", () => {
    const r = rig();

    for (const source of ["search", "hand"]) {
        r.out(syncRead(0x03, 1, [1, 2]), source);
        r.in(status(253, 0x80, [1, 0xff]));
    }
    r.out(syncRead(0x03, 1, [1, 2]), "search");
    r.in(status(253, 0x08, []));
    assert.deepEqual(r.traffic.select({ errorsOnly: true }, 9).map(({ number }) => number), [3, 5]);
});

test("select: at most the newest rows, oldest of them first", () => {
    const r = rig();

    for (let id = 1; id <= 9; id++) r.out(ping(id));
    assert.deepEqual(r.shown(NO_FILTER, 2), ["8 PING", "9 PING"]);
});

test("rows: both lists are bounded, polling has its own", () => {
    const r = rig();

    r.out(ping(7));
    for (let i = 0; i < 10 * POLLS_MAX; i++) r.out(POLL);
    assert.equal(r.shown({}).length, 1);
    assert.ok(r.shown(NO_FILTER, Infinity).length <= 2 * POLLS_MAX + 1);
    for (let i = 0; i < 3 * ROWS_MAX; i++) r.out(ping(1));
    assert.ok(r.shown({}, Infinity).length <= 2 * ROWS_MAX);
});

test("clear: nothing is left to show", () => {
    const r = rig();

    r.out(ping(1));
    r.traffic.clear();
    assert.deepEqual(r.shown(), []);
});
