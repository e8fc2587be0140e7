// SPDX-License-Identifier: MIT
/* Guided set-up of a new servo: the controller tells its steps. */

import { html, nothing } from "lit/html.js";
import { texts } from "../texts/texts.js";
import { ID_MAX } from "../wire/packet.js";
import { SetupPart } from "./setup_part.js";

const t = texts.setup;

class NewPart extends SetupPart {
    #typed = null; // what the user typed; null: the next free ID is proposed

    get #text() {
        return this.#typed ?? String(this.setup.freeId ?? "");
    }

    get #isWrong() {
        return !/^\d+$/.test(this.#text) || Number(this.#text) > ID_MAX || this.#isOfDevice;
    }

    get #isOfDevice() {
        return Number(this.#text) === this.setup.idOfDevice;
    }

    #start = () => this.#setUp(Number(this.#text), { forgets: this.#mustForget });

    async #setUp(id, options) {
        await this.setup.setUpNew(id, options);
        this.#typed = null;
        this.requestUpdate();
    }

    #type({ target }) {
        this.#typed = target.value.trim();
        this.requestUpdate();
    }

    get #isListed() {
        return this.setup.ids.includes(Number(this.#text));
    }

    /* True if the controller refuses the ID: its list has it, or is full. */
    get #mustForget() {
        return !this.#isWrong && (this.setup.isFull || this.#isListed);
    }

    #note() {
        if (this.#isWrong) return html`<strong class="bad">${this.#isOfDevice ? t.newIdOfDevice(this.#text) : t.newIdWrong}</strong>`;
        if (this.#mustForget) return html`<strong class="warn">${this.#isListed ? t.newIdTaken(this.#text) : t.newFull}</strong>`;
        return t.newIdHint(this.setup.freeId);
    }

    #outcome() {
        const { outcome } = this.setup;

        if (outcome?.kind === "new") return html`<p class="new-outcome good" role="status">${t.newDone(outcome.id)}</p>`;
        if (outcome?.kind === "newKnown") return this.#known(outcome.id);
        return outcome?.kind === "newEnded" ? html`<p class="new-outcome" role="status">${t.newEnded}</p>` : nothing;
    }

    /* The controller cannot tell the new servo from one of its list: the user can. */
    #known(id) {
        return html`<div class="new-outcome" role="status"><p class="warn">${t.newKnown}</p>
            <button class="forget-and-set-up" ?disabled=${this.setup.isRunning}
                @click=${() => this.#setUp(id, { forgets: true })}>${t.newForget(id)}</button></div>`;
    }

    render() {
        const { setup } = this;

        return html`<section aria-labelledby="new-title">
            <h2 id="new-title">${t.newServo}</h2>
            ${setup.has("new") ? this.#form() : this.missing()}
        </section>`;
    }

    #form() {
        const { setup } = this;

        return html`<p class="hint">${t.newHint}</p>
            <div class="controls">
                <label>${t.newId}
                    <input class="new-id" inputmode="numeric" .value=${this.#text} ?disabled=${setup.isRunning}
                        aria-invalid=${this.#isWrong} aria-describedby="new-id-note" @input=${(event) => this.#type(event)} />
                </label>
                <button class="set-up-new" ?disabled=${setup.isRunning || this.#isWrong} @click=${this.#start}>${this.#mustForget ? t.newForget(this.#text) : t.newStart}</button>
            </div>
            <p class="hint" id="new-id-note">${this.#note()}</p>
            ${this.progressOf("new", t.newServo)}
            <div class="steps" role="log">${this.linesOf(setup.steps)}</div>
            ${this.#outcome()}`;
    }
}

customElements.define("panel-setup-new", NewPart);
