// SPDX-License-Identifier: MIT
/* After Ctrl-X: asks the device and the servos until it is certain that the robot is stopped.
 *
 * The stop is verified if register INHIBIT of the device is 1 and the torque of each known servo reads
 * 0; without a known servo it is not. While INHIBIT is not 1, Ctrl-X is sent again: docs/safety.md lists how one can be lost. */

import { FAILED, SYNC_READ_MAX, read, syncRead } from "./packet.js";
import { DEVICE, REGISTER } from "./registers.js";

const STOP_MS = 3000; // then the outcome stands
const AGAIN_MS = 150; // from the first Ctrl-X to the second, and between later ones
const AGAIN_LOW_MS = 1500; // between later ones on a line held low: each begins a torque off of 1.4 s, and the reply waits for its end

/* Splits `ids` into groups whose SYNC READ of `count` bytes fits. */
export function groupsOfIds(ids, count) {
    const size = Math.floor(SYNC_READ_MAX / count);
    const groups = [];

    for (let at = 0; at < ids.length; at += size) groups.push(ids.slice(at, at + size));
    return groups;
}

class Stop {
    constructor(wire) {
        this.wire = wire; // {clock, deviceId, sendStop, fence, ask, isLineLow}
        this.againMs = AGAIN_MS;
        this.end = wire.clock.now() + STOP_MS;
        this.sentAt = wire.clock.now();
    }

    get isOver() {
        return this.wire.clock.now() >= this.end;
    }

    /* Returns when INHIBIT reads 1; false: it does not in time. */
    async waitForInhibit() {
        while (!this.isOver) {
            const reply = (await this.wire.fence()) && (await this.wire.ask(read(this.wire.deviceId, DEVICE.INHIBIT, 1)));

            if (reply?.parameters[0] === 1) return true;
            if (this.wire.clock.now() - this.sentAt >= this.againMs) {
                this.sentAt = this.wire.clock.now();
                this.againMs = this.wire.isLineLow ? AGAIN_LOW_MS : AGAIN_MS;
                this.wire.sendStop();
            }
        }
        return false;
    }

    /* Torque of each of `ids`: Map of ID to 0, 1 or FAILED. */
    async readTorque(ids) {
        const torque = new Map(ids.map((id) => [id, FAILED]));

        for (const group of groupsOfIds(ids, 1)) {
            const reply = await this.wire.ask(syncRead(REGISTER.TORQUE_ENABLE, 1, group));

            group.forEach((id, index) => torque.set(id, reply?.parameters[index] ?? FAILED));
        }
        return torque;
    }

    /* Asks until the torque of each servo reads 0, or the time is over. */
    async waitForTorqueOff(servos) {
        let torque = await this.readTorque(servos);

        while (!this.isOver && [...torque.values()].some((value) => value !== 0)) {
            await this.wire.fence();
            torque = await this.readTorque(servos);
        }
        return torque;
    }
}

export async function verifyStop({ servos, ...wire }) {
    const stop = new Stop(wire);
    const inhibited = await stop.waitForInhibit();
    const torque = inhibited ? await stop.waitForTorqueOff(servos) : new Map(servos.map((id) => [id, FAILED]));
    const withTorque = (wanted) => servos.filter((id) => wanted(torque.get(id)));
    const outcome = {
        inhibited,
        off: withTorque((value) => value === 0),
        on: withTorque((value) => value === 1),
        silent: withTorque((value) => value !== 0 && value !== 1),
    };

    return { ...outcome, verified: inhibited && servos.length > 0 && outcome.off.length === servos.length };
}
