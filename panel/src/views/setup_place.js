// SPDX-License-Identifier: MIT
/* The choice of a servo; its ID, rate and factory values. Each change is asked for in a dialog. */

import { html, nothing } from "lit/html.js";
import { RATES } from "../model/setup.js";
import { texts } from "../texts/texts.js";
import { ID_MAX } from "../wire/packet.js";
import { confirmed } from "./confirm.js";
import { SetupPart } from "./setup_part.js";

const t = texts.setup;

const labelled = (text, control) => html`<label class="dialog-field">${text} ${control}</label>`;

const idField = (label, proposed) => ({
    field: labelled(label, html`<input class="dialog-value" inputmode="numeric" size="5" value=${proposed ?? ""} />`),
    isReady: (value) => /^\d+$/.test(value) && Number(value) <= ID_MAX,
});

const rateField = (label) => ({
    field: labelled(label, html`<select class="dialog-value">${RATES.map((rate) => html`<option value=${rate}>${t.rate(rate)}</option>`)}</select>`),
});

class PlacePart extends SetupPart {
    #ask(text, label, field) {
        return confirmed({ text, yes: label.replace(" …", ""), ...field });
    }

    #changeId = async (id) => {
        const to = await this.#ask(t.askId(id, this.setup.isFull), t.changeId, idField(t.newIdOf(id), this.setup.freeId));

        if (to) await this.setup.changeId(id, Number(to));
    };

    #changeRate = async (id) => {
        const rate = await this.#ask(t.askRate(id), t.changeRate, rateField(t.newRateOf(id)));

        if (rate) await this.setup.changeRate(id, Number(rate));
    };

    #changeRateOfAll = async () => {
        const rate = await this.#ask(t.askRateOfAll, t.changeRateOfAll, rateField(t.newRateOfAll));

        if (rate) await this.setup.changeRateOfAll(Number(rate));
    };

    #factory = async (id) => {
        const isTaken = id !== 1 && this.setup.ids.includes(1); // then the controller refuses

        if (await this.#ask(t.askFactory(id, isTaken), t.factory, { isReady: () => !isTaken })) await this.setup.factory(id);
    };

    #outcome() {
        const { outcome } = this.setup;

        if (!outcome || !t.outcomes[outcome.kind]) return nothing;
        return html`<div class="place-outcome" role="status">
            <p class=${outcome.kind === "partly" || outcome.kind === "unchanged" ? "warn" : "good"}>${t.outcomes[outcome.kind]}</p>
            ${this.linesOf(outcome.lines)}
        </div>`;
    }

    #buttons(id) {
        const { setup } = this;
        const button = (command, name, text, call) =>
            setup.has(command) ? html`<button class=${name} ?disabled=${setup.isRunning}
                @click=${() => call(id)}>${text}</button>` : nothing;

        return html`<div class="controls">
            <label>${t.servoLabel}
                <select class="servo" ?disabled=${setup.isRunning} @change=${({ target }) => setup.choose(Number(target.value))}>
                    ${setup.ids.map((one) => html`<option value=${one} .selected=${one === id}>${one}</option>`)}
                </select>
            </label>
            ${button("id", "change-id", t.changeId, this.#changeId)} ${button("baud", "change-rate", t.changeRate, this.#changeRate)}
            ${setup.hasLists ? button("baud", "change-rate-of-all", t.changeRateOfAll, this.#changeRateOfAll) : nothing}
            ${button("factory", "factory", t.factory, this.#factory)}
        </div>`;
    }

    render() {
        const { id } = this.setup;

        return html`<section aria-labelledby="place-title">
            <h2 id="place-title">${t.place}</h2>
            ${id === null ? html`<p>${t.noServo}</p>` : this.#buttons(id)} ${this.session.wire.hasConsole ? nothing : this.missing()}
            ${this.#outcome()}
        </section>`;
    }
}

customElements.define("panel-setup-place", PlacePart);
