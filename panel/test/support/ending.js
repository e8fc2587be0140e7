// SPDX-License-Identifier: MIT
/* Stands for the context of a test in a program that is none: what is to be ended. */
export class Ending {
    #calls = [];

    after(call) {
        this.#calls.unshift(call);
    }

    async end() {
        for (const call of this.#calls) await call();
    }
}
