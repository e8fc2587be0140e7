/* SPDX-License-Identifier: MIT */
/* One servo in units: the calls of servo.h in millidegrees and mRPM. The
 * conversions, their ranges and the profiles are those of units.h; raw access stays servo.h.
 *
 * A call that sends checks its arguments, converts them, and then does what its twin in servo.h
 * does. It returns what that returns: CDS_OK, CDS_BUSY, CDS_NO_ROOM, CDS_NO_REPLY_DUE, CDS_LIMIT,
 * CDS_INHIBITED, CDS_TOO_EARLY; and CDS_BAD_ARGUMENT also for a register or value out of range.
 * CDS_PACKET_SIZE(5) is room for every packet here.
 * IDs are 0 to 253, or CDS_BROADCAST_ID. `profile`, where a call takes one, says what kind of servo
 * that is and must not be NULL. Main context.
 */
#ifndef CDS_SERVO_UNITS_H
#define CDS_SERVO_UNITS_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/bus.h"   // struct cds_request
#include "cds55xx/units.h" // struct cds_register_profile

#ifdef __cplusplus
extern "C" {
#endif

/* Position mode: go to `mdeg` (0 to 300000) at `mrpm` (up to profile->full_speed_mrpm; 0: as fast
 * as it can). Manual 3.1, 0x1E and 0x20, R8 to R10. Divides 32-bit numbers: not for the hot path.
 */
enum cds_result cds_servo_units_move_mdeg(struct cds_bus *bus, struct cds_request *request,
                                          uint8_t id, const struct cds_register_profile *profile,
                                          int32_t mdeg, int32_t mrpm);

/* Endless turn: turn at `mrpm`, positive CCW, up to profile->full_speed_mrpm either way, 0 stands
 * still. CDS_BAD_ARGUMENT for an AX-12, which keeps no speed in endless turn. Manual 3.2, R16.
 * Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_servo_units_turn_mrpm(struct cds_bus *bus, struct cds_request *request,
                                          uint8_t id, const struct cds_register_profile *profile,
                                          int32_t mrpm);

/* Endless turn of an AX-12: drive with -10000 to 10000 (0.01 %) of full torque, positive CCW.
 * CDS_BAD_ARGUMENT for a CDS55xx. Manual: nothing. Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_servo_units_turn_cpct(struct cds_bus *bus, struct cds_request *request,
                                          uint8_t id, const struct cds_register_profile *profile,
                                          int32_t cpct);

/* How far it may turn: goals from `cw_mdeg` to `ccw_mdeg`, 0 to 300000, the former not above the
 * latter. Both 0: endless turn. EEPROM: not for every move. Manual 3.1, 0x06 to 0x09, and 3.2.
 * Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_servo_units_limits_mdeg(struct cds_bus *bus, struct cds_request *request,
                                            uint8_t id, int32_t cw_mdeg, int32_t ccw_mdeg);

/* Torque on or off. Manual 3.1, 0x18. */
enum cds_result cds_servo_units_torque(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                       bool on);

/* Torque limit until power-off, 0 to 10000 (0.01 %), of an AX-12. CDS_BAD_ARGUMENT for a CDS55xx,
 * which has Acc and Dcc there (R7); its limit is MAX_TORQUE, from the next power-up on.
 * Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_servo_units_torque_limit_cpct(struct cds_bus *bus, struct cds_request *request,
                                                  uint8_t id,
                                                  const struct cds_register_profile *profile,
                                                  int32_t cpct);

/* Acc and Dcc of a CDS55xx, 0 to 255 without a unit (R40). CDS_BAD_ARGUMENT for an AX-12, which has
 * its torque limit there (R7). */
enum cds_result cds_servo_units_ramps(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                      const struct cds_register_profile *profile, uint8_t acc,
                                      uint8_t dcc);

/* Writes the register at `address` (CDS_REG_*), in its unit, cds_units_of(). Besides a value out of
 * the unit's range, CDS_BAD_ARGUMENT: one out of the register's own range (control_table.h); a
 * register that is read-only or reserved, or the high byte of a word; a rate that no baud register
 * comes near enough to (CDS_BAUD_ERROR_MAX_PERMILLE). Manual 3.1. Divides 32-bit numbers: not for
 * the hot path. */
enum cds_result cds_servo_units_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                      const struct cds_register_profile *profile, uint8_t address,
                                      int32_t value);

/* The value of the register at `address`, in its unit, cds_units_of(), out of a READ's reply whose
 * parameter `index` is its (low) byte: of a READ from `first` on that is address - first. CDS_OK
 * only if the exchange succeeded and that many parameters came; else *value is left as it was and
 * the reason is returned, as by cds_request_word(): request->result, CDS_PENDING and CDS_CANCELLED
 * included, or CDS_REFUSED; CDS_CORRUPT also if what came is nothing that this register can hold;
 * CDS_BAD_ARGUMENT: there is no such register. Manual 3.1. Divides 32-bit numbers: not for the hot
 * path. */
enum cds_result cds_servo_units_value(const struct cds_request *request, uint8_t index,
                                      const struct cds_register_profile *profile, uint8_t address,
                                      int32_t *value);

/* The present values, of a READ's reply whose parameter `index` (0 to 49) is their (low) byte, into
 * what the last argument points to. Results as cds_servo_units_value(). 0 to 300000 millidegrees
 * (R9); mRPM, positive CCW (R35; not of an AX-12 in endless turn); load in 0.01 % of full torque,
 * positive if it is CCW (R35); millivolts; degrees Celsius. Manual 3.1. Divides 32-bit numbers: not
 * for the hot path. */
enum cds_result cds_servo_units_position_mdeg(const struct cds_request *request, uint8_t index,
                                              int32_t *mdeg);
enum cds_result cds_servo_units_speed_mrpm(const struct cds_request *request, uint8_t index,
                                           const struct cds_register_profile *profile,
                                           int32_t *mrpm);
enum cds_result cds_servo_units_load_cpct(const struct cds_request *request, uint8_t index,
                                          int32_t *cpct);
enum cds_result cds_servo_units_voltage_mV(const struct cds_request *request, uint8_t index,
                                           int32_t *mV);
enum cds_result cds_servo_units_temperature_celsius(const struct cds_request *request,
                                                    uint8_t index, int32_t *celsius);

#ifdef __cplusplus
}
#endif

#endif
