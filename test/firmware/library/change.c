/* SPDX-License-Identifier: MIT */
/* Changes of identity by commands, one in a line. "id FROM TO", "baud ID REGISTER" and "reset ID"
 * (at the rate of the bus) print their outcome. "again" searches once more for a lost servo and
 * prints the outcome. "rate REGISTER" sets the rate of the bus. "scan REGISTER" prints which of IDs
 * 0 to 9 answer at that rate. */
#include <cds55xx/blocking.h>
#include <cds55xx/avr.h>
#include <string.h>

#include "say.h"

#define IDS 10

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_PACKET_SIZE(2)];
static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);
static struct cds_identity identity;
static char line[24];

static enum cds_result settle(enum cds_result begun)
{
    if (begun == CDS_OK)
        while (cds_identity_poll(&identity) == CDS_PENDING)
            cds_bus_poll(&bus);
    say("state", identity.state);
    say("result", identity.steps.result);
    say("written", identity.is_written);
    say("baud", bus.baud_reg);
    return begun;
}

static enum cds_result look(uint8_t baud_reg)
{
    static struct cds_scan scan;
    static struct cds_scan_found found[IDS];
    struct cds_scan_config config = {.bus = &bus,
                                     .request = &request,
                                     .found = found,
                                     .found_capacity = IDS,
                                     .last_id = IDS - 1,
                                     .baud_regs = &baud_reg,
                                     .baud_count = 1};

    cds_blocking_scan(&scan, &config);
    for (uint8_t i = 0; i < scan.count; i++)
        say("found", found[i].id * 1000ul + found[i].baud_reg);
    return (enum cds_result)scan.steps.result;
}

static enum cds_result change(uint8_t what, uint8_t id, uint8_t value)
{
    struct cds_identity_config config = {.bus = &bus,
                                         .request = &request,
                                         .change = what,
                                         .id = id,
                                         .new_id = value,
                                         .new_baud_reg = value};

    return settle(cds_identity_begin(&identity, &config));
}

static uint8_t number(const char *text)
{
    return (uint8_t)(text ? atoi(text) : 0);
}

static enum cds_result obey(const char *word, uint8_t first, uint8_t second)
{
    if (strcmp(word, "id") == 0)
        return change(CDS_IDENTITY_ID, first, second);
    if (strcmp(word, "baud") == 0)
        return change(CDS_IDENTITY_BAUD, first, second);
    if (strcmp(word, "reset") == 0)
        return change(CDS_IDENTITY_RESET, first, 0);
    if (strcmp(word, "again") == 0)
        return settle(identity.state == CDS_IDENTITY_LOST ? cds_identity_look_again(&identity)
                                                          : CDS_OK);
    if (strcmp(word, "rate") == 0)
        return cds_bus_set_baud(&bus, first);
    if (strcmp(word, "scan") == 0)
        return look(first);
    return CDS_BAD_ARGUMENT;
}

int main(void)
{
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    for (;;) {
        const char *word, *first, *second;

        say_hear(line, sizeof line);
        word = strtok(line, " ");
        first = strtok(NULL, " ");
        second = strtok(NULL, " ");
        if (obey(word, number(first), number(second)) == CDS_OK)
            say_text("ok\n");
        else
            say_text("error 1: that cannot be\n");
    }
}
