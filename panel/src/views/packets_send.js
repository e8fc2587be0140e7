// SPDX-License-Identifier: MIT
/* A form for a packet by hand: its bytes are shown as they are typed, and its reply in words. */

import { html, nothing } from "lit/html.js";
import { AT_ID, AT_INSTRUCTION, BROADCAST_ID, INSTRUCTION, packet, toHex } from "../wire/packet.js";
import { packetChangesOwnMode, sendPacket } from "../model/by_hand.js";
import { ComposeError, compose } from "../model/compose.js";
import { hexByte } from "../model/decode.js";
import { typedNumber } from "../model/units.js";
import { noticeText, texts } from "../texts/texts.js";
import { confirmed } from "./confirm.js";
import { Part } from "./part.js";

const t = texts.packets;
const READS = ["READ", "SYNC_READ", "BULK_READ"];
const WRITES = ["WRITE", "REG_WRITE", "SYNC_WRITE"];
const COUNT_MAX = 250;

class SendPart extends Part {
    constructor() {
        super();
        this.form = { instruction: "PING", ids: "1", address: 0x24, count: 2, values: "", hex: "" };
        this.outcome = null; // {level, text}
        this.isSending = false;
    }

    #set(name, value) {
        this.form = { ...this.form, [name]: value };
        this.#show(null);
    }

    get #decoder() {
        return this.session.traffic.decoder;
    }

    /* Registers to choose from: those of the device if its ID stands alone; for a write only those that take one. */
    get #registers() {
        const rows = [...this.#decoder.registersOf(Number(this.form.ids)).values()];

        return WRITES.includes(this.form.instruction) ? rows.filter(({ writable }) => writable) : rows;
    }

    /* The chosen register may be one that the instruction cannot write: then LED, which harms nothing. */
    #chooseInstruction(instruction) {
        this.#set("instruction", instruction);
        const rows = this.#registers;

        if (!rows.some(({ address }) => address === this.form.address))
            this.#chooseRegister((rows.find(({ name }) => name === "LED") ?? rows[0]).address);
    }

    #chooseRegister(address) {
        const row = this.#registers.find((one) => one.address === address);

        this.form = { ...this.form, address, count: row?.bytes ?? this.form.count };
        this.#set("address", address);
    }

    /* The packet, or an error of what is typed: {bytes} or {error}. A field that is empty yet is no error. */
    #packet() {
        try {
            return { bytes: compose(this.form, this.#decoder, this.session.tables.units) };
        } catch (error) {
            if (!(error instanceof ComposeError)) throw error;
            const { hex, values } = this.form;
            if (error.code === "value" && !values) return { error: t.noValues };
            return { error: error.code === "short" && !hex ? "" : t.malformed[error.code](error.detail) };
        }
    }

    /* ---- sending ---- */

    #submit = async (event) => {
        event.preventDefault();
        const { bytes } = this.#packet();

        if (!bytes || this.isSending || !this.session.isConnected) return;
        if (packetChangesOwnMode(this.session, bytes)) return this.#show({ level: "error", text: t.ownMode });
        if (bytes[AT_INSTRUCTION] === INSTRUCTION.RESET && !(await this.#mayReset(bytes))) return;
        this.isSending = true;
        this.#show(null);
        const outcome = await this.#send(bytes);

        this.isSending = false;
        this.#show(outcome);
    };

    #show(outcome) {
        this.outcome = outcome;
        this.requestUpdate();
    }

    #mayReset(bytes) {
        const id = bytes[AT_ID];
        const who = id === BROADCAST_ID ? t.resetAll : t.resetOne(id);

        return confirmed({ text: t.confirmReset(who), yes: t.resetYes, no: texts.board.cancel });
    }

    async #send(bytes) {
        try {
            const replies = await sendPacket(this.session, bytes);

            if (!replies.length) return { level: "info", text: this.session.robot.isInhibited ? `${t.sent} ${t.inhibited}` : t.sent };
            return { level: replies.some(({ error }) => error) ? "error" : "info", text: this.#replies(bytes, replies) };
        } catch (error) {
            return { level: "error", text: this.#failure(error) };
        }
    }

    #replies(bytes, replies) {
        return replies
            .map(({ id, error, parameters }, index) => {
                const { name, text } = this.#decoder.status(packet(id, error, [...parameters]), bytes, index);

                return t.reply(this.#decoder.nameOf(id), name, text);
            })
            .join("\n");
    }

    #failure(error) {
        const { text, remedy } = noticeText({ ...error, code: error.code ?? "unexpected", detail: "", message: error.message });

        if (error.code === "timeout" && this.session.robot.isInhibited) return `${text} ${t.inhibited}`;
        return `${text} ${remedy}`;
    }

    /* ---- rendering ---- */

    #field(name, label, hint, attributes = {}) {
        return html`<label class=${attributes.wide ? "wide" : ""}>
            ${label}
            <input class="send-${name}" size=${attributes.size ?? 8} .value=${String(this.form[name])} aria-describedby="hint-${name}"
                autocomplete="off" spellcheck="false" @input=${({ target }) => this.#set(name, target.value)} />
            <span class="hint" id="hint-${name}">${hint}</span>
        </label>`;
    }

    #register() {
        return html`<label>
            ${t.register}
            <select class="send-register" @change=${({ target }) => this.#chooseRegister(Number(target.value))}>
                ${this.#registers.map(
                    ({ name, address }) =>
                        html`<option value=${address} .selected=${address === this.form.address}>${hexByte(address)} ${name}</option>`,
                )}
            </select>
        </label>`;
    }

    #count() {
        return html`<label>
            ${t.bytes}
            <input class="send-count" inputmode="numeric" size="4" .value=${String(this.form.count)}
                @input=${({ target }) => this.#set("count", Math.min(COUNT_MAX, Math.max(1, Math.trunc(typedNumber(target.value)) || 1)))} />
        </label>`;
    }

    #fields() {
        const { instruction } = this.form;
        const isMany = INSTRUCTION[instruction] >= INSTRUCTION.SYNC_WRITE;

        if (instruction === "hex") return this.#field("hex", t.hex, t.hexHint, { wide: true, size: 24 });
        return html`
            ${this.#field("ids", isMany ? t.ids : t.id, isMany ? t.idsHint : "", { size: isMany ? 10 : 4 })}
            ${READS.includes(instruction) || WRITES.includes(instruction) ? this.#register() : nothing}
            ${READS.includes(instruction) ? this.#count() : nothing}
            ${WRITES.includes(instruction)
                ? this.#field("values", t.values, instruction === "SYNC_WRITE" ? t.valuesOfMany : t.valuesHint, { wide: true, size: 16 })
                : nothing}
        `;
    }

    #preview({ bytes, error }) {
        if (!bytes) return html`<p class="preview malformed" role="status">${error}</p>`;
        const { name, text } = this.#decoder.instruction(bytes);

        return html`<p class="preview" role="status">
            ${t.preview}: <code>${toHex(bytes)}</code><br />
            <span class="soft">${this.#decoder.nameOf(bytes[AT_ID])} ${name} ${text}</span>
        </p>`;
    }

    render() {
        const made = this.#packet();
        const { instruction } = this.form;

        return html`<section aria-label=${t.send}>
            <h2>${t.send}</h2>
            <form class="send" @submit=${this.#submit}>
                <div class="fields">
                    <label>
                        ${t.instruction}
                        <select class="send-instruction" @change=${({ target }) => this.#chooseInstruction(target.value)}>
                            ${Object.keys(t.explain).map(
                                (name) => html`<option value=${name} ?selected=${name === instruction}>${name === "hex" ? t.inHex : name.replace("_", " ")}</option>`,
                            )}
                        </select>
                    </label>
                    ${this.#fields()}
                </div>
                <p class="hint">${t.explain[instruction]}</p>
                ${this.#preview(made)}
                <button class="send-button" ?disabled=${!made.bytes || this.isSending || !this.session.isConnected}>
                    ${this.isSending ? t.sending : t.sendButton}
                </button>
                <p class="outcome ${this.outcome?.level ?? ""}" role="status" aria-live="polite">${this.outcome?.text ?? ""}</p>
            </form>
        </section>`;
    }
}

customElements.define("panel-send", SendPart);
