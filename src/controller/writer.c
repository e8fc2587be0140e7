/* Text for the PC; see writer.h. */
#include "writer.h"

#include <stddef.h>

#include "texts.h" // PACKED_PAIRS

#define CHARACTERS_PER_CALL 4 // the bus must not wait for a text

void writer_end_of_line(struct writer *writer)
{
    writer_char(writer, '\r');
    writer_char(writer, '\n');
}

void writer_text_line(struct writer *writer, const CDS_FLASH char *text)
{
    writer->text = text;
}

static const CDS_FLASH uint8_t pairs[][2] = PACKED_PAIRS;

/* The pair that a byte stands for, 0x80 to 0xFF and on from 0x01 to 0x1F; or more than there are.
 */
static uint8_t pair_of(uint8_t byte)
{
    return byte ? (uint8_t)((byte ^ 0x80) - (byte < 0x80)) : UINT8_MAX;
}

/* The next character of the text, '\0' at its end. */
static char next_character(struct writer *writer)
{
    uint8_t byte, pair;

    if (writer->depth)
        byte = writer->rest[--writer->depth];
    else if ((byte = (uint8_t)*writer->text) != '\0')
        writer->text++;
    while ((pair = pair_of(byte)) < sizeof pairs / sizeof pairs[0]) {
        writer->rest[writer->depth++] = pairs[pair][1];
        byte = pairs[pair][0];
    }
    return (char)byte;
}

bool writer_ready(struct writer *writer)
{
    for (uint8_t left = CHARACTERS_PER_CALL; writer->text; left--) {
        char c;

        if (left == 0 || cds_ring_count(writer->ring) > CDS_RING_SIZE - 2)
            return false; // an end of line is two
        c = next_character(writer);
        if (c) {
            cds_ring_put(writer->ring, (uint8_t)c);
        } else {
            writer_end_of_line(writer);
            writer->text = NULL;
        }
    }
    return cds_ring_count(writer->ring) <= CDS_RING_SIZE - WRITER_PIECE;
}

void writer_char(struct writer *writer, char c)
{
    cds_ring_put(writer->ring, (uint8_t)c);
    writer->within = c != '\n';
}

void writer_string(struct writer *writer, const char *string)
{
    while (*string)
        writer_char(writer, *string++);
}

void writer_flash(struct writer *writer, const CDS_FLASH char *text)
{
    while (*text)
        writer_char(writer, *text++);
}

/* Ten digits, by subtraction: dividing 32 bits costs more. */
static const CDS_FLASH uint32_t powers[] = {1000000000, 100000000, 10000000, 1000000, 100000,
                                            10000,      1000,      100,      10,      1};
#define DIGITS (sizeof powers / sizeof powers[0])

void writer_fixed(struct writer *writer, int32_t value, uint8_t decimals)
{
    uint32_t rest = value < 0 ? 0 - (uint32_t)value : (uint32_t)value;
    bool begun = false;

    if (value < 0)
        writer_char(writer, '-');
    for (uint8_t i = 0; i < DIGITS; i++) {
        uint8_t after = (uint8_t)(DIGITS - 1 - i); // digits that follow
        char digit = '0';

        if (after + 1u == decimals) { // the point is here
            if (rest == 0)
                return;
            writer_char(writer, '.');
        } else if (after < decimals && rest == 0) {
            return;
        }
        for (; rest >= powers[i]; rest -= powers[i])
            digit++;
        begun = begun || digit != '0' || after <= decimals;
        if (begun)
            writer_char(writer, digit);
    }
}

/* Short where most numbers are: ten digits of 32 bits take 0.1 ms. */
void writer_decimal(struct writer *writer, uint16_t number)
{
    char tens = '0';

    if (number >= 100) {
        writer_fixed(writer, number, 0);
        return;
    }
    for (; number >= 10; number -= 10)
        tens++;
    if (tens != '0')
        writer_char(writer, tens);
    writer_char(writer, (char)('0' + number));
}

static char hex_digit(uint8_t value)
{
    return (char)(value < 10 ? '0' + value : 'A' + value - 10);
}

void writer_hex(struct writer *writer, uint8_t byte)
{
    writer_char(writer, hex_digit(byte >> 4));
    writer_char(writer, hex_digit(byte & 0x0F));
}
