// SPDX-License-Identifier: MIT
/* The servos as the page shows them. A loop reads feedback of all servos as fast as the wire allows, and
 * torque, goals, limits and the device in turn with it. Goals go out between two reads.
 *
 * A goal is ignored while the torque of its servo is not known to be on. A servo gets at most 20 goals a
 * second, each at most once; a goal that could not leave within 150 ms is dropped. The goal of a hold also waits for its
 * turn, at most 50 ms, and is never dropped. Torque is switched within 2 s or not at all.
 *
 * Events: `feedback` after each round, `whole` when all servos answer again, `change` when anything else has changed, `notice`, `reset` when the
 * controller has been reset: its RESET_CAUSE is another one, it echoes a line, or it has forgotten its servos. */

import { AT_INSTRUCTION, AT_PARAMETERS, ERRORS_OF_PACKET, FAILED, ID_MAX, INSTRUCTION, errorNames, syncRead, word, wordAt, write } from "../wire/packet.js";
import { DEVICE, REGISTER } from "../wire/registers.js";
import { groupsOfIds } from "../wire/stop.js";
import { pause } from "../wire/clock.js";
import { WireError } from "../wire/wire_error.js";
import { FEEDBACK, LIMITS, STATE } from "./blocks.js";
import { LISTED_MAX, ORDER_MS } from "./controller.js";
import { Failure, parametersOf, readRegisters, writeRegisters } from "./registers.js";
import { Servo } from "./servo.js";
import { RAW_MAX, rawOfDegrees, rawOfRpm, rawOfTurn } from "./units.js";

export const GOAL_RPM = 20; // speed of a goal, if none is given
export const GOAL_PERIOD_MS = 50; // between two goals of a servo
export const GOAL_AGE_MS = 150; // an older goal is dropped

const HOLD_MS = 500; // so long a newer goal waits for the end of a hold; then its age counts
const POSITION_MS = 200; // from the last look at the position to torque on, or to the goal of a hold
const TORQUE_TRIES = 3;
const MOVED_RAW = 17; // 5 degrees
const ROUND_MS = 10; // a faster round would only cost CPU time
const PAUSE_MS = 100; // after an error of the wire
const AWAY_MS = 500; // a servo that was silent for longer has been away
const SLOW_MS = 250; // torque and goals, the device, the motion
const LIMITS_MS = 1000;
const TEXT_MS = 5000; // the command `servos`
const TEXT_ALARM_MS = 1000; // while something is wrong
const RATE_MS = 1000; // over which updates are counted
const POSITION_AT = REGISTER.PRESENT_POSITION - REGISTER.GOAL_POSITION; // in a read from GOAL_POSITION on
const DEVICE_FIRST = DEVICE.LINK_LOSS_ACTION;
const MOTION_COUNT = 6;
const LINE_LOW = 2; // BUS_STATE of the device

const CHANGES_SERVO = /^(scan|new|set|id|baud)\b/; // lines of the page

export class Robot extends EventTarget {
    #wire;
    #controller;
    #clock;
    #isRunning = false;
    #goals = new Map(); // goals that wait, by servo ID: {raw, speed, at, since}; since: the first goal that this one replaces
    #goalSentAt = new Map(); // time of the last goal, by servo ID
    #holds = new Map(); // hold under way, by servo ID: {promise, since}
    #turning = new Set(); // IDs of servos that setTurn() turns, until they have confirmed the end
    #modes = new AbortController(); // another one as soon as a servo may have begun or ended endless turn
    #stops = 0; // counts the stops and resets: a hold from before one does nothing
    #torqueOrders = new Map(); // newest torque command, by servo ID
    #due = new Map(); // time of the next slow read, by its name
    #rounds = []; // times of the last feedback
    #wholeAt = Infinity; // time when all servos last answered
    #isListed = false; // the command `servos` has listed servos

