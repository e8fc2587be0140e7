// SPDX-License-Identifier: MIT
/* The drawing of a position dial: ring with the range between the limits, hand at the present position,
 * mark at the goal, hollow mark at a goal that the servo has not confirmed yet. */

import { nothing, svg } from "lit/html.js";
import { arcOf, pointOf, rotationOf } from "../model/dial.js";
import { DEGREES_MAX } from "../model/units.js";

export const VIEW_BOX = { left: -50, top: -50, width: 100, height: 92 };
const RADIUS = 40;
const RING = arcOf(RADIUS);
const TICK_STEP = 30; // degrees

const TICKS = Array.from({ length: DEGREES_MAX / TICK_STEP + 1 }, (_, index) => {
    const [from, to] = [33, 30].map((radius) => pointOf(index * TICK_STEP, radius));

    return `M${from.x.toFixed(1)} ${from.y.toFixed(1)}L${to.x.toFixed(1)} ${to.y.toFixed(1)}`;
}).join("");

const mark = (name, degrees, shape) =>
    degrees === null ? nothing : svg`<g class=${name} transform="rotate(${rotationOf(degrees)})">${shape}</g>`;

const HAND = svg`<path d="M0 -36.5L3.5 -28H-3.5Z" />`;
const GOAL = svg`<circle cy="-40" r="5" />`;
const LIMIT = svg`<path d="M0 -47V-33" />`;

/* `pendingGoal`: degrees of a goal that is not confirmed, or null. */
export function dialDrawing(servo, pendingGoal) {
    const { low, high } = servo;
    const hasLimits = low !== null && !servo.isEndless && (low > 0 || high < DEGREES_MAX);

    return svg`
        <path class="ring" d=${RING} />
        ${
            hasLimits
                ? svg`<path class="range" pathLength="300" stroke-dasharray="0 ${low} ${Math.max(high - low, 0)} 400" d=${RING} />
                      ${mark("limit", low, LIMIT)}${mark("limit", high, LIMIT)}`
                : svg`<path class="range" d=${RING} />`
        }
        <path class="ticks" d=${TICKS} />
        ${mark("hand", servo.position, HAND)}
        ${servo.isEndless ? nothing : mark("goal-mark", servo.goal, GOAL)}
        ${mark("pending-mark", pendingGoal, GOAL)}
        <path class="grip" d=${RING} />`;
}

/* A point of the screen in the coordinates of the drawing. */
export function pointIn(element, { clientX, clientY }) {
    const box = element.getBoundingClientRect();
    const scale = VIEW_BOX.width / box.width;

    return { x: (clientX - box.left) * scale + VIEW_BOX.left, y: (clientY - box.top) * scale + VIEW_BOX.top };
}
