// SPDX-License-Identifier: MIT
/* An element without shadow root: one style sheet for the page, and labels reach all elements. It is LitElement without
 * attributes and without styles of its own, which the page does not use: saves 2.4 KB gzipped.
 *
 *     class Lamp extends LightElement {
 *         static properties = ["light"]; // a new value renders the lamp again
 *         render() { return html`${this.isOn ? "on" : "off"}`; }
 *     } */

import { noChange, render } from "lit/html.js";

const prepared = new WeakSet([HTMLElement]); // classes whose properties have accessors

/* A new value of a property asks for an update. */
function prepare(type) {
    if (prepared.has(type)) return;
    prepared.add(type);
    prepare(Object.getPrototypeOf(type));
    if (!Object.hasOwn(type, "properties")) return;
    for (const name of type.properties) {
        const key = Symbol(name);

        Object.defineProperty(type.prototype, name, {
            get() {
                return this[key];
            },
            set(value) {
                if (Object.is(value, this[key])) return;
                this[key] = value;
                this.requestUpdate(name);
            },
        });
    }
}

export class LightElement extends HTMLElement {
    #changed = new Set(); // names of the properties that have changed since the last update
    #isPending = false;
    #hasUpdated = false;
    #connect; // resolves the first promise: no update before the element is in the document
    #updateComplete = new Promise((resolve) => (this.#connect = resolve));

    constructor() {
        super();
        prepare(new.target);
        this.requestUpdate();
    }

    connectedCallback() {
        this.#connect();
    }

    disconnectedCallback() {}

    /* Resolves when the update that was asked for is done. */
    get updateComplete() {
        return this.#updateComplete;
    }

    /* Asks for an update: one for all requests of this turn of the event loop. */
    requestUpdate(name) {
        if (name) this.#changed.add(name);
        if (!this.#isPending) this.#updateComplete = this.#updateAfter(this.#updateComplete);
    }

    /* An update that failed is reported as an error of the page. It does not stop the next one. */
    async #updateAfter(last) {
        this.#isPending = true;
        await last.catch((error) => void Promise.reject(error));
        const changed = this.#changed;

        if (this.#render(changed)) this.#tell(changed);
    }

    /* Returns false if no update is due. A change while the content enters the document is for the next update. */
    #render(changed) {
        let content = null;
        let isDue = false;

        try {
            isDue = this.shouldUpdate(changed);
            if (isDue) content = this.render();
        } finally {
            this.#changed = new Set();
            this.#isPending = false;
        }
        if (isDue) render(content, this, { host: this });
        return isDue;
    }

    #tell(changed) {
        const isFirst = !this.#hasUpdated;

        this.#hasUpdated = true;
        if (isFirst) this.firstUpdated(changed);
        this.updated(changed);
    }

    /* ---- a view replaces what it needs; `changed`: a Set of names ---- */

    shouldUpdate() {
        return true;
    }

    render() {
        return noChange;
    }

    firstUpdated() {}

    updated() {}
}
