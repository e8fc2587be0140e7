// SPDX-License-Identifier: MIT
/* What went over the wire, in rows that can be filtered and described.
 *
 * The loop that reads feedback makes some hundred rows a second. They have a short list of their own,
 * so that they do not push out the other rows; a row is described only when the list or the filter needs its text.
 *
 * A row: {number, time, direction, kind, bytes, line, status, source, request, index, ids, group, isPolling, isError,
 * isUnanswered, isDropped, due, replies, described}.
 * `request`: the row that it answers. `index`: the number of replies to it before. `group`: the instruction's name,
 * "line", "stop" or "noise"; a reply has the group of its request. `isDropped`: a stop came before the row left the page.
 * `due`, `replies`: the replies to a row that went out. `described`: its texts, once they were asked for. */

import { END } from "../wire/jobs.js";
import { AT_ERROR, AT_ID, AT_INSTRUCTION, AT_PARAMETERS, ERROR, INSTRUCTION, repliesDue, toHex } from "../wire/packet.js";
import { DEVICE } from "../wire/registers.js";
import { texts } from "../texts/texts.js";
import { FEEDBACK, LIMITS, STATE } from "./blocks.js";
import { idsOf, instructionName } from "./decode.js";

export const ROWS_MAX = 2000;
export const POLLS_MAX = 400;

const POLLED = [FEEDBACK, LIMITS, STATE];
const POLLED_OF_DEVICE = [DEVICE.LINK_LOSS_ACTION, DEVICE.MOTION_PLAY];
const POLLED_LINE = "servos";
/* A line up to an ID, as text of a RegExp. Elsewhere a number behind the command is an angle, a time or a rate. */
const TAKES_IDS = "^(?:(?:monitor|group|teach \\w+)(?: \\d+)*|sync \\w+ \\d+ .*|(?!pose|cycle|bus|sync)\\w+)";

/* True for a packet that the loop of the robot sends again and again. */
function isPollingPacket(bytes) {
    const [address, count] = [bytes[AT_PARAMETERS], bytes[AT_PARAMETERS + 1]];

    if (bytes[AT_INSTRUCTION] === INSTRUCTION.SYNC_READ)
        return POLLED.some((block) => block.address === address && block.count === count);
    return bytes[AT_INSTRUCTION] === INSTRUCTION.READ && POLLED_OF_DEVICE.includes(address) && count > 2;
}

class Rows {
    constructor(max) {
        this.max = max;
        this.list = [];
    }

    push(row) {
        this.list.push(row);
        if (this.list.length > 2 * this.max) this.list.splice(0, this.list.length - this.max);
    }
}

export class Traffic {
    #others = new Rows(ROWS_MAX);
    #polls = new Rows(POLLS_MAX);
    #request = null; // the last row that went out and waits for replies
    #number = 0;

    constructor(decoder) {
        this.decoder = decoder;
        this.begun = null; // time of the first row
    }

    clear() {
        this.#others.list = [];
        this.#polls.list = [];
    }

    /* Takes an event `traffic` of the wire. Returns its row. */
    take(entry) {
        const row = this.#rowOf(entry);

        this.begun ??= entry.time;
        (row.isPolling ? this.#polls : this.#others).push(row);
        return row;
    }

    #rowOf({ direction, kind, time, bytes = null, text = "", status, isExpected, source, dropped = [] }) {
        const row = { number: this.#number++, time, direction, kind, bytes, line: text, status, source, request: null,
            index: 0, ids: [], group: kind, isPolling: false, isError: kind === "noise", isUnanswered: false };

        for (const each of dropped) this.#drop(each);
        if (kind === "key") row.group = "line";
        else if (direction === "out") this.#takeOut(row);
        else if (kind === "packet") this.#takeReply(row, isExpected);
        else if (kind === "line") this.#takeLine(row);
        return row;
    }

    /* A stop has dropped the write `bytes`. */
    #drop(bytes) {
        const isSame = (row) => row.bytes === bytes && !row.isDropped;
        const row = this.#others.list.findLast(isSame) ?? this.#polls.list.findLast(isSame);

