/* Texts of the numbered errors; see errors.h. */
#include "errors.h"

#include "cds55xx/packet.h" // CDS_ERROR_*
#include "texts.h"          // PACKED_...

#define TEXT(name, number, text, remedy)                                                           \
    static const CDS_FLASH char text_##name[] = PACKED_error_##name;
CDS_RESULTS(TEXT)
CONSOLE_ERRORS(TEXT)
#undef TEXT

static const CDS_FLASH char text_unknown[] = "unknown error";

/* By number, which is quick: the bus must not wait for it. */
static const CDS_FLASH char *const CDS_FLASH texts[] = {
#define ROW(name, number, text, remedy) [number] = text_##name,
    CDS_RESULTS(ROW) CONSOLE_ERRORS(ROW)
#undef ROW
};

const CDS_FLASH char *error_text(uint8_t number)
{
    if (number < sizeof texts / sizeof texts[0] && texts[number])
        return texts[number];
    return text_unknown;
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
