/* SPDX-License-Identifier: MIT */
/* Typing keys at the console, for the tests of completion. */
#ifndef TYPING_RIG_H
#define TYPING_RIG_H

#include "console_rig.h"

/* Types keys behind what is typed: what the console has said. */
static inline const char *typed_more(const char *keys)
{
    said_length = 0;
    said[0] = '\0';
    type(keys);
    return said;
}

/* Types keys on an empty line: what the console has said. */
static inline const char *typed(const char *keys)
{
    type("\x15");
    return typed_more(keys);
}

static inline void assert_line(const char *line, const char *keys)
{
    char text[EDITOR_SIZE + 1] = "";

    typed(keys);
    memcpy(text, console.editor.text, console.editor.length);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(line, text, keys);
    TEST_ASSERT_TRUE(console_idle(&console));
}

#endif
