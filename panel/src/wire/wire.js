// SPDX-License-Identifier: MIT
/* The one owner of the port. One packet or one line of text is outstanding at a time; the next one leaves
 * when the reply has come or its time is over. Nothing is ever sent twice, except Ctrl-X and the key that ends a command.
 *
 * After a reply that did not come, the wire first makes sure that no stale reply is on its way: it
 * sends a fence (a READ of the device) and, after text, a marker (`help NAME`), and drops all that
 * comes before their replies. If nothing answers, the state is `silent`: jobs fail at once, and the wire
 * asks again each second.
 *
 * Events: `state`; `traffic` (detail: {direction, kind, time, bytes, text, status, source, dropped}; `dropped`: the
 * earlier writes that this stop has dropped, port/web_serial.js); `text` (a line that belongs to no reply); `notice`
 * (detail: {code, ...}, texts.wire has the text); `close`.
 *
 * States: closed, synchronising, ready, stopping, silent. */

import { Demux } from "./demux.js";
import { FenceJob, LineJob, MarkerJob, PacketJob } from "./jobs.js";
import { Timeout, realClock } from "./clock.js";
import { DEVICE_ID, isPacket, read, toHex } from "./packet.js";
import { WireError } from "./wire_error.js";
import { verifyStop } from "./stop.js";

export const REPLY_MS = 400; // a packet: the slowest reply of 31 servos at 57600 bit/s, and USB
export const LINE_MS = 3000; // a command: the longest time without a line of its reply
export const CTRL_X = 0x18;
const KEY = Uint8Array.of(0x0d); // ends a command
const KEY_AGAIN_MS = 300; // between two keys
const END_MS = 1000; // from the first key; the wire then gives the command up

const SILENCE_MS = 200; // an unfinished packet is then given up; a busy machine passes bytes on with gaps
/* Timeout of a fence during a stop. Short, because the controller drops a packet that waits more than 15 ms behind a
 * SYNC READ. */
const STOP_FENCE_MS = 100;
const OPEN_MS = 6000; // a board that the opening of its port resets, with its boot loader
const MARKER_MS = 500;
const MARKER_LIMIT_MS = 1000; // another program may talk at the port and never answer
const LIMIT_TIMEOUTS = 10; // in so many timeouts a command has ended, unless a user can end it
const RETRY_MS = 1000; // between two attempts while the controller is silent
const FENCE_ATTEMPTS = 5; // 2 s: on a line that is held low, a stop holds up the reply for 1.4 s
const MARKER_ATTEMPTS = 6;
const MARKERS = ["id", "ping", "stop", "release", "scan"];
const FENCE_SIZES = [2, 3, 4, 5, 6, 7, 8]; // bytes; the device has 16 at its start

export class Wire extends EventTarget {
    #port;
    #clock;
    #demux;
    #queue = [];
    #current = null;
    #endsAt = Infinity; // latest end of the current job
    #timeout = null; // timeout of the current job
    #ending = null; // timeout of the next key, while a user ends the current line
    #silence = null; // timeout of an unfinished packet
    #fences = 0;
    #markers = 0;
    #epoch = 0; // counts up with each stop and close: what began before is void
    #stopping = null; // promise of the stop under way
    #isOpening = false;

