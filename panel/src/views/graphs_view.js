// SPDX-License-Identifier: MIT
/* Graphs of the chosen servos and quantities, over the last seconds or a part of the last minutes. */

import { html, nothing } from "lit/html.js";
import { live } from "lit/directives/live.js";
import { GraphWindow } from "../model/graph_window.js";
import { texts } from "../texts/texts.js";
import { colourOf, dashesOf, mark } from "./lines.js";
import { Plot, isLoaded, load, valueText } from "./plot.js";
import { saveFile } from "./save_file.js";
import { View } from "./view.js";

const t = texts.graphs;
const GRAPHS = ["position", "speed", "load", "voltage", "temperature"];
const SPANS = [5, 10, 30, 60, 300]; // seconds
const DRAW_MS = 45; // between two drawings, so that they do not slow the feedback
const SERVOS_AT_FIRST = 3;
const HEIGHT_MIN = 150;
const HEIGHT_MAX = 340;
const CAPTION_HEIGHT = 40;

export class GraphsView extends View {
    #window = new GraphWindow(SPANS[1]);
    #plots = new Map(); // of quantity
    #drawing = ""; // what the plots show
    #made = ""; // what the plots were made for
    #drawnAt = -Infinity;
    #isAsked = true;
    #cursorTime = null; // seconds; null: the cursor is elsewhere
    #cursorFrame = null;
    #resizer = new ResizeObserver(() => this.#ask());
    #scheme = matchMedia("(prefers-color-scheme: dark)");
    #ask = () => {
        this.#isAsked = true;
        this.requestUpdate();
    };

    constructor() {
        super();
        this.ids = null; // chosen servos; null: the first few
        this.quantities = new Set(["position", "load"]);
    }

    connectedCallback() {
        super.connectedCallback();
        this.session.addEventListener("change", this.#ask);
        this.#scheme.addEventListener("change", this.#ask);
        this.#resizer.observe(this);
        this.session.attempt(load).then(this.#ask);
        this.#ask();
    }

    disconnectedCallback() {
        super.disconnectedCallback();
        this.session.removeEventListener("change", this.#ask);
        this.#scheme.removeEventListener("change", this.#ask);
        this.#resizer.disconnect();
    }

    /* Not with each feedback, and not for feedback while paused. */
    shouldUpdate() {
        const isDue = performance.now() - this.#drawnAt >= DRAW_MS && !this.#window.isPaused;

        return this.#isAsked || isDue;
    }

    /* ---- what is shown ---- */

    #idsOf(history) {
        const known = [...new Set([...this.session.robot.ids, ...history.ids])].sort((one, other) => one - other);

        return { known, chosen: this.ids ? known.filter((id) => this.ids.has(id)) : known.slice(0, SERVOS_AT_FIRST) };
    }

    /* The lines of a graph. Position has a dotted line of the goal. */
    #linesOf(quantity, chosen, known) {
        const lineOf = (id, name) => ({ id, quantity: name, index: known.indexOf(id) });

        return chosen.flatMap((id) => [lineOf(id, quantity), ...(quantity === "position" ? [lineOf(id, "goal")] : [])]);
    }

    get #graphs() {
        return GRAPHS.filter((quantity) => this.quantities.has(quantity));
    }

    #choose(set, item, isChosen) {
        if (isChosen) set.add(item);
        else set.delete(item);
        this.#ask();
    }

    #chooseAll(ids) {
        this.ids = new Set(ids);
        this.#ask();
    }

    /* ---- time ---- */

    #setSpan({ target }) {
        this.#window.span = Number(target.value);
        this.#window.goOn();
        this.#ask();
    }

    #do(call) {
        call(this.#window);
        this.#ask();
    }

    #save = () => {
        const { history, range } = this.#window;
        const { known, chosen } = this.#idsOf(history);
        const lines = this.#graphs.flatMap((quantity) => this.#linesOf(quantity, chosen, known));

        saveFile("servos.csv", history.csv(lines, ...range), "text/csv");
    };

    /* ---- plots ---- */

    updated() {
        this.#drawnAt = performance.now();
        this.#isAsked = false;
        if (!this.session.history || !isLoaded()) return;
        const { history, range } = this.#window;
        const size = this.#size();
        const made = [...Object.values(this.#idsOf(history)), ...this.#graphs, this.#scheme.matches].join(" ");

        if (made !== this.#made) this.#makePlots(size);
        this.#made = made;
        const drawing = [made, history.start, history.end, ...range, size.width, size.height].join(" ");

        if (drawing === this.#drawing || [...this.#plots.values()].some(({ isDragged }) => isDragged)) return;
        this.#drawing = drawing;
        for (const plot of this.#plots.values()) plot.draw(history, range, size);
    }

    /* All graphs fit the screen if they can. */
    #size() {
        const width = this.querySelector(".graphs")?.clientWidth ?? 0;
        const top = this.querySelector(".graphs")?.offsetTop ?? 0;
        const height = (innerHeight - top) / Math.max(this.#graphs.length, 1) - CAPTION_HEIGHT;

        return { width, height: Math.round(Math.min(Math.max(height, HEIGHT_MIN), HEIGHT_MAX)) };
    }

    #makePlots(size) {
        const { known, chosen } = this.#idsOf(this.#window.history);
        const colorOf = (css) => getComputedStyle(this.querySelector(css)).color;

        this.#plots.forEach((plot) => plot.end());
        this.#plots = new Map(
            this.#graphs.map((quantity) => {
                const colored = (line) => ({ ...line, color: colorOf(`.mark .${colourOf(line.index)}`), dashes: dashesOf(line.index) });
                const lines = this.#linesOf(quantity, chosen, known).map(colored);

                return [quantity, new Plot(this.querySelector(`[data-quantity="${quantity}"] .plot`), {
                    quantity,
                    lines,
                    colors: { ink: colorOf(".colors .ink"), line: colorOf(".colors .line") },
                    ...size,
                    onZoom: (from, to) => this.#do((shown) => shown.show(from, to)),
                    onReset: () => this.#do((shown) => shown.goOn()),
                    onCursor: () => this.#follow(quantity),
                })];
            }),
        );
    }

    #follow(quantity) {
        const time = this.#plots.get(quantity)?.cursorTime ?? null;

        if (time === this.#cursorTime) return;
        this.#cursorTime = time;
        this.#cursorFrame ??= requestAnimationFrame(() => {
            this.#cursorFrame = null;
            this.#ask();
        });
    }

    /* ---- parts of the view ---- */

    #servoChoice(known, chosen) {
        const set = new Set(chosen);

        return html`<fieldset class="choice servos">
            <legend>${t.servos}</legend>
            <button class="all" @click=${() => this.#chooseAll(known)}>${t.all}</button>
            <button class="none" @click=${() => this.#chooseAll([])}>${t.none}</button>
            ${known.map(
                (id, index) => html`<label class="chip">
                    <input type="checkbox" value=${id} .checked=${set.has(id)}
                        @change=${({ target }) => this.#choose((this.ids = set), id, target.checked)} />
                    ${mark(index)}<span class="unseen">${t.servo}</span> ${id}
                </label>`,
            )}
        </fieldset>`;
    }

    #quantityChoice() {
        return html`<fieldset class="choice quantities">
            <legend>${t.quantities}</legend>
            ${GRAPHS.map(
                (quantity) => html`<label class="chip">
                    <input type="checkbox" value=${quantity} .checked=${this.quantities.has(quantity)}
                        @change=${({ target }) => this.#choose(this.quantities, quantity, target.checked)} />
                    ${t.names[quantity]}
                </label>`,
            )}
        </fieldset>`;
    }

    #toolbar() {
        const shown = this.#window;
        const [from, to] = shown.range;
        const isZoomed = !SPANS.some((span) => t.spanOf(span) === t.spanOf(to - from));
        const isChosen = (span) => live(t.spanOf(span) === t.spanOf(to - from));
        const option = (span) => html`<option value=${span} .selected=${isChosen(span)}>${t.spanOf(span)}</option>`;
        const button = (name, text, call) =>
            html`<button class=${name} aria-label=${text.label ?? text} title=${text.label ?? text} @click=${() => this.#do(call)}>
                ${text.sign ?? text}
            </button>`;

        return html`<div class="toolbar">
            ${shown.isPaused ? button("go-on", t.goOn, () => shown.goOn()) : button("pause", t.pause, () => shown.pause())}
            <label>
                ${t.span}
                <select class="span" @change=${(event) => this.#setSpan(event)}>
                    ${isZoomed ? html`<option .selected=${true} disabled>${t.spanOf(to - from)}</option>` : nothing}
                    ${SPANS.map(option)}
                </select>
            </label>
            <span class="group">
                ${button("zoom-in", t.zoomIn, () => shown.zoomIn())} ${button("zoom-out", t.zoomOut, () => shown.zoomOut())}
                ${button("earlier", t.earlier, () => shown.move(-1))} ${button("later", t.later, () => shown.move(1))}
            </span>
            <button class="save" title=${t.saveHint} @click=${this.#save}>${t.save}</button>
            <p class="hint">${shown.isPaused ? t.paused : t.hint}</p>
        </div>`;
    }

    /* The value at the cursor, else the newest one. */
    #value(id, quantity, known) {
        const goal = () => html`<span class="unit">→<span class="unseen">${t.goal}</span> ${textOf("goal")}</span>`;
        const textOf = (name) => valueText(this.#window.history, { id, quantity: name }, this.#cursorTime) || texts.robot.noValue;

        return html`<span class="value ${quantity}"
            >${mark(known.indexOf(id))}<span class="unseen">${t.servo}</span>${id}: ${textOf(quantity)}
            ${quantity === "position" ? goal() : nothing}</span
        >`;
    }

    #graph(quantity, chosen, known) {
        return html`<figure data-quantity=${quantity} aria-label=${t.names[quantity]}>
            <figcaption>
                <strong>${t.names[quantity]}</strong> <span class="unit">${t.units[quantity]}</span>
                ${quantity === "position" ? html`<span class="unit">${t.dotted}</span>` : nothing}
                ${chosen.map((id) => this.#value(id, quantity, known))}
            </figcaption>
            <div class="plot"></div>
        </figure>`;
    }

    render() {
        const { session } = this;

        if (!session.history) return html`<p>${t.notConnected}</p>`;
        this.#window.follow(session.history);
        const { known, chosen } = this.#idsOf(this.#window.history);

        return html`
            ${this.#toolbar()}
            <div class="choices">${this.#servoChoice(known, chosen)} ${this.#quantityChoice()}</div>
            <div class="graphs">
                ${chosen.length ? nothing : html`<p>${t.noServo}</p>`}
                ${GRAPHS.map((quantity) => (this.quantities.has(quantity) ? this.#graph(quantity, chosen, known) : nothing))}
            </div>
            <div class="colors" aria-hidden="true"><i class="ink"></i><i class="line"></i></div>
        `;
    }
}

customElements.define("panel-graphs", GraphsView);
