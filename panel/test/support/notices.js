// SPDX-License-Identifier: MIT
/* The table of notices for docs/panel.md, from the texts of the page. */

import { texts } from "../../src/texts/texts.js";

/* Reads as text, as a list, and as an object with any field. */
const ANY = new Proxy(["X"], { get: (list, key) => (key in list || typeof key === "symbol" ? list[key] : "X") });

/* What a notice may tell, as it stands in the table; X for all else. */
const KNOWN = {
    id: "N", ids: ["N"], why: "CAUSE", detail: "CAUSE", on: ["N"], silent: ["N"], version: "A", shown: "B",
    line: "LINE", message: "TEXT", number: "N", remedy: "as the console says", setting: "NAME", name: "NAME",
};
const sampleOf = (code) =>
    new Proxy(code === "command" ? { ...KNOWN, line: "COMMAND" } : KNOWN, { get: (known, key) => (key in known ? known[key] : ANY) });

const cell = (text) => String(text).replace(/\|/g, "\\|").replace(/\s+/g, " ").trim();

export function noticesTable() {
    const makers = [texts.port, texts.wire, texts.notice].flatMap(Object.entries);
    const rows = makers.map(([code, make]) => make(sampleOf(code))).map(({ text, remedy }) => `| ${cell(text)} | ${cell(remedy)} |`);

    return ["| notice | what to do |", "|---|---|", ...new Set(rows)].join("\n");
}

export function withNotices(document) {
    return document.replace(/(<!-- notices -->\n).*?(\n<!-- end -->)/s, (_, begin, end) => begin + noticesTable() + end);
}
