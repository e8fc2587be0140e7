// SPDX-License-Identifier: MIT
/* Search for servos, and the rate of the bus. */

import { html, nothing } from "lit/html.js";
import { texts } from "../texts/texts.js";
import { RATES } from "../model/setup.js";
import { confirmed } from "./confirm.js";
import { SetupPart } from "./setup_part.js";

const t = texts.setup;

class FindPart extends SetupPart {
    #how = "";
    #rate = null; // chosen for the bus; null: its present rate

    #list() {
        const { found } = this.setup;

        if (!found?.length) return nothing;
        const columns = [t.columnId, t.columnModel, t.columnRate];
        const rows = found.map(({ id, model, rate }) => [id, model ?? t.noModel, rate ? t.rate(rate) : t.sameRate]);

        return html`<div class="found" tabindex="0" role="region" aria-label=${t.find}><table>
            <thead><tr>${columns.map((text) => html`<th scope="col">${text}</th>`)}</tr></thead>
            <tbody>${rows.map((cells) => html`<tr>${cells.map((cell) => html`<td>${cell}</td>`)}</tr>`)}</tbody>
        </table></div>`;
    }

    #state() {
        const { found, isPartial, operation } = this.setup;

        if (this.runs("search")) return operation.total ? t.progress(operation.done, operation.total) : t.searching;
        if (!found) return texts.status.servos(this.setup.ids.length);
        return `${isPartial && !found.length ? "" : t.foundCount(found.length)} ${isPartial ? t.searchEnded : ""}`.trim();
    }

    #ways() {
        const ways = this.session.wire.hasConsole ? Object.entries(t.hows) : Object.entries(t.hows).slice(0, 1);

        return ways.map(([how, text]) => html`<option value=${how} .selected=${how === this.#how}>${text}</option>`);
    }

    /* Servos that have torque keep it at another rate. */
    #setBusRate = async () => {
        if (this.session.mayHaveTorque && !(await confirmed({ text: t.askBusRate, yes: t.setBusRate }))) return;
        await this.setup.changeRateOfBus(this.#chosenRate);
        this.#rate = null;
    };

    /* A register holds a rate: 57600 bit/s is 57143 in truth. */
    get #chosenRate() {
        return this.#rate ?? RATES.find((rate) => Math.abs(rate - this.setup.busRate) < rate / 50) ?? RATES[0];
    }

    connectedCallback() {
        super.connectedCallback();
        this.setup.readBusRate();
    }

    #busRate() {
        const { setup } = this;
        const silent = [...this.session.robot.servos.values()].filter(({ hasOtherRate }) => hasOtherRate).length;

        if (!setup.has("bus")) return nothing;
        return html`<div class="controls">
                <label>${t.busRate}
                    <select class="bus-rate" @change=${({ target }) => (this.#rate = Number(target.value))}>
                        ${RATES.map((rate) => html`<option value=${rate} .selected=${rate === this.#chosenRate}>${t.rate(rate)}</option>`)}
                    </select>
                </label>
                <button class="set-bus-rate" ?disabled=${setup.isRunning}
                    @click=${this.#setBusRate}>${t.setBusRate}</button>
            </div>
            <p class="hint">${setup.busRate ? html`<strong class=${silent ? "warn" : ""}>${t.busHas(setup.busRate, silent)}</strong>` : nothing} ${t.busRateHint}</p>`;
    }

    render() {
        const { setup } = this;

        return html`<section aria-labelledby="find-title">
            <h2 id="find-title">${t.find}</h2>
            <div class="controls">
                <label>${t.how}
                    <select class="how" ?disabled=${setup.isRunning}
                        @change=${({ target }) => (this.#how = target.value)}>${this.#ways()}</select>
                </label>
                <button class="search" ?disabled=${setup.isRunning} @click=${() => setup.search(this.#how)}>${t.search}</button>
            </div>
            ${this.progressOf("search", t.searching)}
            <p class="search-state" role="status">${this.#state()}</p>
            ${this.#list()} ${this.linesOf(setup.remarks)} ${this.#busRate()}
        </section>`;
    }
}

customElements.define("panel-setup-find", FindPart);
