/* SPDX-License-Identifier: MIT */
/* Texts that several files share; see messages.h. */
#include "console/messages.h"

#include "cds55xx/version.h"

#ifndef BOARD_NAME
#define BOARD_NAME "host"
#endif

const CDS_FLASH char message_nothing[] = "";
const CDS_FLASH char message_until_power_off[] = ", until power-off";
const CDS_FLASH char message_unchanged[] = "unchanged";
const CDS_FLASH char message_servo_label[] = "servo ";
const CDS_FLASH char message_version[] = "cds55xx " CDS_VERSION " " BOARD_NAME;
const CDS_FLASH char message_colon[] = ": ";
const CDS_FLASH char message_on[] = "on";
const CDS_FLASH char message_off[] = "off";
const CDS_FLASH char message_torque_unknown[] = "unknown";
const CDS_FLASH char message_end_failed[] = "%serror %u: %s";
const CDS_FLASH char message_at_percent[] = ", at %u%";
const CDS_FLASH char message_servo[] = "servo %u: %s";
const CDS_FLASH char message_of_servo[] = "servo %u: ";
const CDS_FLASH char message_torque_is_off[] = "moves once torque is on";
const CDS_FLASH char message_is_offline[] = "offline";
const CDS_FLASH char message_usage_due[] = "wrong number of arguments; usage: %s%s";
const CDS_FLASH char message_one_word[] = "; a list of servos is one word: 1,2";
const CDS_FLASH char message_clear[] = "clear";
const CDS_FLASH char message_release[] = "release";
const CDS_FLASH char message_factory[] = "factory values: ID 1, 1 Mbps";
const CDS_FLASH char message_unlisted[] = "; IDs not checked: %u";
const CDS_FLASH char message_at_rate[] = "not at the rate of the bus: 'bus %b' first";
const CDS_FLASH char message_bus_changed[] =
    "the bus changed: any servo at the old rate answers after 'bus %b'";
const CDS_FLASH char message_too_fast[] = "servo %u needs %l ms";
const CDS_FLASH char message_not_within[] =
    "not within the servo's limits; see 'servos' and docs/safety.md";
