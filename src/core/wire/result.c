/* SPDX-License-Identifier: MIT */
/* The texts of results; see result.h. */
#include "cds55xx/result.h"

#include "flash.h" // CDS_FLASH

#define TEXT_OF(name, number, text, remedy) static const CDS_FLASH char name##_TEXT[] = text;
CDS_RESULTS(TEXT_OF)
#undef TEXT_OF

#define ENTRY_OF(name, number, text, remedy) [number] = name##_TEXT,
static const CDS_FLASH char *const CDS_FLASH texts[] = {CDS_RESULTS(ENTRY_OF)};
#undef ENTRY_OF

#define ONE_MORE(name, number, text, remedy) +1
_Static_assert(CDS_CORRUPT < CDS_REFUSED && CDS_REFUSED < CDS_LINE_BUSY &&
                   CDS_CANCELLED < CDS_LINE_BUSY && CDS_LINE_BUSY + 1 == CDS_NO_REPLY_DUE &&
                   CDS_RESERVED + 1 == 0 CDS_RESULTS(ONE_MORE),
               "the order of the results (result.h)");
#undef ONE_MORE

uint8_t cds_result_text(uint8_t result, char *text, uint8_t capacity)
{
    uint8_t length = 0;

    if (result < sizeof texts / sizeof texts[0]) {
        const CDS_FLASH char *from = texts[result];

        for (; from[length] && length < capacity - 1; length++)
            text[length] = from[length];
    }
    text[length] = '\0';
    return length;
}
