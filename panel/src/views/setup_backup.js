// SPDX-License-Identifier: MIT
/* Backup of a servo or the robot as a file; restore, which shows first what differs. */

import { html, nothing } from "lit/html.js";
import { SIZE_MAX } from "../model/backup.js";
import { valueText } from "../model/registers.js";
import { texts } from "../texts/texts.js";
import { textOfFile } from "./read_file.js";
import { saveFile } from "./save_file.js";
import { SetupPart, nameOf } from "./setup_part.js";

const t = texts.setup;
const LIMITS = ["CW_ANGLE_LIMIT", "CCW_ANGLE_LIMIT"];
const UNKNOWN = new Set(["unconfirmed", "unread"]); // outcomes of a register that may have been written

class BackupPart extends SetupPart {
    #isAll = false; // what a restore takes from a file
    #file = ""; // name of the file that was chosen last

    async #save(id) {
        const text = await this.setup.backup(id);

        if (text) saveFile(t.fileName(id, new Date().toISOString().slice(0, 10)), text, "application/json");
    }

    #open = async ({ target }) => {
        const [file] = target.files;

        target.value = ""; // the same file can be chosen again
        if (!file) return;
        this.setup.forgetPlan(); // it is of another file
        this.#file = file.name;
        const scope = this.#isAll ? null : this.setup.id;
        const text = await this.session.attempt(() => textOfFile(file, SIZE_MAX), "compare");

        if (text !== undefined) await this.setup.compare(text, scope);
    };

    /* ---- what differs, and what became of it ---- */

    #head(columns) {
        return html`<thead><tr>${columns.map((text) => html`<th scope="col">${text}</th>`)}</tr></thead>`;
    }

    #value(row, raw) {
        return html`${valueText(row, raw)} <span class="soft">(${raw})</span>`;
    }

    #row(cells) {
        return html`<tr>${cells.map((cell) => html`<td>${cell}</td>`)}</tr>`;
    }

    #plan({ servos }) {
        const rows = servos.flatMap(({ id, changes }) => changes.map((change) => ({ id, ...change })));
        const count = new Set(rows.map(({ id }) => id)).size;
        const endless = servos.filter(({ entry, changes }) => changes.some(({ row }) => LIMITS.includes(row.name)) && !LIMITS.some((name) => entry.registers[name])).map(({ id }) => id);

        if (!rows.length)
            return html`<p class="plan" role="status">
                ${t.fromFile(this.#file)} ${t.same} <button class="close" @click=${() => this.setup.forgetPlan()}>${t.close}</button>
            </p>`;
        return html`<div class="plan">
            <p role="status">${t.fromFile(this.#file)} <b>${t.differs(rows.length, count)}</b>
                ${endless.length ? html`<strong class="warn">${t.endless(endless)}</strong>` : nothing}</p>
            <table class="differences">
                ${this.#head([t.columnServo, t.columnRegister, t.columnNow, t.columnFile])}
                <tbody>${rows.map(({ id, row, now, file }) => this.#row([id, nameOf(row), this.#value(row, now), this.#value(row, file)]))}</tbody>
            </table>
            <div class="controls">
                <button class="restore" ?disabled=${this.setup.isRunning}
                    @click=${() => this.setup.restore()}>${t.writeAll(rows.length)}</button>
                <button class="close" ?disabled=${this.setup.isRunning} @click=${() => this.setup.forgetPlan()}>${texts.board.cancel}</button>
            </div>
        </div>`;
    }

    #restored(outcomes) {
        const failed = outcomes.filter(({ why }) => why);
        const taken = outcomes.length - failed.length;
        const open = failed.filter(({ why }) => UNKNOWN.has(why)).length;
        const refused = failed.length - open;

        if (this.runs("restore")) return nothing;
        return html`<div class="restored">
            <p role="status">
                ${this.setup.isRestoreEarlier ? t.restoreEarlier : nothing}
                ${taken ? html`<b class="good">${t.restored(taken)}</b>` : nothing}
                ${refused ? html`<b class="bad">${t.notTaken(refused)}</b>` : nothing}
                ${open ? html`<b class="warn">${t.notConfirmed(open)}</b>` : nothing}
                <button class="close" @click=${() => this.setup.forgetPlan()}>${t.close}</button>
            </p>
            ${failed.length
                ? html`<table class="differences">
                      ${this.#head([t.columnServo, t.columnRegister, t.columnFile, t.columnOutcome])}
                      <tbody>${failed.map(({ id, row, file, why }) => this.#row([id, nameOf(row), this.#value(row, file), t.why[why] ?? why]))}</tbody>
                  </table>`
                : nothing}
        </div>`;
    }

    /* ---- rendering ---- */

    #forms(id) {
        const { setup } = this;
        const isRunning = setup.isRunning;

        return html`<div class="controls">
                <button class="save-one" ?disabled=${isRunning} @click=${() => this.#save(id)}>${t.saveOne(id)}</button>
                <button class="save-all" ?disabled=${isRunning} @click=${() => this.#save(null)}>${t.saveAll}</button>
            </div>
            <div class="controls">
                <label>${t.scope}
                    <select class="scope" ?disabled=${isRunning} @change=${({ target }) => (this.#isAll = target.value === "all")}>
                        <option value="one" .selected=${!this.#isAll}>${t.scopeOne(id)}</option>
                        <option value="all" .selected=${this.#isAll}>${t.scopeAll}</option>
                    </select>
                </label>
                <label>${t.file} <input class="backup-file" type="file" accept=".json,application/json" ?disabled=${isRunning}
                    @change=${this.#open} /></label>
            </div>`;
    }

    render() {
        const { setup } = this;
        const { id, plan, restored } = setup;

        return html`<section aria-labelledby="backup-title">
            <h2 id="backup-title">${t.backup}</h2>
            <p class="hint">${t.backupHint}</p>
            ${id === null ? html`<p>${t.noServo}</p>` : this.#forms(id)} ${this.progressOf("backup", t.saving)}
            ${this.progressOf("compare", t.comparing)} ${this.progressOf("restore", t.restoring)} ${plan ? this.#plan(plan) : nothing}
            ${restored ? this.#restored(restored) : nothing}
        </section>`;
    }
}

customElements.define("panel-setup-backup", BackupPart);
