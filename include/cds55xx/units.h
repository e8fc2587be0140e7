/* SPDX-License-Identifier: MIT */
/* Registers in units: millidegrees, mRPM, 0.01 %, mV, degrees Celsius, microseconds, bit/s. Whole
 * numbers throughout; each conversion is exact but for one rounding, to the nearest.
 *
 * For every register value, converting it to its unit and back gives it again (of a signed one, bit
 * 10 alone is a zero too, and comes back as 0). Nothing here has a state or waits. A conversion
 * takes 700 cycles of an AVR (950 for bit/s): convert where values enter and leave the program. Any
 * context, but for that reason not an interrupt. Manual 3.1, rulings R8 to R10, R16, R24, R35.
 */
#ifndef CDS_UNITS_H
#define CDS_UNITS_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/result.h" // enum cds_result

#ifdef __cplusplus
extern "C" {
#endif

/* What a register counts. The signed ones are positive for CCW; their register has the magnitude in
 * bits 0 to 9 and CW in bit 10 (R16, R35). The share is in hundredths of a percent because 1001
 * steps of a per mille would not tell 1024 register values apart. */
enum cds_unit {
    CDS_UNIT_NONE,        // not a register (reserved, or the high byte of a word): never converted
    CDS_UNIT_NUMBER,      // as it is, 0 to 65535: numbers, switches, bits, and what has no unit
    CDS_UNIT_MDEG,        // position: 0 to 300000 millidegrees are 0 to 1023 (R8, R9)
    CDS_UNIT_MARGIN_MDEG, // the same steps in one byte: 0 to 74780 millidegrees are 0 to 255
    CDS_UNIT_MRPM,        // speed of a move: 1/1000 RPM, scale of the profile (R10). Register 0 is
                          // "as fast as it can", so only 0 becomes 0: the least above it is 1
    CDS_UNIT_SIGNED_MRPM, // present speed, endless turn: the same scale, 0 stands still
    CDS_UNIT_CPCT,        // share of full torque: 0 to 10000 (0.01 %) are 0 to 1023
    CDS_UNIT_SIGNED_CPCT, // load: the same scale
    CDS_UNIT_MV,          // 0 to 25500 millivolts are 0 to 255 tenths of a volt
    CDS_UNIT_CELSIUS,     // 0 to 255 degrees Celsius
    CDS_UNIT_US,          // return delay: 0 to 508 microseconds are 0 to 254
    CDS_UNIT_BPS,         // 7843 to 2000000 bit/s are 254 to 0, see cds_units_baud()
} __attribute__((packed));

#define CDS_MDEG_MAX 300000 // of a position
#define CDS_CPCT_MAX 10000  // of a share: full torque

/* In what CDS55xx and AX-12 differ. The caller says which servo is which; a program may have
 * profiles of its own. */
struct cds_register_profile {
    uint32_t full_speed_mrpm; // speed at 1023: 1023 to 4000000 mRPM
    uint8_t turn_unit;        // enum cds_unit of MOVING_SPEED in endless turn
    bool has_torque_limit;    // 0x22, 0x23: a torque limit in RAM; else Acc and Dcc (R7)
    uint8_t model_address;    // of the byte that tells the model
    uint8_t model_number;     // what it holds
};

/* Manual 3.1: 62 RPM at 1023; endless turn keeps a speed; byte 0x01 is 1 (CDS5516, R26). */
extern const struct cds_register_profile cds_profile_cds55xx;

/* Robotis' e-manual of the AX-12, AX-12+, AX-12A: 0.111 RPM a unit, 113.553 RPM at 1023; in endless
 * turn ("wheel mode") MOVING_SPEED and PRESENT_SPEED are shares of full drive, not speeds; the word
 * at 0x00 is 12. */
extern const struct cds_register_profile cds_profile_ax12;

/* The unit of the register at `address` (0 to 0x31, CDS_REG_*) of such a servo. CDS_UNIT_NONE:
 * reserved, the high byte of a word, or above 0x31. MOVING_SPEED is CDS_UNIT_MRPM, as in position
 * mode; in endless turn it is profile->turn_unit. On an AX-12 0x22 is CDS_UNIT_CPCT, and the model
 * number is at 0x00. */
enum cds_unit cds_units_of(const struct cds_register_profile *profile, uint8_t address);

/* The value `raw` of a register (what the unit can have: 0 to 65535) in its unit, the nearest whole
 * number, into *value. `profile` is looked at for the two units of mRPM only and may be NULL for
 * others. CDS_OK; CDS_BAD_ARGUMENT: no register of that unit holds such a value, or there is no
 * such unit; *value is left as it was. Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_units_from_register(const struct cds_register_profile *profile,
                                        enum cds_unit unit, uint16_t raw, int32_t *value);

/* The register value nearest to `value`, into *raw; of two as near the greater one (a signed value:
 * the one further from 0; bit/s: the faster one). CDS_OK; CDS_BAD_ARGUMENT: outside the range that
 * stands beside the unit (speeds: 0, or minus, to full_speed_mrpm), or there is no such unit; *raw
 * is left as it was. `profile` as above. Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_units_to_register(const struct cds_register_profile *profile,
                                      enum cds_unit unit, int32_t value, uint16_t *raw);

/* How far off a rate may be for a UART, in 1/1000 (manual 3.1, 0x04: 3 %). */
#define CDS_BAUD_ERROR_MAX_PERMILLE 30

/* The baud register (0 to 254) whose rate, 2 000 000 / (register + 1), is nearest to `bps`, of two
 * the faster one; and by how much that is off in 1/1000 of `bps`, rounded to the nearest, positive
 * if the servo is faster than asked. CDS_OK; CDS_BAD_ARGUMENT: not 7843 to 2000000 bit/s; nothing
 * is written. Manual 3.1, 0x04. Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_units_baud(int32_t bps, uint8_t *baud, int16_t *error_permille);

/* Does a servo keep this baud register without power? True for 1, 3, 7, 16, 34, 103; others work
 * until power-off, and then the last one kept holds again (R24). */
bool cds_units_baud_is_kept(uint8_t baud);

#ifdef __cplusplus
}
#endif

#endif