    constructor(controller) {
        super();
        this.#controller = controller;
        this.#wire = controller.wire;
        this.#clock = controller.wire.clock;
        this.servos = new Map(); // servos by ID, in the order of IDs
        this.device = null; // {linkLoss, saving, busState, resetCause, linkLost, alarms, alarmId, failed, inhibit}; null: not known
        this.motion = null; // {play, override, paused, state, step, error}; null: the firmware has none
    }

    /* Called for each line and packet that is sent. After `scan` or `servos forget` an empty list of servos does not mean a
     * reset. What a user sends, and what changes a servo, may begin or end endless turn: goals that wait are dropped. */
    note({ source, text, bytes }) {
        if (/^\s*(scan|servos\s+forget)\b/i.test(text)) this.#isListed = false;
        const isWrite = bytes[AT_INSTRUCTION] === INSTRUCTION.WRITE && bytes[AT_PARAMETERS] < REGISTER.TORQUE_ENABLE;

        if (source !== "hand" && !isWrite && !CHANGES_SERVO.test(text)) return;
        this.#modes.abort();
        this.#modes = new AbortController();
        this.#due.delete("limits");
    }

    get ids() {
        return [...this.servos.keys()];
    }

    /* Number of servos that answer, or were not asked yet. */
    get answering() {
        return [...this.servos.values()].filter(({ presence }) => presence !== "offline").length;
    }

