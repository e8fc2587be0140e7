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
#define CDS_BROADCAST_ID 0xFE // all servos; answered by none, but for PING
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

/* The seven instructions (2.4), as the INSTRUCTION byte has them. */
enum cds_instruction {
    CDS_PING = 0x01,
    CDS_READ = 0x02,
    CDS_WRITE = 0x03,
    CDS_REG_WRITE = 0x04,
    CDS_ACTION = 0x05,
    CDS_RESET = 0x06,
    CDS_SYNC_WRITE = 0x83,
};

/* Bits of the ERROR byte of a status packet (manual 2.3). */
enum cds_error {
    CDS_ERROR_VOLTAGE = 0x01,     // condition: supply outside registers 0x0C, 0x0D
    CDS_ERROR_ANGLE = 0x02,       // packet: goal outside the angle limits
    CDS_ERROR_OVERHEATING = 0x04, // condition: hotter than register 0x0B
    CDS_ERROR_RANGE = 0x08,       // packet: a value, address or lock refuses it
    CDS_ERROR_CHECKSUM = 0x10,    // packet: came damaged
    CDS_ERROR_OVERLOAD = 0x20,    // condition: the load exceeds the torque
    CDS_ERROR_INSTRUCTION = 0x40, // packet: no such instruction, or ACTION with nothing registered
    CDS_ERROR_NONE_SUCH = 0x80,   // always 0: a packet that has it set is no servo's reply
    /* The bits that say "this packet was not carried out", and those that report a condition. */
    CDS_ERRORS_OF_PACKET = 0x5A,
    CDS_ERRORS_OF_CONDITION = 0x25,
};

/* A packet in the making. The buffer is the caller's. */
struct cds_packet {
    uint8_t *bytes; // the buffer
    uint16_t room;  // of `bytes`; 6 to 258 are of use, below 0xC000
    uint16_t size;  // of the packet, once it was ended
};

/* In `size`: the packet grows, and so many bytes were put so far; or it was refused, and none can
 * come of it, for want of room or for an argument. Of one that grows, at 5 to 257 bytes, the high
 * byte is always the same. */
#define CDS_PACKET_GROWS   0x3FFEu
#define CDS_PACKET_REFUSED 0x8000u // this bit, whatever the others are
#define CDS_PACKET_NO_ROOM 0xA000u

/* Begins a packet: header, ID (0 to 253, or CDS_BROADCAST_ID), instruction. */
void cds_packet_begin(struct cds_packet *packet, uint8_t id, uint8_t instruction);

/* Appends one parameter. What does not fit is not stored, and cds_packet_end() will say so. */
void cds_packet_put(struct cds_packet *packet, uint8_t byte);

/* Appends a word, low byte first (R28). */
void cds_packet_put_word(struct cds_packet *packet, uint16_t word);

/* Fills in LENGTH and checksum. A packet that has been ended stays as it is, and may be sent again.
 * CDS_OK; CDS_NO_ROOM: longer than the buffer or than LENGTH can say; CDS_BAD_ARGUMENT: the ID is
 * 0xFF, something was put behind an ended packet, or what began or built it had refused. A refused
 * packet must not be sent. */
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

/* READ in two steps, for the library's own calls, so that the packet may have begun before it is
 * built. First: may it be? CDS_OK, or what cds_packet_read() returns. Then its size and bytes. */
uint8_t cds_packet_may_read_(const struct cds_packet *packet, uint8_t id, uint8_t address,
                             uint8_t length);
void cds_packet_build_read_(struct cds_packet *packet, uint8_t id, uint8_t address, uint8_t length);

/* Is it being put together? One byte of `size` says so. */
static inline bool cds_packet_grows_(const struct cds_packet *packet)
{
    return (int8_t)(packet->size >> 8) >= 0x40;
}

/* For the library's own calls. Begins a packet with its first `count` parameters; or one that is
 * refused, whatever the room: `id` is CDS_NO_ID. */
#define CDS_NO_ID 0xFF
void cds_packet_start_(struct cds_packet *packet, const uint8_t *data, uint8_t count, uint8_t id,
                       uint8_t instruction);

/* With what ID to begin one of which another argument is wrong. Where there is no room for any
 * packet, that is the reason. */
static inline uint8_t cds_packet_refused_id_(const struct cds_packet *packet, uint8_t id)
{
    return packet->room < CDS_PACKET_SIZE(0) ? id : CDS_NO_ID;
}

/* Appends `count` bytes, 0 to 51: all of them, or none. Returns the buffer, or NULL: none. */
uint8_t *cds_packet_append_(struct cds_packet *packet, const uint8_t *data, uint8_t count);

/* Is there anything to transfer, and does it lie within the control table? */
static inline bool cds_packet_is_length_(uint8_t length)
{
    return (uint8_t)(length - 1u) < CDS_TABLE_SIZE;
}

static inline bool cds_packet_is_within_(uint8_t address, uint8_t length)
{
    return address <= (uint8_t)(CDS_TABLE_SIZE - length);
}

/* An argument is wrong. Where something was wrong before, that is the reason. */
void cds_packet_refuse_(struct cds_packet *packet);

/* WRITE or REG WRITE, for the library's own calls, which end it. */
void cds_packet_begin_write_(struct cds_packet *packet, uint8_t id, uint8_t instruction,
                             uint8_t address, const uint8_t *data, uint8_t length);

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
