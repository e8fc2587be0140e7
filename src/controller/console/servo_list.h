/* SPDX-License-Identifier: MIT */
/* Lists of servos in a line of the console, where its usage says ID, ID|254 or ID...:
 *
 *     3        one servo
 *     1-6      the servos 1 to 6
 *     1,2,5-8  these servos
 *     all      the servos of the robot, as `servos` lists them
 *
 * Several such words may stand behind each other. If the next argument is a number (move, turn,
 * limits, baud), the list is one word. A command whose row has an ID runs for one servo after the
 * other. The reply of each servo begins with "servo 3: ", but not that of `backup`; then follows
 * "ok", what the command prints, or the error. */
#ifndef CONTROLLER_SERVO_LIST_H
#define CONTROLLER_SERVO_LIST_H

#include "console/command.h" // struct command_lists

/* True if the word is `all`, in any case. */
bool servo_list_is_all(const struct token *token);

/* `lists` of struct command_set. */
extern const CDS_FLASH struct command_lists servo_lists;

#endif
