/* SPDX-License-Identifier: MIT */
/* Registers in units; see units.h. */
#include "cds55xx/units.h"

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "compiler.h"              // NOINLINE
#include "flash.h"                 // CDS_FLASH

#define CW 0x400 // bit 10 of a signed register (R35)

const struct cds_register_profile cds_profile_cds55xx = {
    .full_speed_mrpm = 62000,
    .turn_unit = CDS_UNIT_SIGNED_MRPM,
    .has_torque_limit = false,
    .model_address = CDS_REG_MODEL_NUMBER,
    .model_number = 1,
};

const struct cds_register_profile cds_profile_ax12 = {
    .full_speed_mrpm = 111UL * CDS_VALUE_MAX,
    .turn_unit = CDS_UNIT_SIGNED_CPCT,
    .has_torque_limit = true,
    .model_address = CDS_REG_RESERVED_00, // the low byte of a word
    .model_number = 12,
};

/* An address without a row has CDS_UNIT_NONE. The unit of the first two bytes depends on the
 * profile. */
static const CDS_FLASH uint8_t units[CDS_TABLE_SIZE] = {
    [CDS_REG_FIRMWARE_VERSION] = CDS_UNIT_NUMBER,
    [CDS_REG_ID] = CDS_UNIT_NUMBER,
    [CDS_REG_BAUD_RATE] = CDS_UNIT_BPS,
    [CDS_REG_RETURN_DELAY] = CDS_UNIT_US,
    [CDS_REG_CW_ANGLE_LIMIT] = CDS_UNIT_MDEG,
    [CDS_REG_CCW_ANGLE_LIMIT] = CDS_UNIT_MDEG,
    [CDS_REG_MAX_TEMPERATURE] = CDS_UNIT_CELSIUS,
    [CDS_REG_MIN_VOLTAGE] = CDS_UNIT_MV,
    [CDS_REG_MAX_VOLTAGE] = CDS_UNIT_MV,
    [CDS_REG_MAX_TORQUE] = CDS_UNIT_CPCT,
    [CDS_REG_STATUS_RETURN_LEVEL] = CDS_UNIT_NUMBER,
    [CDS_REG_ALARM_LED] = CDS_UNIT_NUMBER,
    [CDS_REG_ALARM_SHUTDOWN] = CDS_UNIT_NUMBER,
    [CDS_REG_DOWN_CALIBRATION] = CDS_UNIT_NUMBER,
    [CDS_REG_UP_CALIBRATION] = CDS_UNIT_NUMBER,
    [CDS_REG_TORQUE_ENABLE] = CDS_UNIT_NUMBER,
    [CDS_REG_LED] = CDS_UNIT_NUMBER,
    [CDS_REG_CW_COMPLIANCE_MARGIN] = CDS_UNIT_MARGIN_MDEG,
    [CDS_REG_CCW_COMPLIANCE_MARGIN] = CDS_UNIT_MARGIN_MDEG,
    [CDS_REG_CW_PROPORTION] = CDS_UNIT_NUMBER,
    [CDS_REG_CCW_PROPORTION] = CDS_UNIT_NUMBER,
    [CDS_REG_GOAL_POSITION] = CDS_UNIT_MDEG,
    [CDS_REG_MOVING_SPEED] = CDS_UNIT_MRPM,
    [CDS_REG_ACC] = CDS_UNIT_NUMBER,
    [CDS_REG_DCC] = CDS_UNIT_NUMBER,
    [CDS_REG_PRESENT_POSITION] = CDS_UNIT_MDEG,
    [CDS_REG_PRESENT_SPEED] = CDS_UNIT_SIGNED_MRPM,
    [CDS_REG_PRESENT_LOAD] = CDS_UNIT_SIGNED_CPCT,
    [CDS_REG_PRESENT_VOLTAGE] = CDS_UNIT_MV,
    [CDS_REG_PRESENT_TEMPERATURE] = CDS_UNIT_CELSIUS,
    [CDS_REG_REGISTERED_INSTRUCTION] = CDS_UNIT_NUMBER,
    [CDS_REG_MOVING] = CDS_UNIT_NUMBER,
    [CDS_REG_LOCK] = CDS_UNIT_NUMBER,
    [CDS_REG_PUNCH] = CDS_UNIT_NUMBER,
};

enum cds_unit cds_units_of(const struct cds_register_profile *profile, uint8_t address)
{
    if (address >= CDS_TABLE_SIZE)
        return CDS_UNIT_NONE;
    if (address <= CDS_REG_MODEL_NUMBER)
        return address == profile->model_address ? CDS_UNIT_NUMBER : CDS_UNIT_NONE;
    if (profile->has_torque_limit && address == CDS_REG_ACC)
        return CDS_UNIT_CPCT;
    if (profile->has_torque_limit && address == CDS_REG_DCC)
        return CDS_UNIT_NONE; // its high byte
    return (enum cds_unit)units[address];
}

/* One unit: value = raw * per / of, raw 0 to top. */
struct scale {
    uint32_t per;
    uint16_t of;
    uint16_t top;
};

