// SPDX-License-Identifier: MIT
/* Inputs of a view that is rendered with each feedback: text that a user is typing stays until it is taken.
 *
 *     keepsTyping(this);                                     // once, in the view
 *     html`<input .value=${taken(name)} @change=${...} />`   // shows `name`, but not over text that is being typed */

import { noChange } from "lit/html.js";
import { Directive, directive } from "lit/directive.js";

const typed = new WeakSet(); // inputs with text that no event "change" has delivered

export function keepsTyping(view) {
    const forget = ({ target }) => typed.delete(target);

    view.addEventListener("input", ({ target }) => typed.add(target));
    view.addEventListener("change", forget, { capture: true });
    view.addEventListener("focusout", forget);
}

class Taken extends Directive {
    update({ element }, [value]) {
        if (!typed.has(element) && element.value !== value) element.value = value;
        return noChange;
    }
}

export const taken = directive(Taken);
