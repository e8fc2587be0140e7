// SPDX-License-Identifier: MIT
/* Counters with their meaning, and what they say about the bus. Read only when the user asks. */

import { html, nothing } from "lit/html.js";
import { ageOf, countedFrom, healthOf, readCounters, startOf } from "../model/counters.js";
import { texts } from "../texts/texts.js";
import { Part } from "./part.js";

const t = texts.packets;

class CountersPart extends Part {
    constructor() {
        super();
        this.servo = null; // of a servo; null: the bus
        this.counters = null; // {since, rows}
        this.start = null; // what is not counted: {time, age, rows: Map of the key to {count, ofScan}}
        this.isReading = false;
    }

    #choose(value) {
        this.servo = value === "" ? null : Number(value);
        this.counters = this.start = null;
        this.#read();
    }

    #read = async () => {
        const { session } = this;

        this.isReading = true;
        this.requestUpdate();
        this.counters = (await session.attempt(() => readCounters(session.controller, this.servo))) ?? this.counters;
        if (this.counters && ageOf(this.counters) < this.start?.age) this.start = null; // the controller was reset
        this.isReading = false;
        this.requestUpdate();
    };

    #countFromNow = async () => {
        await this.#read();
        if (this.counters) this.start = startOf(this.counters);
        this.requestUpdate();
    };

    #health(rows) {
        const findings = healthOf(rows);
        const away = [...this.session.robot.servos.values()].filter(({ presence }) => presence === "offline").map(({ id }) => id);

        if (!findings.length) return html`<p class="health good" role="status">${t.healthy}</p>`;
        const isMixed = findings.some(({ key }) => key === "timeouts") && !this.counters.since;

        return html`<ul class="health" role="status">
                ${findings.map(({ key, count }) => html`<li>${t.findings[key](count, away, this.session.robot.servos.size)}</li>`)}
            </ul>
            ${isMixed ? html`<p class="soft">${t.scanCounts}</p>` : nothing}`;
    }

    #row({ key, count, ofScan, unit, meaning }, hasScan) {
        return html`<tr class=${count ? "" : "soft"} data-key=${key}>
            <th scope="row">${key.replace(/_/g, " ")}</th>
            <td class="number">${count}</td>
            ${hasScan ? html`<td class="number">${ofScan || nothing}</td>` : nothing}
            <td class="meaning">${t.means(unit, meaning)}</td>
        </tr>`;
    }

    #table(rows) {
        const since = this.start ? t.sinceNow(this.start.time) : this.counters.since && t.since(this.counters.since);
        const hasScan = rows.some(({ ofScan }) => ofScan > 0);

        return html`
            ${since ? html`<p class="soft">${since}</p>` : nothing}
            <div class="table">
                <table class="counters">
                    <thead>
                        <tr>
                            <th scope="col">${t.counter}</th>
                            <th scope="col" class="number">${t.counted}</th>
                            ${hasScan ? html`<th scope="col" class="number">${t.ofScan}</th>` : nothing}
                            <th scope="col">${t.meaning}</th>
                        </tr>
                    </thead>
                    <tbody>
                        ${rows.map((row) => this.#row(row, hasScan))}
                    </tbody>
                </table>
            </div>
        `;
    }

    render() {
        const { session } = this;
        const rows = this.counters && countedFrom(this.start, this.counters.rows);
        const ids = session.wire?.hasConsole ? (session.robot?.ids ?? []) : [];

        return html`<section aria-label=${t.health}>
            <h2>${t.health}</h2>
            <p class="controls">
                <label>
                    ${t.countersOf}
                    <select class="counters-of" ?disabled=${!session.isConnected} @change=${({ target }) => this.#choose(target.value)}>
                        <option value="" .selected=${this.servo === null}>${t.bus}</option>
                        ${ids.map((id) => html`<option value=${id} .selected=${this.servo === id}>${texts.board.servoName(id)}</option>`)}
                    </select>
                </label>
                <button class="read-counters" ?disabled=${!session.isConnected || this.isReading} @click=${this.#read}>
                    ${this.isReading ? texts.board.reading : t.readCounters}
                </button>
                <button class="count-from-now" ?disabled=${!session.isConnected || this.isReading} @click=${this.#countFromNow}>${t.countFromNow}</button>
            </p>
            ${this.counters ? html`${this.#health(rows)}${this.#table(rows)}` : html`<p class="soft">${t.noCounters}</p>`}
        </section>`;
    }
}

customElements.define("panel-counters", CountersPart);
