// SPDX-License-Identifier: MIT
/* A console: a line, its reply, earlier lines by Up and Down, completion by Tab. Tab leaves the field if
 * there is nothing to complete, so the keyboard is never caught in it. */

import { html, nothing } from "lit";
import { repeat } from "lit/directives/repeat.js";
import { sendLine } from "../model/by_hand.js";
import { LineHistory, complete, isOfBoard } from "../model/console_line.js";
import { noticeText, texts } from "../texts/texts.js";
import { Part } from "./part.js";

const t = texts.packets;
const REPLIES_MAX = 100;
const LINES_MAX = 1000; // of one reply: `monitor` goes on until it is ended
const PERIOD_MS = 100;

class ConsolePart extends Part {
    #history = new LineHistory();
    #timer = null;
    #number = 0;

    constructor() {
        super();
        this.replies = []; // {number, line, lines, end: "", "ok", or what went wrong}
        this.choices = [];
        this.running = null; // AbortController of the command under way
    }

    get #field() {
        return this.querySelector(".console-line");
    }

    get #tables() {
        const { controller, tables } = this.session;
        const has = tables.commands.filter(({ usage }) => controller?.commands.has(usage));

        return { commands: has.length ? has : tables.commands, registers: tables.registers, settings: tables.settings };
    }

    #later = () => {
        this.#timer ??= setTimeout(() => {
            this.#timer = null;
            this.requestUpdate();
        }, PERIOD_MS);
    };

    /* ---- a command ---- */

    #submit = async (event) => {
        event.preventDefault();
        const line = this.#field.value.trim();

        if (!line || this.running || !this.session.wire?.hasConsole) return;
        this.#history.add(line);
        this.#field.value = "";
        this.choices = [];
        const reply = { number: this.#number++, line, lines: [], end: "" };

        this.replies = [...this.replies, reply].slice(-REPLIES_MAX);
        await this.#run(reply);
        this.requestUpdate();
    };

    async #run(reply) {
        reply.end = this.#refusal(reply.line);
        if (reply.end) return;
        this.running = new AbortController();
        this.requestUpdate();
        try {
            reply.end = await this.#send(reply);
        } catch (error) {
            reply.end = error.code === "stopped" ? t.ended : noticeText({ ...error, detail: "" }).text;
        } finally {
            this.running = null;
        }
    }

    /* Why the page does not send a line; "": it does. */
    #refusal(line) {
        if (isOfBoard(line)) return t.useBoard;
        return /[^\x20-\x7e]/.test(line) ? t.notText : "";
    }

    async #send(reply) {
        const onLine = (text) => {
            reply.lines.push(text);
            if (reply.lines.length > LINES_MAX) reply.lines.shift();
            this.#later();
        };
        const { error } = await sendLine(this.session, reply.line, { onLine, signal: this.running.signal });

        return error ? `error ${error.number}: ${error.text}` : "ok";
    }

    /* ---- keys ---- */

    #key = (event) => {
        const field = this.#field;

        if (event.key === "ArrowUp" || event.key === "ArrowDown") {
            field.value = event.key === "ArrowUp" ? this.#history.up(field.value) : this.#history.down(field.value);
            event.preventDefault();
        } else if (event.key === "Tab" && !event.shiftKey && this.#complete(field)) {
            event.preventDefault();
        }
    };

    /* False: nothing to complete, and the choices are shown already. */
    #complete(field) {
        if (!field.value.trim()) return false;
        const { line, choices } = complete(field.value, this.#tables);
        const isNew = line !== field.value || choices.join() !== this.choices.join();

        field.value = line;
        this.choices = choices.length > 1 ? choices : [];
        this.requestUpdate();
        return choices.length > 0 && isNew;
    }

    #take(usage) {
        const field = this.#field;

        field.value = `${usage.split(" ")[0]} `;
        field.focus();
    }

    updated() {
        const output = this.querySelector(".console-output");

        if (output) output.scrollTop = output.scrollHeight;
    }

    /* ---- rendering ---- */

    #reply({ line, lines, end }) {
        return html`<li>
            <pre><b>&gt; ${line}</b>${lines.map((text) => `\n${text}`)}${end ? "\n" : nothing}<span class=${end === "ok" ? "good" : "bad"}>${end}</span></pre>
        </li>`;
    }

    #commands() {
        const { commands } = this.#tables;
        const headings = [...new Set(commands.map((row) => row.heading))];

        return html`<details class="commands">
            <summary>${t.commands}</summary>
            ${headings.map(
                (heading) => html`<h3>${heading}</h3>
                    <ul>
                        ${commands
                            .filter((row) => row.heading === heading)
                            .map(
                                (row) => html`<li>
                                    <button class="plain" @click=${() => this.#take(row.usage)}><code>${row.usage}</code></button>
                                    ${row.what}
                                </li>`,
                            )}
                    </ul>`,
            )}
        </details>`;
    }

    #form() {
        return html`<form class="console-form" @submit=${this.#submit}>
            <label>
                ${t.command}
                <input class="console-line" autocomplete="off" autocapitalize="off" spellcheck="false" maxlength="240"
                    aria-describedby="console-keys" ?disabled=${!this.session.isConnected} @keydown=${this.#key} />
            </label>
            ${this.running
                ? html`<button type="button" class="console-end" @click=${() => this.running?.abort()}>${t.end}</button>`
                : html`<button class="console-run" ?disabled=${!this.session.isConnected}>${t.run}</button>`}
        </form>`;
    }

    render() {
        const { session } = this;

        if (session.isConnected && !session.wire.hasConsole)
            return html`<section aria-labelledby="console-title">
                <h2 id="console-title">${t.console}</h2>
                <p>${t.noConsole}</p>
            </section>`;
        return html`<section aria-labelledby="console-title">
            <h2 id="console-title">${t.console}</h2>
            <ol class="console-output" role="log" tabindex="0" aria-label=${t.output}>
                ${repeat(this.replies, ({ number }) => number, (reply) => this.#reply(reply))}
            </ol>
            ${this.#form()}
            <p class="hint" id="console-keys" role="status">${this.choices.length ? t.choices(this.choices) : t.keys}</p>
            ${this.#commands()}
        </section>`;
    }
}

customElements.define("panel-console", ConsolePart);
