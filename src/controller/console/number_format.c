/* SPDX-License-Identifier: MIT */
/* Values of registers with units, for the printer; see number_format.h. */
#include "console/number_format.h"

#include "cds55xx/control_table.h" // cds_register_name()
#include "console/unit_names.h"    // unit_shown[]

void number_print_bare(struct printer *printer, enum cds_unit unit, uint16_t raw)
{
    int32_t value = raw;

    if (unit != CDS_UNIT_NONE &&
        cds_units_from_register(&cds_profile_cds55xx, unit, raw, &value) != CDS_OK) {
        printer_char(printer, '?');
        return;
    }
    printer_fixed(printer, value, unit_shown[unit].exponent);
}

void number_print(struct printer *printer, enum cds_unit unit, uint16_t raw)
{
    number_print_bare(printer, unit, raw);
    printer_flash(printer, unit_shown[unit].text);
}

void number_print_name(struct printer *printer, uint8_t address)
{
    char name[CDS_REGISTER_NAME_SIZE];

    cds_register_name(address, name, sizeof name);
    printer_string(printer, name);
    printer_equals(printer);
}
