/* SPDX-License-Identifier: MIT */
/* Text for the PC; see printer.h. */
#include "console/printer.h"

#include <stddef.h>

#include "cds55xx/control_table.h" // cds_register_name()
#include "cds55xx/packet.h"        // CDS_ID_MAX
#include "console/number_format.h" // number_print()

/* The bus must not wait for a message. */
#define CHARACTERS_PER_CALL 4
/* Bytes for 3 characters, a number with its unit (15) and CR LF. */
#define CALL_BYTES 20

/* Conversions that print a register's value, and its unit. */
static const CDS_FLASH struct {
    char letter;
    uint8_t unit; // enum cds_unit
} conversions[] = {
    {'a', CDS_UNIT_MDEG},    {'r', CDS_UNIT_SIGNED_MRPM}, {'v', CDS_UNIT_MV},
    {'c', CDS_UNIT_CELSIUS}, {'b', CDS_UNIT_BPS},
};

#define CONVERSIONS (sizeof conversions / sizeof conversions[0])

void printer_typed_char(struct printer *printer, char c)
{
    printer_char(printer, c >= ' ' && c < 0x7F ? c : '?');
}

void printer_end_of_line(struct printer *printer)
{
    printer_char(printer, '\r');
    printer_char(printer, '\n');
}

void printer_text(struct printer *printer, const CDS_FLASH char *message)
{
    printer->text = message;
    printer->next = 0;
    printer->ends = false;
    printer->within = true;
}

void printer_line(struct printer *printer, const CDS_FLASH char *message)
{
    printer_text(printer, message);
    printer->ends = true;
}

#if PRINTER_HAS_ROOM
void printer_set_id(struct printer *printer, uint8_t id)
{
    printer->id_for_remedy = id <= CDS_ID_MAX ? (uint16_t)(id + 1) : 0;
}

static void print_id(struct printer *printer)
{
    static const CDS_FLASH char no_id[] = "ID";

    if (printer->id_for_remedy)
        printer_decimal(printer, (uint16_t)(printer->id_for_remedy - 1));
    else
        printer_flash(printer, no_id);
}

void printer_set_command(struct printer *printer, const CDS_FLASH char *usage)
{
    printer->command_for_remedy = usage;
}

static void print_command(struct printer *printer)
{
    static const CDS_FLASH char no_command[] = "COMMAND";
    const CDS_FLASH char *c = printer->command_for_remedy;

    for (c = c ? c : no_command; *c && *c != ' '; c++)
        printer_char(printer, *c);
}

static void print_register(struct printer *printer, uint8_t address)
{
    char name[CDS_REGISTER_NAME_SIZE];

    cds_register_name(address, name, sizeof name);
    printer_string(printer, name);
}
#endif

/* Ends what is printed. True: there is more to print. */
static bool goes_on(struct printer *printer)
{
    while (printer->text && *printer->text == '\0') {
        printer->text = printer->outer;
        printer->outer = NULL;
        if (printer->text == NULL && printer->ends)
            printer_end_of_line(printer);
        if (printer->text == NULL) {
            printer_set_id(printer, CDS_BROADCAST_ID);
            printer_set_command(printer, NULL);
        }
    }
    return printer->text != NULL;
}

static union printer_value take_value(struct printer *printer)
{
    return printer->values[printer->next++];
}

static void print_long(struct printer *printer)
{
    uint16_t low = take_value(printer).number;
    uint32_t value = (uint32_t)take_value(printer).number << 16 | low;

    printer_fixed(printer, (int32_t)(value <= INT32_MAX ? value : INT32_MAX), 0);
}

/* False: the letter is no conversion of a unit. */
static bool print_unit(struct printer *printer, char letter)
{
    for (uint8_t i = 0; i < CONVERSIONS; i++) {
        if (conversions[i].letter == letter) {
            number_print(printer, (enum cds_unit)conversions[i].unit, take_value(printer).number);
            return true;
        }
    }
    return false;
}

/* Prints what the letter behind a % stands for. False: nothing. */
static bool print_value(struct printer *printer, char letter)
{
    if (letter == 'u')
        printer_decimal(printer, take_value(printer).number);
    else if (letter == 'l')
        print_long(printer);
#if PRINTER_HAS_ROOM
    else if (letter == 'i')
        print_id(printer);
    else if (letter == 'm')
        print_command(printer);
    else if (letter == 'x')
        printer_address(printer, (uint8_t)take_value(printer).number);
    else if (letter == 'n')
        print_register(printer, (uint8_t)take_value(printer).number);
#endif
    else
        return print_unit(printer, letter);
    return true;
}

/* Prints the next character of the message, or a value. False: a number, which takes long. */
static bool print_next(struct printer *printer)
{
    char c = *printer->text++;

    if (c == '%' && *printer->text == 's') {
        printer->outer = printer->text + 1;
        printer->text = take_value(printer).text;
        return true;
    }
    if (c == '%' && print_value(printer, *printer->text)) {
        printer->text++;
        return false;
    }
    cds_ring_put(printer->ring, (uint8_t)c);
    return true;
}

bool printer_ready(struct printer *printer)
{
    uint8_t count = cds_ring_count(printer->ring);

    if (printer->text) {
        if (count > CDS_RING_SIZE - CALL_BYTES)
            return false;
        for (uint8_t left = CHARACTERS_PER_CALL; goes_on(printer); left--)
            if (left == 0 || !print_next(printer))
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
    uint32_t remaining = value < 0 ? 0 - (uint32_t)value : (uint32_t)value;
    bool begun = false;

    if (value < 0)
        printer_char(printer, '-');
    for (uint8_t left = DIGITS; left; left--) {
        uint32_t power = powers[DIGITS - left];
        char digit = '0';

        if (left <= decimals && remaining == 0)
            return;
        if (left == decimals)
            printer_char(printer, '.');
        for (; remaining >= power; remaining -= power)
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
