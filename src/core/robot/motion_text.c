/* SPDX-License-Identifier: MIT */
/* Why a move was refused or has ended, in words; see motion.h. */
#include "cds55xx/motion.h"
#include "cds55xx/result.h"
#include "flash.h" // CDS_FLASH

static const CDS_FLASH char text_too_fast[] = "too fast, it needs ";
static const CDS_FLASH char text_ms[] = " ms";

/* A text that grows, with a zero behind it. */
struct text {
    char *characters;
    uint8_t length, capacity;
};

static void add_character(struct text *text, char c)
{
    if (text->length + 1 < text->capacity)
        text->characters[text->length++] = c;
    text->characters[text->length] = '\0';
}

static void add_flash(struct text *text, const CDS_FLASH char *from)
{
    while (*from)
        add_character(text, *from++);
}

static void add_number(struct text *text, uint32_t number)
{
    uint32_t power = 1;

    while (number / power >= 10)
        power *= 10;
    for (; power; power /= 10)
        add_character(text, (char)('0' + number / power % 10));
}

uint8_t cds_motion_text(const struct cds_motion *motion, uint8_t result, char *text,
                        uint8_t capacity)
{
    struct text told = {.characters = text, .capacity = capacity};

    if (result != CDS_LIMIT || motion->move_result != CDS_LIMIT || motion->shortest_ms == 0)
        return cds_result_text(result, text, capacity);
    add_flash(&told, text_too_fast);
    add_number(&told, motion->shortest_ms);
    add_flash(&told, text_ms);
    return told.length;
}
