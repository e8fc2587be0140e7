/* SPDX-License-Identifier: MIT */
/* The wire: what a packet is made of, and building instruction packets in the caller's buffer.
 * Manual: 2.2 (instruction packet), 2.3 (status packet), 2.4 (the seven instructions).
 *
 * All functions run in the main context, touch nothing but their arguments and never wait.
 */
#ifndef CDS_PACKET_H
#define CDS_PACKET_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/control_table.h" // CDS_TABLE_SIZE
#include "cds55xx/result.h"        // enum cds_result

#ifdef __cplusplus
extern "C" {
#endif

#define CDS_HEADER       0xFF // stands twice before every packet
#define CDS_ID_MAX       253  // IDs of servos: 0 to 253
#define CDS_BROADCAST_ID 0xFE // all servos; only PING is answered
#define CDS_NO_ID        0xFF // no servo
#define CDS_LENGTH_MIN   2    // no parameters
#define CDS_LENGTH_MAX   254  // of LENGTH, the number of bytes that follow it

/* Where the bytes of a packet stand. */
enum {
    CDS_AT_ID = 2,
    CDS_AT_LENGTH = 3,
    CDS_AT_INSTRUCTION = 4, // of an instruction packet
    CDS_AT_ERROR = 4,       // of a status packet
    CDS_AT_PARAMETERS = 5,
    CDS_AT_SYNC_LENGTH = 6, // of a SYNC WRITE: how many bytes each servo gets
};

/* Bytes of a packet with n parameters: header (2), ID, LENGTH, INSTRUCTION or ERROR, checksum. */
#define CDS_PACKET_SIZE(n) (6u + (n))
/* Bytes of a SYNC WRITE of `length` bytes to each of `servos` servos. */
#define CDS_SYNC_WRITE_SIZE(servos, length) CDS_PACKET_SIZE(2u + (servos) * (1u + (length)))

/* The seven instructions (2.4), as the INSTRUCTION byte has them. A new one also needs: a builder
 * in packet.c, a call in servo.h and blocking.h, is_idempotent() of queue.c, check_packet() of
 * permit.c, cds_written_by() of limits.c if it writes, learn_packet() of learn.c. */
enum cds_instruction {
    CDS_PING = 0x01,
    CDS_READ = 0x02,
    CDS_WRITE = 0x03,
    CDS_REG_WRITE = 0x04,
    CDS_ACTION = 0x05,
    CDS_RESET = 0x06,
    CDS_SYNC_WRITE = 0x83,
} __attribute__((packed));

/* Bits of the ERROR byte of a status packet (manual 2.3). */
enum cds_error {
    CDS_ERROR_VOLTAGE = 0x01,     // condition: supply outside registers 0x0C, 0x0D
    CDS_ERROR_ANGLE = 0x02,       // packet: goal outside the angle limits
    CDS_ERROR_OVERHEATING = 0x04, // condition: hotter than register 0x0B
    CDS_ERROR_RANGE = 0x08,       // packet: the servo refuses a value or address, or is locked
    CDS_ERROR_CHECKSUM = 0x10,    // packet: it arrived damaged
    CDS_ERROR_OVERLOAD = 0x20,    // condition: the load exceeds the torque
    CDS_ERROR_INSTRUCTION = 0x40, // packet: no such instruction, or ACTION with nothing registered
    CDS_ERROR_NONE_SUCH = 0x80,   // always 0: a packet that has it set is no servo's reply
    /* The bits that say "this packet was not carried out", and those that report a condition. */
    CDS_ERRORS_OF_PACKET = 0x5A,
    CDS_ERRORS_OF_CONDITION = 0x25,
} __attribute__((packed));

/* A packet in the making. The buffer is the caller's. */
struct cds_packet {
    uint8_t *bytes;    // the buffer
    uint16_t capacity; // of `bytes`; 6 to 258 are of use, below 0xC000
    uint16_t size; // of the packet once it was ended; 0, or above CDS_LENGTH_MAX + 4, before that
};

/* Begins a packet: header, ID (0 to 253, or CDS_BROADCAST_ID), instruction. */
void cds_packet_begin(struct cds_packet *packet, uint8_t id, uint8_t instruction);

/* Appends one parameter. What does not fit is not stored, and cds_packet_end() will say so. */
void cds_packet_put(struct cds_packet *packet, uint8_t byte);

/* Appends a word, low byte first (R28). */
void cds_packet_put_word(struct cds_packet *packet, uint16_t word);

/* Fills in LENGTH and checksum. A packet that has been ended stays as it is, and may be sent again.
 * CDS_OK; CDS_NO_ROOM: longer than the buffer or than LENGTH can say; CDS_BAD_ARGUMENT: the ID is
 * 0xFF, something was put behind an ended packet, or what began it had refused. A refused packet
 * must not be sent. The calls below that build a whole packet leave an ended one as it was if they
 * refuse.
 */
enum cds_result cds_packet_end(struct cds_packet *packet);

/* The seven instructions (2.4.1 to 2.4.7), whole. `length` counts bytes, 1 to 50 for data.
 * Each returns what cds_packet_end() returns, and CDS_BAD_ARGUMENT when the address (0 to 0x31) or
 * the length is outside the control table, or an instruction is not meant for broadcast. */
enum cds_result cds_packet_ping(struct cds_packet *packet, uint8_t id);
enum cds_result cds_packet_read(struct cds_packet *packet, uint8_t id, uint8_t address,
                                uint8_t length);
enum cds_result cds_packet_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                 const uint8_t *data, uint8_t length);
enum cds_result cds_packet_reg_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                     const uint8_t *data, uint8_t length);
enum cds_result cds_packet_action(struct cds_packet *packet, uint8_t id);
enum cds_result cds_packet_reset(struct cds_packet *packet, uint8_t id);

/* SYNC WRITE grows servo by servo: begin, then a block for each, then cds_packet_end().
 * `length`: bytes for each servo, 1 to 50, from register `address` (0 to 0x31) on. A block is the
 * ID (0 to 253) and `length` bytes of `data`. Begin returns CDS_OK, or CDS_BAD_ARGUMENT when
 * address and length are outside the control table (2.4.7). */
enum cds_result cds_packet_sync_begin(struct cds_packet *packet, uint8_t address, uint8_t length);
void cds_packet_sync_add(struct cds_packet *packet, uint8_t id, const uint8_t *data);

/* ~(ID + LENGTH + ... + last parameter) of the packet at `bytes`, by its LENGTH (2.2). */
uint8_t cds_packet_checksum(const uint8_t *bytes);

#ifdef __cplusplus
}
#endif

#endif
