// SPDX-License-Identifier: MIT
/* All that the page has: the port and its wire, the controller, the robot, notices, traffic. Views show
 * a session and call it; they touch neither port nor wire.
 *
 * Events: `change` (state, notices, servos: show the page again), `disconnect` (a question about this connection is
 * void), `feedback` (new values of the servos), `hand` (a line by hand is sent: it may change what the board stores),
 * `traffic` (detail: a row of the traffic). */

import { Wire } from "../wire/wire.js";
import { pause, realClock } from "../wire/clock.js";
import { noticeText } from "../texts/texts.js";
import { CapturePort } from "../port/replay.js";
import { isForgetting, operationOf } from "./console_line.js";
import { Controller } from "./controller.js";
import { Decoder } from "./decode.js";
import { History } from "./history.js";
import { Robot } from "./robot.js";
import { Traffic } from "./traffic.js";

const NOTICES_MAX = 20;
const INFO_MS = 8000; // information then goes away by itself
const INFO_TO_DO_MS = 20000; // one with a remedy or a button
/* Errors of the controller. */
const ERROR_LINE_LOW = 9;
const ERROR_INHIBITED = 12; // a servo is inhibited
const ERROR_STOPPED = 54;
const ERROR_STOPPING = 64; // torque off is under way
const ERROR_LINK_LOST = 65;
const ERROR_TOO_MANY = 40; // servos in its list
const ERROR_NOT_NEW = 95; // `new`: the servo that answers may be one of the list
const LISTS_SERVOS = new Set(["goal-not-kept", "goal-refused", "goal-unconfirmed", "inhibited", "joint-moves", "refused", "servo-silent", "turn-not-ended", "turning"]); // one notice lists all servos
const WITHDRAWN_BY = { // notices that an event withdraws
    release: ["clear-inhibited", "goal-unconfirmed", "inhibited", "motion-inhibited", "release-refused", "stop-no-inhibit", "stop-unverified", "stopped", ERROR_INHIBITED, ERROR_STOPPED, ERROR_STOPPING, ERROR_LINK_LOST],
    stop: ["lost-stopping", "stop-failed", "stop-no-inhibit", "stop-not-sent", "stop-unverified", "turning"],
    back: ["silent"],
    motion: ["motion-ended"],
};
/* Notices that no other notice pushes out: the robot may move, or its torque is not known. */
const ABOUT_SAFETY = new Set([...WITHDRAWN_BY.stop, "lost", "reset", "silent", "turn-not-ended"]);
const LOST = new Set(["lost", "lost-stopping"]);
const RANKS = ["info", "warning", "error"]; // which notices go first if there are too many
const STALE_MS = 2000; // so long a confirmed stop is shown without new feedback
const PORT_TAKEN_MS = 5000; // a page that has been left gives its port free in this time
const PORT_RETRY_MS = 250;
const BANNER = /^cds55xx \d/; // a controller in the mode for people tells it after a reset
const PORT_TAKEN = /another client is connected/; // the simulator says so, then hangs up

const UNWATCHED = "unwatched-still"; // this notice outlives the connection

const isStopDue = ({ code }) => code === "stop-not-sent";

export class Session extends EventTarget {
    #stopping = null; // promise of the last stop
    #staleAt = 0; // when the confirmed stop is no longer shown, unless feedback comes
    #staleTimer = null; // of the confirmed stop
    #expiry = null; // timer of the information that goes away next
    #wasInhibited = false;
    #isRenewing = false; // asks a controller that was reset
    #isRetrying = false; // another client has the port, and connectAtLoad() tries again

    constructor({ tables, clock = realClock }) {
        super();
        this.tables = tables;
        this.clock = clock;
        this.state = "disconnected"; // disconnected, connecting, connected, silent
        this.stopState = "none"; // none, stopping, verified, unchecked (no servo was asked), unverified, failed
        this.stopOutcome = null;
        this.notices = []; // {key, input, code, ids, operation, number, text, remedy, level, time, undo}; undo(): the button Undo
        this.traffic = new Traffic(new Decoder(tables, () => this.wire?.deviceId));
        this.capture = null; // the port of the last connection; `text` is the capture
        this.portName = "";
        this.isWaiting = false; // connectAtLoad() has found that another client has the port
        this.wire = null;
        this.controller = null;
        this.robot = null;
        this.history = null; // History of the servos, since the connection began
        this.seenIds = new Set(); // IDs of servos since the page began: a servo that was forgotten may only be unplugged
        this.starts = 0; // counts connections, and resets of the controller: what was read of it before is old
    }

