// SPDX-License-Identifier: MIT
/* The page: header with connection, state and Stop; notices; tabs; the view of the chosen tab.
 *
 * In the address: #ID chooses the tab; ?ws=URL is the address of the WebSocket, and ?connect connects to
 * it at once. */

import tables from "#tables";
import { html, nothing } from "lit/html.js";
import { ReplayPort } from "./port/replay.js";
import { WebSerialPort } from "./port/web_serial.js";
import { WebSocketPort } from "./port/web_socket.js";
import { RATES } from "./model/setup.js";
import { Session } from "./model/session.js";
import { takesSpace } from "./keys.js";
import { texts } from "./texts/texts.js";
import { answerNo, confirmed } from "./views/confirm.js";
import { textOfFile } from "./views/read_file.js";
import { View } from "./views/view.js";
import { VIEWS } from "./views/views.js";

const RATE = 115200; // of most boards
const RECORDING_MAX = 20000000; // bytes; the page itself saves less, with 31 servos in each reply, too

class App extends View {
    #elements = new Map(); // of each view that was shown
    #parameters = new URLSearchParams(location.search);

    constructor() {
        super();
        this.session = new Session({ tables });
        this.isFramed = globalThis.top !== globalThis.self; // the page around it could lead the clicks of a user
        this.tab = this.#tabOfAddress();
        this.rate = RATE;
        this.address = this.#parameters.get("ws") ?? WebSocketPort.urlBeside(location) ?? "ws://127.0.0.1:8055/websockify";
        for (const name of ["error", "unhandledrejection"]) globalThis.addEventListener(name, this.#tellError);
        if (this.isFramed) return;
        this.#keepFocus();
        this.session.addEventListener("disconnect", answerNo);
        globalThis.addEventListener("hashchange", () => this.#show(this.#tabOfAddress()));
        globalThis.addEventListener("keydown", (event) => this.#key(event), { capture: true });
        globalThis.addEventListener("keyup", (event) => this.#keyUp(event), { capture: true });
        globalThis.addEventListener("pagehide", () => this.session.disconnect()); // a page that the browser keeps would keep the port
        if (this.#parameters.has("connect")) this.session.connectAtLoad(() => new WebSocketPort(this.address));
    }

    /* An exception that nothing caught, as one in a render. Told once: the notice renders the views, which may fail again. */
    #tellError = ({ reason, error = reason }) => {
        if (error && !this.session.notices.some(({ code }) => code === "unexpected")) this.session.notify(error);
    };

    /* ---- keys ---- */

    #isEscapeDown = false;

    #key(event) {
        this.#isEscapeDown ||= event.key === "Escape";
        if (event.repeat || event.isComposing) return;
        const isSpace = event.key === " " && !(event.ctrlKey || event.altKey || event.metaKey || takesSpace(event.target));

        if (event.key === "Escape") this.#stopByEscape();
        if (!isSpace) return;
        event.preventDefault(); // the page would scroll
        this.session.stop();
    }

    /* The Escape that closes the list of a <select> gives a keyup, and no keydown. */
    #keyUp(event) {
        if (event.key !== "Escape") return;
        if (!this.#isEscapeDown) this.#stopByEscape();
        this.#isEscapeDown = false;
    }

    #stopByEscape() {
        answerNo();
        this.session.stop();
    }

    /* The focus of the keyboard goes back to its button, if that was disabled meanwhile, or to the tab if it is gone. After a
     * click of a mouse nothing gets it: Space stops. */
    #focused = null;

    #keepFocus() {
        for (const name of ["focusin", "pointerdown"])
            document.addEventListener(name, ({ target }) => (this.#focused = name === "focusin" && target.matches(":focus-visible") ? target : null));
    }

    #noticesShown = 0;

    updated() {
        const { activeElement, body } = document;
        const { length } = this.session.notices;
        const box = this.querySelector(".notices");

        if (length > this.#noticesShown && box) box.scrollTop = box.scrollHeight; // the newest one is in sight
        this.#noticesShown = length;

        if (this.#focused && activeElement === body)
            (this.#focused.isConnected ? this.#focused : this.querySelector("[aria-selected=true]")).focus({ preventScroll: true });
    }

    /* ---- connection ---- */

    #connectSocket = () => this.session.connect(new WebSocketPort(this.address));
    #connectSerial = () => this.session.connect(new WebSerialPort({ baudRate: this.rate }));

    #disconnect = async () => {
        const { session } = this;
        const { askDisconnect, disconnect: yes } = texts.connect;

        if (session.capture.port.isReplay || !session.mayHaveTorque || (await confirmed({ text: askDisconnect(session.linkLoss ?? {}), yes }))) session.disconnect();
    };

    #replay = async ({ target }) => {
        const [file] = target.files;

        target.value = "";
        if (!file) return;
        const port = await this.session.attempt(async () => new ReplayPort(await textOfFile(file, RECORDING_MAX)));

        if (port) await this.session.connect(port);
    };

    /* ---- tabs ---- */

    #tabOfAddress() {
        const id = location.hash.slice(1);

        return VIEWS.find((view) => view.id === id) ?? VIEWS[0];
    }

    #show(view) {
        this.tab = view;
        answerNo();
        this.requestUpdate();
        scrollTo(0, 0); // each view begins at its top
    }

    /* Each view is made once; only the chosen one is in the document. */
    #elementOf(view) {
        if (!this.#elements.has(view)) {
            const element = document.createElement(view.tag);

            element.session = this.session;
            this.#elements.set(view, element);
        }
        return this.#elements.get(view);
    }

    #tabKey(event) {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];

        if (!step) return;
        const next = VIEWS[(VIEWS.indexOf(this.tab) + step + VIEWS.length) % VIEWS.length];

        location.hash = next.id;
        this.updateComplete.then(() => this.querySelector(`#tab-${next.id}`)?.focus());
    }

