// SPDX-License-Identifier: MIT
/* Reads a file that the user has chosen. */

import { Failure } from "../model/registers.js";

/* Returns the text of `file`. Throws Failure if it has more than `max` bytes, or cannot be read, as after it was
 * deleted. */
export async function textOfFile(file, max) {
    if (file.size > max) throw new Failure("file-large", { limit: max / 1000 });
    try {
        return await file.text();
    } catch (error) {
        throw new Failure("file-unread", { detail: error.message });
    }
}
