// SPDX-License-Identifier: MIT
/* A part of a view that is rendered only when its own fields change, not with each feedback of the
 * servos. `session` as in a view. The view sets `mode` to modeOf(): a new value renders the part again. */

import { LightElement } from "./light_element.js";

export class Part extends LightElement {
    static properties = ["session", "mode"];
}

/* A text that changes with the connection, a reset of the controller, the firmware or the inhibit. */
export function modeOf({ state, starts, wire, controller, robot }) {
    return [state, starts, wire?.hasConsole, wire?.hasDevice, controller?.profile, controller?.version, robot?.isInhibited].join(" ");
}
