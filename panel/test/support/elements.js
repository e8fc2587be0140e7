// SPDX-License-Identifier: MIT
/* Node has no elements. Import this before a view. */

const classes = new Map(); // by the name of the element

globalThis.HTMLElement ??= class extends EventTarget {};
globalThis.customElements ??= { define: (name, type) => classes.set(name, type), get: (name) => classes.get(name) };
