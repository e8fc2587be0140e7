// SPDX-License-Identifier: MIT
/* All texts of the page; a file for each view. */

import { board } from "./board.js";
import { graphs } from "./graphs.js";
import { motion } from "./motion.js";
import { notice, port, wire } from "./notices.js";
import { decode, packets } from "./packets.js";
import { page } from "./page.js";
import { robot } from "./robot.js";
import { registers, setup } from "./setup.js";

const LENGTH_MAX = 200; // characters

export const texts = { ...page, robot, decode, packets, board, graphs, setup, registers, motion, wire, port, notice };

/* A name out of a file may be a megabyte long. */
const cut = (value) => (typeof value === "string" && value.length > LENGTH_MAX ? `${value.slice(0, LENGTH_MAX)}…` : value);
const cutAll = (value) => (Array.isArray(value) ? value.map(cut) : cut(value));

/* Text, remedy and level (error, warning, info) of a notice {code, ...}. */
export function noticeText(detail) {
    const make = notice[detail.code] ?? wire[detail.code] ?? port[detail.code];
    const short = Object.fromEntries(Object.entries(detail).map(([name, value]) => [name, cutAll(value)]));

    if (make) return { level: "error", ...make(short) };
    return { level: "error", ...notice.unexpected({ message: detail.code }) };
}
