// SPDX-License-Identifier: MIT
/* Which elements take keys for themselves. */

/* Everywhere else Space stops the robot. A slider does not use Space. */
const TAKES_SPACE = "button, input:not([type=range]), select, textarea, summary, option, [contenteditable], [role=button], [role=switch]";
const TAKES_TEXT = "input:not([type=range], [type=checkbox], [type=radio]), select, textarea, [contenteditable]";

export function takesSpace(element) {
    return Boolean(element?.closest?.(TAKES_SPACE));
}

export function takesText(element) {
    return Boolean(element?.closest?.(TAKES_TEXT));
}
