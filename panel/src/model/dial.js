// SPDX-License-Identifier: MIT
/* Geometry of a position dial, seen as one looks at the horn: 0 degrees at the lower right, 150 at the
 * top, 300 at the lower left; more degrees are counterclockwise. The centre is (0, 0), y goes down. */

import { DEGREES_MAX } from "./units.js";

const MIDDLE = DEGREES_MAX / 2;
const RADIANS = Math.PI / 180;
const JUMP = 150; // degrees: a drag that jumps farther has crossed the gap below

export function pointOf(degrees, radius) {
    const angle = (degrees - MIDDLE) * RADIANS; // from the top, counterclockwise

    return { x: -radius * Math.sin(angle), y: -radius * Math.cos(angle) };
}

/* The angle of `transform="rotate()"` for a mark that is drawn at the top. */
export const rotationOf = (degrees) => (MIDDLE - degrees).toFixed(1);

/* The whole range as a path, from 0 degrees on. */
export function arcOf(radius) {
    const [from, to] = [pointOf(0, radius), pointOf(DEGREES_MAX, radius)];
    const xy = ({ x, y }) => `${x.toFixed(2)} ${y.toFixed(2)}`;

    return `M${xy(from)}A${radius} ${radius} 0 1 0 ${xy(to)}`;
}

/* Degrees at a point; in the gap below the nearer end. */
export function degreesAt(x, y) {
    const degrees = MIDDLE + Math.atan2(-x, -y) / RADIANS;

    return Math.min(Math.max(degrees, 0), DEGREES_MAX);
}

/* Degrees at a point of a drag that was at `before`. A drag through the gap stays at its end. */
export function degreesOfDrag(before, x, y) {
    const degrees = degreesAt(x, y);

    if (Math.abs(degrees - before) <= JUMP) return degrees;
    return before > MIDDLE ? DEGREES_MAX : 0;
}
