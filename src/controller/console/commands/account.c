/* SPDX-License-Identifier: MIT */
/* counters: since when they count, and what scan, diagnose and new have added. */
#include <string.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "console/account.h"
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/messages.h"

static const CDS_FLASH char message_since_reset[] = "since the reset, %l s ago";
static const CDS_FLASH char message_since_joined[] = "since servo %u joined the robot";

#define SECOND_US 1000000ul

#define COUNTERS (sizeof(struct cds_stats) / sizeof(uint16_t))

void account_tick(void)
{
    struct account *account = command_set.account;

    if (cds_port_now_us() - account->counted_us < SECOND_US)
        return;
    account->counted_us += SECOND_US;
    account->seconds++;
}

void account_begin(struct console *console)
{
    struct after_scan *job = after_scan_job(console);

    cds_bus_stats(console->bus, &job->begun);
    job->noise = job->begun.noise_bytes;
}

/* All counters are words. */
static uint16_t counter(const struct cds_stats *stats, uint8_t index)
{
    uint16_t value;

    memcpy(&value, (const uint8_t *)stats + 2 * index, sizeof value);
    return value;
}

void account_end(struct console *console)
{
    struct account *account = command_set.account;
    struct cds_stats *begun = &after_scan_job(console)->begun;
    struct cds_stats now;

    cds_bus_stats(console->bus, &now);
    for (uint8_t i = 0; i < COUNTERS; i++) {
        uint16_t sum =
            (uint16_t)(counter(&account->searched, i) + counter(&now, i) - counter(begun, i));

        memcpy((uint8_t *)&account->searched + 2 * i, &sum, sizeof sum);
    }
    *begun = now; // a second call adds nothing
}

uint16_t account_searched(uint8_t index)
{
    return counter(&command_set.account->searched, index);
}

void account_print_since(struct console *console)
{
    const struct account *account = command_set.account;
    union printer_value *values = console->printer.values;
    bool is_of_bus = console->line.id == CDS_BROADCAST_ID;

    values[0].number = is_of_bus ? (uint16_t)account->seconds : console->line.id;
    values[1].number = (uint16_t)(account->seconds >> 16);
    printer_line(&console->printer, is_of_bus ? message_since_reset : message_since_joined);
}
