// SPDX-License-Identifier: MIT
/* A clock that stands still until a test moves it. */

/* Lets all promises go on that can. */
export async function settle() {
    for (let i = 0; i < 50; i++) await Promise.resolve();
}

export class FakeClock {
    #now = 0;
    #timers = new Set();

    now() {
        return this.#now;
    }

    after(ms, call) {
        const timer = { at: this.#now + ms, call };

        this.#timers.add(timer);
        return timer;
    }

    cancel(timer) {
        this.#timers.delete(timer);
    }

    /* The page is held up for `ms`: time passes, and neither a timer runs nor bytes are taken. */
    stall(ms) {
        this.#now += ms;
    }

    /* Moves on by `ms`; each timer on the way runs at its time. */
    async advance(ms) {
        const end = this.#now + ms;

        await settle();
        for (let timer = this.#next(end); timer; timer = this.#next(end)) {
            this.#timers.delete(timer);
            this.#now = Math.max(this.#now, timer.at);
            timer.call();
            await settle();
        }
        this.#now = end;
        await settle();
    }

    #next(end) {
        const due = [...this.#timers].filter((timer) => timer.at <= end);

        return due.sort((one, other) => one.at - other.at)[0];
    }
}
