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

export const texts = { ...page, robot, decode, packets, board, graphs, setup, registers, motion, wire, port, notice };

/* Text, remedy and level (error, warning, info) of a notice {code, ...}. */
export function noticeText(detail) {
    const make = notice[detail.code] ?? wire[detail.code] ?? port[detail.code];

    if (make) return { level: "error", ...make(detail) };
    return { level: "error", ...notice.unexpected({ message: detail.code }) };
}
