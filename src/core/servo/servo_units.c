/* SPDX-License-Identifier: MIT */
/* One servo in units; see servo_units.h. */
#include "cds55xx/servo_units.h"

#include <stddef.h> // NULL

#include "cds55xx/control_table.h" // CDS_REG_*, struct cds_register
#include "cds55xx/servo.h"         // cds_servo_write()

/* Both at once, so that neither acts without the other (R28). */
static enum cds_result write_words(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                   uint8_t address, uint16_t first, uint16_t second)
{
    uint8_t data[4] = {(uint8_t)first, (uint8_t)(first >> 8), (uint8_t)second,
                       (uint8_t)(second >> 8)};

    return cds_servo_write(bus, request, id, address, data, sizeof data);
}

enum cds_result cds_servo_units_move_mdeg(struct cds_bus *bus, struct cds_request *request,
                                          uint8_t id, const struct cds_register_profile *profile,
                                          int32_t mdeg, int32_t mrpm)
{
    uint16_t position, speed;

    if (cds_units_to_register(profile, CDS_UNIT_MDEG, mdeg, &position) != CDS_OK ||
        cds_units_to_register(profile, CDS_UNIT_MRPM, mrpm, &speed) != CDS_OK)
        return CDS_BAD_ARGUMENT;
    return write_words(bus, request, id, CDS_REG_GOAL_POSITION, position, speed);
}

static enum cds_result write_word(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                  uint8_t address, const struct cds_register_profile *profile,
                                  enum cds_unit unit, int32_t value)
{
    uint16_t raw;
    enum cds_result result = cds_units_to_register(profile, unit, value, &raw);

    return result == CDS_OK ? cds_servo_write_word(bus, request, id, address, raw) : result;
}

enum cds_result cds_servo_units_turn_mrpm(struct cds_bus *bus, struct cds_request *request,
                                          uint8_t id, const struct cds_register_profile *profile,
                                          int32_t mrpm)
{
    if (profile->turn_unit != CDS_UNIT_SIGNED_MRPM)
        return CDS_BAD_ARGUMENT;
    return write_word(bus, request, id, CDS_REG_MOVING_SPEED, profile, CDS_UNIT_SIGNED_MRPM, mrpm);
}

enum cds_result cds_servo_units_turn_cpct(struct cds_bus *bus, struct cds_request *request,
                                          uint8_t id, const struct cds_register_profile *profile,
                                          int32_t cpct)
{
    if (profile->turn_unit != CDS_UNIT_SIGNED_CPCT)
        return CDS_BAD_ARGUMENT;
    return write_word(bus, request, id, CDS_REG_MOVING_SPEED, profile, CDS_UNIT_SIGNED_CPCT, cpct);
}

enum cds_result cds_servo_units_limits_mdeg(struct cds_bus *bus, struct cds_request *request,
                                            uint8_t id, int32_t cw_mdeg, int32_t ccw_mdeg)
{
    uint16_t cw, ccw;

    if (cw_mdeg > ccw_mdeg || cds_units_to_register(NULL, CDS_UNIT_MDEG, cw_mdeg, &cw) != CDS_OK ||
        cds_units_to_register(NULL, CDS_UNIT_MDEG, ccw_mdeg, &ccw) != CDS_OK)
        return CDS_BAD_ARGUMENT;
    return write_words(bus, request, id, CDS_REG_CW_ANGLE_LIMIT, cw, ccw);
}

enum cds_result cds_servo_units_torque(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                       bool on)
{
    return cds_servo_write_byte(bus, request, id, CDS_REG_TORQUE_ENABLE, on);
}

enum cds_result cds_servo_units_torque_limit_cpct(struct cds_bus *bus, struct cds_request *request,
                                                  uint8_t id,
                                                  const struct cds_register_profile *profile,
                                                  int32_t cpct)
{
    if (!profile->has_torque_limit)
        return CDS_BAD_ARGUMENT;
    return write_word(bus, request, id, CDS_REG_ACC, profile, CDS_UNIT_CPCT, cpct);
}

enum cds_result cds_servo_units_ramps(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                      const struct cds_register_profile *profile, uint8_t acc,
                                      uint8_t dcc)
{
    uint8_t data[2] = {acc, dcc};

    if (profile->has_torque_limit)
        return CDS_BAD_ARGUMENT;
    return cds_servo_write(bus, request, id, CDS_REG_ACC, data, sizeof data);
}

