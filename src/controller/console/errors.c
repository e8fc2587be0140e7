/* SPDX-License-Identifier: MIT */
/* Texts of the numbered errors; see errors.h. */
#include "console/errors.h"

#include <stdbool.h>

#include "cds55xx/packet.h"     // CDS_ERROR_*
#include "console/command.h"    // command_set
#include "console/messages.h"   // FLASH_TEXT()
#include "robot/motion_start.h" // enum motion_refusal
#include "robot/robot.h"        // enum robot_refusal

_Static_assert((int)ERROR_TOO_MANY == ROBOT_TOO_MANY && (int)ERROR_CYCLE == ROBOT_BUSY &&
                   (int)ERROR_STOPPED == ROBOT_STOPPED && (int)ERROR_MOTION == ROBOT_IN_MOTION,
               "the console prints what the robot returns");
_Static_assert((int)ERROR_NO_GROUP == MOTION_NO_GROUP && (int)ERROR_ENDLESS == MOTION_ENDLESS &&
                   (int)ERROR_OMITTED == MOTION_OMITTED && (int)ERROR_MOTION == MOTION_BUSY &&
                   (int)ERROR_SAVING == MOTION_SAVING &&
                   (int)ERROR_NO_SEQUENCE == MOTION_NO_SEQUENCE &&
                   (int)ERROR_POSE_GONE == MOTION_POSE_GONE &&
                   (int)ERROR_NO_MOTION == MOTION_NONE && (int)ERROR_ABSENT == MOTION_ABSENT &&
                   (int)ERROR_STUCK == MOTION_STUCK && (int)ERROR_TORQUE_OFF == MOTION_TORQUE_OFF &&
                   (int)ERROR_TOO_FAST == MOTION_TOO_FAST && (int)ERROR_PAUSED == MOTION_PAUSED,
               "the console prints what motion_start.h returns");

const CDS_FLASH char *const CDS_FLASH errors_with_remedies[] = {
#define ROW(name, number, text, remedy) [number] = FLASH_TEXT(text "; " remedy),
    CDS_RESULTS(ROW) CONSOLE_ERRORS(ROW) FULL_ERRORS(ROW)
#undef ROW
};

const CDS_FLASH char *const CDS_FLASH errors_without_remedies[] = {
#define ROW(name, number, text, remedy) [number] = FLASH_TEXT(text),
    CDS_RESULTS(ROW) CONSOLE_ERRORS(ROW)
#undef ROW
};

const CDS_FLASH char *error_text(uint8_t number)
{
    return command_set.errors[number];
}

const CDS_FLASH char *error_text_of_servo(uint8_t number)
{
    bool has_word = number >= ERROR_SERVO_INSTRUCTION && number <= ERROR_SERVO_ANGLE;

    return error_text(number) + (has_word ? sizeof "servo: " - 1 : 0);
}

uint8_t error_of_servo(uint8_t *bits)
{
    static const CDS_FLASH uint8_t table[][2] = {
        {CDS_ERROR_INSTRUCTION, ERROR_SERVO_INSTRUCTION},
        {CDS_ERROR_RANGE, ERROR_SERVO_RANGE},
        {CDS_ERROR_CHECKSUM, ERROR_SERVO_CHECKSUM},
        {CDS_ERROR_ANGLE, ERROR_SERVO_ANGLE},
    };

    for (uint8_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        if (*bits & table[i][0]) {
            *bits = (uint8_t)(*bits & ~table[i][0]);
            return table[i][1];
        }
    }
    return 0;
}
