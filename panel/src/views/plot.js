// SPDX-License-Identifier: MIT
/* One graph: a quantity of several servos over time, drawn by uPlot, which is a file of its own: a page that
 * shows no graph does not load it. */

import { QUANTITIES } from "../model/history.js";

const CURSOR_KEY = "graphs"; // all graphs have one cursor
const BUTTONS = new Set(["mousedown", "mouseup", "dblclick"]); // only the graph at the pointer takes them
const DRAG_MIN = 4; // pixels; a shorter drag is a click
const POINTS_PER_PIXEL = 2;
const FONT = "12px system-ui, sans-serif";
const AXIS_WIDTH = 56;
const TIME_SPACE = 80; // pixels between two times at the least: a time with its unit is 60 wide
const LEAST_SPAN = { position: 5, speed: 5, load: 10, voltage: 1, temperature: 4 }; // of the axis

let uPlot = null;

export const isLoaded = () => uPlot !== null;

/* Loads uPlot. A Plot can be made when this has resolved. */
export async function load() {
    uPlot ??= (await import("uplot")).default;
}

/* The axis shows all values, and never less than `span`. */
function rangeOf(span) {
    return (plot, least, greatest) => {
        if (least === null || greatest === null) return [0, span];
        const margin = Math.max((greatest - least) * 0.08, (span - (greatest - least)) / 2);

        return [least - margin, greatest + margin];
    };
}

export class Plot {
    #plot;
    #series;
    #history;
    #range = [0, 1];
    isDragged = false;

    /* `lines`: [{id, quantity, color, dashes}]. `colors`: {ink, line}. onZoom(from, to), onReset(), onCursor(). */
    constructor(element, { quantity, lines, colors, width, height, onZoom, onReset, onCursor }) {
        this.#series = lines;
        const axis = { stroke: colors.ink, font: FONT, grid: { stroke: colors.line, width: 1 }, ticks: { show: false } };
        const timesOf = (plot, times) => times.map((time) => (time < 0 ? "" : `${+time.toFixed(3)} s`));
        const strokeOf = ({ quantity: shown, dashes }) => (shown === "goal" ? { width: 1, dash: [1, 3] } : { width: 1.5, dash: dashes });
        const options = {
            width,
            height,
            legend: { show: false },
            cursor: {
                sync: { key: CURSOR_KEY, setSeries: false, filters: { pub: (type) => !BUTTONS.has(type) } },
                drag: { x: true, y: false, setScale: false },
                bind: { dblclick: () => onReset, mousedown: this.#follow(true), mouseup: this.#follow(false) },
                points: { size: 6 },
                y: false,
            },
            scales: { x: { time: false, range: () => this.#range }, y: { range: rangeOf(LEAST_SPAN[quantity]) } },
            axes: [
                { ...axis, size: 28, space: TIME_SPACE, values: timesOf },
                { ...axis, size: AXIS_WIDTH },
            ],
            series: [{}, ...lines.map((line) => ({ stroke: line.color, ...strokeOf(line), points: { show: false } }))],
            hooks: {
                setSelect: [(plot) => this.#selected(plot, onZoom)],
                setCursor: [onCursor],
            },
        };

        this.#plot = new uPlot(options, [[], ...lines.map(() => [])], element);
    }

    /* What is drawn stands still during a drag, which is one of the main button. */
    #follow(isDragged) {
        return (plot, target, handler) => (event) => {
            if (event.button) return null;
            this.isDragged = isDragged;
            return handler(event);
        };
    }

    #selected(plot, onZoom) {
        const { left, width } = plot.select;

        if (width < DRAG_MIN) return;
        const [from, to] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];

        plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        onZoom(from, to);
    }

    draw(history, range, { width, height }) {
        this.#history = history;
        this.#range = range;
        if (width !== this.#plot.width || height !== this.#plot.height) this.#plot.setSize({ width, height });
        this.#plot.setData(history.lines(this.#series, ...range, width * POINTS_PER_PIXEL));
    }

    /* Seconds at the cursor; null: it is elsewhere. */
    get cursorTime() {
        const { left } = this.#plot.cursor;

        return left >= 0 && this.#history ? this.#plot.posToVal(left, "x") : null;
    }

    end() {
        this.#plot.destroy();
    }
}

/* The value of a line at `time`, or the newest one, as a text; "": none. */
export function valueText(history, { id, quantity }, time) {
    const sample = time === null ? history.end - 1 : Math.min(history.sampleAt(time), history.end - 1);
    const value = sample < history.first ? null : history.valueOf(id, quantity, sample);

    return value === null ? "" : value.toFixed(QUANTITIES[quantity].digits);
}
