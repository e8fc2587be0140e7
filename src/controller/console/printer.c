/* Text for the PC; see writer.h. */
#include "console/printer.h"

#include <stddef.h>
#include <string.h>

#include "console/number.h" // number_write()
#include "texts.h"          // TEXTS

#define CODES_PER_CALL 4  // the bus must not wait for a text
#define ROOM           20 // for as many characters, the last one a number with its unit, and the end

static const CDS_FLASH char plain[TEXT_MARK] = TEXT_PLAIN;
static const CDS_FLASH uint8_t pairs[][2] = TEXT_PAIRS;
static const CDS_FLASH uint8_t texts[] = TEXTS;

/* What a mark stands for: MARKS of scripts/texts.py. */
enum mark {
    MARK_DECIMAL,
    MARK_TEXT, // its values, if it has marks, are the next ones
    MARK_LONG, // two values: 32 bits, of which 31 are shown
    MARK_UNIT, // of `units`, and so are those behind it
} __attribute__((packed));

static const CDS_FLASH uint8_t marked_units[] = {CDS_UNIT_MDEG, CDS_UNIT_SIGNED_MRPM, CDS_UNIT_MV,
                                                 CDS_UNIT_CELSIUS, CDS_UNIT_BPS};

void writer_end_of_line(struct writer *writer)
{
    writer_char(writer, '\r');
    writer_char(writer, '\n');
}

uint16_t writer_text_at(uint16_t text, uint8_t index)
{
    const CDS_FLASH uint8_t *at = &texts[text];

    for (; index; index--)
        at += *at + 1;
    return (uint16_t)(at - texts);
}

static void begin_text(struct writer *writer, uint16_t text)
{
    const CDS_FLASH uint8_t *at = &texts[text];

    writer->left = *at++;
    writer->text = at;
}

void writer_text(struct writer *writer, uint16_t text)
{
    begin_text(writer, text);
    writer->next = 0;
    writer->ends = false;
    writer->within = true;
}

void writer_line(struct writer *writer, uint16_t text)
{
    writer_text(writer, text);
    writer->ends = true;
}

void writer_line_at(struct writer *writer, uint16_t text, uint8_t index)
{
    writer_line(writer, writer_text_at(text, index));
}

/* Ends what is written. True: there is more to write. */
static bool goes_on(struct writer *writer)
{
    while (writer->text && !writer->depth && !writer->left) {
        writer->text = writer->outer;
        writer->left = writer->outer_left;
        writer->outer = NULL;
        if (!writer->text && writer->ends)
            writer_end_of_line(writer);
    }
    return writer->text != NULL;
}

static void write_long(struct writer *writer)
{
    uint32_t value;

    memcpy(&value, &writer->values[writer->next], sizeof value);
    writer->next = (uint8_t)(writer->next + 2);
    writer_fixed(writer, (int32_t)(value <= INT32_MAX ? value : INT32_MAX), 0);
}

static void write_value(struct writer *writer, uint8_t mark)
{
    uint16_t value = writer->values[writer->next];

    if (mark == MARK_LONG) {
        write_long(writer);
        return;
    }
    writer->next++;
    switch (mark) {
    case MARK_DECIMAL: writer_decimal(writer, value); break;
    case MARK_TEXT:
        writer->outer = writer->text;
        writer->outer_left = writer->left;
        begin_text(writer, value);
        break;
    default: number_write(writer, (enum cds_unit)marked_units[mark - MARK_UNIT], value); break;
    }
}

/* Writes what the next code of the text stands for. False: a number, which takes long. */
static bool write_code(struct writer *writer)
{
    uint8_t code;

    if (writer->depth) {
        code = writer->rest[--writer->depth];
    } else {
        code = *writer->text++;
        writer->left--;
    }
    for (; code >= TEXT_PAIR; code = pairs[code - TEXT_PAIR][0])
        writer->rest[writer->depth++] = pairs[code - TEXT_PAIR][1];
    if (code < TEXT_MARK) {
        cds_ring_put(writer->ring, (uint8_t)plain[code]);
        return true;
    }
    write_value(writer, (uint8_t)(code - TEXT_MARK));
    return code == TEXT_MARK + MARK_TEXT;
}

bool writer_ready(struct writer *writer)
{
    uint8_t count = cds_ring_count(writer->ring);

    if (writer->text) {
        if (count > CDS_RING_SIZE - ROOM)
            return false;
        for (uint8_t left = CODES_PER_CALL; goes_on(writer); left--)
            if (left == 0 || !write_code(writer))
                return false;
        count = cds_ring_count(writer->ring);
    }
    return count <= CDS_RING_SIZE - WRITER_PIECE;
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
    for (uint8_t left = DIGITS; left; left--) {
        uint32_t power = powers[DIGITS - left];
        char digit = '0';

        if (left <= decimals && rest == 0)
            return;
        if (left == decimals)
            writer_char(writer, '.');
        for (; rest >= power; rest -= power)
            digit++;
        begun = begun || digit != '0' || left <= decimals + 1;
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

void writer_address(struct writer *writer, uint8_t address)
{
    writer_char(writer, '0');
    writer_char(writer, 'x');
    writer_hex(writer, address);
}

void writer_equals(struct writer *writer)
{
    static const CDS_FLASH char text[] = " = ";

    writer_flash(writer, text);
}
