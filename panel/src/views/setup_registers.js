// SPDX-License-Identifier: MIT
/* The registers of a servo: all of them with value, unit, range, area and help; one at a time can be edited. */

import { html, nothing } from "lit/html.js";
import { rangeOf, rawAt, shownValue, typedValue, valueText } from "../model/registers.js";
import { unitText, withUnit } from "../model/units.js";
import { texts } from "../texts/texts.js";
import { confirmed } from "./confirm.js";
import { SetupPart } from "./setup_part.js";

const t = texts.setup;
const LIMITS = ["CW_ANGLE_LIMIT", "CCW_ANGLE_LIMIT"]; // the lower one, the upper one
const PLACES = new Set(["ID", "BAUD_RATE"]); // have buttons of their own
const FOCUSED = "panel-setup-registers .edit-form input";

function rangeText(row) {
    const [low, high] = rangeOf(row);

    return t.to(low, withUnit(high, row.scale.name));
}

class RegistersPart extends SetupPart {
    #edited = null; // {id, wire, name, unit, raw: texts of the fields, isRaw: which of them was typed}; of a servo at a wire
    #note = {}; // of the last write: {text, registers}; true until registers are read again

    /* ---- editing ---- */

    #edit(row) {
        const raw = rawAt(this.setup.registers.bytes, row);

