// SPDX-License-Identifier: MIT
/* The controller as the page uses it: what its firmware has, and commands of its console. */

import { FAILED, ID_MAX, read, syncRead, word, write } from "../wire/packet.js";
import { DEVICE, REGISTER } from "../wire/registers.js";
import { Failure, parametersOf } from "./registers.js";

export const ORDER_MS = 2000; // what a user orders leaves within this time or not at all: a command may run for minutes
const NOT_IN_FIRMWARE = ": not in this firmware"; // a line of `help`
export const LISTED_MAX = 18; // servos that the console lists
const SCAN_GROUP = 32; // IDs in a packet of a scan
const SCAN_MS = 3000; // for the answer to it
const SEARCH_MS = 30000; // `scan` diagnoses up to four servos in silence; at 7.8 kbps `scan rescue` asks 254 IDs in 5 s
const ERROR_LINK_LOST = 65;

/* The console has answered `error N: text; remedy`. `line`: the command. `lines`: the reply before it. */
export class CommandError extends Error {
    constructor(line, { number, text }, lines, remedies) {
        const [what, ...remedy] = text.split("; ");

        super(what);
        this.name = "CommandError";
        this.line = line;
        this.number = number;
        this.lines = lines;
        this.remedy = remedies[number]?.remedy ?? remedy.join("; "); // that of the table names what the page has
    }
}

export class Controller {
    #wire;

    constructor(wire, tables) {
        this.#wire = wire;
        this.tables = tables;
        this.profile = "bridge"; // bridge, console, full
        this.version = "";
        this.board = "";
        this.modeBefore = null; // setting `echo` before the page changed it; null: not known
        this.hasOwnMode = true; // false while the page has given the mode of before back, to save it
        this.commands = new Set(); // usage of each command, as in the tables
        this.onDone = () => {}; // (line) is called when a command has succeeded
        this.unwatchedMs = 0; // value of link_loss_ms after the command that needs 0; 0: there is no such command
        this.onWatch = () => {}; // (code of a notice, ms): link_loss_ms was set to 0; code "": it was set back
        this.hasMotion = false; // timed moves, stored poses and sequences
    }

    get wire() {
        return this.#wire;
    }

    /* True if the tables of the page are of another version than the firmware. */
    get isOtherVersion() {
        return this.version !== this.shownVersion;
    }

    /* The version of the page, as exact as the firmware tells its own. */
    get shownVersion() {
        return this.profile === "bridge" ? this.tables.version.split(".").slice(0, 2).join(".") : this.tables.version;
    }

    hasCommand(name) {
        return this.tables.commands.some((row) => row.name === name && this.commands.has(row.usage));
    }

    /* Puts the console into the mode for programs, and asks what the firmware has. */
    async setUp() {
        if (this.#wire.hasConsole) await this.#askConsole();
        else await this.#askDevice();
        this.hasMotion = this.#wire.hasDevice && (await this.#overrideOfMotion()) > 0;
    }

    /* 0: the device has no such register. */
    async #overrideOfMotion() {
        const { parameters } = await this.#wire.request(read(this.#wire.deviceId, DEVICE.MOTION_OVERRIDE, 1));

        return parameters[0] ?? 0;
    }

    async #askConsole() {
        await this.#askMode();
        const { error } = await this.#wire.command("mode program");

        if (error) await this.run("echo off"); // an older firmware has no command `mode`
        const [first = ""] = await this.run("version");

        [, this.version = "", this.board = ""] = /^cds55xx (\S+) ?(\S*)/.exec(first) ?? [];
        this.#takeHelp(await this.run("help"));
        if (!this.#wire.hasDevice) await this.#findDevice();
    }

    /* With echo, the line itself stands before its reply. */
    async #askMode() {
        const { lines } = await this.#wire.command("settings echo");
        const mode = lines.map((line) => /^echo = (\d)/.exec(line)?.[1]).find((value) => value !== undefined);

