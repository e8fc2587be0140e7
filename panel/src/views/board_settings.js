// SPDX-License-Identifier: MIT
/* The settings: what is changed here is sent by “Apply” or “Save”, never by typing. */

import { html, nothing } from "lit/html.js";
import { Settings, risksOf } from "../model/settings.js";
import { RATES } from "../model/setup.js";
import { BAUD_CLOCK } from "../model/units.js";
import { texts } from "../texts/texts.js";
import { confirmed } from "./confirm.js";
import { Part } from "./part.js";

const t = texts.board;
const OWN_RATE = 255;
const DELAY_US = 2;

/* The values that a setting can be set to, [[value, text]]; undefined: any of its range. `value` is in force. */
function choicesOf(name, value) {
    if (!name.endsWith("_baud")) return t.choices[name]?.map((text, index) => [index, t.choice(index, text)]);
    const rates = new Map([[value, texts.setup.rate(Math.round(BAUD_CLOCK / (value + 1)))], ...RATES.map((rate) => [Math.round(BAUD_CLOCK / rate) - 1, texts.setup.rate(rate)])]);

    return [...(name === "host_baud" ? rates.set(OWN_RATE, t.ownRate) : rates)];
}

class SettingsPart extends Part {
    static properties = ["onDone"]; // onDone(): settings may have changed

    #settings = null;
    #changes = new Map(); // of the name: what is typed
    #isBusy = false;
    #start = 0; // session.starts of the settings that are shown

    /* The view is opened again: a command may have changed settings. */
    connectedCallback() {
        super.connectedCallback();
        if (this.#settings && this.session.isConnected && !this.#isBusy) this.#do(() => this.#settings.read());
    }

    updated() {
        if (this.session.isConnected && this.session.starts !== this.#start) this.#readNew();
    }

    /* Another connection: another controller, perhaps. Or the controller was reset: the saved settings are in force. */
    #readNew() {
        this.#start = this.session.starts;
        this.#settings = new Settings(this.session);
        this.#changes.clear();
        this.#do(() => this.#settings.read());
    }

    async #do(call) {
        this.#isBusy = true;
        this.requestUpdate();
        const isDone = await this.session.attempt(async () => {
            await call();
            return true;
        }, "settings");

        this.#isBusy = false;
        this.onDone?.();
        for (const [name, text] of this.#changes) if (this.#isInForce(name, text)) this.#changes.delete(name);
        this.requestUpdate();
        return isDone;
    }

    /* ---- what is typed ---- */

    #isInForce(name, text) {
        return text === String(this.#settings.values.get(name));
    }

    /* The value in force may be another one as soon as what is under way has ended. */
    #type(name, text) {
        if (!this.#isBusy && this.#isInForce(name, text)) this.#changes.delete(name);
        else this.#changes.set(name, text);
        this.requestUpdate();
    }

    #isWrong({ name, lowest, highest }) {
        const text = this.#changes.get(name);

        return text !== undefined && !(/^\d+$/.test(text) && Number(text) >= lowest && Number(text) <= highest);
    }

