// SPDX-License-Identifier: MIT
/* The operations of the view Set-up: search, new servo, diagnosis, registers, backup and restore. One at a time
 * runs; a failure is a notice of the session. What was found stays until another connection. What a
 * restore has left undone stays longer: the port may have been lost meanwhile.
 *
 * Event: `change`. */

import { ID_MAX } from "../wire/packet.js";
import { CommandError, LISTED_MAX } from "./controller.js";
import { checkLimits, differences, entriesFor, entryOf, readBackup, textOfBackup } from "./backup.js";
import { Failure, rawAt, readRegisters, registerRows, silences, writeRegister } from "./registers.js";

/* The rates at which a search looks, bit/s. */
export const RATES = [1000000, 500000, 250000, 115200, 57600, 19200];

const SEARCH_MS = 15000; // `new` and `diagnose` say nothing while they search, 4 s each time
const CHANGE_MS = 10000; // a change of the rate of a servo
const ERROR_KEY = 49; // the user has ended a command
const ENDED_CODES = new Set(["cancelled", "ended"]); // errors of the wire: the user has ended the command
const ERROR_LIMIT = 11; // `new`: the ID is in the controller's list
const ERROR_NOT_NEW = 95; // `new`: the servo that answers may be one of the list
const IS_SILENT = new Set([9, 10, 11, 12, 13, 18]); // findings: the servo gives no reply that the controller hears
const FATAL_CODES = new Set(["stopped", "closed", "silent", "cancelled"]); // errors of the wire after which the next job would fail, too

export class Setup extends EventTarget {
    #wire = null; // of the connection that the results belong to
    #servos = null; // servos of the robot after the last operation

    constructor(session) {
        super();
        this.session = session;
        this.rows = registerRows(session.tables);
        this.#wire = session.wire;
        session.addEventListener("change", () => this.#follow());
        this.#clear();
    }

    #clear() {
        this.operation = null; // {kind, lines, done, total, signal, end(), isEnding()}
        this.found = null; // servos of the last search: [{id, model, rate}]; null: no search yet
        this.remarks = []; // lines of the last search behind the servos
        this.isPartial = false; // true until the last search has asked all IDs
        this.busRate = null; // bit/s; null: not known
        this.steps = []; // lines of the last set-up of a new servo
        this.outcome = null; // outcome of the last change: {kind, lines}
        this.isDiagnosisEnded = false; // the user has ended the last diagnosis
        this.findings = []; // findings of the last diagnosis: [{id, number, text, remedy, measured, isGood, at}]
        this.chosen = null; // ID of the servo whose registers are shown
        this.registers = null; // {id, bytes, at, isOld}; isOld: a write since then, and no reply to the read behind it
        this.plan = null; // plan of a restore: {scope, servos: [{id, entry, changes}]}
        this.restored = null; // outcome of a restore: [{id, row, file, now, why}]; why "": written
        this.isRestoreEarlier = false; // `restored` is of an earlier connection
    }

