// SPDX-License-Identifier: MIT
/* Renews the table of notices in a document, between its lines `<!-- notices -->` and `<!-- end -->`.
 *
 * usage: node notices.mjs DOCUMENT */

import { readFileSync, writeFileSync } from "node:fs";
import { withNotices } from "./test/support/notices.js";

const [path] = process.argv.slice(2);

writeFileSync(path, withNotices(readFileSync(path, "utf8")));
