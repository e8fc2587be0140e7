// SPDX-License-Identifier: MIT
/* The clock of the page. Tests put a clock of their own in its place and move it by hand. */

export const realClock = {
    now: () => performance.now(), // ms
    after: (ms, call) => setTimeout(call, ms),
    cancel: (timer) => clearTimeout(timer),
};

/* Resolves after `ms`. */
export function pause(clock, ms) {
    return new Promise((resolve) => clock.after(ms, resolve));
}
