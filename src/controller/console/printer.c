/* Text for the PC; see printer.h. */
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

void printer_end_of_line(struct printer *printer)
{
    printer_char(printer, '\r');
    printer_char(printer, '\n');
}

uint16_t printer_text_at(uint16_t text, uint8_t index)
{
    const CDS_FLASH uint8_t *at = &texts[text];

    for (; index; index--)
        at += *at + 1;
    return (uint16_t)(at - texts);
}

static void begin_text(struct printer *printer, uint16_t text)
{
    const CDS_FLASH uint8_t *at = &texts[text];

    printer->left = *at++;
    printer->text = at;
}

void printer_text(struct printer *printer, uint16_t text)
{
    begin_text(printer, text);
    printer->next = 0;
    printer->ends = false;
    printer->within = true;
}

void printer_line(struct printer *printer, uint16_t text)
{
    printer_text(printer, text);
    printer->ends = true;
}

void printer_line_at(struct printer *printer, uint16_t text, uint8_t index)
{
    printer_line(printer, printer_text_at(text, index));
}

/* Ends what is written. True: there is more to write. */
static bool goes_on(struct printer *printer)
{
    while (printer->text && !printer->depth && !printer->left) {
        printer->text = printer->outer;
        printer->left = printer->outer_left;
        printer->outer = NULL;
        if (!printer->text && printer->ends)
            printer_end_of_line(printer);
    }
    return printer->text != NULL;
}

static void write_long(struct printer *printer)
{
    uint32_t value;

    memcpy(&value, &printer->values[printer->next], sizeof value);
    printer->next = (uint8_t)(printer->next + 2);
    printer_fixed(printer, (int32_t)(value <= INT32_MAX ? value : INT32_MAX), 0);
}

static void write_value(struct printer *printer, uint8_t mark)
{
    uint16_t value = printer->values[printer->next];

    if (mark == MARK_LONG) {
        write_long(printer);
        return;
    }
    printer->next++;
    switch (mark) {
    case MARK_DECIMAL: printer_decimal(printer, value); break;
    case MARK_TEXT:
        printer->outer = printer->text;
        printer->outer_left = printer->left;
        begin_text(printer, value);
        break;
    default: number_write(printer, (enum cds_unit)marked_units[mark - MARK_UNIT], value); break;
    }
}

/* Writes what the next code of the text stands for. False: a number, which takes long. */
static bool write_code(struct printer *printer)
{
    uint8_t code;

    if (printer->depth) {
        code = printer->rest[--printer->depth];
    } else {
        code = *printer->text++;
        printer->left--;
    }
    for (; code >= TEXT_PAIR; code = pairs[code - TEXT_PAIR][0])
        printer->rest[printer->depth++] = pairs[code - TEXT_PAIR][1];
    if (code < TEXT_MARK) {
        cds_ring_put(printer->ring, (uint8_t)plain[code]);
        return true;
    }
    write_value(printer, (uint8_t)(code - TEXT_MARK));
    return code == TEXT_MARK + MARK_TEXT;
}

bool printer_ready(struct printer *printer)
{
    uint8_t count = cds_ring_count(printer->ring);

    if (printer->text) {
        if (count > CDS_RING_SIZE - ROOM)
            return false;
        for (uint8_t left = CODES_PER_CALL; goes_on(printer); left--)
            if (left == 0 || !write_code(printer))
                return false;
        count = cds_ring_count(printer->ring);
    }
    return count <= CDS_RING_SIZE - PRINTER_PIECE;
}

void printer_char(struct printer *printer, char c)
{
    cds_ring_put(printer->ring, (uint8_t)c);
    printer->within = c != '\n';
}

void printer_string(struct printer *printer, const char *string)
{
    while (*string)
        printer_char(printer, *string++);
}

void printer_flash(struct printer *printer, const CDS_FLASH char *text)
{
    while (*text)
        printer_char(printer, *text++);
}

/* Ten digits, by subtraction: dividing 32 bits costs more. */
static const CDS_FLASH uint32_t powers[] = {1000000000, 100000000, 10000000, 1000000, 100000,
                                            10000,      1000,      100,      10,      1};
#define DIGITS (sizeof powers / sizeof powers[0])

void printer_fixed(struct printer *printer, int32_t value, uint8_t decimals)
{
    uint32_t rest = value < 0 ? 0 - (uint32_t)value : (uint32_t)value;
    bool begun = false;

    if (value < 0)
        printer_char(printer, '-');
    for (uint8_t left = DIGITS; left; left--) {
        uint32_t power = powers[DIGITS - left];
        char digit = '0';

        if (left <= decimals && rest == 0)
            return;
        if (left == decimals)
            printer_char(printer, '.');
        for (; rest >= power; rest -= power)
            digit++;
        begun = begun || digit != '0' || left <= decimals + 1;
        if (begun)
            printer_char(printer, digit);
    }
}

/* Short where most numbers are: ten digits of 32 bits take 0.1 ms. */
void printer_decimal(struct printer *printer, uint16_t number)
{
    char tens = '0';

    if (number >= 100) {
        printer_fixed(printer, number, 0);
        return;
    }
    for (; number >= 10; number -= 10)
        tens++;
    if (tens != '0')
        printer_char(printer, tens);
    printer_char(printer, (char)('0' + number));
}

static char hex_digit(uint8_t value)
{
    return (char)(value < 10 ? '0' + value : 'A' + value - 10);
}

void printer_hex(struct printer *printer, uint8_t byte)
{
    printer_char(printer, hex_digit(byte >> 4));
    printer_char(printer, hex_digit(byte & 0x0F));
}

void printer_address(struct printer *printer, uint8_t address)
{
    printer_char(printer, '0');
    printer_char(printer, 'x');
    printer_hex(printer, address);
}

void printer_equals(struct printer *printer)
{
    static const CDS_FLASH char text[] = " = ";

    printer_flash(printer, text);
}