    get isConnected() {
        return this.state === "connected" || this.state === "silent";
    }

    /* True while INHIBIT reads 1. Without device it cannot be read: then after each stop. */
    get isInhibited() {
        if (!this.isConnected) return false;
        return this.wire.hasDevice ? this.robot.isInhibited : this.stopState !== "none";
    }

    /* IDs of the servos that are inhibited by themselves, as after a power cut. */
    get lostIds() {
        return this.isConnected ? [...this.robot.servos.values()].filter(({ inhibit }) => inhibit === "lost").map(({ id }) => id) : [];
    }

    /* True unless each servo is known to have no torque. */
    get mayHaveTorque() {
        return [...this.robot.servos.values()].some(({ torque }) => torque !== false);
    }

    /* What the controller does once the link is lost, {ms, action}; null: not known. ms is 0 while a command needs that. */
    get linkLoss() {
        return this.controller.unwatchedMs ? { ms: 0 } : (this.robot.device?.linkLoss ?? null);
    }

    /* True while a command of the console runs: values of the servos are old. */
    get isBusy() {
        return Boolean(this.wire?.isBusyWithText);
    }

    /* ---- connection ---- */

    /* As connect(), when the page loads. The previous page may still hold the port, so connectAtLoad() retries for
     * PORT_TAKEN_MS. The state stays `connecting` meanwhile. */
    async connectAtLoad(makePort) {
        const end = this.clock.now() + PORT_TAKEN_MS;

        while (this.clock.now() < end) {
            await this.connect(makePort(), { isPatient: true });
            if (!this.#isRetrying) return;
            const { wire } = this;

            await pause(this.clock, PORT_RETRY_MS);
            if (this.wire !== wire || this.state === "disconnected") return; // the user has connected, or disconnected
        }
        this.#isRetrying = false;
        this.#setState("disconnected");
        this.notify({ code: "port-taken" });
    }

    /* Opens the port and asks what the controller has. Never throws: a failure becomes a notice. With `isPatient` a
     * port that another client has gives no notice; the caller tries again. */
    async connect(port, { isPatient = false } = {}) {
        while (this.state !== "disconnected" && !this.#isRetrying) await this.disconnect(); // again if another connect() came between
        this.#clear(port, isPatient);
        const { wire, capture } = this;

        try {
            await wire.open();
            await this.#setUp();
            this.#setState("connected");
            if (isPatient && this.notices.some(isStopDue)) this.stop(); // the user pressed it before the port was there
            this.#tellFirmware();
            await this.robot.findServos();
            this.robot.start();
        } catch (error) {
            if (this.wire !== wire) return; // another connection has begun
            if (error.code !== "closed") this.notify(error);
            if (wire.state === "closed") this.#takeClose();
            else if (this.state === "connecting") await this.disconnect();
            else this.robot.start();
        } finally {
            capture.endStart();
        }
    }

    #takeClose() {
        if (!this.#isRetrying) this.#setState("disconnected");
    }

    /* The simulator tells that another client has it, then hangs up. The page closes the port first. */
    #takeTaken(wire, isPatient) {
        this.#isRetrying = this.isWaiting = isPatient;
        if (!isPatient) this.notify({ code: "port-taken" });
        wire.close();
    }

    /* Asks what the firmware has, again after a stop that came between. */
    async #setUp() {
        for (;;) {
            try {
                await this.controller.setUp();
                return;
            } catch (error) {
                if (error.code !== "stopped") throw error;
                await this.#stopping;
            }
        }
    }

