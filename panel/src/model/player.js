// SPDX-License-Identifier: MIT
/* Plays a path from the page: first all servos go to the start of the path together, then each gets at most 20 goals a
 * second, each with the speed that leads to it. A goal is never sent late: if the page is held up, if a command has the
 * wire, or if a stop comes, the replay ends and the servos stay at their last goals.
 *
 * Works with each firmware, since it needs packets only. */

import { pause } from "../wire/clock.js";
import { GOAL_PERIOD_MS } from "./robot.js";
import { MotionError } from "./motions.js";
import { degreesOf, RPM_MAX } from "./units.js";

export const TICK_MS = GOAL_PERIOD_MS;
export const AHEAD_MS = 100; // a goal is where the servo shall be so much later

const RPM = 20; // on the way to the start
const ARRIVED_RAW = 7; // 2 degrees
const ARRIVE_MS = 2000; // beyond the time that the way takes
const LATE_MS = 400; // a page that is held up for longer ends the replay
const BUSY_MS = 600; // goals that could not leave for longer end the replay; the command "servos" takes 300 ms at 19200 bit/s
const RESERVE = 1.15; // of the speed: a servo that lags catches up
const RPM_PER_SPEED = 1000 / 6; // rpm of a degree in a ms

/* Why these servos take no goal. */
export function torqueError(robot, ids) {
    const servos = ids.map((id) => robot.servos.get(id) ?? {});
    const silent = ids.filter((_, index) => servos[index].presence === "offline");

    if (silent.length) return new MotionError("servo-silent", { ids: silent });
    return new MotionError("motion-torque", { ids, names: new Set(servos.flatMap(({ alarms = [] }) => alarms)), isInhibited: servos.some(({ inhibit }) => inhibit) });
}

export class Player {
    #session;
    #isEnding = false;
    #tick = 0; // when `time` was true

    constructor(session) {
        this.#session = session;
        this.state = "idle"; // idle, begin (the servos go to the start of the path), playing
        this.time = 0; // of the path, ms
        this.percent = 100; // of the speed
        this.isPaused = false;
        this.samples = []; // where the servos were: {t, raw}
    }

    get isPlaying() {
        return this.state !== "idle";
    }

    /* Ends what plays: with the next tick the goal of each servo becomes its present position. */
    end() {
        this.#isEnding = true;
    }

    /* Sends servos to `positions` (Map of ID to raw) so that all arrive together, and waits until they are
     * there. Throws MotionError. False: ended. */
    async goTo(positions) {
        if (this.isPlaying) throw new MotionError("motion-playing");
        this.#begin();
        try {
            return await this.#goTo(positions);
        } finally {
            this.#change("idle");
        }
    }

    /* Plays `path` once. Throws MotionError. False: ended by end() or by the user's Stop. */
    async play(path) {
        if (this.isPlaying) throw new MotionError("motion-playing");
        this.#begin();
        try {
            const start = path.at(0);

            if (!(await this.#goTo(new Map(path.ids.map((id, index) => [id, Math.round(start[index])]))))) return false;
            this.#change("playing");
            return await this.#follow(path);
        } finally {
            this.#change("idle");
        }
    }

    #begin() {
        this.#isEnding = false;
        this.isPaused = false;
        this.samples = [];
        this.time = 0;
        this.#change("begin");
    }

    #change(state) {
        this.state = state;
        this.#session.dispatchEvent(new Event("change"));
    }

