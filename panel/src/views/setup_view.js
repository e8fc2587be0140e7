// SPDX-License-Identifier: MIT
/* Set-up of servos: search, new servo, diagnosis, registers, backup. */

import { html } from "lit/html.js";
import { Setup } from "../model/setup.js";
import { texts } from "../texts/texts.js";
import { View } from "./view.js";
import "./setup_backup.js";
import "./setup_diagnose.js";
import "./setup_find.js";
import "./setup_new.js";
import "./setup_place.js";
import "./setup_registers.js";

export class SetupView extends View {
    #setup = null;

    render() {
        if (!this.session.isConnected) return html`<p>${texts.setup.notConnected}</p>`;
        this.#setup ??= new Setup(this.session);
        const setup = this.#setup;

        return html`<div class="setup">
            <div class="setup-bus">
                <panel-setup-find .setup=${setup}></panel-setup-find>
                <panel-setup-new .setup=${setup}></panel-setup-new>
                <panel-setup-diagnose .setup=${setup}></panel-setup-diagnose>
            </div>
            <div class="setup-servo">
                <panel-setup-place .setup=${setup}></panel-setup-place>
                <panel-setup-backup .setup=${setup}></panel-setup-backup>
                <panel-setup-registers .setup=${setup}></panel-setup-registers>
            </div>
        </div>`;
    }
}

customElements.define("panel-setup", SetupView);