    #clear(port, isPatient) {
        this.starts++;
        this.isWaiting &&= isPatient;
        this.portName = port.name ?? "";
        this.notices = this.notices.filter((notice) => notice.code === UNWATCHED || (isPatient && isStopDue(notice)));
        this.stopState = "none";
        this.#isRetrying = false;
        this.capture = new CapturePort(port);
        this.wire = new Wire(this.capture, { clock: this.clock });
        this.controller = new Controller(this.wire, this.tables);
        this.controller.onDone = (line) => this.takeDone(line);
        this.controller.onWatch = (code, ms) => {
            this.withdraw(["unwatched", UNWATCHED]);
            if (code) this.notify({ code, ms });
        };
        this.robot = new Robot(this.controller);
        this.history = new History(this.clock.now());
        this.#listen(this.wire, this.robot, isPatient);
        this.#setState("connecting");
    }

    async disconnect() {
        const { controller, robot, wire } = this;

        robot?.end();
        await wire?.close([...controller.takeLastPackets(), ...robot.endsOfTurns()]);
        if (this.wire === wire) this.#setState("disconnected");
    }

    #listen(wire, robot, isPatient) {
        const on = (target, name, call) =>
            target.addEventListener(name, (event) => this.wire === wire && call(event.detail));

        on(wire, "traffic", (entry) => this.#record(entry));
        on(wire, "text", (text) => {
            if (this.state === "connecting" && PORT_TAKEN.test(text)) this.#takeTaken(wire, isPatient);
            if (this.isConnected && BANNER.test(text)) this.#renew();
        });
        on(wire, "notice", (detail) => {
            if (detail.code === "back") this.withdraw(WITHDRAWN_BY.back);
            this.notify({ ...detail, ...this.linkLoss });
        });
        on(wire, "state", (state) => this.#follow(state));
        on(wire, "close", () => {
            robot.end();
            this.#takeClose();
        });
        on(robot, "feedback", () => {
            this.history.take(robot.servos.values(), this.clock.now());
            this.#staleAt = this.clock.now() + STALE_MS;
            this.#followStop();
            this.dispatchEvent(new Event("feedback"));
        });
        on(robot, "whole", () => this.#remove(({ code, id, number }) => code === "servo-silent" || number === ERROR_LINE_LOW || (code === "motion-ended" && !id))); // no servo answered
        on(robot, "change", () => {
            for (const id of robot.ids) this.seenIds.add(id);
            this.#change();
        });
        on(robot, "notice", (detail) => this.notify(detail));
        on(robot, "reset", () => this.#renew());
    }

    /* The controller was reset: it has another mode, and has forgotten stop and servos. */
    async #renew() {
        if (this.#isRenewing) return;
        const { controller, robot } = this;
        const mode = controller.modeBefore;

        this.#isRenewing = true;
        this.stopState = "none";
        robot.forget();
        controller.takeWatched(); // the saved value is in force
        this.notify({ code: "reset" });
        await this.attempt(async () => {
            await this.#setUp();
            controller.modeBefore ||= mode; // 0 is the mode of the page itself
            await robot.findServos();
        });
        this.#isRenewing = false;
        this.starts++;
        this.#change();
    }

    #follow(state) {
        if (this.isConnected && (state === "silent" || state === "ready"))
            this.#setState(state === "silent" ? "silent" : "connected");
        else this.#change();
    }

    #tellFirmware() {
        const { controller, wire } = this;

        if (controller.profile !== "full") this.notify({ code: controller.profile });
        if (controller.isOtherVersion)
            this.notify({ code: "other-version", version: controller.version, shown: controller.shownVersion });
        if (!wire.hasDevice) this.notify({ code: "no-device" });
    }

    /* ---- what a user does ---- */

    /* Stops the robot. Never throws; `stopState` is "verified" only when device and servos were asked. */
    stop() {
        const isReplay = this.state !== "disconnected" && this.capture.port.isReplay;

        if (isReplay || !this.wire || this.wire.state === "closed") {
            this.notify({ code: isReplay ? "stop-replay" : "stop-not-sent" });
            return Promise.resolve();
        }
        this.#stopping = this.#stop();
        return this.#stopping;
    }

    async #stop() {
        this.stopState = "stopping";
        const stop = this.wire.stop({ servos: this.robot.ids, isLineLow: this.robot.isLineLow }); // Ctrl-X leaves here, before anything that may fail

        this.robot.forgetGoals();
        this.#change();
        try {
            this.stopOutcome = await stop;
            this.stopState = stateOf(this.stopOutcome);
            this.robot.takeStop(this.stopOutcome);
            this.#staleAt = this.clock.now() + STALE_MS;
            this.#expireStop();
            if (this.stopState === "verified") this.withdraw(WITHDRAWN_BY.stop);
            if (this.stopState === "unverified") {
                const code = this.stopOutcome.inhibited ? "stop-unverified" : "stop-no-inhibit";

                this.notify({ code, ...this.stopOutcome });
            }
        } catch {
            this.stopState = "failed";
            this.notify({ code: "stop-failed" });
        }
        this.#change();
    }

    get #isStopShown() {
        return this.stopState === "verified" || this.stopState === "unchecked";
    }

    /* Nothing tells that a controller is dead while a long command has the wire: the confirmed stop expires. */
    #expireStop() {
        const left = this.#staleAt - this.clock.now();

        this.clock.cancel(this.#staleTimer); // of an earlier stop
        if (!this.#isStopShown) return;
        if (left > 0) {
            this.#staleTimer = this.clock.after(left, () => this.#expireStop());
        } else {
            this.stopState = "none";
            this.#change();
        }
    }

    /* That torque is off is told until it is on. What an inhibit has refused is told until its end, also if another program or a
     * line by hand ends it. A confirmed stop is shown only while feedback comes, INHIBIT reads 1, and the torque of each
     * servo reads 0. */
    #followStop() {
        const { robot } = this;

        this.notices = this.notices.filter(({ code, ids }) => code !== "motion-torque" || this.isInhibited || !ids.every((id) => robot.servos.get(id)?.torque));
        const isReleased = this.#wasInhibited && robot?.device?.inhibit === 0;

        this.#wasInhibited = robot?.device?.inhibit === 1;
        if (isReleased) this.withdraw(WITHDRAWN_BY.release);
        const isStopped = robot?.isInhibited && [...robot.servos.values()].every(({ torque }) => torque === false);

        if (isStopped && this.stopState === "unverified" && robot.servos.size) {
            this.stopState = "verified";
            this.withdraw(WITHDRAWN_BY.stop);
            this.#expireStop();
        }
        if (!this.#isStopShown) return;
        if (!isStopped || this.state === "silent" || this.state === "disconnected") this.stopState = "none";
    }

    /* Allows driving again. */
    async release() {
        await this.attempt(async () => {
            await this.controller.release();
            this.robot.takeRelease();
            this.withdraw(WITHDRAWN_BY.release);
            this.stopState = "none";
        });
    }

    /* The controller has released servo `id` alone. The notice goes when it has no other servo. */
    takeRelease(id) {
        const { servos } = this.robot;

        if (servos.has(id)) servos.get(id).inhibit = "";
        if (!this.isInhibited && [...servos.values()].every(({ inhibit }) => !inhibit)) this.withdraw(["inhibited", ERROR_INHIBITED]);
    }

    /* A command has succeeded: withdraws the notice that the same operation has failed. */
    takeDone(line) {
        if (isForgetting(line)) this.withdraw([ERROR_TOO_MANY, ERROR_NOT_NEW]);
        const done = operationOf(line);

        this.#remove(({ code, operation }) => code === "command" && operation === done);
    }

    /* The board has taken a motion, or plays one. */
    takeMotion() {
        this.withdraw(WITHDRAWN_BY.motion);
    }

    /* Runs `call`; a failure is a notice. Returns what `call` returns, or undefined. `input`: a name of what the user has
     * given. The notice that it was refused goes when it is given again. */
    async attempt(call, input) {
        try {
            const value = await call();

            if (input) this.#remove((notice) => notice.input === input);
            return value;
        } catch (error) {
            if (!this.#hasNoticeOfLoss(error)) this.notify(error, input);
            return undefined;
        } finally {
            this.#change();
        }
    }

    /* ---- notices and traffic ---- */

    /* A lost port fails all that waited, and has a notice of its own. */
    #hasNoticeOfLoss({ code }) {
        return code === "closed" && this.notices.some((shown) => LOST.has(shown.code));
    }

    /* Shows a notice: {code, ...}, or an error of wire, port, console or robot. The same notice again only
     * renews the one that is shown; one of another servo joins it. Information goes away by itself; warnings and errors
     * stay until they are dismissed or withdrawn. */
    notify(what, input) {
        const detail = what.name === "CommandError" ? this.#ofCommand(what) : { ...what, message: what.message };
        const code = detail.code ?? "unexpected";
        const isOfMany = LISTS_SERVOS.has(code);
        const key = `${code} ${isOfMany ? detail.why : detail.id ?? ""} ${detail.line ?? ""}`;
        const before = this.notices.find((shown) => shown.key === key)?.ids ?? [];
        const ids = isOfMany ? [...new Set([...before, ...(detail.ids ?? [detail.id])])].sort((one, other) => one - other) : detail.ids;
        const operation = operationOf(detail.line === undefined ? "" : String(detail.line));
        const notice = { key, input, code, id: detail.id, ids, operation, number: detail.number, time: this.clock.now(), undo: detail.undo, ...noticeText({ ...detail, code, ids }) };

        if (code === "unexpected") console.error(what);
        this.notices = withoutOldest(NOTICES_MAX, [...this.notices.filter((shown) => shown.key !== key && !(input && shown.input === input)), notice]);
        this.#followInfo();
        this.#change();
    }

    /* Removes the information whose time is over, and comes back when the next one is due. */
    #followInfo() {
        const left = (notice) => notice.time + msShown(notice) - this.clock.now();

        this.clock.cancel(this.#expiry);
        this.notices = this.notices.filter((notice) => left(notice) > 0);
        const next = Math.min(...this.notices.map(left));

        if (next < Infinity) this.#expiry = this.clock.after(next, () => (this.#followInfo(), this.#change()));
    }

    /* Removes the notices of these codes, and of these errors of the controller. */
    withdraw(codes) {
        this.#remove(({ code, number }) => codes.includes(code) || codes.includes(number));
    }

    #remove(isOver) {
        if (!this.notices.some(isOver)) return;
        this.notices = this.notices.filter((notice) => !isOver(notice));
        this.#followInfo();
        this.#change();
    }

    #ofCommand({ line, message, number, remedy }) {
        return { code: "command", line, message: line.startsWith("id ") ? message.replace("ID or rate", "ID") : message, number, remedy };
    }

    dismiss(notice) {
        this.#remove((shown) => shown === notice);
    }

    #record(entry) {
        this.dispatchEvent(new CustomEvent("traffic", { detail: this.traffic.take(entry) }));
        if (entry.direction !== "out") return;
        this.robot.note(entry);
        if (entry.kind === "line") this.#change(); // isBusy begins
    }

    #setState(state) {
        this.state = state;
        if (state === "disconnected") this.dispatchEvent(new Event("disconnect"));
        this.#change();
    }

    #change() {
        this.#followStop();
        this.dispatchEvent(new Event("change"));
    }
}

function stateOf({ verified, inhibited, off, on, silent }) {
    if (verified) return "verified";
    return inhibited && ![...off, ...on, ...silent].length ? "unchecked" : "unverified";
}

/* ms that a notice stays by itself. */
function msShown({ level, remedy, undo }) {
    if (level !== "info") return Infinity;
    return remedy || undo ? INFO_TO_DO_MS : INFO_MS;
}

/* The newest notices, without the oldest of the least level. Those about safety stay. */
function withoutOldest(count, notices) {
    const kept = [...notices];

    for (const rank of RANKS)
        while (kept.length > count) {
            const oldest = kept.findIndex(({ code, level }) => level === rank && !ABOUT_SAFETY.has(code));

            if (oldest < 0) break;
            kept.splice(oldest, 1);
        }
    return kept;
}
