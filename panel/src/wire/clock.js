// SPDX-License-Identifier: MIT
/* The clock of the page. Tests put a clock of their own in its place and move it by hand. */

export const realClock = {
    now: () => performance.now(), // ms
    after: (ms, call) => setTimeout(call, ms),
    cancel: (timer) => clearTimeout(timer),
};

const GRACE_MS = 20;

/* Calls `call` after `ms` unless cancelled. If the page was blocked, the timer may fire before bytes that have
 * already arrived are delivered. So the last GRACE_MS are a second timer: it lets those bytes in first. */
export class Timeout {
    #clock;
    #timer;

    constructor(clock, ms, call) {
        this.#clock = clock;
        this.#timer = clock.after(ms - GRACE_MS, () => (this.#timer = clock.after(GRACE_MS, call)));
    }

    cancel() {
        this.#clock.cancel(this.#timer);
    }
}

/* Resolves after `ms`. */
export function pause(clock, ms) {
    return new Promise((resolve) => clock.after(ms, resolve));
}
