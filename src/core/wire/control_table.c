/* SPDX-License-Identifier: MIT */
/* The control table by address and by name; see control_table.h. */
#include "cds55xx/control_table.h"

#include "compiler.h" // NOINLINE
#include "flash.h"    // CDS_FLASH

/* A register in flash, 5 bytes. Its address is the sum of the widths before it; its lowest value is
 * 0. */
struct row {
    uint8_t width : 2, access : 2, area : 1;
    uint16_t initial, highest;
};

static const CDS_FLASH struct row registers[] = {
#define ROW(name, address, width, access, area, initial, lowest, highest)                          \
    {width, CDS_ACCESS_##access, CDS_AREA_##area, initial, highest},
    CDS_REGISTERS(ROW)
#undef ROW
};

#define LOWEST(name, address, width, access, area, initial, lowest, highest) | (lowest)
_Static_assert((0 CDS_REGISTERS(LOWEST)) == 0, "rows have no lowest value");
#undef LOWEST

/* All names one after the other, each with its NUL: "ID\0BAUD_RATE\0..." */
static const CDS_FLASH char names[] =
#define NAME(name, address, width, access, area, initial, lowest, highest) #name "\0"
    CDS_REGISTERS(NAME)
#undef NAME
    ;

#define REGISTERS (sizeof registers / sizeof registers[0])

/* The row that holds the byte `address`, or REGISTERS. */
static NOINLINE uint8_t row_of(uint8_t address)
{
    uint8_t row = 0, end = 0;

    for (; row < REGISTERS; row++) {
        end = (uint8_t)(end + registers[row].width);
        if (address < end)
            break;
    }
    return row;
}

static void describe(uint8_t row, struct cds_register *out)
{
    uint8_t address = 0;

    for (uint8_t i = 0; i < row; i++)
        address = (uint8_t)(address + registers[i].width);
    *out = (struct cds_register){.address = address,
                                 .width = registers[row].width,
                                 .access = registers[row].access,
                                 .area = registers[row].area,
                                 .initial = registers[row].initial,
                                 .highest = registers[row].highest};
}

static const CDS_FLASH char *name_of(uint8_t row)
{
    const CDS_FLASH char *name = names;

    for (; row; row--) {
        while (*name)
            name++;
        name++;
    }
    return name;
}

bool cds_register_at(uint8_t address, struct cds_register *out)
{
    uint8_t row = row_of(address);

    if (row == REGISTERS)
        return false;
    describe(row, out);
    return true;
}

static char upper(char c)
{
    if (c >= 'a' && c <= 'z')
        return (char)(c - 'a' + 'A');
    return c == '-' ? '_' : c;
}

static bool same(const char *name, uint8_t length, const CDS_FLASH char *stored)
{
    for (; length; length--)
        if (*stored == '\0' || upper(*name++) != *stored++)
            return false;
    return *stored == '\0';
}

bool cds_register_named(const char *name, uint8_t length, struct cds_register *out)
{
    const CDS_FLASH char *stored = names;

    for (uint8_t row = 0; row < REGISTERS; row++) {
        if (same(name, length, stored)) {
            describe(row, out);
            return true;
        }
        while (*stored)
            stored++;
        stored++;
    }
    return false;
}

uint8_t cds_register_name(uint8_t address, char *name, uint8_t room)
{
    uint8_t row = row_of(address);
    uint8_t length = 0;

    if (row < REGISTERS)
        for (const CDS_FLASH char *from = name_of(row); *from && length + 1 < room; from++)
            name[length++] = *from;
    if (room)
        name[length] = '\0';
    return length;
}
