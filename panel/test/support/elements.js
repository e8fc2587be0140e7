// SPDX-License-Identifier: MIT
/* Node has no elements. Import this before a view. */

globalThis.HTMLElement ??= class extends EventTarget {};
globalThis.customElements ??= { define: () => {} };
