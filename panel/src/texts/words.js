// SPDX-License-Identifier: MIT
/* Words of several texts. */

export const servo = ({ id, ids = [id] }) => (ids.length > 1 ? `Servos ${ids.join(", ")}` : `Servo ${ids}`);
export const does = ({ ids = [] }) => (ids.length > 1 ? "do" : "does");
export const many = (count, one, more = `${one}s`) => `${count} ${count === 1 ? one : more}`;
/* What becomes of the robot once the link is lost. ms undefined: not known. */
export const afterLoss = ({ ms, action }) =>
    action && ms
        ? `After ${ms} ms the controller ${action > 1 ? "switches torque off for servos that answer" : "inhibits driving; a movement under way goes on"}.`
        : `The robot goes on with its last orders${ms === undefined ? ", unless link_loss_ms ends it" : ""}.`;
export const list = (ids) => `servo${ids.length > 1 ? "s" : ""} ${ids.join(", ")}`;