        if (row) Object.assign(row, { isDropped: true, isError: false, isUnanswered: false, described: null });
    }

    #takeOut(row) {
        if (this.#request && row.kind !== "stop") {
            this.#request.isUnanswered = true;
            this.#request.isError = this.#request.source !== "probe"; // a firmware may have no device, or no console
        }
        row.due = 0;
        row.replies = 0;
        if (row.kind === "packet") {
            row.ids = idsOf(row.bytes);
            row.group = instructionName(row.bytes);
            row.due = repliesDue(row.bytes);
            row.isPolling = row.source === "page" && isPollingPacket(row.bytes);
        } else if (row.kind === "line") {
            row.due = 1;
            row.isPolling = row.source === "page" && row.line === POLLED_LINE;
        }
        this.#request = row.due ? row : null;
    }

    /* A search asks IDs that no servo has. */
    #takeReply(row, isExpected) {
        const isAbsentId = this.#request?.source === "search" && row.bytes[AT_ERROR] === ERROR.SOME_FAILED;

        row.ids = [row.bytes[AT_ID]];
        row.isError = row.bytes[AT_ERROR] !== 0 && !isAbsentId;
        row.group = "status";
        if (isExpected) this.#answer(row);
        else row.isError = true;
    }

    #takeLine(row) {
        row.isError = /^error \d+/.test(row.line);
        if (this.#request?.kind !== "line") return;
        const request = this.#request;

        row.request = request;
        row.isPolling = request.isPolling && !row.isError;
        if (END.test(row.line)) this.#request = null;
    }

    #answer(row) {
        const request = this.#request;

        if (!request) return;
        row.request = request;
        row.index = request.replies++;
        row.group = request.group;
        row.ids = request.ids;
        if (request.due > 1) row.ids = [row.bytes[AT_ID]]; // BULK READ: each servo answers by itself
        row.isPolling = request.isPolling;
        if (request.replies >= request.due) this.#request = null;
    }

    /* ---- to look at ---- */

    /* The newest `count` rows that fit `filter`, oldest first. filter: {id, group, errorsOnly, text,
     * withPolling}; an empty field fits all. */
    select(filter, count) {
        const rows = [];

        for (const row of this.#newestFirst(filter.withPolling)) {
            if (!this.#fits(row, filter)) continue;
            rows.push(row);
            if (rows.length === count) break;
        }
        return rows.reverse();
    }

    *#newestFirst(withPolling) {
        const others = this.#others.list;
        const polls = withPolling ? this.#polls.list : [];
        let [one, other] = [others.length - 1, polls.length - 1];

        while (one >= 0 || other >= 0) {
            const isPoll = one < 0 || (other >= 0 && polls[other].number > others[one].number);

            yield isPoll ? polls[other--] : others[one--];
        }
    }

    #fits(row, { id = null, group = "", errorsOnly = false, text = "" }) {
        if (errorsOnly && !row.isError) return false;
        if (group && row.group !== group) return false;
        if (id !== null && !this.#isOf(row, id)) return false;
        return !text || this.#searchText(row).includes(text.toLowerCase());
    }

    /* A line that was sent is of a servo if its ID stands where the command takes an ID; a reply, if it names the servo, or
     * answers such a line. */
    #isOf(row, id) {
        if (row.kind !== "line") return row.ids.includes(id);
        const before = row.direction === "out" ? TAKES_IDS : "\\b(?:servo|id)";

        return new RegExp(`${before} ${id}\\b`, "i").test(row.line) || Boolean(row.request && this.#isOf(row.request, id));
    }

    #searchText(row) {
        const { who, name, text, hex } = this.describe(row);

        return `${who} ${name} ${text} ${hex}`.toLowerCase();
    }

    /* {who, name, text, hex}; the texts are made once. */
    describe(row) {
        row.described ??= { who: "", name: "", text: "", hex: row.bytes ? toHex(row.bytes) : "", ...this.#describe(row) };
        return row.described;
    }

    #describe(row) {
        const t = texts.decode;

        if (row.isDropped) return { name: t.dropped, text: row.line };
        if (row.kind === "stop") return { name: t.stop, text: "" };
        if (row.kind === "key") return { name: t.key, text: "" };
        if (row.kind === "noise") return { name: t.noise, text: t.noiseText(row.bytes.length) };
        if (row.kind === "line") return { name: t.line, text: row.line, hex: "" };
        const who = this.decoder.nameOf(row.bytes[AT_ID]);

        if (row.direction === "out") return { who, ...this.decoder.instruction(row.bytes) };
        return { who, ...this.decoder.status(row.bytes, row.request?.bytes ?? null, row.index) };
    }
}
