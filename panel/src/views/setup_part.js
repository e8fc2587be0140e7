// SPDX-License-Identifier: MIT
/* A part of the view Set-up: rendered when the set-up changes (model/setup.js), not with each feedback of the
 * servos. */

import { html, nothing } from "lit/html.js";
import { texts } from "../texts/texts.js";
import { LightElement } from "./light_element.js";

const t = texts.setup;

/* The name of a register; a narrow column breaks it behind an underscore. */
export function nameOf({ name }) {
    return html`<code>${name.split("_").map((part, index) => (index ? html`_<wbr />${part}` : part))}</code>`;
}

export class SetupPart extends LightElement {
    static properties = ["setup"];

    #refresh = () => this.requestUpdate();

    connectedCallback() {
        super.connectedCallback();
        this.setup.addEventListener("change", this.#refresh);
        this.requestUpdate();
    }

    disconnectedCallback() {
        super.disconnectedCallback();
        this.setup.removeEventListener("change", this.#refresh);
    }

    get session() {
        return this.setup.session;
    }

    /* True while the operation `kind` runs. */
    runs(kind) {
        return this.setup.operation?.kind === kind;
    }

    /* How far the operation `kind` is, and a button that ends it. */
    progressOf(kind, label) {
        const { operation } = this.setup;

        if (operation?.kind !== kind) return nothing;
        const isEnding = operation.isEnding();

        return html`<p class="progress">
            ${operation.total
                ? html`<progress aria-label=${label} max=${operation.total} .value=${operation.done}></progress>`
                : html`<progress aria-label=${label}></progress>`}
            <button class="end" ?disabled=${isEnding} @click=${() => this.setup.end()}>${isEnding ? t.ending : t.end}</button>
        </p>`;
    }

    /* Lines of the controller. Returns nothing if there is none. */
    linesOf(lines) {
        if (!lines.length) return nothing;
        return html`<ul class="lines">${lines.map((line) => html`<li>${line.replace(/; a key ends it$/, "")}</li>`)}</ul>`;
    }

    missing() {
        return html`<p class="hint">${t.notInFirmware(this.session.controller.profile)}</p>`;
    }
}
