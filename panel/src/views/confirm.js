// SPDX-License-Identifier: MIT
/* Asks in a dialog. The rest of the view is inert meanwhile, but not the header: Stop stays at hand, so
 * the dialog is not modal. Esc closes the dialog, and stops the robot as everywhere. */

import { html, render } from "lit/html.js";
import { texts } from "../texts/texts.js";

/* Answers the open question, if there is one, with no. */
export const answerNo = () => document.querySelectorAll("dialog").forEach((dialog) => dialog.close("no"));

const valueIn = (dialog) => dialog.querySelector(".dialog-value")?.value;

/* Resolves with false unless the user presses the button `yes`: then with the value of the field, or true. `field`: a template
 * that stands between question and buttons, with a control of the class dialog-value. `isReady(value)`: false disables
 * `yes`. An older question that is still open is answered with no. */
export function confirmed({ text, yes, no = texts.board.cancel, field, isReady = () => true }) {
    answerNo();
    const view = document.querySelector("main");
    const before = document.activeElement;
    const dialog = dialogOf({ text, yes, no, field, isReady });

    document.body.append(dialog);
    view.inert = true;
    dialog.show();
    const input = dialog.querySelector("input, select") ?? dialog.querySelector(".no");

    input.focus();
    input.select?.(); // what is typed replaces the proposed value
    return new Promise((resolve) => {
        dialog.addEventListener("close", () => {
            dialog.remove();
            if (!document.querySelector("dialog")) {
                view.inert = false;
                before?.focus();
            }
            resolve(dialog.returnValue === "yes" && (valueIn(dialog) ?? true));
        });
    });
}

function dialogOf({ text, yes, no, field, isReady }) {
    const dialog = document.createElement("dialog");
    const canSay = { yes: () => isReady(valueIn(dialog)), no: () => true };
    const button = (label, value) => html`<button class=${value} ?disabled=${!canSay[value]()} @click=${() => dialog.close(value)}>${label}</button>`;
    const update = () =>
        render(html`<p id="dialog-question">${text}</p>${field}
            <p class="hint">${texts.escHint}</p>
            <p>${button(no, "no")} ${button(yes, "yes")}</p>`, dialog);

    dialog.setAttribute("aria-labelledby", "dialog-question");
    dialog.addEventListener("input", update);
    dialog.addEventListener("keydown", ({ key, target }) => {
        if (key === "Enter" && target.matches("input") && canSay.yes()) dialog.close("yes");
    });
    update();
    update(); // with the value of the field
    return dialog;
}
