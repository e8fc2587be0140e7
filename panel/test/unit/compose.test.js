// SPDX-License-Identifier: MIT
/* Packets that a user types: by fields and in hexadecimal. */

import assert from "node:assert/strict";
import test from "node:test";
import { compose, idsOfText, packetOfHex } from "../../src/model/compose.js";
import { Decoder } from "../../src/model/decode.js";
import { toHex } from "../../src/wire/packet.js";
import { texts } from "../../src/texts/texts.js";
import { tables } from "../support/tables.js";

const all = tables();
const decoder = new Decoder(all);
const form = (more) => compose({ ids: "1", address: 0x1e, count: 2, values: "", hex: "", ...more }, decoder, all.units);
const hexOf = (more) => toHex(form(more));

/* The code of the error that `call` throws. It must have a text. */
function codeOf(call) {
    try {
        call();
    } catch (error) {
        assert.ok(texts.packets.malformed[error.code]?.(error.detail), `no text for ${error.code}`);
        return error.code;
    }
    return "ok";
}

test("packetOfHex: adds a missing header and checksum", () => {
    for (const text of ["FF FF 01 02 01 FB", "FFFF010201FB", "01 02 01", "ff ff 01 02 01", "01 02 01 fb"])
        assert.equal(toHex(packetOfHex(text)), "FF FF 01 02 01 FB");
});

test("packetOfHex: malformed bytes are an error each", () => {
    const cases = { "0": "hex", "xy": "hex", "": "short", "01": "short", "FF FF FF 02 01": "id", "01 01 01": "length",
        "01 FF 01": "length", "01 03 01": "size", "01 02 01 FB 00": "size", "01 02 01 FC": "checksum" };

    for (const [text, code] of Object.entries(cases)) assert.equal(codeOf(() => packetOfHex(text)), code, text);
});

test("idsOfText: lists and ranges", () => {
    assert.deepEqual(idsOfText("1-3,5 9"), [1, 2, 3, 5, 9]);
    for (const [text, code] of [["", "no-ids"], ["a", "ids"], ["3-1", "ids"], ["254", "id"], ["1,1", "ids-twice"]])
        assert.equal(codeOf(() => idsOfText(text)), code, text);
});

test("compose: each instruction", () => {
    assert.equal(hexOf({ instruction: "PING" }), "FF FF 01 02 01 FB");
    assert.equal(hexOf({ instruction: "READ" }), "FF FF 01 04 02 1E 02 D8");
    assert.equal(hexOf({ instruction: "WRITE", values: "150, 20" }), "FF FF 01 07 03 1E 00 02 4A 01 89");
    assert.equal(hexOf({ instruction: "REG_WRITE", values: "512raw" }), "FF FF 01 05 04 1E 00 02 D5");
    assert.equal(hexOf({ instruction: "ACTION", ids: "254" }), "FF FF FE 02 05 FA");
    assert.equal(hexOf({ instruction: "RESET" }), "FF FF 01 02 06 F6");
    assert.equal(hexOf({ instruction: "SYNC_WRITE", ids: "1,2", values: "150" }), "FF FF FE 0A 83 1E 02 01 00 02 02 00 02 4D");
    assert.equal(hexOf({ instruction: "SYNC_WRITE", ids: "1,2", values: "0x0; 0x200" }).slice(0, -3), "FF FF FE 0A 83 1E 02 01 00 00 02 00 02");
    assert.equal(hexOf({ instruction: "SYNC_READ", ids: "1-2" }).slice(0, -3), "FF FF FE 06 84 1E 02 01 02");
    assert.equal(hexOf({ instruction: "BULK_READ", ids: "1-2" }).slice(0, -3), "FF FF FE 09 92 00 02 01 1E 02 02 1E");
    assert.equal(hexOf({ instruction: "hex", hex: "01 02 01" }), "FF FF 01 02 01 FB");
});

test("compose: a hexadecimal value may begin with a letter", () => {
    for (const [values, bytes] of [["0xff", "FF 00"], ["0xAB", "AB 00"], ["0x1ff", "FF 01"], ["0xFraw", "0F 00"]])
        assert.equal(hexOf({ instruction: "WRITE", values }).slice(18, -3), bytes, values);
});

test("compose: takes units of the page and of the console", () => {
    for (const values of ["1000000", "1000000bit/s", "1000000 bps", "1raw"])
        assert.equal(hexOf({ instruction: "WRITE", address: 0x04, values }).slice(0, -3), "FF FF 01 04 03 04 01", values);
    for (const values of ["150°", "150 deg"]) assert.equal(hexOf({ instruction: "WRITE", values }).slice(18, -3), "00 02", values);
    assert.equal(decoder.values(1, 0x04, [1, 1]), "BAUD_RATE 1000000 bit/s, RETURN_DELAY 2 us");
});

test("compose: registers of the device have no unit", () => {
    assert.equal(hexOf({ instruction: "WRITE", ids: "253", address: 0x0a, values: "500" }).slice(0, -3), "FF FF FD 05 03 0A F4 01");
});

test("compose: what does not fit is an error each", () => {
    const cases = [
        [{ values: "" }, "value"], [{ values: "90," }, "value"], [{ values: "ninety" }, "value"], [{ values: "90V" }, "unit"],
        [{ values: "70000raw" }, "fit"], [{ values: "-5" }, "fit"], [{ values: "1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1" }, "no-register"],
        [{ ids: "1,2", values: "90" }, "one-id"], [{ ids: "255", values: "90" }, "id"],
        [{ instruction: "SYNC_WRITE", ids: "1-3", values: "1;2" }, "groups"],
        [{ instruction: "SYNC_WRITE", ids: "1,2", values: "1; 2, 3" }, "too-long"],
        [{ instruction: "SYNC_READ", ids: "0-253" }, "too-long"],
        [{ instruction: "BULK_READ", ids: "0-253" }, "too-long"],
    ];

    for (const [more, code] of cases)
        assert.equal(codeOf(() => form({ instruction: "WRITE", ...more })), code, JSON.stringify(more));
});
