// SPDX-License-Identifier: MIT
/* Asks in a dialog. The rest of the view is inert meanwhile, but not the header: Stop stays at hand, so
 * the dialog is not modal. Esc closes the dialog, and stops the robot as everywhere. */

/* Answers the open question, if there is one, with no. */
export const answerNo = () => document.querySelectorAll("dialog").forEach((dialog) => dialog.close("no"));

/* Resolves with true only if the user presses the button `yes`. `field`: an element that stands between
 * question and buttons, for example an input with its label. `isReady()`: false disables `yes`. An older question that is
 * still open is answered with no. */
export function confirmed({ text, yes, no, field = null, isReady = () => true }) {
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
            resolve(dialog.returnValue === "yes");
        });
    });
}

function dialogOf({ text, yes, no, field, isReady }) {
    const dialog = document.createElement("dialog");
    const question = document.createElement("p");
    const buttons = document.createElement("p");
    const button = (label, value, name) => {
        const element = document.createElement("button");

        element.textContent = label;
        element.className = name;
        element.addEventListener("click", () => dialog.close(value));
        buttons.append(element, " ");
        return element;
    };

    question.textContent = text;
    question.id = "dialog-question";
    dialog.setAttribute("aria-labelledby", question.id);
    button(no, "no", "no");
    const yesButton = button(yes, "yes", "yes");
    const update = () => (yesButton.disabled = !isReady());

    dialog.append(question, ...(field ? [field] : []), buttons);
    dialog.addEventListener("input", update);
    dialog.addEventListener("keydown", ({ key, target }) => {
        if (key === "Enter" && target.matches("input") && isReady()) dialog.close("yes");
    });
    update();
    return dialog;
}