    get #online() {
        return this.ids.filter((id) => this.servos.get(id).presence === "online");
    }

    /* Feedback of all servos a second. */
    get rate() {
        const since = this.#clock.now() - RATE_MS;

        return this.#rounds.filter((time) => time > since).length;
    }

    get isInhibited() {
        return this.device?.inhibit === 1;
    }

    get isLineLow() {
        return this.device?.busState === LINE_LOW;
    }

    /* Shows these servos; what is known of a servo that stays is kept. A damaged line may have named an ID that no
     * servo can have. At the ID of the device the page reads the device, not the servo. */
    setServos(ids) {
        const own = this.#wire.hasDevice ? this.#wire.deviceId : null;

        if (ids.includes(own)) this.#notice({ code: "servo-behind-device", id: own });
        const sorted = [...new Set(ids)].filter((id) => id <= ID_MAX && id !== own).sort((one, other) => one - other);

        this.servos = new Map(sorted.map((id) => [id, this.servos.get(id) ?? new Servo(id)]));
        this.#goals = new Map([...this.#goals].filter(([id]) => this.servos.has(id)));
        this.#due.clear();
        this.#change();
    }

    /* Finds servos: those that the controller knows, else by a scan. `more`: IDs that take the place of the scan. */
    async findServos({ more, ...options } = {}) {
        const known = options.how === undefined ? await this.#knownServos() : [];

        if (known.length || more) {
            if (known.length >= LISTED_MAX && this.#wire.hasDevice) known.push(...(more ?? (await this.#unlisted())));
            this.setServos(known);
            return;
        }
        const found = [];

        await this.#controller.scan({ ...options, onFound: (servo) => {
            found.push(servo.id);
            options.onFound?.(servo);
        } });
        this.setServos(found);
    }

    /* IDs of the servos that answer; the console lists 18. */
    async #unlisted() {
        const ids = [];

        await this.#controller.scanByPackets({ onFound: ({ id }) => ids.push(id) });
        return ids;
    }

    async #knownServos() {
        if (!this.#wire.hasConsole) return [];
        const lines = await this.#controller.run("servos");

        return lines.map((line) => /^servo (\d+):/.exec(line)).filter((match) => match).map((match) => Number(match[1]));
    }

    start() {
        if (this.#isRunning) return;
        this.#isRunning = true;
        this.#run();
    }

    end() {
        this.#isRunning = false;
    }

    /* A stop has begun: no goal may leave any more, and the torque of no servo is known. */
    forgetGoals() {
        this.#stops++;
        this.dropGoals([...this.#goals.keys()]);
        this.#turning.clear();
        for (const servo of this.servos.values()) servo.torque = null;
        this.#change();
    }

    /* The controller was reset: nothing is known of it and of the servos, but their IDs. */
    forget() {
        this.device = null;
        this.motion = null;
        this.#isListed = false;
        this.servos = new Map(this.ids.map((id) => [id, new Servo(id)]));
        this.#due.clear();
        this.forgetGoals();
    }

    /* The outcome of a stop. */
    takeStop({ inhibited, off, on }) {
        if (inhibited) this.device = { ...this.device, inhibit: 1 };
        for (const id of off) if (this.servos.has(id)) this.servos.get(id).torque = false;
        for (const id of on) if (this.servos.has(id)) this.servos.get(id).torque = true;
        this.#due.clear();
        this.#change();
    }

    /* The controller has ended the inhibit. */
    takeRelease() {
        if (this.device) this.device.inhibit = 0;
        for (const servo of this.servos.values()) servo.inhibit = "";
    }

    /* ---- what a user does ---- */

    /* Sends the servo to `degrees` soon. False: ignored, since torque is off, not known, or driving is
     * inhibited. */
    setGoal(id, degrees, rpm = GOAL_RPM) {
        return this.#offerGoal(id, { raw: rawOfDegrees(degrees), speed: rawOfRpm(rpm) });
    }

    /* For how long no goal of these servos could leave, though there were newer ones again and again, in ms. */
    waitOfGoals(ids) {
        const waits = ids.map((id) => this.#goals.get(id)).filter((goal) => goal).map(({ since }) => this.#clock.now() - since);

        return Math.max(0, ...waits);
    }

    /* Goals of these servos that wait are not sent. */
    dropGoals(ids) {
        for (const id of ids) if (this.#goals.delete(id)) this.servos.get(id).goalState = "dropped";
    }

    /* Turns a servo in endless turn: more than 0 is counterclockwise. False: ignored, as by setGoal(). hold()
     * ends the turn. */
    setTurn(id, rpm) {
        const isTaken = this.#offerGoal(id, { raw: null, speed: rawOfTurn(rpm) });

        if (isTaken) this.#turning.add(id);
        return isTaken;
    }

    /* Packets that end the turns of setTurn(). */
    endsOfTurns() {
        return [...this.#turning].map((id) => write(id, REGISTER.MOVING_SPEED, word(0)));
    }

    #offerGoal(id, goal) {
        const servo = this.servos.get(id);

        if (!servo || servo.torque !== true || this.isInhibited || this.#wire.state !== "ready") return false;
        const now = this.#clock.now();

        this.#goals.set(id, { ...goal, at: now, since: this.#goals.get(id)?.since ?? now });
        servo.goalState = "waiting";
        return true;
    }

    /* Ends a movement: the goal becomes the present position; in endless turn the speed becomes 0. Unlike
     * another goal it is never dropped: it waits for a controller that does not answer. Another hold of the servo meanwhile
     * is this one. Does nothing while torque is off, or if a stop comes first. */
    hold(id) {
        this.#goals.delete(id);
        if (!this.#holds.has(id)) {
            const promise = this.#hold(id).finally(() => this.#endHold(id));

            this.#holds.set(id, { promise, since: this.#clock.now() });
        }
        return this.#holds.get(id).promise;
    }

    /* A goal that came meanwhile follows the hold: its age counts from now on. */
    #endHold(id) {
        const goal = this.#goals.get(id);

        if (goal && this.#isBehindHold(id)) goal.at = this.#clock.now();
        this.#holds.delete(id);
    }

    #isBehindHold(id) {
        return this.#clock.now() - (this.#holds.get(id)?.since ?? -Infinity) <= HOLD_MS;
    }

    /* A servo that does not answer is asked twice: the first packet may have met a controller that did not answer. */
    async #hold(id) {
        const stops = this.#stops;
        const wait = this.#waitOf(id);

        if (wait > 0) await pause(this.#clock, wait);
        for (let tries = 2; ; await this.#wire.whenReady()) {
            const servo = this.servos.get(id);

            if (!servo || servo.torque === false || stops !== this.#stops) return;
            try {
                await this.#endMovement(servo);
                return;
            } catch (error) {
                if (error.code === "stopped") return;
                servo.goalState = "unconfirmed";
                if (error.code === "servo-silent") tries--;
                if (tries && /silent$/.test(error.code)) continue;
                if (!tries && !servo.isEndless && (await this.#isServoInhibited(id))) return;
                throw servo.isEndless ? new Failure("turn-not-ended", { id }) : error;
            }
        }
    }

    async #endMovement(servo) {
        try {
            await this.#knowsMode(servo);
            if (servo.isEndless) await writeRegisters(this.#wire, servo.id, REGISTER.MOVING_SPEED, word(0));
            else await this.#holdWithin(servo);
        } finally {
            this.#goalSentAt.set(servo.id, this.#clock.now());
        }
        if (this.#goals.has(servo.id)) return;
        servo.goalState = "confirmed";
        this.#turning.delete(servo.id);
    }

    /* Time until the servo may get another goal, in ms. */
    #waitOf(id) {
        return (this.#goalSentAt.get(id) ?? -Infinity) + GOAL_PERIOD_MS - this.#clock.now();
    }

    /* If the write would leave late, the position is old: it is read again. Torque may have gone off meanwhile. */
    async #holdWithin(servo) {
        const block = await readRegisters(this.#wire, servo.id, REGISTER.TORQUE_ENABLE, FEEDBACK.address + 2 - REGISTER.TORQUE_ENABLE);

        if (!block[0]) return;
        const position = wordAt(block, FEEDBACK.address - REGISTER.TORQUE_ENABLE);
        const raw = Math.min(Math.max(position, servo.raw.low ?? 0), servo.raw.high ?? RAW_MAX);

        const bytes = [...word(raw), ...word(servo.raw.goalSpeed || rawOfRpm(GOAL_RPM))];

        try {
            await writeRegisters(this.#wire, servo.id, REGISTER.GOAL_POSITION, bytes, { notAfter: this.#clock.now() + POSITION_MS });
            servo.raw.goal = raw;
        } catch (error) {
            if (error.code !== "late") throw error;
            await this.#holdWithin(servo);
        }
    }

    /* Switches torque. On: the goal becomes the present position first, and is read back, so nothing
     * moves. It is dropped if other commands have the wire for 2 s. A later command for the same servo cancels this one.
     * Throws Failure or WireError. */
    setTorque(id, isOn) {
        return this.#switchTorque(id, isOn, this.#orderTorque([id]));
    }

    #orderTorque(ids) {
        const order = Symbol();

        for (const id of ids) this.#torqueOrders.set(id, order);
        return order;
    }

    async #switchTorque(id, isOn, order) {
        const isCancelled = () => this.#torqueOrders.get(id) !== order;

        if (isCancelled()) return;
        this.#goals.delete(id);
        if (isOn && this.isInhibited) throw new Failure("inhibited", { id });
        try {
            if (isOn) await this.#torqueOn(id, isCancelled);
            else await this.#writeTorque(id, 0, this.#clock.now() + ORDER_MS);
        } catch (error) {
            if (isOn && error.code === "servo-silent" && (await this.#isServoInhibited(id))) throw new Failure("inhibited", { id });
            throw error.code === "late" ? new Failure(isOn ? "torque-on-late" : "torque-off-late", { id }) : error;
        }
        if (isCancelled()) return; // torque off takes one packet, and overtakes torque on
        const servo = this.servos.get(id);

        if (servo) servo.torque = isOn;
        this.#change();
    }

    /* True if the controller inhibits this servo, so that it does not send a packet that drives it. Asks the controller:
     * the inhibit may be newer than the last reply of `servos`. */
    async #isServoInhibited(id) {
        await this.#readText().catch(() => {}); // what is known already must do
        const servo = this.servos.get(id);

        return Boolean(servo?.inhibit) && servo.presence !== "offline";
    }

    /* Switches torque of `ids`, or of all servos that are online, one after the other. `keepsGoals`: a servo that
     * has torque keeps its goal. A servo that fails is told by onError(error), and the others go on; a stop, a
     * lost port, or a command that has the wire for 2 s ends it. */
    async setTorqueAll(isOn, onError, { ids = this.#online, keepsGoals = false } = {}) {
        const order = this.#orderTorque(ids);

        for (const [index, id] of ids.entries()) {
            if (isOn && keepsGoals && this.servos.get(id)?.torque === true) continue;
            try {
                await this.#switchTorque(id, isOn, order);
            } catch (error) {
                if (["stopped", "closed", "silent"].includes(error.code)) throw error;
                if (/^torque-.*late$/.test(error.code) || (error.code === "inhibited" && this.isInhibited)) throw new Failure(error.code, { ids: ids.slice(index) });
                onError(error);
            }
        }
    }

    /* Clears the alarms that the controller has kept. It never ends an inhibit, as the command `clear` would. */
    async clearAlarms() {
        if (this.#wire.hasDevice) await this.#controller.writeDevice(DEVICE.ALARMS, [0]);
        else if ((await this.#controller.run("status")).includes("driving: allowed")) await this.#controller.order("clear");
        else throw new Failure("clear-inhibited");
        this.#due.delete("device");
        this.#due.delete("text");
    }

    #writeTorque(id, value, notAfter) {
        return writeRegisters(this.#wire, id, REGISTER.TORQUE_ENABLE, [value], { notAfter });
    }

    /* Begins again with the position if the joint was moved meanwhile, or if another job came before torque on. */
    async #torqueOn(id, isCancelled) {
        const end = this.#clock.now() + ORDER_MS;

        for (let left = TORQUE_TRIES; left; left--) {
            const isHeld = await this.#holdPosition(id, end);

            if (isCancelled()) return;
            if (!isHeld) continue;
            try {
                await this.#writeTorque(id, 1, Math.min(this.#clock.now() + POSITION_MS, end));
                return;
            } catch (error) {
                if (error.code !== "late" || left === 1) throw error;
            }
        }
        throw new Failure("joint-moves", { id });
    }

    /* Limits and goal are read first: the controller checks a servo with limits by them. The last read has the goal and
     * the position. False: the joint is elsewhere by then. */
    async #holdPosition(id, notAfter) {
        const limits = await readRegisters(this.#wire, id, LIMITS.address, LIMITS.count, { notAfter });
        const isEndless = limits.every((byte) => byte === 0);
        const position = Math.min(wordAt(await readRegisters(this.#wire, id, FEEDBACK.address, 2, { notAfter }), 0), RAW_MAX);
        const wanted = [...word(position), ...word(isEndless ? 0 : rawOfRpm(GOAL_RPM))];

        await writeRegisters(this.#wire, id, REGISTER.GOAL_POSITION, wanted, { notAfter });
        const kept = await readRegisters(this.#wire, id, REGISTER.GOAL_POSITION, POSITION_AT + 2, { notAfter });

        if (wanted.some((byte, index) => byte !== kept[index])) throw new Failure("goal-not-kept", { id });
        return isEndless || Math.abs(Math.min(wordAt(kept, POSITION_AT), RAW_MAX) - position) <= MOVED_RAW;
    }

    /* ---- the loop ---- */

    async #run() {
        while (this.#isRunning) {
            const begun = this.#clock.now();

            try {
                await this.#round();
                await this.#wait(begun);
            } catch (error) {
                if (!(error instanceof WireError) && error.name !== "CommandError") this.#notice(error);
                if (error.code === "closed") this.end();
                this.#due.delete("text"); // it tells whether the controller was reset
                await pause(this.#clock, PAUSE_MS);
            }
        }
    }

    #wait(begun) {
        const left = begun + ROUND_MS - this.#clock.now();

        return left > 0 ? pause(this.#clock, left) : null;
    }

    async #round() {
        await this.#sendGoals();
        await this.#readAll(FEEDBACK, (servo, bytes) => servo.takeFeedback(bytes, this.#clock.now()));
        this.#countRound();
        this.dispatchEvent(new Event("feedback"));
        this.#tellWhole();
        await this.#sendGoals();
        await this.#readSlowly();
    }

    #countRound() {
        const now = this.#clock.now();

        if (this.servos.size) this.#rounds.push(now);
        while (this.#rounds[0] <= now - RATE_MS) this.#rounds.shift();
    }

    /* A single lost reply does not count: on a line with noise the notices would go at once. */
    #tellWhole() {
        const now = this.#clock.now();

        if (this.answering < this.servos.size) return;
        if (now - this.#wholeAt > AWAY_MS) this.dispatchEvent(new Event("whole"));
        this.#wholeAt = now;
    }

    /* Reads a block of all servos. A servo that failed has bytes FF. */
    async #readAll({ address, count }, take) {
        for (const group of groupsOfIds(this.ids, count)) {
            const parameters = parametersOf(this.#wire.deviceId, await this.#wire.request(syncRead(address, count, group)));

            group.forEach((id, index) => {
                const bytes = parameters.slice(index * count, (index + 1) * count);
                const servo = this.servos.get(id);

                if (!servo) return; // the list has changed
                if (bytes.every((byte) => byte === FAILED)) this.#failed(servo);
                else take(servo, bytes);
            });
        }
    }

    #failed(servo) {
        if (servo.presence !== "offline") this.#due.delete("text");
        servo.presence = "offline";
        servo.torque = null;
    }

    /* One slow read a round, so that feedback stays even. */
    async #readSlowly() {
        const reads = {
            state: [SLOW_MS, () => this.#readAll(STATE, (servo, bytes) => servo.takeState(bytes))],
            device: [SLOW_MS, () => this.#readDevice()],
            motion: [SLOW_MS, () => this.#readMotion()],
            limits: [LIMITS_MS, () => this.#readAll(LIMITS, (servo, bytes) => this.#takeLimits(servo, bytes))],
            text: [this.#isWell() ? TEXT_MS : TEXT_ALARM_MS, () => this.#readText()],
        };
        const now = this.#clock.now();

        for (const [name, [period, call]] of Object.entries(reads)) {
            if (now < (this.#due.get(name) ?? -Infinity)) continue;
            this.#due.set(name, now + period);
            await call();
            this.#change();
            return;
        }
    }

    /* State is read before limits. */
    #takeLimits(servo, bytes) {
        const isNew = servo.low === null;

        servo.takeLimits(bytes);
        if (isNew && servo.isEndless && servo.torque && servo.goalSpeed) this.#notice({ code: "turning", id: servo.id });
    }

    #isWell() {
        const { device } = this;

        return !device?.alarms && !device?.inhibit && [...this.servos.values()].every((servo) => servo.presence === "online");
    }

    async #readDevice() {
        if (!this.#wire.hasDevice) return;
        const bytes = await this.#controller.readDevice(DEVICE_FIRST, DEVICE.INHIBIT - DEVICE_FIRST + 1);
        const [saving, busState, resetCause, linkLost, alarms, alarmId, failed, inhibit] = bytes.slice(DEVICE.SAVE - DEVICE_FIRST);
        const before = this.device;

        const linkLoss = { ms: wordAt(bytes, 1), action: bytes[0] };

        this.device = { linkLoss, saving, busState, resetCause, linkLost, alarms, alarmId, failed, inhibit };
        if (before?.resetCause !== undefined && before.resetCause !== resetCause) this.#tellReset();
        if (before?.alarms !== alarms || before?.inhibit !== inhibit) this.#due.delete("text");
    }

    async #readMotion() {
        if (!this.#controller.hasMotion) return;
        const [play, override, paused, state, step, error] =
            await this.#controller.readDevice(DEVICE.MOTION_PLAY, MOTION_COUNT);

        this.motion = { play, override, paused, state, step, error };
    }

    /* The command `servos` tells inhibits and alarms of each servo. */
    async #readText() {
        if (!this.#wire.hasConsole || !this.servos.size) return;
        const { hasOwnMode } = this.#controller;
        const lines = await this.#controller.run("servos");
        const matches = lines.map((line) => /^servo (\d+): (.*)$/.exec(line)).filter((match) => match);
        const isEchoed = lines.includes("servos") && hasOwnMode && this.#controller.hasOwnMode;
        const isForgotten = this.#isListed && !matches.length;

        this.#isListed = matches.length > 0;
        for (const [, id, text] of matches) this.servos.get(Number(id))?.takeLine(text);
        if (isEchoed || isForgotten) this.#tellReset();
    }

    #tellReset() {
        this.dispatchEvent(new Event("reset"));
    }

    /* ---- goals ---- */

    async #sendGoals() {
        for (const [id, goal] of [...this.#goals]) {
            const now = this.#clock.now();
            const servo = this.servos.get(id);

            if (this.#goals.get(id) !== goal) continue; // a stop has dropped it, or a newer one waits
            if (this.#isBehindHold(id)) continue;
            const isOld = now - goal.at > GOAL_AGE_MS;

            if (!isOld && (this.#holds.has(id) || this.#waitOf(id) > 0 || !(await this.#knowsMode(servo)))) continue;
            if (this.#goals.get(id) !== goal) continue; // as above, meanwhile
            this.#goals.delete(id);
            if (servo.torque !== true || isOld || servo.isEndless !== (goal.raw === null)) {
                servo.goalState = "dropped";
                continue;
            }
            this.#goalSentAt.set(id, now);
            await this.#sendGoal(servo, goal);
        }
    }

    /* Reads whether the servo turns without end, unless it is known. False: the next round reads it again. */
    async #knowsMode(servo) {
        const modes = this.#modes;

        if (servo.modes === modes) return true;
        try {
            this.#takeLimits(servo, await readRegisters(this.#wire, servo.id, LIMITS.address, LIMITS.count));
            servo.modes = modes;
        } catch (error) {
            if (error instanceof WireError) throw error;
        }
        return modes === this.#modes && servo.modes === modes;
    }

    /* Sends the goal once. Without an answer it is shown as not confirmed. */
    async #sendGoal(servo, { raw, speed, at }) {
        const bytes =
            raw === null
                ? write(servo.id, REGISTER.MOVING_SPEED, word(speed))
                : write(servo.id, REGISTER.GOAL_POSITION, [...word(raw), ...word(speed)]);

        try {
            const { error } = await this.#wire.request(bytes, { notAfter: at + GOAL_AGE_MS, signal: this.#modes.signal });

            if (error & ERRORS_OF_PACKET) this.#goalFailed(servo, "refused", errorNames(error & ERRORS_OF_PACKET).join(", "));
            else this.#goalTaken(servo, raw, speed);
        } catch (error) {
            if (error.code === "timeout") this.#goalFailed(servo, "unconfirmed");
            else servo.goalState = "dropped";
            if (!["timeout", "late", "cancelled"].includes(error.code)) throw error;
        }
    }

    #goalTaken(servo, raw, speed) {
        if (raw !== null) servo.raw.goal = raw;
        servo.raw.goalSpeed = speed;
        if (!this.#goals.has(servo.id)) servo.goalState = "confirmed";
    }

    #goalFailed(servo, state, why = "") {
        servo.goalState = state;
        this.#notice({ code: `goal-${state}`, id: servo.id, why });
    }

    #notice(detail) {
        this.dispatchEvent(new CustomEvent("notice", { detail }));
    }

    #change() {
        this.dispatchEvent(new Event("change"));
    }
}