    #follow() {
        if (this.session.wire !== this.#wire) {
            const { restored } = this;

            this.#wire = this.session.wire;
            this.#clear();
            this.isRestoreEarlier = Boolean(restored?.some(({ why }) => why));
            if (this.isRestoreEarlier) this.restored = restored;
        }
        if (!this.operation) this.#followServos();
        this.findings = this.findings.filter(({ id, number, at }) => !(IS_SILENT.has(number) && this.session.robot?.servos.get(id)?.updatedAt > at));
        this.#change();
    }

    /* The servos of the robot are others, as by a search in the view Robot: what was found here before is old. */
    #followServos() {
        if (this.session.robot?.servos === this.#servos) return;
        this.#dropFound();
        this.outcome = null;
        this.#takeServos();
    }

    #takeServos() {
        const isNew = this.#servos !== this.session.robot?.servos;

        this.#servos = this.session.robot?.servos;
        if (isNew) this.readBusRate();
    }

    /* The view Board and the console can change it, too. */
    async readBusRate() {
        const { session } = this;
        const wire = this.#wire;

        if (!session.isConnected || !this.has("bus")) return;
        const lines = await session.controller.run("bus").catch(() => []); // the next one tells

        if (wire !== this.#wire) return;
        this.busRate = Number(/ at (\d+)bps/.exec(lines)?.[1] ?? 0) || null;
        this.#change();
    }

    #change() {
        this.dispatchEvent(new Event("change"));
    }

    /* ---- what the firmware has ---- */

    has(command) {
        return Boolean(this.session.controller?.hasCommand(command));
    }

    /* A list of servos may stand in a command. */
    get hasLists() {
        return this.session.controller?.profile === "full";
    }

    /* ---- servos ---- */

    get ids() {
        return this.session.robot?.ids ?? [];
    }

    get isRunning() {
        return this.operation !== null;
    }

    /* The servo of the registers: the chosen one if the robot has it. */
    get id() {
        return this.ids.includes(this.chosen) ? this.chosen : (this.ids[0] ?? null);
    }

    /* The ID at which the controller itself answers, so that no servo can, or null. */
    get idOfDevice() {
        const { wire } = this.session;

        return wire?.hasDevice ? wire.deviceId : null;
    }

    /* True if the controller's list has no room for another ID. */
    get isFull() {
        return this.ids.length >= LISTED_MAX;
    }

    #checkNewId(id) {
        if (id === this.idOfDevice) throw new Failure("id-of-device", { id });
    }

    /* The lowest ID from 2 on that no servo is known to have or to have had, or null. 1 comes last: new servos have it. */
    get freeId() {
        const taken = new Set([...this.session.seenIds, ...(this.found ?? []).map(({ id }) => id)]);

        if (this.idOfDevice !== null) taken.add(this.idOfDevice);
        for (let id = 2; id <= ID_MAX; id++) if (!taken.has(id)) return id;
        return [0, 1].find((id) => !taken.has(id)) ?? null;
    }

    choose(id) {
        this.chosen = id;
        this.#change();
    }

    /* ---- one operation at a time ---- */

    /* Returns what `call` returns, or undefined if it failed. `input`: session.js. */
    async #run(kind, call, input = kind) {
        if (this.operation) return undefined;
        const ending = new AbortController();
        const operation = { kind, lines: [], done: 0, total: 0, signal: ending.signal, end: () => ending.abort(), isEnding: () => ending.signal.aborted };

        this.operation = operation;
        this.#change();
        const value = await this.session.attempt(() => call(operation), input);

        if (this.operation === operation) this.operation = null;
        this.#takeServos();
        this.#change();
        return value;
    }

    end() {
        this.operation?.end();
        this.#change();
    }

    /* Runs a command that a key ends. Returns true if it was not ended. */
    async #endable(operation, call) {
        try {
            await call();
            return true;
        } catch (error) {
            const isEnded = operation.isEnding() && (error.number === ERROR_KEY || ENDED_CODES.has(error.code));

            if (!isEnded) throw error;
            return false;
        }
    }

    #take(operation, line) {
        const progress = /^(\d+) of (\d+)\b/.exec(line);

        operation.lines.push(line);
        if (progress) [operation.done, operation.total] = progress.slice(1).map(Number);
        this.#change();
    }

    /* The controller may have other servos now. `more`: robot.js. */
    async #findServos(options) {
        await this.session.robot.findServos(options);
    }

    /* ---- search ---- */

    /* `how`: "" at the rate of the bus, "all" at the listed rates, "rescue" at all rates. */
    search(how) {
        return this.#run("search", async (operation) => {
            this.found = [];
            this.outcome = null;
            this.remarks = [];
            const { controller, robot, wire } = this.session;
            const scan = () =>
                controller.scan({
                    how,
                    signal: operation.signal,
                    onFound: (servo) => this.found.push(servo),
                    onProgress: (line) => this.#takeSearch(operation, line),
                });

            this.isPartial = true; // until the search has asked all IDs
            this.isPartial = !(await this.#endable(operation, scan)) || operation.isEnding();
            const more = how || this.isPartial ? robot.ids : this.found.map(({ id }) => id);

            if (wire.hasConsole) await this.#findServos({ more }); // no key would end another scan
            else if (!this.isPartial) robot.setServos(this.found.map(({ id }) => id));
        });
    }

    #takeSearch(operation, line) {
        if (!/^id \d+|^\d+ of |^\d+ found/.test(line)) this.remarks.push(line);
        this.#take(operation, line);
    }

    /* ---- new servo ---- */

    /* `forgets`: empties the controller's list first, because the new servo, or the one whose place it takes, is in it. */
    setUpNew(id, { forgets = false } = {}) {
        return this.#run("new", async (operation) => {
            this.steps = [];
            this.outcome = null;
            this.#checkNewId(id);
            if (forgets) await this.session.controller.run("servos forget");
            const onLine = (line) => {
                const step = /step (\d) of (\d)/.exec(line);

                this.steps.push(line);
                if (step) [operation.done, operation.total] = step.slice(1).map(Number);
                this.#take(operation, line);
            };
            const run = () => this.session.controller.runLong(`new ${id}`, { onLine, signal: operation.signal, timeout: SEARCH_MS });

            try {
                if (!(await this.#endable(operation, run))) {
                    this.outcome = { kind: "newEnded", lines: [] };
                    return;
                }
            } catch (error) {
                this.steps = [];
                if (error.number !== ERROR_LIMIT && error.number !== ERROR_NOT_NEW) throw error;
                this.outcome = { kind: "newKnown", lines: [], id }; // has the remedy, so no notice comes
                return;
            }
            this.outcome = { kind: "new", lines: [], id };
            this.chosen = id;
            this.registers = this.found = null;
            await this.#findServos();
        });
    }

    /* ---- diagnosis ---- */

    /* `who`: an ID, "all" (profile full), or "": any servo. */
    diagnose(who) {
        return this.#run("diagnose", async (operation) => {
            this.findings = [];
            this.isDiagnosisEnded = false;
            const onLine = (line) => this.#takeFinding(line, typeof who === "number" ? who : null);
            const run = () => this.session.controller.runLong(`diagnose ${who}`.trim(), { onLine, signal: operation.signal, timeout: SEARCH_MS });

            this.isDiagnosisEnded = !(await this.#endable(operation, run));
        });
    }

    #takeFinding(line, id) {
        const [, own, number] = /^(?:servo (\d+): )?finding (\d+): /.exec(line) ?? [];
        const failed = /^servo (\d+): (.*)$/.exec(line);

        if (number !== undefined) {
            const { text, remedy } = this.session.tables.findings[number] ?? { text: line, remedy: "" };

            this.findings.push({ id: own === undefined ? id : Number(own), number: Number(number), text, remedy, measured: [], isGood: number === "1", at: this.session.clock.now() });
        } else if (failed) {
            this.findings.push({ id: Number(failed[1]), number: null, text: failed[2], remedy: "", measured: [], isGood: false });
        } else {
            this.findings.at(-1)?.measured.push(line);
        }
        this.#change();
    }

    /* ---- changes of where a servo answers ---- */

    /* The controller must forget a full list first; a search fills it again. */
    changeId(id, to) {
        return this.session.attempt(() => {
            this.#checkNewId(to);
            return this.#changePlace("id", `id ${id} ${to}`, { id: to }, this.isFull);
        }, "own id");
    }

    changeRate(id, rate) {
        return this.#changePlace("rate", `baud ${id} ${rate}bps`, { id, rate });
    }

    changeRateOfAll(rate) {
        return this.#changePlace("rateOfAll", `baud all ${rate}bps`, { id: this.id });
    }

    factory(id) {
        return this.#changePlace("factory", `factory ${id}`, { id: 1, rate: RATES[0] });
    }

    changeRateOfBus(rate) {
        return this.#changePlace("bus", `bus ${rate}bps`, { id: this.id });
    }

    /* `change`: {id, rate} that the servo of `command` then has. */
    #changePlace(kind, command, change, forgets = false) {
        const who = command.split(" ")[1];

        return this.#run(kind, async () => {
            this.outcome = null;
            this.registers = null;
            try {
                if (forgets) await this.session.controller.order("servos forget");
                this.outcome = { kind, lines: await this.session.controller.order(command, { timeout: CHANGE_MS }) };
                this.chosen = change.id;
                this.#dropFound(who, change, kind === "id");
            } catch (error) {
                if (error instanceof CommandError) this.outcome = outcomeOfFailure(error);
                throw error;
            } finally {
                if (this.session.isConnected) await this.#findServos(forgets ? { how: "" } : {}).catch(() => {}); // the first failure is told
            }
            if (kind === "id" || kind === "factory") this.session.seenIds.delete(Number(who));
        });
    }

    /* Servo `who` has `change`. The servos at the rate of the bus are others, unless `isKnown`; if `who` is "all", so are all. Servos
     * that were found at rates of their own stay: a rescue takes 11 minutes. */
    #dropFound(who, change, isKnown) {
        const kept = this.found?.filter(({ rate }) => isKnown || (rate && who !== "all"));

        this.found = kept?.length ? kept.map((row) => (String(row.id) === who ? { ...row, ...change } : row)) : null;
    }

    /* ---- registers ---- */

    readAll(id = this.id) {
        return this.#run("read", () => this.#read(id), `read ${id}`);
    }

    async #read(id) {
        this.chosen = id;
        this.registers = { id, bytes: await readRegisters(this.session.wire, id), at: this.session.clock.now() };
    }

    /* Returns true if the register has the value now, as far as it can be read. */
    write(id, row, raw) {
        return this.#run("write", async () => {
            try {
                checkLimits(id, await readRegisters(this.session.wire, id), this.rows, { [row.name]: raw });
                if ((await writeRegister(this.session.controller, id, row, raw)) === null) this.session.notify({ code: "level-silent", id });
            } finally {
                if (this.session.isConnected) await this.#read(id).catch(() => this.#markOld()); // the first failure is told
            }
            return true;
        }, `write ${id} ${row.name}`);
    }

    #markOld() {
        if (this.registers) this.registers = { ...this.registers, isOld: true };
    }

    /* ---- backup ---- */

    /* The text of a file with the servo `id`, or with all if it is null. */
    backup(id) {
        return this.#run("backup", async (operation) => {
            const ids = id === null ? this.ids : [id];
            const servos = [];

            operation.total = ids.length;
            for (const one of ids) {
                if (operation.isEnding()) return undefined;
                servos.push(entryOf(this.rows, one, await readRegisters(this.session.wire, one)));
                operation.done++;
                this.#change();
            }
            return textOfBackup(servos, { page: this.session.tables.version, saved: new Date().toISOString() });
        });
    }

    /* Compares a file with the servo `id`, or with the whole robot. Writes nothing. */
    compare(text, id) {
        this.forgetPlan();
        return this.#run("compare", async (operation) => {
            const entries = entriesFor(readBackup(text, this.rows), id);

            operation.total = entries.length;
            const servos = [];

            for (const entry of entries) {
                if (operation.isEnding()) return;
                await this.#tryServo(entries, async () => servos.push({ id: entry.id, entry, changes: await this.#differences(entry) }));
                operation.done++;
                this.#change();
            }
            if (servos.length) this.plan = { scope: id, servos };
        });
    }

    /* A servo that fails does not hold up the others of the file: a notice names it. */
    async #tryServo({ length }, call) {
        try {
            await call();
        } catch (error) {
            if (length === 1 || FATAL_CODES.has(error.code)) throw error;
            this.session.notify(error);
        }
    }

    async #differences(entry) {
        return differences(entry, await readRegisters(this.session.wire, entry.id), this.rows);
    }

    forgetPlan() {
        this.plan = null;
        this.restored = null;
        this.isRestoreEarlier = false;
        this.#change();
    }

    /* Writes what differs. A servo must still be as it was when the file was compared. */
    restore() {
        return this.#run("restore", async (operation) => {
            const planned = this.plan.servos;
            const servos = [];

            for (const { id, entry, changes } of planned)
                await this.#tryServo(planned, async () => {
                    if (!isSame(changes, await this.#differences(entry))) throw new Failure("backup-changed", { id });
                    servos.push({ id, entry, changes });
                });
            if (!servos.length) return;
            this.plan = null;
            this.restored = servos.flatMap(({ id, changes }) => changes.map(({ row, file }) => ({ id, row, file, why: "ended" })));
            this.registers = null;
            operation.total = this.restored.length;
            for (const { id, entry, changes } of servos) if (changes.length) await this.#tryServo(servos, () => this.#restoreServo(operation, id, entry));
        }, "compare");
    }

    /* Torque may have been switched on since the file was compared, so the limits are checked again. A status return
     * level that silences the servo is written behind all that is read back. */
    async #restoreServo(operation, id, entry) {
        const own = this.restored.filter((one) => one.id === id);
        const isLast = ({ row, file }) => silences(row, file);

        if (!operation.isEnding()) await this.#differences(entry);
        await this.#restoreRegisters(operation, own.filter((one) => !isLast(one)));
        await this.#readBack(id);
        await this.#restoreRegisters(operation, own.filter(isLast));
    }

    async #restoreRegisters(operation, outcomes) {
        for (const outcome of outcomes) {
            if (!operation.isEnding()) await this.#restoreRegister(outcome);
            operation.done++;
            this.#change();
        }
    }

    async #restoreRegister(outcome) {
        const { id, row, file } = outcome;

        outcome.why = "unconfirmed";
        try {
            outcome.why = (await writeRegister(this.session.controller, id, row, file)) === null ? "unread" : "";
        } catch (error) {
            if (FATAL_CODES.has(error.code)) throw error;
            outcome.why = error instanceof CommandError ? [error.message, error.remedy].filter((part) => part).join("; ") : (error.why ?? error.code);
        }
    }

    /* Reads all written registers of the servo once more: a later write may have changed an earlier one. */
    async #readBack(id) {
        const own = this.restored.filter((outcome) => outcome.id === id && !outcome.why);

        if (!own.length) return;
        const bytes = await readRegisters(this.session.wire, id).catch((error) => {
            if (FATAL_CODES.has(error.code)) throw error;
            return null;
        });

        for (const outcome of own) if (!bytes || rawAt(bytes, outcome.row) !== outcome.file) outcome.why = "unconfirmed";
    }
}

/* The outcome of a failed change, or null. The controller tells "unchanged: ..." for a servo that it has not changed. */
function outcomeOfFailure({ lines }) {
    if (!lines.length) return null;
    return { kind: lines.every((line) => line.startsWith("unchanged:")) ? "unchanged" : "partly", lines };
}

function isSame(one, other) {
    return one.length === other.length && one.every(({ row, now }, index) => row.name === other[index].row.name && now === other[index].now);
}