        this.#edited = { id: this.setup.id, wire: this.session.wire, name: row.name, unit: shownValue(row, raw).number, raw: String(raw), isRaw: false };
        this.#note = {};
        this.requestUpdate();
        this.updateComplete.then(() => this.querySelector(FOCUSED)?.focus());
    }

    /* The focus goes back to the button Edit, unless the user has gone to another field. */
    #cancel(name) {
        const { activeElement } = document;
        const isHere = !activeElement || activeElement === document.body || this.contains(activeElement);

        this.#edited = null;
        this.requestUpdate();
        if (isHere) this.updateComplete.then(() => this.querySelector(`[data-register="${name}"] .edit`)?.focus());
    }

    /* One field follows the other. */
    #type(row, text, isRaw) {
        const edited = this.#edited;
        const { raw } = typedValue(row, text, isRaw);

        edited.isRaw = isRaw;
        edited[isRaw ? "raw" : "unit"] = text;
        edited[isRaw ? "unit" : "raw"] = raw === undefined ? "" : isRaw ? shownValue(row, raw).number : String(raw);
        this.requestUpdate();
    }

    get #typed() {
        const { name, isRaw, unit, raw } = this.#edited;

        const typed = typedValue(this.#rowOf(name), isRaw ? raw : unit, isRaw);

        return typed.raw !== undefined && this.#isCrossed(name, typed.raw) ? { problem: "crossed" } : typed;
    }

    #rowOf(name) {
        return this.setup.rows.find((row) => row.name === name);
    }

    /* True if the limit would be beyond the other limit, as it was read. */
    #isCrossed(name, raw) {
        if (!LIMITS.includes(name)) return false;
        const [low, high] = this.#limitsWith(name, raw);

        return low > high;
    }

    /* Both limits, as they were read, with `raw` as the limit `name`. */
    #limitsWith(name, raw) {
        return LIMITS.map((limit) => (limit === name ? raw : rawAt(this.setup.registers.bytes, this.#rowOf(limit))));
    }

    /* What must be confirmed before the write; undefined: nothing. */
    #questionFor({ name }, raw) {
        return LIMITS.includes(name) && this.#limitsWith(name, raw).some(Boolean) ? undefined : t.confirmations[name];
    }

    /* What is typed while the write is under way stays, and the form with it. */
    #write = async (row) => {
        const { raw } = this.#typed;
        const { id } = this.setup;
        const edited = this.#edited;
        const sent = { ...edited };
        const question = this.#questionFor(row, raw);

        if (raw === undefined || this.setup.isRunning) return;
        if (question && !(await confirmed({ text: t.asks(id, row.name, valueText(row, raw), question), yes: t.write }))) return;
        if (!(await this.setup.write(id, row, raw))) return;
        this.#note = { text: t.written(id, row.name), registers: this.setup.registers };
        if (this.#edited === edited && edited.unit === sent.unit && edited.raw === sent.raw) this.#cancel(row.name);
    };

    #key(event, row) {
        if (event.key === "Enter" && event.target.matches("input")) {
            event.preventDefault(); // it would press Cancel of the question, which gets the focus
            this.#write(row);
        }
        if (event.key === "Escape") this.#cancel(row.name);
    }

    #field(row, isRaw, text, problem) {
        const unit = isRaw ? t.rawValue : unitText(row.scale.name);

        return html`<label>
            <input inputmode="decimal" size="7" .value=${text} aria-label=${t.newValue(row.name, unit)}
                aria-invalid=${Boolean(problem) && this.#edited.isRaw === isRaw}
                aria-describedby="edit-note" @input=${({ target }) => this.#type(row, target.value, isRaw)} />
            ${unit}
        </label>`;
    }

    #form(row) {
        const { unit, raw } = this.#edited;
        const { problem } = this.#typed;
        const problemText = problem ? `${t.problems[problem]} ` : "";
        const range = rangeText(row);
        const rangeOfRaw = row.scale.name ? `; ${t.to(row.lowest, withUnit(row.highest, t.rawValue))}` : "";

        return html`<div class="edit-form" @keydown=${(event) => this.#key(event, row)}>
            ${row.scale.name ? this.#field(row, false, unit, problem) : nothing} ${this.#field(row, true, raw, problem)}
            <button class="write" ?disabled=${Boolean(problem) || this.setup.isRunning} @click=${() => this.#write(row)}>${t.write}</button>
            <button class="cancel" @click=${() => this.#cancel(row.name)}>${texts.board.cancel}</button>
            <span id="edit-note" role="status" class=${problem ? "bad" : "soft"}>${problemText}${range}${rangeOfRaw}</span>
        </div>`;
    }

    /* ---- the table ---- */

    #action(row) {
        if (!row.writable) return html`<span class="soft">${t.readOnly}</span>`;
        if (PLACES.has(row.name)) return nothing;
        return html`<button class="edit" aria-label=${t.editOf(row.name)} ?disabled=${this.setup.isRunning}
            @click=${() => this.#edit(row)}>${t.edit}</button>`;
    }

    #row(row, bytes) {
        const raw = rawAt(bytes, row);
        const isEdited = this.#edited?.name === row.name && this.#edited.id === this.setup.id;

        return html`<tr data-register=${row.name} class=${isEdited ? "edited" : ""}>
            <th scope="row"><code>${row.name}</code><span class="help">${texts.registers[row.name]}</span></th>
            ${isEdited
                ? html`<td class="form" colspan="5">${this.#form(row)}</td>`
                : html`<td class="value">${valueText(row, raw)}</td>
                      <td class="raw"><span class="unit">${t.rawValue}</span> ${raw}</td>
                      <td class="range">${row.writable ? rangeText(row) : nothing}</td>
                      <td class="area">${row.area}</td>
                      <td class="action">${this.#action(row)}</td>`}
        </tr>`;
    }

    #table(registers) {
        const { bytes, at, isOld: isSilent } = registers;
        const note = this.#note.registers === registers && this.#note.text;
        const seconds = Math.max(0, Math.round((this.session.clock.now() - at) / 1000));
        const isRunning = this.session.isBusy || this.setup.isRunning;
        const isOld = isRunning || isSilent;

        return html`<p class="hint" role="status">${isRunning ? t.oldNow : isSilent ? t.oldSilent : note || t.readAt(seconds)} ${t.areaHint}</p>
            <table class=${isOld ? "registers old" : "registers"}>
                <thead>
                    <tr>
                        <th scope="col">${t.columnRegister}</th>
                        <th scope="col">${t.columnValue}</th>
                        <th scope="col">${t.columnRaw}</th>
                        <th scope="col">${t.columnRange}</th>
                        <th scope="col">${t.columnArea}</th>
                        <td></td>
                    </tr>
                </thead>
                <tbody>${this.setup.rows.map((row) => this.#row(row, bytes))}</tbody>
            </table>`;
    }

    render() {
        const { setup } = this;
        const { registers, id } = setup;
        const isShown = registers?.id === id;

        if (this.#edited?.wire !== this.session.wire) this.#edited = null;
        return html`<section aria-labelledby="registers-title">
            <h2 id="registers-title">${id === null ? t.registers : t.registersOf(id)}</h2>
            ${id === null
                ? html`<p>${t.noServo}</p>`
                : html`<div class="controls">
                          <button class="read-all" ?disabled=${setup.isRunning}
                              @click=${() => setup.readAll(id)}>${this.runs("read") ? t.reading : t.readAll}</button>
                      </div>
                      ${isShown ? this.#table(registers) : html`<p class="soft">${t.notRead}</p>`}`}
        </section>`;
    }
}

customElements.define("panel-setup-registers", RegistersPart);
