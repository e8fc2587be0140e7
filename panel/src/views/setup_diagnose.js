// SPDX-License-Identifier: MIT
/* Why a servo does not answer, in words. */

import { html, nothing } from "lit/html.js";
import { texts } from "../texts/texts.js";
import { ID_MAX } from "../wire/packet.js";
import { SetupPart } from "./setup_part.js";

const t = texts.setup;
const OTHER = "other";

class DiagnosePart extends SetupPart {
    #who = null; // null: a servo is proposed
    #other = "1";
    #isRunning = false;

    /* The chosen servo. At first one that does not answer, else the one of the registers. */
    get #chosen() {
        const offline = [...this.session.robot.servos.values()].find(({ presence }) => presence === "offline");

        return this.#who ?? String(offline?.id ?? this.setup.id ?? "");
    }

    get #isWrong() {
        return this.#who === OTHER && (!/^\d+$/.test(this.#other) || Number(this.#other) > ID_MAX);
    }

    #start = () => {
        const who = this.#who === OTHER ? this.#other : this.#chosen;

        this.setup.diagnose(/^\d+$/.test(who) ? Number(who) : who);
    };

    #set(name, value) {
        if (name === "who") this.#who = value;
        else this.#other = value.trim();
        this.requestUpdate();
    }

    #choices() {
        const { ids, hasLists } = this.setup;
        const all = hasLists && ids.length ? [["all", t.allServos]] : [];
        const choices = [["", t.anyServo], ...all, ...ids.map((id) => [String(id), t.servo(id)]), [OTHER, t.otherId]];

        return choices.map(([value, text]) => html`<option value=${value} .selected=${value === this.#chosen}>${text}</option>`);
    }

    #finding({ id, text, remedy, measured, isGood }) {
        return html`<li class=${isGood ? "finding good" : "finding"}>
            <p><b>${id === null ? t.someServo : t.servo(id)}:</b> ${text}.</p>
            ${remedy && !isGood ? html`<p><b>${texts.remedy}</b> ${remedy}.</p>` : nothing}
            <p class="soft">${measured.map(t.measured).join(" ")}</p>
        </li>`;
    }

    /* The result is often below the screen. */
    updated() {
        const isOver = this.#isRunning && !this.runs("diagnose");

        this.#isRunning = this.runs("diagnose");
        if (isOver) this.querySelector(".findings")?.scrollIntoView({ block: "nearest" });
    }

    #form() {
        const { setup } = this;

        return html`<p class="hint">${t.diagnoseHint}</p>
            <div class="controls">
                <label>${t.servoChoice}
                    <select class="whom" ?disabled=${setup.isRunning}
                        @change=${({ target }) => this.#set("who", target.value)}>${this.#choices()}</select>
                </label>
                ${this.#who === OTHER
                    ? html`<label>${t.otherIdLabel}
                          <input inputmode="numeric" .value=${this.#other} aria-invalid=${this.#isWrong}
                              @input=${({ target }) => this.#set("other", target.value)} />
                      </label>`
                    : nothing}
                <button class="diagnose" ?disabled=${setup.isRunning || this.#isWrong} @click=${this.#start}>${t.diagnose}</button>
            </div>
            ${this.progressOf("diagnose", t.diagnosing)}
            ${setup.isDiagnosisEnded ? html`<p class="diagnosis-ended" role="status">${t.diagnosisEnded}</p>` : nothing}
            <ul class="findings" role="status">${setup.findings.map((finding) => this.#finding(finding))}</ul>`;
    }

    render() {
        return html`<section aria-labelledby="diagnosis-title">
            <h2 id="diagnosis-title">${t.diagnosis}</h2>
            ${this.setup.has("diagnose") ? this.#form() : this.missing()}
        </section>`;
    }
}

customElements.define("panel-setup-diagnose", DiagnosePart);