/* The register at `address` of such a servo; false if there is none of a known unit. */
static bool find(const struct cds_register_profile *profile, uint8_t address, enum cds_unit *unit,
                 struct cds_register *out)
{
    *unit = cds_units_of(profile, address);
    if (*unit == CDS_UNIT_NONE || !cds_register_at(address, out))
        return false;
    if (profile->has_torque_limit && address == CDS_REG_ACC) { // else as in control_table.h
        out->width = 2;
        out->highest = CDS_VALUE_MAX;
    }
    return true;
}

static bool fits_uart(int32_t bps)
{
    uint8_t baud;
    int16_t error;

    return cds_units_baud(bps, &baud, &error) == CDS_OK && error <= CDS_BAUD_ERROR_MAX_PERMILLE &&
           error >= -CDS_BAUD_ERROR_MAX_PERMILLE;
}

enum cds_result cds_servo_units_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                      const struct cds_register_profile *profile, uint8_t address,
                                      int32_t value)
{
    struct cds_register it;
    enum cds_unit unit;
    uint16_t raw;

    if (!find(profile, address, &unit, &it) || it.access != CDS_ACCESS_RW)
        return CDS_BAD_ARGUMENT;
    if (cds_units_to_register(profile, unit, value, &raw) != CDS_OK)
        return CDS_BAD_ARGUMENT;
    if (raw < it.lowest || raw > it.highest || (unit == CDS_UNIT_BPS && !fits_uart(value)))
        return CDS_BAD_ARGUMENT;
    return it.width == 1 ? cds_servo_write_byte(bus, request, id, address, (uint8_t)raw)
                         : cds_servo_write_word(bus, request, id, address, raw);
}

/* Converts the register of `width` bytes at `index` of the reply to `unit`. CDS_CORRUPT: it has no
 * value that a servo may have. */
static enum cds_result value_of(const struct cds_request *request, uint8_t index, uint8_t width,
                                const struct cds_register_profile *profile, enum cds_unit unit,
                                int32_t *value)
{
    uint16_t raw;
    uint8_t byte = 0;
    enum cds_result result;

    if (width == 1) {
        result = cds_request_byte(request, index, &byte);
        raw = byte;
    } else {
        result = cds_request_word(request, index, &raw);
    }
    if (result != CDS_OK)
        return result;
    return cds_units_from_register(profile, unit, raw, value) == CDS_OK ? CDS_OK : CDS_CORRUPT;
}

enum cds_result cds_servo_units_value(const struct cds_request *request, uint8_t index,
                                      const struct cds_register_profile *profile, uint8_t address,
                                      int32_t *value)
{
    struct cds_register it;
    enum cds_unit unit;

    if (!find(profile, address, &unit, &it))
        return CDS_BAD_ARGUMENT;
    return value_of(request, index, it.width, profile, unit, value);
}

enum cds_result cds_servo_units_position_mdeg(const struct cds_request *request, uint8_t index,
                                              int32_t *mdeg)
{
    return value_of(request, index, 2, NULL, CDS_UNIT_MDEG, mdeg);
}

enum cds_result cds_servo_units_speed_mrpm(const struct cds_request *request, uint8_t index,
                                           const struct cds_register_profile *profile,
                                           int32_t *mrpm)
{
    return value_of(request, index, 2, profile, CDS_UNIT_SIGNED_MRPM, mrpm);
}

enum cds_result cds_servo_units_load_cpct(const struct cds_request *request, uint8_t index,
                                          int32_t *cpct)
{
    return value_of(request, index, 2, NULL, CDS_UNIT_SIGNED_CPCT, cpct);
}

enum cds_result cds_servo_units_voltage_mV(const struct cds_request *request, uint8_t index,
                                           int32_t *mV)
{
    return value_of(request, index, 1, NULL, CDS_UNIT_MV, mV);
}

enum cds_result cds_servo_units_temperature_celsius(const struct cds_request *request,
                                                    uint8_t index, int32_t *celsius)
{
    return value_of(request, index, 1, NULL, CDS_UNIT_CELSIUS, celsius);
}