    /* ---- parts of the page ---- */

    #connection() {
        const c = texts.connect;

        if (this.session.state !== "disconnected")
            return html`<span class="port">${this.session.portName}</span>
                <button class="disconnect" @click=${this.#disconnect}>${c.disconnect}</button>`;
        return html`
            <button class="serial" ?disabled=${!WebSerialPort.isSupported()} @click=${this.#connectSerial}>
                ${c.serial}
            </button>
            <label>
                ${c.rate}
                <select @change=${({ target }) => (this.rate = Number(target.value))}>
                    ${RATES.map((rate) => html`<option value=${rate} ?selected=${rate === this.rate}>${texts.setup.rate(rate)}</option>`)}
                </select>
            </label>
            <button class="socket" @click=${this.#connectSocket}>${c.socket}</button>
            <details>
                <summary>${c.more}</summary>
                <div class="more">
                    <label>
                        ${c.address}
                        <input type="url" .value=${this.address} @change=${({ target }) => (this.address = target.value.trim())} />
                    </label>
                    <label class="replay">${c.replay} <input type="file" accept=".txt" @change=${this.#replay} /></label>
                </div>
            </details>
            ${WebSerialPort.isSupported() ? nothing : html`<p class="hint">${c.noSerial}</p>`}
        `;
    }

    #stateLine() {
        const { session } = this;
        const parts = [texts.state[session.isWaiting && session.state === "connecting" ? "waiting" : session.state]];

        if (session.isConnected) {
            if (session.capture.port.isReplay) parts[0] = texts.state.replay;
            const servos = [...session.robot.servos.values()];

            parts.push(texts.status.servos(servos.length, servos.filter(({ presence }) => presence === "offline").length));
            parts.push(session.isBusy ? texts.status.old : texts.status.rate(session.robot.rate));
        }
        return html`<p class="state-line" role="status">${parts.join(" · ")}</p>`;
    }

    #stop() {
        const { session } = this;
        const { isInhibited, lostIds } = session;
        const text = texts.stop[session.stopState] || (isInhibited ? texts.status.inhibited : texts.status.lost(lostIds));

        return html`<div class="stop-box">
            <button class="stop" title=${texts.stop.hint} @click=${() => session.stop()}>${texts.stop.button}</button>
            <p class="stop-state ${session.stopState}" role="status" aria-live="assertive">${text}</p>
            ${(isInhibited || lostIds.length) && session.stopState !== "stopping"
                ? html`<button class="release" title=${texts.stop.releaseHint} @click=${() => session.release()}>
                      ${texts.stop.release}
                  </button>`
                : nothing}
        </div>`;
    }

    #notices() {
        const { notices } = this.session;

        return html`<section class="notices" aria-label=${texts.notices} aria-live="polite">
            ${notices.map(
                (notice) => html`<div class="notice ${notice.level}" data-code=${notice.code}>
                    <p>
                        ${notice.text}${notice.remedy ? html` <strong>${texts.remedy}</strong> ${notice.remedy}` : nothing}
                    </p>
                    ${notice.undo ? html`<button class="undo" @click=${notice.undo}>${texts.undo}</button>` : nothing}
                    <button aria-label=${texts.dismiss} title=${texts.dismiss} @click=${() => this.session.dismiss(notice)}>×</button>
                </div>`,
            )}
            ${notices.length > 2 ? html`<button class="dismiss-all" @click=${() => notices.forEach((notice) => this.session.dismiss(notice))}>${texts.dismissAll}</button>` : nothing}
        </section>`;
    }

    #tabs() {
        return html`<nav role="tablist" @keydown=${(event) => this.#tabKey(event)}>
            ${VIEWS.map(
                (view) => html`<a
                    id="tab-${view.id}"
                    role="tab"
                    href="#${view.id}"
                    aria-controls="view"
                    aria-selected=${view === this.tab}
                    tabindex=${view === this.tab ? 0 : -1}
                    >${texts.tabs[view.id]}</a
                >`,
            )}
        </nav>`;
    }

    render() {
        if (this.isFramed) return html`<main><p>${texts.framed}</p></main>`;
        return html`
            <header class=${this.session.state}>
                <h1>${texts.name}</h1>
                <div class="connection">${this.#connection()}</div>
                ${this.#stop()} ${this.#stateLine()} ${this.#tabs()}
            </header>
            ${this.#notices()}
            <main id="view" role="tabpanel" aria-labelledby="tab-${this.tab.id}">${this.#elementOf(this.tab)}</main>
        `;
    }
}

customElements.define("panel-app", App);
