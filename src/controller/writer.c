/* Text for the PC; see writer.h. */
#include "writer.h"

#include <stddef.h>

#define CHARACTERS_PER_CALL 4 // the bus must not wait for a text

static const CDS_FLASH char end_of_line[] = "\r\n";

void writer_end_of_line(struct writer *writer)
{
    writer->text = end_of_line;
    writer->ending = true;
}

void writer_text_line(struct writer *writer, const CDS_FLASH char *text)
{
    writer->text = text;
    writer->ending = false;
}

bool writer_ready(struct writer *writer)
{
    for (uint8_t left = CHARACTERS_PER_CALL; writer->text; left--) {
        if (left == 0)
            return false;
        if (*writer->text == '\0') {
            if (writer->ending)
                writer->text = NULL;
            else
                writer_end_of_line(writer);
        } else if (cds_ring_put(writer->ring, (uint8_t)*writer->text)) {
            writer->text++;
        } else {
            return false;
        }
    }
    return cds_ring_count(writer->ring) <= CDS_RING_SIZE - WRITER_PIECE;
}

void writer_char(struct writer *writer, char c)
{
    cds_ring_put(writer->ring, (uint8_t)c);
}

void writer_string(struct writer *writer, const char *string)
{
    while (*string)
        writer_char(writer, *string++);
}

void writer_decimal(struct writer *writer, uint16_t number)
{
    static const CDS_FLASH uint16_t powers[] = {10000, 1000, 100, 10, 1};
    bool begun = false;

    for (uint8_t i = 0; i < sizeof powers / sizeof powers[0]; i++) {
        char digit = '0';

        for (; number >= powers[i]; number = (uint16_t)(number - powers[i]))
            digit++;
        begun = begun || digit != '0' || powers[i] == 1;
        if (begun)
            writer_char(writer, digit);
    }
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