static const CDS_FLASH struct scale scales[] = {
    [CDS_UNIT_NUMBER] = {1, 1, UINT16_MAX},
    [CDS_UNIT_MDEG] = {CDS_MDEG_MAX, CDS_VALUE_MAX, CDS_VALUE_MAX},
    [CDS_UNIT_MARGIN_MDEG] = {CDS_MDEG_MAX, CDS_VALUE_MAX, UINT8_MAX},
    [CDS_UNIT_MRPM] = {.of = CDS_VALUE_MAX, .top = CDS_VALUE_MAX}, // `per` is the profile's
    [CDS_UNIT_SIGNED_MRPM] = {.of = CDS_VALUE_MAX, .top = CDS_VALUE_MAX},
    [CDS_UNIT_CPCT] = {CDS_CPCT_MAX, CDS_VALUE_MAX, CDS_VALUE_MAX},
    [CDS_UNIT_SIGNED_CPCT] = {CDS_CPCT_MAX, CDS_VALUE_MAX, CDS_VALUE_MAX},
    [CDS_UNIT_MV] = {100, 1, UINT8_MAX},
    [CDS_UNIT_CELSIUS] = {1, 1, UINT8_MAX},
    [CDS_UNIT_US] = {2, 1, 254},
};
#define SCALES (sizeof scales / sizeof scales[0])

/* No scale reaches further; times CDS_VALUE_MAX it still fits 32 bits, rounding included. */
#define MAGNITUDE_MAX 4000000

static NOINLINE bool scale_of(const struct cds_register_profile *profile, enum cds_unit unit,
                              struct scale *out)
{
    if ((unsigned)unit >= SCALES || unit == CDS_UNIT_NONE)
        return false;
    *out = scales[unit];
    if (unit == CDS_UNIT_MRPM || unit == CDS_UNIT_SIGNED_MRPM)
        out->per = profile->full_speed_mrpm;
    return true;
}

static bool is_signed(enum cds_unit unit)
{
    return unit == CDS_UNIT_SIGNED_MRPM || unit == CDS_UNIT_SIGNED_CPCT;
}

/* A rate is no multiple of its register, so CDS_UNIT_BPS has no scale. */
#define BAUD_CLOCK  2000000 // bit/s at baud register 0
#define DIVISOR_MAX 255     // baud register 254
#define LOWEST_BPS  7843    // its rate, rounded

static enum cds_result rate_from_register(uint16_t raw, int32_t *bps)
{
    uint16_t divisor = (uint16_t)(raw + 1);

    if (raw >= DIVISOR_MAX)
        return CDS_BAD_ARGUMENT;
    *bps = (BAUD_CLOCK + divisor / 2) / divisor;
    return CDS_OK;
}

enum cds_result cds_units_baud(int32_t bps, uint8_t *baud, int16_t *error_permille)
{
    uint32_t product;
    uint16_t divisor;
    int32_t error, half;

    if (bps < LOWEST_BPS || bps > BAUD_CLOCK)
        return CDS_BAD_ARGUMENT;
    divisor = (uint16_t)(BAUD_CLOCK / bps); // its rate is `bps` or faster, the next one slower
    product = (uint32_t)bps * divisor;      // at most 3/2 of the clock, here and below
    if ((BAUD_CLOCK - product) * (2u * divisor + 1u) > product) { // below the middle of both rates
        divisor++;
        product += (uint32_t)bps;
    }
    error = (int32_t)(BAUD_CLOCK - product) * 1000;
    half = (int32_t)(product / 2);
    *baud = (uint8_t)(divisor - 1);
    *error_permille = (int16_t)((error + (error < 0 ? -half : half)) / (int32_t)product);
    return CDS_OK;
}

bool cds_units_baud_is_kept(uint8_t baud)
{
    switch (baud) {
    case 1:
    case 3:
    case 7:
    case 16:
    case 34:
    case 103: return true;
    default: return false;
    }
}

static enum cds_result rate_to_register(int32_t bps, uint16_t *raw)
{
    uint8_t baud;
    int16_t error;
    enum cds_result result = cds_units_baud(bps, &baud, &error);

    if (result == CDS_OK)
        *raw = baud;
    return result;
}

enum cds_result cds_units_from_register(const struct cds_register_profile *profile,
                                        enum cds_unit unit, uint16_t raw, int32_t *value)
{
    struct scale scale;
    uint16_t magnitude = raw;
    int32_t converted;

    if (unit == CDS_UNIT_BPS)
        return rate_from_register(raw, value);
    if (is_signed(unit))
        magnitude &= (uint16_t)~CW;
    if (!scale_of(profile, unit, &scale) || magnitude > scale.top)
        return CDS_BAD_ARGUMENT;
    converted = (int32_t)((magnitude * scale.per + scale.of / 2) / scale.of);
    *value = magnitude == raw ? converted : -converted;
    return CDS_OK;
}

enum cds_result cds_units_to_register(const struct cds_register_profile *profile,
                                      enum cds_unit unit, int32_t value, uint16_t *raw)
{
    struct scale scale;
    uint32_t magnitude = (uint32_t)value; // a negative value of an unsigned unit is now too large
    uint16_t converted, sign = 0;

    if (unit == CDS_UNIT_BPS)
        return rate_to_register(value, raw);
    if (is_signed(unit) && value < 0) {
        magnitude = 0 - magnitude;
        sign = CW;
    }
    if (!scale_of(profile, unit, &scale) || magnitude > MAGNITUDE_MAX ||
        magnitude * scale.of > scale.top * scale.per) // the top of a scale rounds down
        return CDS_BAD_ARGUMENT;
    converted = (uint16_t)((magnitude * scale.of + scale.per / 2) / scale.per);
    if (unit == CDS_UNIT_MRPM && magnitude && !converted)
        converted = 1; // 0 is full speed (R10)
    *raw = converted ? converted | sign : 0;
    return CDS_OK;
}
