/* SPDX-License-Identifier: MIT */
/* Texts of the console: plain strings in flash. A message is a named string beside the code that
 * prints it; printer.h lists what may stand for a value in it. Here are those that several files
 * share. */
#ifndef CONTROLLER_MESSAGES_H
#define CONTROLLER_MESSAGES_H

#include "flash.h" // CDS_FLASH

/* A string in flash for the initialiser of a static table: a plain literal would stand in RAM. */
#define FLASH_TEXT(string) ((const CDS_FLASH char[]){string})

extern const CDS_FLASH char message_nothing[];         // ""
extern const CDS_FLASH char message_until_power_off[]; // ", until power-off"
extern const CDS_FLASH char message_unchanged[];       // "unchanged"
extern const CDS_FLASH char message_servo_label[];     // "servo "
extern const CDS_FLASH char message_version[];         // "cds55xx 0.1.0 atmega128"
extern const CDS_FLASH char message_own_rate[];        // ", 115200bps, the board's own"; in main.c
extern const CDS_FLASH char message_colon[];           // ": "
extern const CDS_FLASH char message_on[];              // "on"
extern const CDS_FLASH char message_off[];             // "off"
extern const CDS_FLASH char message_torque_unknown[];  // "unknown"
extern const CDS_FLASH char message_end_failed[];      // of a motion: "%serror %u: %s"
extern const CDS_FLASH char message_at_percent[];      // ", at %u%"
extern const CDS_FLASH char message_servo[];           // "servo %u: %s"
extern const CDS_FLASH char message_of_servo[];        // "servo %u: "
extern const CDS_FLASH char message_torque_is_off[];
extern const CDS_FLASH char message_is_offline[];  // "offline"
extern const CDS_FLASH char message_clear[];       // "clear"
extern const CDS_FLASH char message_release[];     // "release"
extern const CDS_FLASH char message_usage_due[];   // "wrong number of arguments; usage: %s%s"
extern const CDS_FLASH char message_one_word[];    // "; a list of servos is one word: 1,2"
extern const CDS_FLASH char message_factory[];     // what reset and factory do
extern const CDS_FLASH char message_unlisted[];    // "; IDs not checked: %u"
extern const CDS_FLASH char message_at_rate[];     // "not at the rate of the bus: 'bus %b' ..."
extern const CDS_FLASH char message_bus_changed[]; // "the bus changed: ..."
extern const CDS_FLASH char message_too_fast[];    // "servo %u needs %l ms"
extern const CDS_FLASH char message_not_within[];  // CDS_LIMIT of what sets no ID

#endif
