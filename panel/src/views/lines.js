// SPDX-License-Identifier: MIT
/* How the lines of many servos look: eight colours (lines.css), then the same ones with dashes. The first 32
 * differ from each other. */

import { svg, html } from "lit/html.js";

const COLOURS = 8;
const DASHES = [[], [14, 4], [5, 4], [14, 4, 4, 4]]; // lengths of line and gap, pixels

export const colourOf = (index) => `c${index % COLOURS}`;
export const dashesOf = (index) => DASHES[Math.floor(index / COLOURS) % DASHES.length];
export const polyline = (index, points) =>
    svg`<polyline class="joint ${colourOf(index)}" stroke-dasharray=${dashesOf(index)} points=${points} />`;

/* A piece of the line, for a legend. */
export const mark = (index) => html`<svg class="mark" width="26" height="10" aria-hidden="true">
    ${polyline(index, "0,5 26,5")}
</svg>`;
