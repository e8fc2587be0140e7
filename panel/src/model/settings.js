// SPDX-License-Identifier: MIT
/* The settings of the controller: by the console, or, without one, by the registers of the device.
 *
 * The page works in the mode for programs, setting `echo` 0. The setting that a user sees is `kept`: the
 * mode that the controller had before, and gets again at the next reset. It is put in force only while
 * the settings are saved. */

import { packet, word, wordAt, INSTRUCTION } from "../wire/packet.js";
import { pause } from "../wire/clock.js";
import { DEVICE } from "../wire/registers.js";
import { Failure } from "./registers.js";

const SAVE_MS = 5000; // then the EEPROM has failed
const POLL_MS = 20;
const DEVICE_OFF = 254;
const MODE_OF_PAGE = 0;
const OWN_MODE = `settings echo ${MODE_OF_PAGE}`;
const FIRST = 0x03; // registers of the device that SAVE keeps
const LAST = 0x0e;
const SAVE_FAILED = 2;

/* Names of the changes, {name: value}, that take feedback or Stop away. A user must say yes first. */
export function risksOf(changes) {
    return ["bus_baud", "device_id"].filter((name) => changes[name] !== undefined && (name === "bus_baud" || changes[name] === DEVICE_OFF));
}

export class Settings {
    #session;

    constructor(session) {
        this.#session = session;
        this.rows = session.tables.settings;
        this.values = new Map(); // of the name: the value in force; of `echo`: what is kept
        this.origin = ""; // what the controller says of the settings at its start
        this.saved = null; // a Map of the values that are saved, as far as they are known; null: nothing was changed here yet
    }

    /* False: a value in force is not saved; null: not known. */
    get isSaved() {
        return this.saved && this.rows.every(({ name }) => this.saved.get(name) === this.values.get(name));
    }

    get #controller() {
        return this.#session.controller;
    }

    get #wire() {
        return this.#session.wire;
    }

    /* The row of the device that holds a setting. */
    #registerOf(name) {
        return this.#session.tables.device.find((row) => row.name === (name === "device_id" ? "ID" : name.toUpperCase()));
    }

    async read() {
        if (this.#wire.hasConsole) this.#takeLines(await this.#controller.run("settings"));
        else this.#takeBytes(await this.#controller.readDevice(FIRST, LAST - FIRST + 1));
        if (this.#controller.modeBefore !== null) this.values.set("echo", this.#controller.modeBefore);
    }

    #takeLines(lines) {
        for (const line of lines) {
            const [, name, value] = /^(\w+) = (\d+)/.exec(line) ?? [];

            if (this.rows.some((row) => row.name === name)) this.values.set(name, Number(value));
            this.origin = /^settings at start: (.*)$/.exec(line)?.[1] ?? this.origin;
        }
    }

    #takeBytes(bytes) {
        for (const { name } of this.rows) {
            const row = this.#registerOf(name);
            const at = row.address - FIRST;

            this.values.set(name, row.bytes === 2 ? wordAt(bytes, at) : bytes[at]);
        }
    }

    /* Puts values in force, {name: value}. Throws CommandError, WireError, or Error with `code`. */
    async apply(changes) {
        if (this.#session.robot.ids.includes(changes.device_id)) throw new Failure("device-id-taken", { setting: changes.device_id });
        for (const [name, value] of Object.entries(changes)) {
            if (name === "echo" && this.#wire.hasConsole) this.#controller.modeBefore = value;
            else await this.#set(name, value);
            this.saved ??= new Map();
            this.values.set(name, value);
            this.#follow(name, value);
        }
    }

    async #set(name, value) {
        if (this.#wire.hasConsole) {
            await this.#controller.run(`settings ${name} ${value}`);
        } else {
            const row = this.#registerOf(name);
            const bytes = row.bytes === 2 ? word(value) : [value];

            if (await this.#controller.writeDevice(row.address, bytes)) throw new Failure("setting-refused", { setting: name });
        }
    }

    /* What the page itself has to do with a setting. */
    #follow(name, value) {
        if (name === "device_id") {
            this.#wire.hasDevice = value !== DEVICE_OFF;
            if (this.#wire.hasDevice) this.#wire.deviceId = value;
        }
        if (name === "host_baud") this.#session.notify({ code: "host-rate" });
        if (name === "link_loss_ms") this.#controller.takeWatched();
    }

    /* Refused while a command keeps link_loss_ms at 0: the 0 would be saved. */
    async save() {
        const { unwatchedMs: ms } = this.#controller;

        if (ms) throw new Failure("unwatched-still", { ms });
        if (this.#wire.hasConsole) await this.#withMode(() => this.#controller.run("save"));
        else await this.#saveByPacket();
        this.saved = new Map(this.values);
    }

    /* Runs `call` while the mode that is kept is in force. */
    async #withMode(call) {
        const mode = this.values.get("echo") ?? MODE_OF_PAGE;

        if (mode === MODE_OF_PAGE) return call();
        return this.#thenTakeMode(async () => {
            await this.#controller.run(`settings echo ${mode}`);
            return call();
        });
    }

    /* Runs `call`, which may change the mode, then takes the mode of the page. `waits`: false if the page must connect again
     * first. */
    async #thenTakeMode(call, { waits = true } = {}) {
        const controller = this.#controller;

        controller.hasOwnMode = false;
        try {
            return await call();
        } finally {
            await (waits ? controller.insist(OWN_MODE) : controller.run(OWN_MODE).catch(() => {}));
            controller.hasOwnMode = true;
        }
    }

    async #saveByPacket() {
        const { clock } = this.#session;
        const end = clock.now() + SAVE_MS;

        if (await this.#controller.writeDevice(DEVICE.SAVE, [1])) throw new Failure("not-saved");
        for (;;) {
            const [state] = await this.#controller.readDevice(DEVICE.SAVE, 1);

            if (state === 0) return;
            if (state === SAVE_FAILED || clock.now() > end) throw new Failure("not-saved");
            await pause(clock, POLL_MS);
        }
    }

    /* The settings of a new controller, in force at once and not saved. */
    async defaults() {
        const initial = new Map(this.rows.map((row) => [row.name, row.initial]));

        if (this.#wire.hasConsole) await this.#defaultsByConsole(initial);
        else if ((await this.#wire.request(packet(this.#wire.deviceId, INSTRUCTION.RESET))).error)
            throw new Failure("defaults-refused");
        const before = this.values;

        this.values = initial;
        this.saved ??= new Map();
        for (const name of ["device_id", "host_baud"])
            if (before.get(name) !== initial.get(name)) this.#follow(name, initial.get(name));
    }

    async #defaultsByConsole(initial) {
        const waits = this.values.get("host_baud") === initial.get("host_baud");

        await this.#thenTakeMode(() => this.#controller.run("defaults"), { waits });
        this.#controller.modeBefore = initial.get("echo");
    }
}
