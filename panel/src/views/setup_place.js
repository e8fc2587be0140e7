// SPDX-License-Identifier: MIT
/* The choice of a servo; its ID, rate and factory values. Each change is asked for in a dialog. */

import { html, nothing } from "lit/html.js";
import { RATES } from "../model/setup.js";
import { texts } from "../texts/texts.js";
import { ID_MAX } from "../wire/packet.js";
import { confirmed } from "./confirm.js";
import { SetupPart } from "./setup_part.js";

const t = texts.setup;

/* A label with an input or a select in it, for the dialog. */
function labelled(text, control) {
    const label = document.createElement("label");

    label.className = "dialog-field";
    label.append(text, control);
    return label;
}

function idField(label, proposed) {
    const attributes = { inputMode: "numeric", size: 5, value: proposed ?? "", className: "dialog-value" };
    const input = Object.assign(document.createElement("input"), attributes);

    return { control: input, field: labelled(label, input), isReady: () => /^\d+$/.test(input.value) && Number(input.value) <= ID_MAX };
}

function rateField(label) {
    const select = Object.assign(document.createElement("select"), { className: "dialog-value" });

    select.append(...RATES.map((rate) => new Option(t.rate(rate), rate)));
    return { control: select, field: labelled(label, select) };
}

class PlacePart extends SetupPart {
    async #ask(text, yes, { control, field, isReady } = {}) {
        const isConfirmed = await confirmed({ text, yes, no: t.cancel, field, isReady });

        return isConfirmed ? (control ? Number(control.value) : true) : null;
    }

    #changeId = async (id) => {
        const to = await this.#ask(t.askId(id), t.changeId.replace(" …", ""), idField(t.newIdOf(id), this.setup.freeId));

        if (to !== null) await this.setup.changeId(id, to);
    };

    #changeRate = async (id) => {
        const rate = await this.#ask(t.askRate(id), t.changeRate.replace(" …", ""), rateField(t.newRateOf(id)));

        if (rate !== null) await this.setup.changeRate(id, rate);
    };

    #changeRateOfAll = async () => {
        const rate = await this.#ask(t.askRateOfAll, t.changeRateOfAll.replace(" …", ""), rateField(t.newRateOfAll));

        if (rate !== null) await this.setup.changeRateOfAll(rate);
    };

    #factory = async (id) => {
        if (await this.#ask(t.askFactory(id), t.factory.replace(" …", ""))) await this.setup.factory(id);
    };

    #outcome() {
        const { outcome } = this.setup;

        if (outcome?.kind === "full")
            return html`<div class="place-outcome" role="status"><p class="warn">${t.listFull}</p>
                ${this.setup.isFull ? this.forgetButton() : nothing}</div>`;
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
