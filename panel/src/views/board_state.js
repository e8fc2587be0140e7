// SPDX-License-Identifier: MIT
/* Alarms with their remedies, and the status of the controller. Read when the view opens, when the user
 * asks, and when the device tells of other alarms. */

import { html, nothing } from "lit/html.js";
import { readAlarms, readStatus } from "../model/board.js";
import { texts } from "../texts/texts.js";
import { Part } from "./part.js";

const t = texts.board;

/* A list of names with their values. */
export function factList(facts, name = "") {
    return html`<dl class="facts ${name}">${facts.map(([label, text]) => html`<div><dt>${label}</dt><dd>${text}</dd></div>`)}</dl>`;
}

class BoardStatePart extends Part {
    static properties = ["alarms", "lost"]; // lost: IDs of servos whose torque went off by itself, in one text

    #isReading = false;

    constructor() {
        super();
        this.list = null; // alarms of the controller; null: not read
        this.status = null;
    }

    connectedCallback() {
        super.connectedCallback();
        this.read();
    }

    /* The bits of the device or a servo have changed, or a stop, a release or another connection came. */
    updated(changed) {
        if (this.list && (changed.has("alarms") || changed.has("lost") || changed.has("mode"))) this.read();
    }

    read = async () => {
        const { session } = this;

        if (this.#isReading || !session.isConnected) return;
        this.#isReading = true;
        this.requestUpdate();
        await session.attempt(async () => {
            this.list = await readAlarms(session);
            this.status = await readStatus(session);
        });
        this.#isReading = false;
        this.requestUpdate();
    };

    #clear = async () => {
        await this.session.attempt(() => this.session.robot.clearAlarms());
        await this.read();
    };

    #alarms() {
        const row = (what, advice) => html`<li><b>${what}</b> <span>${advice}</span></li>`;

        return html`<section aria-labelledby="alarms-title">
            <h2 id="alarms-title">${t.alarms}</h2>
            ${this.list?.length || this.lost
                ? html`<ul class="alarms" role="status">
                      ${this.list?.map(({ who, condition }) => row(t.alarmOf(who, condition), t.conditions[condition] ?? ""))}
                      ${this.lost ? row(t.inhibitedAlone(this.lost.split(" ")), texts.robot.lost) : nothing}
                  </ul>`
                : html`<p role="status">${this.list ? t.noAlarms : t.notRead}</p>`}
            <button class="clear-alarms" @click=${this.#clear}>${t.clear}</button>
            <p class="hint">${t.clearHint}</p>
        </section>`;
    }

    #facts(isDetail) {
        const rows = this.status.filter((row) => row.isDetail === isDetail);

        return factList(rows.map(({ label, text }) => [label, text]));
    }

    #status() {
        return html`<section aria-labelledby="status-title">
            <h2 id="status-title">${t.status}</h2>
            ${this.status ? this.#facts(false) : html`<p>${t.notRead}</p>`}
            ${this.status?.some((row) => row.isDetail)
                ? html`<details class="details"><summary>${t.details}</summary>${this.#facts(true)}</details>`
                : nothing}
            <button class="read-status" ?disabled=${this.#isReading} aria-label=${this.#isReading ? t.reading : t.readAgainOf(t.status)}
                @click=${this.read}>${this.#isReading ? t.reading : t.readAgain}</button>
        </section>`;
    }

    render() {
        return html`<div class="board-middle">${this.#status()} ${this.#alarms()}</div>`;
    }
}

customElements.define("panel-board-state", BoardStatePart);
