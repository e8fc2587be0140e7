// SPDX-License-Identifier: MIT
/* Bytes as hexadecimal text. */

/* "FF FF 01 02 01 FB" */
export function toHex(bytes) {
    return Array.from(bytes, (byte) => byte.toString(16).toUpperCase().padStart(2, "0")).join(" ");
}

/* Reads hexadecimal bytes with or without spaces between them. Throws RangeError. */
export function fromHex(text) {
    const digits = text.replace(/[\s,]+/g, "").replace(/0x/gi, "");

    if (digits.length % 2 || /[^0-9a-f]/i.test(digits)) throw new RangeError(`not hexadecimal bytes: ${text}`);
    return Uint8Array.from(digits.match(/../g) ?? [], (pair) => parseInt(pair, 16));
}
