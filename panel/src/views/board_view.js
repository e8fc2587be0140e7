// SPDX-License-Identifier: MIT
/* The controller: firmware, inhibit, alarms, status, settings. */

import { html, nothing } from "lit/html.js";
import { texts } from "../texts/texts.js";
import { modeOf } from "./part.js";
import { View } from "./view.js";
import "./board_settings.js";
import { factList } from "./board_state.js";

const t = texts.board;

export class BoardView extends View {
    #readStatus = () => this.querySelector("panel-board-state")?.read();

    #controller() {
        const { controller, wire } = this.session;
        const facts = [
            [t.firmware, controller.version],
            [t.page, controller.shownVersion],
            [t.boardName, controller.board || t.unknownBoard],
            [t.profile, controller.profile],
            [t.deviceId, wire.hasDevice ? wire.deviceId : t.noDevice],
        ];

        return html`<section aria-labelledby="controller-title">
            <h2 id="controller-title">${t.controller}</h2>
            ${factList(facts, "firmware")}
            <p class="offers"><b>${t.offered}:</b> ${t.offers[controller.profile]}</p>
        </section>`;
    }

    /* [style, text] of the inhibit. */
    #inhibit() {
        const { lostIds, robot, wire } = this.session;

        if (!wire.hasDevice) return ["", t.unknownState];
        if (!robot.device) return ["", t.notRead];
        if (robot.device.inhibit) return ["bad", t.inhibited];
        return lostIds.length ? ["warn", t.allowedButFor(texts.status.lost(lostIds))] : ["good", t.allowed];
    }

    #driving() {
        const { session } = this;
        const { device } = session.robot;
        const [style, text] = this.#inhibit();

        return html`<section aria-labelledby="driving-title">
            <h2 id="driving-title">${t.driving}</h2>
            <p class="driving ${style}" role="status">${text} ${device?.linkLost ? t.linkLost : nothing}</p>
            <button class="board-release" ?disabled=${device?.inhibit === 0 && !device.linkLost && !session.lostIds.length}
                @click=${() => session.release()}>${t.release}</button>
            <p class="hint">${texts.stop.releaseHint}</p>
        </section>`;
    }

    render() {
        const { session } = this;

        if (!session.isConnected) return html`<p>${t.notConnected}</p>`;
        const mode = modeOf(session);

        return html`
            <div class="board-top">${this.#controller()} ${this.#driving()}</div>
            <panel-board-state .session=${session} .mode=${mode} .alarms=${session.robot.device?.alarms} .lost=${session.lostIds.join(" ")}></panel-board-state>
            <panel-settings .session=${session} .mode=${mode} .onDone=${this.#readStatus}></panel-settings>
        `;
    }
}

customElements.define("panel-board", BoardView);
