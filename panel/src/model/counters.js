// SPDX-License-Identifier: MIT
/* Counters of the bus, the host link and the bridge, and what they say about the health of the bus.
 *
 * The device has all counters; the console tells how much of those of the bus `scan` and `diagnose`
 * have caused, and since when it counts. A counter that only one of them has is shown, too. */

import { wordAt } from "../wire/packet.js";

const LINE = /^([a-z ]+?) (\d+)(?:, of these (\d+) .*)?$/;
const TROUBLES = ("timeouts corrupt framing_errors line_busy duplicate_replies unexpected_packets stale_replies overruns ring_overflows " +
    "echo_errors noise_bytes host_malformed host_gaps").split(" "); // 0 on a good bus; texts.packets.findings tells each
const OF_SERVO = ["ok", "timeouts", "corrupt", "stale_replies", "duplicate_replies", "unexpected_packets", "echo_errors"];

/* "BUS_STALE_REPLIES" is "stale_replies", "HOST_GAPS" is "host_gaps". */
const keyOf = (name) => name.replace(/^BUS_/, "").toLowerCase();

/* Rows of the device that are counters. */
export function counterRows(tables) {
    return tables.device.filter((row) => row.what);
}

/* The lines of the command `counters`: {since, counts: Map of key to {count, ofScan}}. */
export function parseCounters(lines) {
    const counts = new Map();
    let since = "";

    for (const line of lines) {
        const match = LINE.exec(line);

        if (/^since /.test(line)) since = line;
        else if (match) counts.set(match[1].replace(/ /g, "_"), { count: Number(match[2]), ofScan: Number(match[3] ?? 0) });
    }
    return { since, counts };
}

async function readDevice(controller, rows) {
    const first = rows[0].address;
    const last = rows.at(-1);
    const bytes = await controller.readDevice(first, last.address + last.bytes - first);

    return new Map(rows.map((row) => [keyOf(row.name), { count: wordAt(bytes, row.address - first), ofScan: 0 }]));
}

/* Reads counters: of the bus and all else, or of servo `id`. Returns {since, rows: [{key, count, ofScan,
 * unit, meaning}]}. */
export async function readCounters(controller, id = null) {
    const { wire } = controller;
    const rows = counterRows(controller.tables);
    const counts = id === null && wire.hasDevice ? await readDevice(controller, rows) : new Map();
    const text = wire.hasConsole
        ? parseCounters(await controller.run(id === null ? "counters" : `counters ${id}`))
        : { since: "", counts: new Map() };

    for (const [key, value] of text.counts) counts.set(key, value);
    return {
        since: text.since,
        rows: rows
            .map((row) => ({ key: keyOf(row.name), unit: row.unit, meaning: row.what, ...counts.get(keyOf(row.name)) }))
            .filter((row) => row.count !== undefined && (id === null || OF_SERVO.includes(row.key))),
    };
}

/* Seconds that the controller counts; NaN: not told. */
export const ageOf = ({ since }) => Number(/(\d+) s ago/.exec(since)?.[1]);

/* Counters that were read, as the start from which others are counted. */
export function startOf(counters) {
    return { time: new Date().toTimeString().slice(0, 8), age: ageOf(counters), rows: new Map(counters.rows.map((row) => [row.key, row])) };
}

/* A counter begins again at 0 behind 65535. */
const less = (count, before = 0) => (count - before) & 0xffff;

/* The rows without what was counted before `start`; null: all. */
export function countedFrom(start, rows) {
    if (!start) return rows;
    return rows.map((row) => {
        const { count, ofScan } = start.rows.get(row.key) ?? {};

        return { ...row, count: less(row.count, count), ofScan: less(row.ofScan, ofScan) };
    });
}

/* What is wrong: [{key, count}]. What `scan` has caused does not count. */
export function healthOf(rows) {
    return TROUBLES.map((key) => {
        const row = rows.find((one) => one.key === key);

        return { key, count: row ? less(row.count, row.ofScan) : 0 };
    }).filter(({ count }) => count > 0);
}
