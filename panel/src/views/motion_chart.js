// SPDX-License-Identifier: MIT
/* Curves of joints over time, as SVG: degrees upwards, seconds to the right. */

import { html, nothing, svg } from "lit/html.js";
import { DEGREES_MAX, degreesOf } from "../model/units.js";
import { colourOf, mark, polyline } from "./lines.js";

const HEIGHT = 220;
const LEFT = 40; // room for the angles
const RIGHT = 8;
const TOP = 22; // room for names
const BOTTOM = 22; // room for the times
const SPAN_MIN = 20; // degrees
const SAMPLES = 240;
const MARKS_MAX = 500; // more circles take seconds to draw
const LABEL = 7; // width of a character

/* Steps of 1, 2 or 5 that give about `count` lines over `span`. */
function roundStep(span, count) {
    const rough = span / count;
    const power = 10 ** Math.floor(Math.log10(rough));

    return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= rough);
}

function multiples(low, high, step) {
    const first = Math.ceil(low / step - 1e-9);

    return Array.from({ length: Math.max(0, Math.floor(high / step + 1e-9) - first + 1) }, (_, index) => (first + index) * step);
}

/* Points of a path: {times, rows: positions of each joint in degrees}. */
function sampled({ ids, duration, at, begins = [] }) {
    const times = [...Array.from({ length: SAMPLES + 1 }, (_, index) => (duration * index) / SAMPLES), ...begins];

    times.sort((one, other) => one - other);
    const positions = times.map((time) => at(time).map(degreesOf));

    return { times, rows: ids.map((_, joint) => positions.map((row) => row[joint])) };
}

class Scale {
    constructor(duration, angles, width) {
        const low = angles.reduce((one, other) => Math.min(one, other), Infinity);
        const high = angles.reduce((one, other) => Math.max(one, other), -Infinity);
        const more = Math.max(SPAN_MIN - (high - low), (high - low) * 0.12) / 2;

        this.width = Math.max(width, 200);
        this.duration = Math.max(duration, 1);
        this.low = Math.max(0, low - more);
        this.high = Math.min(DEGREES_MAX, high + more);
    }

    x(time) {
        return LEFT + ((this.width - LEFT - RIGHT) * time) / this.duration;
    }

    y(degrees) {
        return HEIGHT - BOTTOM - ((HEIGHT - TOP - BOTTOM) * (degrees - this.low)) / (this.high - this.low);
    }

    points(times, row) {
        return times.map((time, index) => `${this.x(time).toFixed(1)},${this.y(row[index]).toFixed(1)}`).join(" ");
    }
}

function grid(scale) {
    const seconds = scale.duration / 1000;
    const everyDegrees = roundStep(scale.high - scale.low, 4);
    const everySecond = roundStep(seconds, Math.max(2, scale.width / 90));
    const digits = Math.max(0, -Math.floor(Math.log10(everySecond)));

    return svg`
        ${multiples(scale.low, scale.high, everyDegrees).map((degrees) => svg`
            <line class="grid" x1=${LEFT} x2=${scale.width - RIGHT} y1=${scale.y(degrees)} y2=${scale.y(degrees)} />
            <text class="angle" x=${LEFT - 6} y=${scale.y(degrees) + 4}>${degrees.toFixed(0)}°</text>`)}
        ${multiples(0, seconds, everySecond).map((time) => svg`
            <text class="time" x=${Math.min(scale.x(time * 1000), scale.width - RIGHT - 10)} y=${HEIGHT - 6}>${time.toFixed(digits)} s</text>`)}`;
}

/* The steps of a sequence: its way, its rest, and the name of its pose. */
function bands(scale, { begins, steps, selected, onSelect }) {
    return steps.map(({ pose, time, dwell }, index) => {
        const x = scale.x(begins[index]);
        const atPose = scale.x(begins[index] + time);
        const width = scale.x(begins[index] + time + dwell) - x;

        return svg`<g class=${index === selected ? "band selected" : "band"} @click=${() => onSelect(index)}>
            <rect class="way" x=${x} y=${TOP} width=${Math.max(width, 1)} height=${HEIGHT - TOP - BOTTOM} />
            ${dwell ? svg`<rect class="dwell" x=${atPose} y=${TOP} width=${x + width - atPose} height=${HEIGHT - TOP - BOTTOM} />` : nothing}
            <line class="end" x1=${x + width} x2=${x + width} y1=${TOP} y2=${HEIGHT - BOTTOM} />
            ${width > pose.length * LABEL + 4 ? svg`<text class="pose" x=${x + width / 2} y=${TOP - 7}>${pose}</text>` : nothing}
        </g>`;
    });
}

/* `path`: what is shown (model/path.js). `other`: samples [{t, raw}] of the same joints, drawn thin above it.
 * `points`: the points [{t, raw}] that stay of a recording; they are marked if they are few. */
export function chart({ path, width, label, sequence, other: samples = [], points = [] }) {
    const { times, rows } = sampled(path);
    const every = Math.ceil(samples.length / (2 * SAMPLES));
    const other = samples.filter((_, index) => index % every === 0);
    const marked = points.length * path.ids.length > MARKS_MAX ? [] : points;
    const second = path.ids.map((_, joint) => other.map(({ raw }) => degreesOf(raw[joint])));
    const scale = new Scale(path.duration, [...rows, ...second].flat(), width);

    return html`<svg class="curves" role="img" aria-label=${label} width=${scale.width} height=${HEIGHT} viewBox="0 0 ${scale.width} ${HEIGHT}">
        ${sequence ? bands(scale, { ...sequence, begins: path.begins }) : nothing} ${grid(scale)}
        ${rows.map((row, joint) => polyline(joint, scale.points(times, row)))}
        ${second.map((row, joint) => other.length
            ? svg`<polyline class="joint other" points=${scale.points(other.map(({ t }) => t), row)} />`
            : nothing)}
        ${marked.flatMap(({ t, raw }) => raw.map((value, joint) =>
            svg`<circle class="joint ${colourOf(joint)}" r="2.5" cx=${scale.x(t)} cy=${scale.y(degreesOf(value))} />`))}
    </svg>`;
}

/* A line at `time`, above a chart; NaN: none. */
export function playhead(duration, width, time) {
    const x = new Scale(duration, [], width).x(time);

    return Number.isNaN(x) ? nothing : html`<svg class="playhead" width=${width} height=${HEIGHT} aria-hidden="true">
        <line x1=${x} x2=${x} y1=${TOP} y2=${HEIGHT - BOTTOM} />
    </svg>`;
}

/* Which colour is which servo. */
export function legend(ids, nameOf) {
    return html`<ul class="legend">
        ${ids.map((id, index) => html`<li>
            ${mark(index)} ${nameOf(id)}
        </li>`)}
    </ul>`;
}