        this.modeBefore = mode === undefined ? null : Number(mode);
    }

    /* A line of `help`: "  id OLD NEW: give a servo another ID". Only the profile full has `diagnose`. */
    #takeHelp(lines) {
        const has = ({ usage }) =>
            lines.some((line) => line.trim().startsWith(`${usage}: `) && !line.endsWith(NOT_IN_FIRMWARE));
        const rows = this.tables.commands.filter(has);

        this.commands = new Set(rows.map((row) => row.usage));
        this.profile = this.hasCommand("diagnose") ? "full" : "console";
    }

    async #findDevice() {
        const [line = ""] = await this.run("settings device_id");
        const id = Number(/= (\d+)/.exec(line)?.[1] ?? NaN);

        if (!(id <= ID_MAX)) return; // 254: the device is off
        this.#wire.deviceId = id;
        this.#wire.hasDevice = true;
    }

    async #askDevice() {
        const [version] = await this.readDevice(DEVICE.VERSION, 1);

        this.profile = "bridge";
        this.version = `${version >> 4}.${version & 15}`;
    }

    /* Runs a command. Returns the lines of its reply; throws CommandError or WireError. */
    async run(line, options) {
        const { lines, error } = await this.#wire.command(line, options);

        if (error) throw new CommandError(line, error, lines, this.tables.errors);
        this.onDone(line);
        return lines;
    }

    /* Runs a command that needs a silent page. If the controller would stop the robot meanwhile, link_loss_ms is 0 for this time.
     * It is not saved: after a reset the saved value is in force. */
    async runLong(line, options) {
        const ms = await this.#watchedMs();

        if (!ms) return this.run(line, options);
        this.unwatchedMs = ms;
        this.onWatch("unwatched", ms);
        try {
            await this.run("settings link_loss_ms 0");
            return this.run(line, options); // not awaited: the line that sets it back is queued at once
        } finally {
            this.#watchAgain(ms);
        }
    }

    async #watchAgain(ms) {
        try {
            await this.insist(`settings link_loss_ms ${ms}`);
            this.takeWatched();
        } catch {
            if (this.unwatchedMs) this.onWatch("unwatched-still", ms);
        }
    }

    /* As run(). After a stop or a missing reply it sends the line again once the wire is ready. */
    async insist(line) {
        for (;;) {
            try {
                return await this.run(line);
            } catch (error) {
                if (!["stopped", "silent", "timeout"].includes(error.code)) throw error;
            }
            await this.#wire.whenReady();
        }
    }

    /* The packet that sets link_loss_ms back before the port closes. It ends the command. */
    takeLastPackets() {
        const ms = this.unwatchedMs;

        if (!ms || !this.#wire.hasDevice) return [];
        this.unwatchedMs = 0;
        return [write(this.#wire.deviceId, DEVICE.LINK_LOSS_MS, word(ms))];
    }

    /* link_loss_ms has the value that the user wants. */
    takeWatched() {
        this.unwatchedMs = 0;
        this.onWatch("");
    }

    /* link_loss_ms if the controller stops the robot as soon as the page is silent for this time. */
    async #watchedMs() {
        return this.#wire.hasConsole && Number(/loss_ms = ([1-9]\d*).*loss_action = [12]/.exec(await this.run("settings"))?.[1] ?? 0);
    }

    /* As run(), for what a user orders: fails as `late` if other commands have the wire for ORDER_MS. */
    order(line, options) {
        return this.run(line, { notAfter: this.#wire.clock.now() + ORDER_MS, ...options });
    }

    /* Reads registers of the device. Throws Failure or WireError. */
    async readDevice(address, count) {
        const { deviceId } = this.#wire;

        return parametersOf(deviceId, await this.#wire.request(read(deviceId, address, count)));
    }

    /* Writes registers of the device, as an order of a user. Returns the error bits of its reply. */
    async writeDevice(address, bytes) {
        const notAfter = this.#wire.clock.now() + ORDER_MS;

        return (await this.#wire.request(write(this.#wire.deviceId, address, bytes), { notAfter })).error;
    }

    /* Finds servos: at the rate of the bus; `how` = "all": at the listed rates; "rescue": at all rates. If the link is
     * watched, packets take the place of a search at the rate of the bus.
     * onFound({id, ...}) is called for each servo, onProgress(text) for each line. Returns the lines, or,
     * without a console, nothing. */
    async scan({ how = "", onFound = () => {}, onProgress = () => {}, signal } = {}) {
        const { hasConsole, hasDevice } = this.#wire;

        if (!hasConsole || (!how && hasDevice && (await this.#watchedMs()))) return this.scanByPackets({ onFound, onProgress, signal });
        let listed = 0;
        const onLine = (line) => {
            const found = /^id (\d+) model (\d+)(?:.*? at (\d+)bps)?/.exec(line);

            onProgress(line);
            if (found) onFound({ id: Number(found[1]), model: Number(found[2]), rate: Number(found[3]) || null });
            if (found) listed = Number(found[1]) + 1;
        };
        const lines = await this.runLong(`scan ${how}`.trim(), { onLine, signal, timeout: SEARCH_MS });
        const count = Number(/^(\d+) found/m.exec(lines.join("\n"))?.[1] ?? 0);

        if (!how && count > LISTED_MAX && hasDevice) await this.scanByPackets({ first: listed, onFound, onProgress, signal });
        return lines;
    }

    /* Finds servos at the rate of the bus by packets, those that the console does not list, too. */
    async scanByPackets({ first = 0, onFound = () => {}, onProgress = () => {}, signal } = {}) {
        const own = this.#wire.hasDevice ? this.#wire.deviceId : null; // the controller itself would answer
        const ids = Array.from({ length: ID_MAX + 1 - first }, (_, index) => first + index).filter((id) => id !== own);
        const total = first + ids.length;

        while (ids.length && !signal?.aborted) {
            const group = ids.splice(0, SCAN_GROUP);
            const parameters = parametersOf(this.#wire.deviceId, await this.#wire.request(syncRead(REGISTER.ID, 1, group), { timeout: SCAN_MS, source: "search" }));

            group.forEach((id, index) => parameters[index] !== FAILED && onFound({ id, model: null, rate: null }));
            onProgress(`${total - ids.length} of ${total} IDs asked`);
        }
        return [];
    }

    /* Ends the inhibit after a stop or a lost link. Nothing moves. A lost link must be acknowledged first, which
     * clears the alarms, too. Throws CommandError, Failure or WireError if the controller refuses. */
    async release() {
        if (!this.#wire.hasConsole) return this.#releaseByPacket();
        try {
            await this.order("release");
        } catch (error) {
            if (error.number !== ERROR_LINK_LOST) throw error;
            await this.order("clear");
            await this.order("release");
        }
    }

    async #releaseByPacket() {
        const refuses = (register) => this.writeDevice(register, [0]);

        if (!(await refuses(DEVICE.INHIBIT))) return;
        if ((await refuses(DEVICE.LINK_LOST)) || (await refuses(DEVICE.INHIBIT))) throw new Failure("release-refused");
    }
}
