// SPDX-License-Identifier: MIT
/* A console: a line, its reply, earlier lines by Up and Down, completion by Tab. Tab leaves the field if
 * there is nothing to complete, so the keyboard is never caught in it. */

import { html, nothing } from "lit/html.js";
import { live } from "lit/directives/live.js";
import { repeat } from "lit/directives/repeat.js";
import { sendLine } from "../model/by_hand.js";
import { LineHistory, complete, changesOwnMode } from "../model/console_line.js";
import { noticeText, texts } from "../texts/texts.js";
import { Part } from "./part.js";

const t = texts.packets;
const REPLIES_MAX = 100;
const LINES_MAX = 1000; // of one reply: `monitor` goes on until it is ended
const PERIOD_MS = 100;
const NEAR_END = 8; // px

class ConsolePart extends Part {
    #history = new LineHistory();
    #timer = null;
    #number = 0;
    #isAtEnd = true; // the newest line is in sight

    constructor() {
        super();
        this.replies = []; // {number, line, lines, end: "", "ok", or what went wrong}
        this.text = ""; // what is typed; stays when the field goes, as at a firmware without console
        this.choices = [];
        this.running = null; // AbortController of the command under way
    }

    /* A list that is put into the document again begins at its top, and no event tells it. */
    connectedCallback() {
        super.connectedCallback();
        this.requestUpdate();
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
        const line = this.text.trim();

        if (!line || this.running || !this.session.wire?.hasConsole) return;
        this.#history.add(line);
        this.#isAtEnd = true;
        this.text = "";
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
        if (changesOwnMode(line)) return t.ownMode;
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
        if (event.key === "ArrowUp" || event.key === "ArrowDown") {
            this.#put(event.key === "ArrowUp" ? this.#history.up(this.text) : this.#history.down(this.text));
            event.preventDefault();
        } else if (event.key === "Tab" && !event.shiftKey && this.#complete()) {
            event.preventDefault();
        }
    };

    #put(text) {
        this.text = text;
        this.requestUpdate();
    }

    /* False: nothing to complete, and the choices are shown already. */
    #complete() {
        if (!this.text.trim()) return false;
        const { line, choices } = complete(this.text, this.#tables);
        const isNew = line !== this.text || choices.join() !== this.choices.join();

        this.choices = choices.length > 1 ? choices : [];
        this.#put(line);
        return choices.length > 0 && isNew;
    }

    #take(usage) {
        this.#put(`${usage.split(" ")[0]} `);
        this.#field.focus();
    }

    updated() {
        const output = this.querySelector(".console-output");

        if (this.#isAtEnd && output) output.scrollTop = output.scrollHeight;
    }

    #scrolled({ target }) {
        if (this.isConnected) this.#isAtEnd = target.scrollHeight - target.scrollTop - target.clientHeight <= NEAR_END;
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
                    aria-describedby="console-keys" .value=${live(this.text)} ?disabled=${!this.session.isConnected}
                    @input=${({ target }) => (this.text = target.value)} @keydown=${this.#key} />
            </label>
            ${this.running
                ? html`<button type="button" class="console-end" @click=${() => this.running?.abort()}>${t.end}</button>`
                : html`<button class="console-run" ?disabled=${!this.session.isConnected}>${t.run}</button>`}
        </form>`;
    }

    #content() {
        return html`<ol class="console-output" role="log" tabindex="0" aria-label=${t.output} @scroll=${this.#scrolled}>
                ${repeat(this.replies, ({ number }) => number, (reply) => this.#reply(reply))}
            </ol>
            ${this.#form()}
            <p class="hint" id="console-keys" role="status">${this.choices.length ? t.choices(this.choices) : t.keys}</p>
            ${this.#commands()}`;
    }

    render() {
        const { session } = this;

        return html`<section aria-label=${t.console}>
            <h2>${t.console}</h2>
            ${session.isConnected && !session.wire.hasConsole ? html`<p>${t.noConsole}</p>` : this.#content()}
        </section>`;
    }
}

customElements.define("panel-console", ConsolePart);
