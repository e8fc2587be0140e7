// SPDX-License-Identifier: MIT
/* Help to type a line for the console: earlier lines, completion, and how long a command may be silent. */

const HISTORY_MAX = 100;
const SILENT_MS = 10000;
const LONG_MS = 600000; // `motion wait` says nothing while a sequence plays
const LONG = /^(?:scan|motion +wait|new|diagnose)\b/i;
const OWN_MODE = /^(?:mode|echo|defaults|save)\b|^settings +(?:echo|device_id|host_baud) +\S/i;

/* The longest time without a line of the reply. */
export const silenceOf = (line) => (LONG.test(line.trim()) ? LONG_MS : SILENT_MS);

/* True for a line that changes or saves the mode of the console, or that changes the ID of the device or the rate of the host
 * link. The page needs all three. The view Board has these settings. */
export const changesOwnMode = (line) => OWN_MODE.test(line.trim());

/* The operation of a line: the line without the value that a user changes when he tries again, as "id 1" of "id 1 9". */
export function operationOf(line) {
    const text = line.trim().toLowerCase().replace(/\s+/g, " ");

    return /^(?:new|bus|set \S+ \S+|(?:id|baud) \S+)(?= )/.exec(text)?.[0] ?? text;
}

/* True for a line that empties the controller's list of servos. */
export const isForgetting = (line) => /^\s*servos\s+forget\s*$/i.test(line);

export class LineHistory {
    #lines = [];
    #at = 0;
    #draft = "";

    add(line) {
        if (this.#lines.at(-1) !== line) this.#lines.push(line);
        this.#lines = this.#lines.slice(-HISTORY_MAX);
        this.#at = this.#lines.length;
        this.#draft = "";
    }

    /* The line before; `current` is what stands there now. */
    up(current) {
        if (this.#at === this.#lines.length) this.#draft = current;
        if (this.#at > 0) this.#at--;
        return this.#lines[this.#at] ?? current;
    }

    down(current) {
        if (this.#at >= this.#lines.length) return current;
        this.#at++;
        return this.#lines[this.#at] ?? this.#draft;
    }
}

const startsWith = (word, begin) => word.toLowerCase().startsWith(begin.toLowerCase());

function commonPrefix(words) {
    let length = words[0].length;

    for (const word of words) while (!startsWith(word, words[0].slice(0, length))) length--;
    return words[0].slice(0, length);
}

/* Words that may stand behind the name of a command: those of its usage, registers, settings. */
function wordsBehind(name, { commands, registers, settings }) {
    const words = new Set();

    for (const { name: command, usage } of commands) {
        if (command !== name) continue;
        for (const word of usage.split(/[\s[\]|.,:]+/).slice(1)) {
            if (/^[a-z]+$/.test(word)) words.add(word);
            if (word === "REG") registers.forEach((row) => words.add(row.name));
            if (word === "SETTING") settings.forEach((row) => words.add(row.name));
            if (word === "COMMAND") commands.forEach((row) => words.add(row.name));
        }
    }
    return [...words];
}

/* Completes the last word of `line`. Returns {line, choices}: the line as far as all choices share it.
 * `tables`: {commands, registers, settings}. */
export function complete(line, tables) {
    const [, before, word] = /^(.*?)(\S*)$/.exec(line);
    const name = before.trim().split(/\s+/)[0].toLowerCase();
    const words = name ? wordsBehind(name, tables) : [...new Set(tables.commands.map((row) => row.name))];
    const choices = words.filter((one) => startsWith(one, word));

    if (!choices.length) return { line, choices };
    const begin = before + commonPrefix(choices);

    return { line: choices.length === 1 ? `${begin} ` : begin, choices };
}
