/* SPDX-License-Identifier: MIT */
/* How registers' units are shown; see unit_names.h. */
#include "console/unit_names.h"

#include "console/number_parse.h" // enum number_kind

const CDS_FLASH struct unit_shown unit_shown[] = {
    [CDS_UNIT_NONE] = {"", NUMBER_BARE, 0},     [CDS_UNIT_NUMBER] = {"", NUMBER_BARE, 0},
    [CDS_UNIT_MDEG] = {"deg", NUMBER_ANGLE, 3}, [CDS_UNIT_MARGIN_MDEG] = {"deg", NUMBER_ANGLE, 3},
    [CDS_UNIT_MRPM] = {"rpm", NUMBER_SPEED, 3}, [CDS_UNIT_SIGNED_MRPM] = {"rpm", NUMBER_SPEED, 3},
    [CDS_UNIT_CPCT] = {"%", NUMBER_SHARE, 2},   [CDS_UNIT_SIGNED_CPCT] = {"%", NUMBER_SHARE, 2},
    [CDS_UNIT_MV] = {"V", NUMBER_VOLTAGE, 3},   [CDS_UNIT_CELSIUS] = {"C", NUMBER_TEMPERATURE, 0},
    [CDS_UNIT_US] = {"us", NUMBER_TIME, 0},     [CDS_UNIT_BPS] = {"bps", NUMBER_RATE, 0},
};