    get #clock() {
        return this.#session.clock;
    }

    /* The user has pressed Stop, which tells its own state. */
    get #isStopped() {
        const { robot, stopState } = this.#session;

        return stopState === "stopping" || (stopState !== "none" && robot.isInhibited);
    }

    /* Throws unless each servo of `ids` takes goals. */
    #check(ids) {
        const { robot } = this.#session;

        if (!this.#session.isConnected) throw new MotionError("closed");
        if (robot.isInhibited || this.#session.stopState === "stopping") throw new MotionError("motion-inhibited");
        const off = ids.filter((id) => robot.servos.get(id)?.torque !== true);

        if (off.length) throw torqueError(robot, off);
        const endless = ids.filter((id) => robot.servos.get(id).isEndless);

        if (endless.length) throw new MotionError("motion-endless", { ids: endless });
        if (robot.motion?.state) throw new MotionError("motion-playing");
    }

    #goal(id, raw, rpm) {
        if (this.#session.robot.setGoal(id, degreesOf(raw), Math.min(RPM_MAX, rpm))) return;
        if (this.#session.wire.state !== "ready") throw new MotionError("silent");
        throw torqueError(this.#session.robot, [id]);
    }

    async #goTo(positions) {
        const { robot } = this.#session;
        const ids = [...positions.keys()];

        this.#check(ids);
        this.#session.takeMotion();
        const ways = ids.map((id) => degreesOf(Math.abs(positions.get(id) - robot.servos.get(id).raw.position)));
        const ms = (Math.max(...ways) / RPM) * RPM_PER_SPEED;
        const begun = this.#clock.now();
        const end = begun + ms + ARRIVE_MS;
        const send = (id, index) => this.#goal(id, positions.get(id), (ways[index] / Math.max(ms, TICK_MS)) * RPM_PER_SPEED);

        ids.forEach(send);
        for (;;) {
            const away = ids.filter((id) => Math.abs(robot.servos.get(id)?.raw.position - positions.get(id)) > ARRIVED_RAW);

            if (this.#isStopped) return false;
            if (!away.length) return true;
            if (this.#isEnding) return this.#rest(ids);
            this.#check(ids);
            if (this.#isHeldUp(ids)) throw this.#busy(ids);
            ids.forEach((id, index) => {
                if (robot.servos.get(id).goalState !== "dropped") return; // at a low rate the last of many goals may be too old
                if (this.#clock.now() > begun + BUSY_MS) throw this.#busy(ids);
                send(id, index);
            });
            if (this.#clock.now() > end) throw new MotionError("motion-not-there", { ids: away });
            await pause(this.#clock, TICK_MS);
        }
    }

    #isHeldUp(ids) {
        return this.#session.robot.waitOfGoals(ids) > BUSY_MS;
    }

    /* No goal may leave behind what held it up: the servo would make up for the time at once. */
    #busy(ids) {
        this.#session.robot.dropGoals(ids);
        return new MotionError("late");
    }

    /* The servos stay where they are. */
    #rest(ids) {
        const { robot } = this.#session;

        for (const id of ids) {
            const servo = robot.servos.get(id);

            if (servo?.torque === true) robot.setGoal(id, servo.position);
        }
        return false;
    }

    async #follow(path) {
        const { robot } = this.#session;
        const onFeedback = () => this.#sample(path.ids);
        let sent = { raw: path.at(0).map(Math.round), time: 0 };

        this.#tick = this.#clock.now();
        robot.addEventListener("feedback", onFeedback);
        try {
            while (!this.#isOver(path)) {
                await pause(this.#clock, TICK_MS);
                if (this.#isStopped) return false;
                this.#check(path.ids);
                if (this.#isEnding) return this.#rest(path.ids);
                if (this.#isHeldUp(path.ids)) throw this.#busy(path.ids);
                this.#advance();
                sent = this.#send(path, sent);
            }
            return true;
        } finally {
            robot.removeEventListener("feedback", onFeedback);
        }
    }

    /* The servos had the time to reach the last goal. */
    #isOver(path) {
        return this.time >= path.duration + AHEAD_MS;
    }

    get #rate() {
        return this.isPaused ? 0 : this.percent / 100;
    }

    #advance() {
        const now = this.#clock.now();

        if (now - this.#tick > LATE_MS) throw new MotionError("motion-late");
        this.time += (now - this.#tick) * this.#rate;
        this.#tick = now;
    }

    /* Sends the goals of the time that is ahead, if there are new ones. Returns what was sent last. */
    #send(path, sent) {
        const time = Math.min(this.time + AHEAD_MS * this.#rate, path.duration);

        if (time < sent.time) return sent;
        const raw = path.at(time).map(Math.round);

        path.ids.forEach((id, index) => {
            const servo = this.#session.robot.servos.get(id);

            if (raw[index] === sent.raw[index] && servo.goalState !== "dropped") return; // it is sent already
            const way = degreesOf(Math.abs(raw[index] - servo.raw.position));

            this.#goal(id, raw[index], Math.max(1, (way / AHEAD_MS) * RPM_PER_SPEED * RESERVE));
        });
        return { raw, time };
    }

    #sample(ids) {
        const servos = ids.map((id) => this.#session.robot.servos.get(id));
        const t = this.time + (Math.max(...servos.map(({ updatedAt }) => updatedAt)) - this.#tick) * this.#rate;

        if (t > (this.samples.at(-1)?.t ?? 0)) this.samples.push({ t, raw: servos.map(({ raw }) => raw.position) });
    }
}
