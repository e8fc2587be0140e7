// SPDX-License-Identifier: MIT
/* Base of all views. A view shows this.session and is rendered again, at most once a frame, when the
 * session changes or has new values of the servos.
 *
 * The page has a strict Content-Security-Policy: a template must have no attribute `style`. Use classes,
 * attributes of SVG, or element.style in updated(). */

import { LightElement } from "./light_element.js";

export class View extends LightElement {
    static properties = ["session"];

    #frame = null;
    #refresh = () => {
        this.#frame ??= requestAnimationFrame(() => {
            this.#frame = null;
            this.requestUpdate();
        });
    };

    connectedCallback() {
        super.connectedCallback();
        for (const name of ["change", "feedback"]) this.session.addEventListener(name, this.#refresh);
        this.#refresh();
    }

    disconnectedCallback() {
        super.disconnectedCallback();
        for (const name of ["change", "feedback"]) this.session.removeEventListener(name, this.#refresh);
        cancelAnimationFrame(this.#frame);
        this.#frame = null;
    }
}
