// SPDX-License-Identifier: MIT
/* An element without shadow root: one style sheet for the page, and labels reach all elements. */

import { LitElement } from "lit";

export class LightElement extends LitElement {
    createRenderRoot() {
        return this;
    }
}
