// SPDX-License-Identifier: MIT
/* The packets of protocol 1.0: builds instruction packets, takes status packets apart.
 * A packet is FF FF ID LENGTH INSTRUCTION-or-ERROR PARAMETERS CHECKSUM; LENGTH counts the bytes that
 * follow it. Manual: 2.2 to 2.4; docs/device.md for SYNC READ and BULK READ. */

export { fromHex, toHex } from "../port/hex.js";

export const HEADER = 0xff;
export const ID_MAX = 253;
export const DEVICE_ID = 253; // default of the setting device_id
export const BROADCAST_ID = 254;
export const LENGTH_MIN = 2;
export const LENGTH_MAX = 254;
export const AT_ID = 2;
export const AT_LENGTH = 3;
export const AT_ERROR = 4; // of a status packet
export const AT_INSTRUCTION = 4; // of an instruction packet
export const AT_PARAMETERS = 5;
export const FAILED = 0xff; // byte of a servo that did not answer a SYNC READ

export const INSTRUCTION = Object.freeze({
    PING: 0x01,
    READ: 0x02,
    WRITE: 0x03,
    REG_WRITE: 0x04,
    ACTION: 0x05,
    RESET: 0x06,
    SYNC_WRITE: 0x83,
    SYNC_READ: 0x84,
    BULK_READ: 0x92,
});

/* Bits of the ERROR byte. */
export const ERROR = {
    VOLTAGE: 0x01,
    ANGLE: 0x02,
    OVERHEATING: 0x04,
    RANGE: 0x08,
    CHECKSUM: 0x10,
    OVERLOAD: 0x20,
    INSTRUCTION: 0x40,
    SOME_FAILED: 0x80, // of a SYNC READ: the bytes of a servo that failed are FF
};

export const ERRORS_OF_PACKET = 0x5a; // the packet was not carried out

const ERROR_NAMES = [
    "input voltage",
    "angle limit",
    "overheating",
    "range",
    "checksum",
    "overload",
    "instruction",
    "some servos failed",
];

/* The names of the bits that are set, lowest first. */
export function errorNames(bits) {
    return ERROR_NAMES.filter((_, bit) => bits & (1 << bit));
}

/* The checksum of the bytes from ID to the last parameter. */
export function checksum(bytes, from = AT_ID, to = bytes.length) {
    let sum = 0;

    for (let at = from; at < to; at++) sum += bytes[at];
    return ~sum & 0xff;
}

/* Low byte and high byte of a word. */
export function word(value) {
    return [value & 0xff, (value >> 8) & 0xff];
}

/* The word at index `at`, low byte first. */
export function wordAt(bytes, at) {
    return bytes[at] | (bytes[at + 1] << 8);
}

function byteOrThrow(value, what, highest = 255) {
    if (!Number.isInteger(value) || value < 0 || value > highest)
        throw new RangeError(`${what} ${value} is out of range: 0 to ${highest}`);
    return value;
}

/* Builds a packet. Throws RangeError if a byte is out of range or the packet is too long. */
export function packet(id, instruction, parameters = []) {
    const length = parameters.length + LENGTH_MIN;

    byteOrThrow(id, "ID", BROADCAST_ID);
    byteOrThrow(instruction, "instruction");
    if (length > LENGTH_MAX)
        throw new RangeError(`${parameters.length} parameters are too many: ${LENGTH_MAX - LENGTH_MIN} at most`);
    parameters.forEach((value) => byteOrThrow(value, "parameter"));
    const bytes = Uint8Array.of(HEADER, HEADER, id, length, instruction, ...parameters, 0);

    bytes[bytes.length - 1] = checksum(bytes, AT_ID, bytes.length - 1);
    return bytes;
}

export const ping = (id) => packet(id, INSTRUCTION.PING);
export const read = (id, address, count) => packet(id, INSTRUCTION.READ, [address, count]);
export const write = (id, address, bytes) => packet(id, INSTRUCTION.WRITE, [address, ...bytes]);
export const action = (id = BROADCAST_ID) => packet(id, INSTRUCTION.ACTION);
export const reset = (id) => packet(id, INSTRUCTION.RESET);

/* `blocks`: array of [id, bytes]; all have `count` bytes. */
export function syncWrite(address, count, blocks) {
    for (const [id, bytes] of blocks)
        if (bytes.length !== count) throw new RangeError(`servo ${id}: ${bytes.length} bytes in place of ${count}`);
    return packet(BROADCAST_ID, INSTRUCTION.SYNC_WRITE, [
        address,
        count,
        ...blocks.flatMap(([id, bytes]) => [id, ...bytes]),
    ]);
}

export const SYNC_READ_MAX = 252; // bytes of all servos together

/* One status packet of the device answers: `count` bytes of each servo, in the order of `ids`. */
export function syncRead(address, count, ids) {
    if (ids.length * count > SYNC_READ_MAX)
        throw new RangeError(`${ids.length} servos with ${count} bytes each: ${SYNC_READ_MAX} bytes at most`);
    return packet(BROADCAST_ID, INSTRUCTION.SYNC_READ, [address, count, ...ids]);
}

/* Each servo answers by itself. `blocks`: array of [count, id, address]. */
export function bulkRead(blocks) {
    return packet(BROADCAST_ID, INSTRUCTION.BULK_READ, [0, ...blocks.flat()]);
}

/* Number of status packets that answer an instruction packet. */
export function repliesDue(bytes) {
    const instruction = bytes[AT_INSTRUCTION];

    if (instruction === INSTRUCTION.BULK_READ) return (bytes[AT_LENGTH] - 3) / 3;
    if (instruction === INSTRUCTION.SYNC_READ || instruction === INSTRUCTION.PING) return 1;
    return bytes[AT_ID] === BROADCAST_ID ? 0 : 1;
}

/* The fields of a whole status packet. */
export function statusOf(bytes) {
    return {
        id: bytes[AT_ID],
        error: bytes[AT_ERROR],
        parameters: bytes.slice(AT_PARAMETERS, -1),
    };
}

/* True if the array is one whole packet with a right checksum. */
export function isPacket(bytes) {
    const length = bytes[AT_LENGTH];

    return (
        bytes.length >= AT_PARAMETERS + 1 &&
        bytes[0] === HEADER &&
        bytes[1] === HEADER &&
        bytes[AT_ID] !== HEADER &&
        length >= LENGTH_MIN &&
        length <= LENGTH_MAX &&
        bytes.length === length + 4 &&
        checksum(bytes, AT_ID, bytes.length - 1) === bytes[bytes.length - 1]
    );
}
