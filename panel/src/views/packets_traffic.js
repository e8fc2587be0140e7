// SPDX-License-Identifier: MIT
/* The list of packets and lines with its filter. It is rendered at most ten times a second, and has at
 * most ROWS_SHOWN rows in the document. */

import { html, nothing } from "lit/html.js";
import { repeat } from "lit/directives/repeat.js";
import { AT_ID, INSTRUCTION } from "../wire/packet.js";
import { texts } from "../texts/texts.js";
import { Part } from "./part.js";
import { saveFile } from "./save_file.js";

const t = texts.packets;
export const ROWS_SHOWN = 200;
const PERIOD_MS = 100;
const GROUPS = [...Object.keys(INSTRUCTION).map((name) => name.replace("_", " ")), ...Object.keys(t.groups)];
const NEAR_END = 8; // pixels

class TrafficPart extends Part {
    #timer = null;
    #isAtEnd = true;

    constructor() {
        super();
        this.filter = { id: null, group: "", errorsOnly: false, text: "", withPolling: false, showBytes: false };
        this.frozen = null; // rows that are shown while paused
    }

    connectedCallback() {
        super.connectedCallback();
        this.session.addEventListener("traffic", this.#later);
        this.requestUpdate();
    }

    disconnectedCallback() {
        super.disconnectedCallback();
        this.session.removeEventListener("traffic", this.#later);
        clearTimeout(this.#timer);
        this.#timer = null;
    }

    #later = () => {
        if (this.frozen) return;
        this.#timer ??= setTimeout(() => {
            this.#timer = null;
            this.requestUpdate();
        }, PERIOD_MS);
    };

    /* ---- what a user does ---- */

    #set(name, value) {
        this.filter = { ...this.filter, [name]: value };
        if (this.frozen) this.#freeze();
        this.requestUpdate();
    }

    #freeze() {
        this.frozen = this.#select();
    }

    #pause = () => {
        if (this.frozen) this.frozen = null;
        else this.#freeze();
        this.requestUpdate();
    };

    #clear = () => {
        this.session.traffic.clear();
        if (this.frozen) this.frozen = [];
        this.requestUpdate();
    };

    #save = () => saveFile(t.fileName, this.session.capture.text);

    #select() {
        return this.session.traffic.select(this.filter, ROWS_SHOWN);
    }

    /* ---- the newest row stays in sight if it was ---- */

    /* A list that is put into the document again begins at its top, and no event tells it. */
    #scrolled({ target }) {
        if (this.isConnected) this.#isAtEnd = target.scrollHeight - target.scrollTop - target.clientHeight <= NEAR_END;
    }

    updated() {
        const list = this.querySelector(".traffic");

        if (this.#isAtEnd && list) list.scrollTop = list.scrollHeight;
    }

    /* ---- rendering ---- */

    #idFilter({ target }) {
        const text = target.value.trim();
        const isId = /^\d+$/.test(text);

        target.setAttribute("aria-invalid", text !== "" && !isId);
        this.#set("id", isId ? Number(text) : null);
    }

    #check(label, name) {
        return html`<label class="check">
            <input type="checkbox" class=${name} .checked=${this.filter[name]} @change=${({ target }) => this.#set(name, target.checked)} />
            ${label}
        </label>`;
    }

    #controls() {
        return html`<div class="controls" role="group" aria-label=${t.filter}>
            <label>
                ${t.servo}
                <input class="filter-id" inputmode="numeric" size="4" placeholder=${t.anyServo} title=${t.oneServo}
                    @input=${(event) => this.#idFilter(event)} />
            </label>
            <label>
                ${t.group}
                <select class="filter-group" @change=${({ target }) => this.#set("group", target.value)}>
                    <option value="">${t.anyGroup}</option>
                    ${GROUPS.map((name) => html`<option value=${name}>${t.groups[name] ?? name}</option>`)}
                </select>
            </label>
            <label>
                ${t.text}
                <input class="filter-text" type="search" size="12" @input=${({ target }) => this.#set("text", target.value)} />
            </label>
            ${this.#check(t.errorsOnly, "errorsOnly")} ${this.#check(t.withPolling, "withPolling")} ${this.#check(t.showBytes, "showBytes")}
            <span class="buttons">
                <button class="pause" aria-pressed=${this.frozen !== null} @click=${this.#pause}>${this.frozen ? t.goOn : t.pause}</button>
                <button class="clear" @click=${this.#clear}>${t.clear}</button>
                <button class="save" title=${t.saveHint} ?disabled=${!this.session.capture} @click=${this.#save}>${t.save}</button>
            </span>
        </div>`;
    }

    #row(row) {
        const { who, name, text, hex } = this.session.traffic.describe(row);
        const seconds = ((row.time - this.session.traffic.begun) / 1000).toFixed(3);
        const classes = `row ${row.direction} ${row.kind}${row.isError ? " error" : ""}`;

        return html`<li class=${classes} data-id=${row.bytes ? row.bytes[AT_ID] : ""}>
            <span class="time">${seconds}</span>
            <span class="arrow" role="img" aria-label=${t[row.direction]}>${t.arrows[row.direction]}</span>
            <span class="who">${who}</span>
            <span class="what">
                <b>${name}</b> ${text}${row.isUnanswered ? html` <em>${texts.decode.unanswered}</em>` : nothing}
                ${this.filter.showBytes && hex ? html`<code class="bytes">${hex}</code>` : nothing}
            </span>
        </li>`;
    }

    render() {
        const rows = this.frozen ?? this.#select();

        return html`<section aria-label=${t.traffic}>
            <h2>${t.traffic} <span class="soft">${t.count(rows.length)}</span></h2>
            ${this.#controls()}
            <ol class="traffic" tabindex="0" aria-label=${t.list} @scroll=${this.#scrolled}>
                ${rows.length ? repeat(rows, ({ number }) => number, (row) => this.#row(row)) : html`<li class="soft">${t.empty}</li>`}
            </ol>
        </section>`;
    }
}

customElements.define("panel-traffic", TrafficPart);