    get #wrong() {
        return this.#settings.rows.filter((row) => this.#isWrong(row));
    }

    /* ---- what is sent ---- */

    /* What is typed meanwhile stays. */
    async #applyChanges() {
        for (const [name, text] of [...this.#changes]) {
            await this.#settings.apply({ [name]: Number(text) });
            if (this.#changes.get(name) === text) this.#changes.delete(name);
        }
    }

    /* Asks first if feedback or Stop would be lost. */
    async #mayApply() {
        const risks = risksOf(Object.fromEntries([...this.#changes].map(([name, text]) => [name, Number(text)])));
        const text = risks.map((name) => t.risks[name]).join(" ");

        return !risks.length || confirmed({ text, yes: t.applyAllTheSame });
    }

    #apply = async () => {
        if (await this.#mayApply()) await this.#do(() => this.#applyChanges());
    };

    #save = async () => {
        if (!(await this.#mayApply())) return;
        await this.#do(async () => {
            await this.#applyChanges();
            await this.#settings.save();
        });
    };

    #undo = () => {
        this.#changes.clear();
        this.#do(() => this.#settings.read());
    };

    #defaults = async () => {
        if (!(await confirmed({ text: t.confirmDefaults, yes: t.confirmYes }))) return;
        this.#changes.clear();
        await this.#do(() => this.#settings.defaults());
    };

    /* ---- rendering ---- */

    #field(row, choices) {
        const { name } = row;
        const text = this.#changes.get(name) ?? String(this.#settings.values.get(name) ?? "");
        const id = `setting-${name}`;
        const option = ([value, choice]) => html`<option value=${value}
            .selected=${String(value) === text}>${choice}</option>`;

        if (choices)
            return html`<select id=${id} aria-describedby="help-${name}" @change=${({ target }) => this.#type(name, target.value)}>
                ${choices.map(option)}
            </select>`;
        return html`<input
            id=${id}
            inputmode="numeric"
            .value=${text}
            aria-invalid=${this.#isWrong(row)}
            aria-describedby="help-${name}"
            @input=${({ target }) => this.#type(name, target.value)}
        />`;
    }

    #row(row) {
        const { name, lowest, highest, initial, unit, what } = row;
        const isWrong = this.#isWrong(row);
        const value = Number(this.#changes.get(name) ?? this.#settings.values.get(name));
        const choices = choicesOf(name, this.#settings.values.get(name));
        const meaning = name === "return_delay" && !isWrong ? `${DELAY_US * value} ${t.us}` : "";
        const shownUnit = /^[a-z]+$/.test(unit) && !choices ? unit.replace("us", t.us) : "";

        return html`<div class="setting ${this.#changes.has(name) ? "changed" : ""}" data-name=${name}>
            <label for="setting-${name}">${name}</label>
            <div class="value">${this.#field(row, choices)} <span class="unit">${meaning || shownUnit}</span></div>
            <p class="help" id="help-${name}">
                ${what}. ${choices ? nothing : html`<span class="soft">${t.range(lowest, highest, initial)}</span>`}
                ${isWrong ? html`<strong class="bad">${texts.setup.problems.outOfRange}</strong>` : nothing}
                ${name === "echo" && value === 0 && !this.#settings.isSaved ? html`<strong class="warn">${t.echoHint}</strong>` : nothing}
            </p>
        </div>`;
    }

    #state() {
        if (this.#changes.size) return t.changed(this.#changes.size);
        return { true: t.saved, false: t.notSaved, null: t.unknownSaved }[this.#settings.isSaved];
    }

    #buttons() {
        const isBlocked = this.#isBusy || this.#wrong.length > 0;
        const hasChanges = this.#changes.size > 0;

        return html`<p class="controls">
            <button class="apply" title=${t.applyHint} ?disabled=${isBlocked || !hasChanges} @click=${this.#apply}>${t.apply}</button>
            <button class="save-settings" title=${t.saveHint} ?disabled=${isBlocked || (this.#settings.isSaved && !hasChanges)} @click=${this.#save}>${t.save}</button>
            <button class="undo" ?disabled=${this.#isBusy} aria-label=${hasChanges ? t.undo : t.readAgainOf(t.settings)}
                @click=${this.#undo}>${hasChanges ? t.undo : t.readAgain}</button>
            <button class="defaults" ?disabled=${this.#isBusy} @click=${this.#defaults}>${t.defaults}</button>
            <span class="settings-state" role="status">${this.#state()}</span>
        </p>`;
    }

    /* The first read may have failed, as by a stop. */
    #unread() {
        if (this.#isBusy || !this.#settings) return html`<p>${t.reading}</p>`;
        return html`<p>${t.settingsUnread}
            <button class="undo" aria-label=${t.readAgainOf(t.settings)} @click=${this.#undo}>${t.readAgain}</button></p>`;
    }

    render() {
        if (!this.#settings?.values.size) return html`<section><h2>${t.settings}</h2>${this.#unread()}</section>`;
        return html`<section aria-labelledby="settings-title">
            <h2 id="settings-title">${t.settings}</h2>
            ${this.#settings.origin ? html`<p class="soft">${t.atStart(this.#settings.origin)}</p>` : nothing} ${this.#buttons()}
            <div class="settings">${this.#settings.rows.map((row) => this.#row(row))}</div>
        </section>`;
    }
}

customElements.define("panel-settings", SettingsPart);
