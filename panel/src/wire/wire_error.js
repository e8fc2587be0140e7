// SPDX-License-Identifier: MIT
/* Why the wire did not carry out a request or a command. `code` names an entry of texts.wire, which has
 * the text and the remedy.
 *
 * timeout: no reply in time. late: not sent, `notAfter` had passed. stopped: cancelled by a stop.
 * closed: the port is closed. silent: the controller does not answer at all. cancelled: by its sender,
 * before it was sent. ended: by its sender, and the controller did not tell the end. */

export class WireError extends Error {
    constructor(code, detail = "") {
        super(detail ? `${code}: ${detail}` : code);
        this.name = "WireError";
        this.code = code;
        this.detail = detail;
    }
}
