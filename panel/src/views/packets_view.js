// SPDX-License-Identifier: MIT
/* Traffic, packets by hand, counters, console. Each is a part of its own. */

import { html, nothing } from "lit/html.js";
import { texts } from "../texts/texts.js";
import { modeOf } from "./part.js";
import { View } from "./view.js";
import "./packets_console.js";
import "./packets_counters.js";
import "./packets_send.js";
import "./packets_traffic.js";

export class PacketsView extends View {
    render() {
        const { session } = this;
        const mode = modeOf(session);

        return html`
            ${session.isConnected ? nothing : html`<p>${texts.packets.notConnected}</p>`}
            <panel-traffic .session=${session} .mode=${mode}></panel-traffic>
            <div class="packets-below">
                <panel-console .session=${session} .mode=${mode}></panel-console>
                <panel-send .session=${session} .mode=${mode}></panel-send>
            </div>
            <panel-counters .session=${session} .mode=${mode}></panel-counters>
        `;
    }
}

customElements.define("panel-packets", PacketsView);
