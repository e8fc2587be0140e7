/* SPDX-License-Identifier: MIT */
/* Hints as typing.h gives them, and for a part of a name, of 3 characters or more, all names that
 * contain it:
 *
 *     ... unknown register; did you mean MAX_TEMPERATURE or PRESENT_TEMPERATURE?
 *
 * The profile `full` links them on chips with flash for them. Main context. */
#ifndef CONTROLLER_HINT_PARTS_H
#define CONTROLLER_HINT_PARTS_H

#include "console/typing.h" // struct command_typing

extern const CDS_FLASH struct command_typing typing_with_parts;

#endif
