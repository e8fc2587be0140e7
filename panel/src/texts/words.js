// SPDX-License-Identifier: MIT
/* Words of several texts. */

export const servo = ({ id, ids = [id] }) => (ids.length > 1 ? `Servos ${ids.join(", ")}` : `Servo ${ids}`);
export const does = ({ ids = [] }) => (ids.length > 1 ? "do" : "does");
export const many = (count, one, more = `${one}s`) => `${count} ${count === 1 ? one : more}`;
export const list = (ids) => `servo${ids.length > 1 ? "s" : ""} ${ids.join(", ")}`;
