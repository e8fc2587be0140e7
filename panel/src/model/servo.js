// SPDX-License-Identifier: MIT
/* What the page knows of one servo. Register values are raw; the getters give units. null: not known. */

import { FEEDBACK_OFFSET, STATE_OFFSET, LIMITS_OFFSET } from "./blocks.js";
import { degreesOf, percentOf, rpmOf, voltsOf } from "./units.js";
import { wordAt } from "../wire/packet.js";

export const OLD_MS = 500; // values that are older are shown as old

export class Servo {
    constructor(id) {
        this.id = id;
        this.presence = "unknown"; // unknown, online, offline
        this.torque = null;
        this.led = null;
        this.inhibit = ""; // "", stopped, host (its link was lost), lost (its own state)
        this.alarms = []; // names of conditions
        this.hasOtherRate = false; // not at the rate of the bus
        this.raw = {}; // position, speed, load, voltage, temperature, goal, goalSpeed, low, high
        this.goalState = "none"; // none, waiting, confirmed, unconfirmed, dropped, refused
        this.updatedAt = -Infinity; // ms of the clock, of the last feedback
    }

    get position() {
        return this.#value("position", degreesOf);
    }

    get speed() {
        return this.#value("speed", rpmOf);
    }

    get load() {
        return this.#value("load", percentOf);
    }

    get voltage() {
        return this.#value("voltage", voltsOf);
    }

    get temperature() {
        return this.#value("temperature", (raw) => raw);
    }

    get goal() {
        return this.#value("goal", degreesOf);
    }

    get goalSpeed() {
        return this.#value("goalSpeed", rpmOf);
    }

    get low() {
        return this.#value("low", degreesOf);
    }

    get high() {
        return this.#value("high", degreesOf);
    }

    /* Endless turn: both angle limits are 0. */
    get isEndless() {
        return this.raw.low === 0 && this.raw.high === 0;
    }

    isOld(now) {
        return now - this.updatedAt > OLD_MS;
    }

    #value(name, convert) {
        return this.raw[name] === undefined ? null : convert(this.raw[name]);
    }

    /* Takes the 8 bytes from PRESENT_POSITION on. */
    takeFeedback(bytes, now) {
        this.raw.position = wordAt(bytes, FEEDBACK_OFFSET.position);
        this.raw.speed = wordAt(bytes, FEEDBACK_OFFSET.speed);
        this.raw.load = wordAt(bytes, FEEDBACK_OFFSET.load);
        this.raw.voltage = bytes[FEEDBACK_OFFSET.voltage];
        this.raw.temperature = bytes[FEEDBACK_OFFSET.temperature];
        this.presence = "online";
        this.updatedAt = now;
    }

    /* Takes the 10 bytes from TORQUE_ENABLE on. */
    takeState(bytes) {
        this.torque = { 0: false, 1: true }[bytes[STATE_OFFSET.torque]] ?? null;
        this.led = bytes[STATE_OFFSET.led] === 1;
        this.raw.goal = wordAt(bytes, STATE_OFFSET.goal);
        this.raw.goalSpeed = wordAt(bytes, STATE_OFFSET.speed);
    }

    /* Takes the 4 bytes from CW_ANGLE_LIMIT on. */
    takeLimits(bytes) {
        this.raw.low = wordAt(bytes, LIMITS_OFFSET.low);
        this.raw.high = wordAt(bytes, LIMITS_OFFSET.high);
    }

    /* Takes a line of the command `servos`: "servo 1: online, torque on, inhibited: stopped, alarms: range". */
    takeLine(text) {
        this.hasOtherRate = text.startsWith("not at the rate");
        this.inhibit = /inhibited: (\w+)/.exec(text)?.[1] ?? "";
        this.alarms = /alarms: (.*)$/.exec(text)?.[1].split(" + ") ?? [];
    }
}