    constructor(port, { clock = realClock, deviceId = DEVICE_ID } = {}) {
        super();
        this.#port = port;
        this.#clock = clock;
        this.deviceId = deviceId;
        this.state = "closed";
        this.hasConsole = true; // false: the firmware takes no text (profile bridge)
        this.hasDevice = true; // false: the device does not answer under deviceId
        this.isUnresponsive = false; // the controller does not answer; the wire asks again and again
        this.#demux = new Demux({
            onPacket: (status, bytes) => this.#takePacket(status, bytes),
            onLine: (text) => this.#takeLine(text),
            onNoise: (bytes) => this.#emitTraffic("in", "noise", { bytes, text: toHex(bytes) }),
        });
    }

    get clock() {
        return this.#clock;
    }

    /* True while a line of text is outstanding or waits: the page sends no packets then. */
    get isBusyWithText() {
        return [this.#current, ...this.#queue].some((job) => job?.kind === "line");
    }

    /* Resolves when the wire takes jobs, at once or after a stop or a silence. Throws WireError if it is closed. */
    async whenReady() {
        while (this.state !== "ready") {
            if (this.state === "closed") throw new WireError("closed");
            await new Promise((resolve) => this.addEventListener("state", resolve, { once: true }));
        }
    }

    /* Opens the port and waits until the controller answers. Throws WireError or what the port throws. */
    async open() {
        this.#port.onBytes = (bytes) => this.#receive(bytes);
        this.#port.onClose = (reason) => this.#closed(reason);
        this.#isOpening = true;
        try {
            await this.#port.open();
            if (!this.#isOpening) throw new WireError("closed"); // by close(), while the port opened
            this.#demux.clear();
            this.isUnresponsive = false;
            this.#setState("synchronising");
            while (!(await this.#tryFirstContact())) await this.#stopping.catch(() => {});
        } catch (error) {
            const isClosed = !this.#isOpening;

            this.#closed(null);
            await this.#port.close();
            throw isClosed ? new WireError("closed") : error;
        } finally {
            this.#isOpening = false;
        }
    }

    /* Returns false if a stop interrupted it. */
    async #tryFirstContact() {
        try {
            await this.#firstContact(this.#epoch);
            return true;
        } catch (error) {
            if (error.code !== "stopped") throw error;
            return false;
        }
    }

    /* Sends a packet. Resolves with its status packet {id, error, parameters}, an array of them (BULK READ),
     * or null if none is due. `notAfter`: time of the clock after which it must not be sent. `source`:
     * jobs.js. */
    request(bytes, { timeout = REPLY_MS, notAfter, signal, source } = {}) {
        if (!isPacket(bytes)) throw new RangeError(`not a packet: ${toHex(bytes)}`);
        return this.#submit(new PacketJob(bytes, { timeout, notAfter, signal, source, deviceId: this.deviceId }));
    }

    /* Sends a line of text. Resolves with {lines, error}; error is null or {number, text}. `timeout`: the
     * longest time without a line of the reply. `limit`: the longest time of the whole reply. `signal`: ends the command by a
     * key, as scan; if its reply does not come soon, the command fails as `ended`. */
    command(line, { timeout = LINE_MS, signal, limit = signal ? Infinity : LIMIT_TIMEOUTS * timeout, notAfter, onLine, source } = {}) {
        if (/[^\x20-\x7e]/.test(line)) throw new RangeError(`not a line of text: ${line}`);
        if (!line.trim()) return Promise.resolve({ lines: [], error: null }); // the console does not answer
        return this.#submit(new LineJob(line, { timeout, limit, notAfter, onLine, signal, source }));
    }

    /* Stops the robot: Ctrl-X leaves before all that waits. Resolves, once the device and the servos
     * have been asked, with {inhibited, off, on, silent, verified}; off, on and silent are IDs out of
     * `servos`. `isLineLow`: the line is held low. Another call while a stop is under way sends another Ctrl-X. */
    stop({ servos = [], isLineLow } = {}) {
        if (this.state === "closed") return Promise.reject(new WireError("closed"));
        this.#epoch++;
        this.#setState("stopping");
        this.sendStop();
        this.#demux.silence(); // the reply to a packet from before does not hold up what confirms the stop
        this.#failAll("stopped");
        this.#stopping ??= this.#stop(servos, isLineLow);
        return this.#stopping;
    }

    sendStop() {
        const bytes = Uint8Array.of(CTRL_X);

        this.#emitTraffic("out", "stop", { dropped: this.#write(bytes, true), bytes, text: "Ctrl-X" });
    }

    /* `last`: packets that leave at once, before the port closes; their replies are not awaited. */
    async close(last = []) {
        if (this.state === "closed" && !this.#isOpening) return;
        for (const bytes of this.state === "closed" ? [] : last) {
            this.#write(bytes);
            this.#emitTraffic("out", "packet", { bytes, source: "page" });
        }
        this.#isOpening = false;
        this.#closed(null);
        await this.#port.close();
    }

    /* ---- jobs ---- */

    #submit(job) {
        if (this.state === "closed" || this.state === "silent") {
            job.fail(this.state);
        } else if (this.state === "stopping") {
            job.fail("stopped");
        } else {
            this.#queue.push(job);
            this.#listenToSignal(job);
            this.#dropWhenLate(job);
            this.#pump();
        }
        return job.promise;
    }

    /* A job that still waits at `notAfter` fails at once, not when its turn comes: a command may run for minutes. */
    #dropWhenLate(job) {
        if (job.notAfter === Infinity) return;
        const timer = this.#clock.after(job.notAfter + 1 - this.#clock.now(), () => {
            const index = this.#queue.indexOf(job);

            if (index < 0) return;
            this.#queue.splice(index, 1);
            job.fail("late");
        });

        job.promise.catch(() => {}).finally(() => this.#clock.cancel(timer));
    }

    #listenToSignal(job) {
        const { signal } = job;

        if (!signal) return;
        const abort = () => this.#abort(job);

        if (signal.aborted) abort();
        else signal.addEventListener("abort", abort, { once: true });
        job.promise.finally(() => signal.removeEventListener("abort", abort)).catch(() => {});
    }

    /* Cancels a job that waits. A line under way gets a key that ends it. Its reply still comes, or the
     * wire gives the command up after 1.2 s: at the first multiple of KEY_AGAIN_MS behind END_MS. */
    #abort(job) {
        const index = this.#queue.indexOf(job);

        if (index >= 0) {
            this.#queue.splice(index, 1);
            job.fail("cancelled");
        } else if (this.#current === job && job.kind === "line") {
            this.#sendKey(job, this.#clock.now() + END_MS);
        }
    }

    /* A key may be lost, so it is sent again until the reply ends: behind the reply it is an empty line, which the console
     * ignores. At `end` the command is given up. */
    #sendKey(job, end) {
        this.#write(KEY);
        this.#emitTraffic("out", "key", { bytes: KEY });
        this.#ending = new Timeout(this.#clock, KEY_AGAIN_MS, () => {
            if (this.#current !== job) return;
            if (this.#clock.now() < end) this.#sendKey(job, end);
            else this.#giveUp(job, "ended");
        });
    }

    #pump() {
        while (this.state === "ready" && !this.#current && this.#queue.length) {
            const job = this.#queue.shift();

            if (this.#clock.now() > job.notAfter) job.fail("late");
            else this.#begin(job);
        }
    }

    #begin(job) {
        this.#current = job;
        this.#endsAt = this.#clock.now() + job.limit;
        this.#write(job.bytes);
        this.#emitTraffic("out", job.kind === "line" || job.kind === "marker" ? "line" : "packet", {
            bytes: job.bytes,
            text: job.line,
            source: job.source,
        });
        if (this.#current !== job) return; // the port was lost at the write
        if (job.due === 0) this.#finish(job, () => job.end(null));
        else this.#armTimer(job);
    }

    #armTimer(job) {
        this.#timeout?.cancel();
        const left = Math.min(job.timeout, this.#endsAt - this.#clock.now());

        this.#timeout = new Timeout(this.#clock, left, () => this.#giveUp(job, "timeout"));
    }

    /* The job has ended, or `end` ends it. */
    #finish(job, end = () => {}) {
        this.#forgetCurrent();
        end();
        this.#pump();
    }

    /* Without a reply, or without its end. */
    #giveUp(job, code) {
        this.#forgetCurrent();
        const isText = job.kind === "line";

        job.fail(code, job.line ?? toHex(job.bytes));
        if (this.state === "ready") this.#resynchronise(this.#epoch, isText);
    }

    #forgetCurrent() {
        this.#timeout?.cancel();
        this.#timeout = null;
        this.#ending?.cancel();
        this.#ending = null;
        this.#current = null;
    }

    #failAll(code) {
        const jobs = [this.#current, ...this.#queue].filter((job) => job);

        this.#forgetCurrent();
        this.#queue = [];
        for (const job of jobs) job.fail(code, job.line);
    }

    /* ---- what arrives ---- */

    #receive(bytes) {
        if (this.state === "closed") return;
        this.#silence?.cancel();
        this.#demux.take(bytes);
        if (this.#demux.isWithinPacket)
            this.#silence = new Timeout(this.#clock, SILENCE_MS, () => this.#demux.silence());
    }

    #takePacket(status, bytes) {
        const job = this.#current;
        const isExpected = Boolean(job && !job.isOver && job.accepts(status));

        this.#emitTraffic("in", "packet", { bytes, status, isExpected });
        if (!isExpected) return;
        job.take(status);
        if (job.isOver) this.#finish(job);
        else this.#armTimer(job);
    }

    /* A prompt of the mode `person` stands before a line, or is a line. */
    #takeLine(line) {
        const text = line.replace(/^(?:> )+/, "");
        const job = this.#current;

        this.#emitTraffic("in", "line", { text });
        if (!text || text === ">") return;
        if (!job || job.isOver || !job.takeLine(text)) {
            this.dispatchEvent(new CustomEvent("text", { detail: text }));
        } else if (job.isOver) {
            this.#finish(job);
        } else {
            this.#armTimer(job);
        }
    }

    /* ---- resynchronisation ---- */

    /* Until the first contact it is not known what can answer. */
    get #source() {
        return this.#isOpening ? "probe" : "page";
    }

    #nextFence({ timeout = REPLY_MS, older } = {}) {
        const size = FENCE_SIZES[this.#fences++ % FENCE_SIZES.length];

        return new FenceJob(read(this.deviceId, 0, size), { timeout, deviceId: this.deviceId, older, source: this.#source });
    }

    #nextMarker() {
        return new MarkerJob(MARKERS[this.#markers++ % MARKERS.length], { timeout: MARKER_MS, limit: MARKER_LIMIT_MS, source: this.#source });
    }

    /* Sends a job of the wire itself. False: no reply. Throws WireError if the epoch has passed. */
    async #probe(epoch, job) {
        this.#check(epoch);
        this.#begin(job);
        const isAnswered = await job.promise.then(
            () => true,
            () => false,
        );

        this.#check(epoch);
        return isAnswered;
    }

    #check(epoch) {
        if (epoch !== this.#epoch) throw new WireError(this.state === "closed" ? "closed" : "stopped");
    }

    async #attempt(epoch, count, next) {
        for (let left = count; left; left--) if (await this.#probe(epoch, next())) return true;
        return false;
    }

    /* The first answer of the controller tells what it has: a device, a console. */
    async #firstContact(epoch) {
        const end = this.#clock.now() + OPEN_MS;
        let device = false;
        let console = false;

        while (!device && !console && this.#clock.now() < end) {
            device = await this.#attempt(epoch, 1, () => this.#nextFence());
            console = await this.#attempt(epoch, 1, () => this.#nextMarker());
        }
        if (device && !console) console = await this.#attempt(epoch, 2, () => this.#nextMarker());
        if (console && !device) device = await this.#attempt(epoch, 2, () => this.#nextFence());
        if (!device && !console) throw new WireError("silent");
        this.hasDevice = device;
        this.hasConsole = console;
        this.#becomeReady();
    }

    async #waitForAnswer(epoch, isText) {
        if (this.hasDevice && !(await this.#attempt(epoch, FENCE_ATTEMPTS, () => this.#nextFence()))) return false;
        if (!this.hasConsole || (!isText && this.hasDevice)) return true;
        return this.#attempt(epoch, MARKER_ATTEMPTS, () => this.#nextMarker());
    }

    /* Called after a missing reply or a stop: makes sure that no stale reply or text is on its way. */
    async #resynchronise(epoch, isText) {
        if (!this.isUnresponsive) this.#setState("synchronising");
        try {
            if (await this.#waitForAnswer(epoch, isText)) this.#becomeReady();
            else this.#becomeSilent(epoch);
        } catch (error) {
            if (!(error instanceof WireError)) throw error; // a stop or a close goes on from here
        }
    }

    #becomeReady() {
        const wasSilent = this.isUnresponsive;

        this.isUnresponsive = false;
        this.#setState("ready");
        if (wasSilent) this.#notice("back");
        this.#pump();
    }

    #becomeSilent(epoch) {
        if (!this.isUnresponsive) this.#notice("silent");
        this.isUnresponsive = true;
        this.#setState("silent");
        this.#failAll("silent");
        this.#clock.after(RETRY_MS, () => {
            if (epoch === this.#epoch && this.state === "silent") this.#resynchronise(epoch, true);
        });
    }

    /* ---- stop ---- */

    /* During a stop a fence is sent every STOP_FENCE_MS. The reply to any fence of the last REPLY_MS counts. */
    async #stop(servos, isLineLow) {
        let sent = []; // [fence, time], newest first
        const fence = () => {
            const now = this.#clock.now();

            sent = sent.filter(([, time]) => now - time < REPLY_MS);
            const next = this.#nextFence({ timeout: STOP_FENCE_MS, older: sent.map(([one]) => one) });

            sent = [[next, now], ...sent];
            return this.#ask(next);
        };

        try {
            return await verifyStop({
                clock: this.#clock,
                deviceId: this.deviceId,
                servos,
                isLineLow,
                sendStop: () => this.sendStop(),
                fence,
                ask: (bytes) => this.#ask(new PacketJob(bytes, { timeout: REPLY_MS, deviceId: this.deviceId })),
            });
        } finally {
            this.#stopping = null;
            if (this.state === "stopping") this.#goOn();
        }
    }

    #goOn() {
        if (this.#isOpening) this.#setState("synchronising");
        else this.#resynchronise(this.#epoch, true);
    }

    /* Sends a packet of the stop itself. Resolves with the status packet, or null: no reply. */
    async #ask(job) {
        if (this.state !== "stopping") throw new WireError("closed");
        this.#begin(job);
        try {
            return await job.promise;
        } catch (error) {
            if (error.code === "timeout" || error.code === "stopped") return null; // stopped: by a second stop
            throw error;
        }
    }

    /* ---- the port ---- */

    #write(bytes, isStop) {
        try {
            return this.#port.write(bytes, isStop);
        } catch (error) {
            return void this.#closed(String(error.message ?? error));
        }
    }

    #closed(reason) {
        if (this.state === "closed") return;
        const wasStopping = this.state === "stopping";

        this.#epoch++;
        this.#silence?.cancel();
        this.#setState("closed");
        this.#failAll("closed");
        this.#demux.clear();
        if (reason !== null) this.#notice(wasStopping ? "lost-stopping" : "lost", { detail: reason });
        this.dispatchEvent(new CustomEvent("close", { detail: { reason, wasStopping } }));
    }

    #setState(state) {
        if (state === this.state) return;
        this.state = state;
        this.dispatchEvent(new CustomEvent("state", { detail: state }));
    }

    #notice(code, more = {}) {
        this.dispatchEvent(new CustomEvent("notice", { detail: { code, ...more } }));
    }

    #emitTraffic(direction, kind, more) {
        this.dispatchEvent(new CustomEvent("traffic", { detail: { direction, kind, time: this.#clock.now(), ...more } }));
    }
}
