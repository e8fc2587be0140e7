// SPDX-License-Identifier: MIT
/* A part of a view that is rendered only when its own fields change, not with each feedback of the
 * servos. `session` as in a view; the view sets `mode`, a text that changes when the part must be shown
 * again: modeOf(). */

import { LitElement } from "lit";

export class Part extends LitElement {
    static properties = { session: { attribute: false }, mode: { attribute: false } };

    createRenderRoot() {
        return this;
    }
}

/* What parts depend on: connection, firmware, inhibit, and whether a command runs. */
export function modeOf({ state, wire, controller, robot }) {
    return [state, wire?.hasConsole, wire?.hasDevice, controller?.profile, controller?.version, robot?.isInhibited].join(" ");
}
