// SPDX-License-Identifier: MIT
/* Moves one servo while a key is held.
 *
 * The goal runs a little ahead of the present position and is renewed with each feedback. So the servo
 * stops by itself at most 0.25 s later if the page hangs or the port is lost. A servo in endless turn has no
 * goal and is not moved: its card has a slider. */

const AHEAD_S = 0.25; // way that the goal runs ahead, at the speed of the jog
const AHEAD_MIN = 3; // degrees
const DEGREES_PER_S = 6; // at 1 rpm

export class Jog {
    #session;
    #move = null; // {id, direction, rpm}
    #renew = () => this.#step();

    constructor(session) {
        this.#session = session;
    }

    /* ID of the servo that moves; null: none. */
    get id() {
        return this.#move?.id ?? null;
    }

    /* `direction`: 1 is to more degrees, -1 to less. False: ignored, since torque is off or not known. */
    start(id, direction, rpm) {
        this.stop();
        this.#move = { id, direction, rpm };
        this.#session.addEventListener("feedback", this.#renew);
        return this.#step() || this.#forget();
    }

    /* The servo stops where it is. Resolves when the servo has confirmed it, or its failure is a notice. */
    async stop() {
        const { id } = this;

        if (id === null) return;
        this.#forget();
        await this.#session.attempt(() => this.#session.robot.hold(id));
    }

    #forget() {
        this.#session.removeEventListener("feedback", this.#renew);
        this.#move = null;
        return false;
    }

    #step() {
        const { id, direction, rpm } = this.#move;
        const { robot } = this.#session;
        const servo = robot.servos.get(id);
        const isDriven = !servo?.isEndless && this.#go(robot, servo, direction, rpm);

        if (!isDriven) this.#forget(); // a stop, or torque went off
        return isDriven;
    }

    #go(robot, servo, direction, rpm) {
        if (!servo || servo.position === null) return false;
        const ahead = Math.max(rpm * DEGREES_PER_S * AHEAD_S, AHEAD_MIN);
        const goal = Math.min(Math.max(servo.position + direction * ahead, servo.low ?? 0), servo.high ?? Infinity);

        return robot.setGoal(servo.id, goal, rpm);
    }
}
