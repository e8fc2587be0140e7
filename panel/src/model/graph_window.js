// SPDX-License-Identifier: MIT
/* The part of the time that the graphs show: the last seconds, or, while paused, any part of what was
 * recorded until then. Times are seconds. */

const ZOOM = 2;
const MOVE = 0.5; // of the width
const WIDTH_MIN = 0.1;

export class GraphWindow {
    #history;
    #frozen = null; // copy of the history, since the pause
    #from = 0;
    #to = 0;

    constructor(span) {
        this.span = span;
    }

    get isPaused() {
        return this.#frozen !== null;
    }

    /* The history to show. */
    get history() {
        return this.#frozen ?? this.#history;
    }

    /* The live history. Another one is another connection: a pause ends. */
    follow(history) {
        if (history !== this.#history) this.#frozen = null;
        this.#history = history;
    }

    get range() {
        if (this.isPaused) return [this.#from, this.#to];
        const end = this.#history.lastTime;

        return [end - this.span, end];
    }

    pause() {
        if (this.isPaused) return;
        [this.#from, this.#to] = this.range;
        this.#frozen = this.#history.copy();
    }

    goOn() {
        this.#frozen = null;
    }

    /* Shows from `from` to `to`, and pauses. */
    show(from, to) {
        this.pause();
        const width = Math.max(to - from, WIDTH_MIN);
        const middle = (from + to) / 2;

        [this.#from, this.#to] = [middle - width / 2, middle + width / 2];
    }

    zoomIn() {
        this.#scale(1 / ZOOM);
    }

    zoomOut() {
        this.#scale(ZOOM);
    }

    #scale(factor) {
        this.pause();
        const { firstTime, lastTime } = this.#frozen;
        const [from, to] = this.range;
        const middle = (from + to) / 2;
        const half = Math.min(((to - from) / 2) * factor, Math.max((lastTime - firstTime) / 2, WIDTH_MIN));

        this.show(middle - half, middle + half);
    }

    /* `direction`: -1 is to earlier, 1 to later. Stays within what was recorded. */
    move(direction) {
        this.pause();
        const { firstTime, lastTime } = this.#frozen;
        const [from, to] = this.range;
        const wanted = direction * MOVE * (to - from);
        const step = direction < 0 ? Math.max(wanted, Math.min(firstTime - from, 0)) : Math.min(wanted, Math.max(lastTime - to, 0));

        this.show(from + step, to + step);
    }
}
