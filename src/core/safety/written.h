/* What a packet writes into the registers of one servo; not installed. Main context. */
#ifndef CDS_WRITTEN_H
#define CDS_WRITTEN_H

#include <stdbool.h>
#include <stdint.h>

/* Which registers are written, or were read: bits of `sets`. */
enum cds_sets {
    CDS_SETS_ID = 1,
    CDS_SETS_REPLY = 2,        // baud rate, return delay, status return level
    CDS_SETS_MODE = 4,         // angle limits
    CDS_SETS_TORQUE = 8,       // TORQUE_ENABLE
    CDS_SETS_GAIN = 16,        // compliance margins, proportions, punch
    CDS_SETS_GOAL = 32,        // one byte of it, or both
    CDS_SETS_SPEED = 64,       // one byte of it, or both
    CDS_SETS_REGISTERED = 128, // 0x2C
};

/* `length` bytes of servo `id`, from register `address` on. */
struct cds_written {
    const uint8_t *data;
    uint8_t address, length, id;
    uint8_t sets; // CDS_SETS_* bits
};

/* Returns the CDS_SETS_* bits of `length` registers from `address` on. */
uint8_t cds_written_sets(uint8_t address, uint8_t length);

/* Describes what the packet `bytes`, a WRITE, REG WRITE or SYNC WRITE, writes: all of a WRITE; of a
 * SYNC WRITE all but data and ID, which cds_written_block() sets. False: it writes nothing. */
bool cds_written_by(const uint8_t *bytes, struct cds_written *written);

/* Sets data and ID to block `index` of the packet, 0 for all but a SYNC WRITE. False: it has no
 * such block. A block that is cut off is none. */
bool cds_written_block(const uint8_t *bytes, uint8_t index, struct cds_written *written);

/* Returns the byte of register `reg`, or NULL if it is not written. */
static inline const uint8_t *cds_written_byte(const struct cds_written *written, uint8_t reg)
{
    uint8_t index = (uint8_t)(reg - written->address);

    return index < written->length && reg >= written->address ? written->data + index : NULL;
}

/* Returns the word of register `reg`, low byte first (R28), or NULL if not both bytes are written.
 */
static inline const uint8_t *cds_written_word(const struct cds_written *written, uint8_t reg)
{
    return cds_written_byte(written, (uint8_t)(reg + 1)) ? cds_written_byte(written, reg) : NULL;
}

/* Returns the value of register `reg`, or `otherwise` if it is not written. */
static inline uint8_t cds_written_value(const struct cds_written *written, uint8_t reg,
                                        uint8_t otherwise)
{
    const uint8_t *byte = cds_written_byte(written, reg);

    return byte ? *byte : otherwise;
}

#endif
