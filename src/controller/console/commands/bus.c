/* scan, counters, bus. */
#include <stddef.h>
#include <string.h>

#include "console/console.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "compiler.h" // NOINLINE
#include "console/messages.h"

/* ---- scan ---- */

enum scan_choice { SCAN_HERE, SCAN_ALL, SCAN_RESCUE } __attribute__((packed));

uint8_t scan_begin(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_scan_config config = {
        .bus = console->bus,
        .request = console->line.request,
        .found = robot->work.scan.found,
        .found_capacity = ROBOT_SERVOS,
        .last_id = CDS_ID_MAX,
        .tries_every_rate = console->line.choice == SCAN_RESCUE,
        .reads_details = true,
    };
    uint8_t error = robot_claim(robot, ROBOT_SCAN);

    if (error)
        return error;
    if (console->line.choice == SCAN_HERE) {
        config.baud_regs = &robot->baud;
        config.baud_count = 1;
    }
    return robot_begun(robot, cds_scan_begin(&robot->work.scan.scan, &config));
}

/* What else is to be said of it, if it does not simply belong to the robot from now on.
 * console->part counts those that do. */
static uint16_t remark(struct console *console, const struct cds_scan_found *found)
{
    if (found->result != CDS_OK)
        return TEXT_FOUND_DAMAGED;
    if (found->details == CDS_OK && found->own_baud_reg != found->baud_reg)
        return TEXT_FOUND_NEIGHBOUR;
    if (found->baud_reg != console->robot->baud)
        return TEXT_NOTHING;
    if (!robot_add(console->robot, found->id))
        return TEXT_FOUND_TOO_MANY;
    console->part++;
    return TEXT_NOTHING;
}

/* "id 5 model 1 at 57600bps" */
NOINLINE static void tell_found(struct console *console, const struct cds_scan_found *found)
{
    uint16_t *value = console->printer.values;

    *value++ = found->id;
    if (found->details == CDS_OK) {
        *value++ = TEXT_FOUND_MODEL;
        *value++ = found->model;
    } else {
        *value++ = TEXT_NOTHING;
    }
    if (console->line.choice != SCAN_HERE) {
        *value++ = TEXT_FOUND_RATE;
        *value++ = found->baud_reg;
    } else {
        *value++ = TEXT_NOTHING;
    }
    *value = remark(console, found);
    printer_line(&console->printer, TEXT_FOUND);
}

/* Is all known of what was found as number `index`? */
static bool is_whole(const struct robot *robot, uint8_t index)
{
    const struct cds_scan_found *found = &robot->work.scan.found[index];

    return found->details != CDS_PENDING || found->result != CDS_OK ||
           robot->operation != ROBOT_SCAN;
}

/* A whole scan at the robot's rate tells how many servos are not of the robot. */
static bool sum_up(struct console *console)
{
    struct robot *robot = console->robot;
    const struct cds_scan *scan = &robot->work.scan.scan;

    if (console->error == 0 && console->line.choice == SCAN_HERE)
        robot->strangers = (uint8_t)(scan->count - console->part);
    console->printer.values[0] = scan->count;
    console->printer.values[1] = scan->asked;
    printer_line(&console->printer, TEXT_FOUND_IN_ALL);
    return false;
}

/* Progress is told at each new rate, and whenever somebody was found. */
bool scan_poll(struct console *console)
{
    struct robot *robot = console->robot;
    const struct cds_scan *scan = &robot->work.scan.scan;
    uint8_t *index = &console->index;
    bool over = !console_operates(console, ROBOT_SCAN);

    if (*index < scan->count && *index < ROBOT_SERVOS && is_whole(robot, *index)) {
        tell_found(console, &robot->work.scan.found[(*index)++]);
        return true;
    }
    if (over)
        return sum_up(console);
    if (console->line.choice != SCAN_HERE && scan->total && scan->baud_index == console->phase) {
        console->printer.values[0] = scan->asked;
        console->printer.values[1] = scan->total;
        console->printer.values[2] = scan->config.tries_every_rate
                                         ? scan->baud_index
                                         : scan->config.baud_regs[scan->baud_index];
        printer_line(&console->printer, TEXT_ASKED);
        console->phase++;
    }
    return true;
}

/* ---- counters ---- */

/* Those of a servo, in the order of their struct: which of the bus's they are called like. */
static const CDS_FLASH uint8_t servo_counters[] = {2, 3, 4, 8, 9, 10, 14};

#define SERVO_COUNTERS (sizeof servo_counters)
#define BUS_COUNTERS   (sizeof(struct cds_stats) / sizeof(uint16_t))
#define SERVO_BYTES_AT offsetof(struct cds_servo_counters, stale_replies) // behind words

_Static_assert(sizeof(struct cds_servo_counters) == SERVO_COUNTERS + SERVO_BYTES_AT / 2,
               "each has a name");

uint8_t counters_begin(struct console *console)
{
    return console->line.id == CDS_BROADCAST_ID || console_servo(console) ? 0 : ERROR_NOT_KNOWN;
}

/* Number `index` of a servo's, a word or a byte. */
static uint16_t servo_counter(const struct cds_servo_counters *counters, uint8_t index)
{
    const uint8_t *byte = (const uint8_t *)counters + SERVO_BYTES_AT / 2 + index;
    uint16_t word;

    if (index >= SERVO_BYTES_AT / 2)
        return *byte;
    memcpy(&word, (const uint8_t *)counters + 2 * index, sizeof word);
    return word;
}

/* A line a call: number `index`. */
bool counters_poll(struct console *console)
{
    struct cds_stats counters;
    uint8_t index = console->index++, name = index, count = BUS_COUNTERS;
    uint16_t *value = &console->printer.values[0];

    if (console->line.id != CDS_BROADCAST_ID) {
        const struct cds_servo_state *servo = console_servo(console);

        if (servo == NULL) { // it has another ID by now
            console->error = ERROR_NOT_KNOWN;
            return false;
        }
        *value = servo_counter(&servo->counters, index);
        name = servo_counters[index];
        count = SERVO_COUNTERS;
    } else {
        cds_bus_stats(console->bus, &counters);
        memcpy(value, (const uint8_t *)&counters + 2 * index, sizeof *value);
    }
    printer_line_at(&console->printer, TEXT_COUNTER_SENT, name);
    return console->index < count;
}

/* ---- bus ---- */

uint8_t bus_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t error;

    if (line->numbers == 0)
        return 0;
    if (console->robot->operation != ROBOT_IDLE)
        return ERROR_CYCLE;
    error = console_number(console, 0, CDS_UNIT_BPS);
    line->to = (uint8_t)console->raw;
    return error;
}

/* A request of the state check may be on its way: it changes when that is over. */
bool bus_poll(struct console *console)
{
    if (console->line.numbers && cds_bus_set_baud(console->bus, console->line.to) == CDS_BUSY)
        return true;
    console->printer.values[0] = console->bus->baud_reg;
    printer_line_at(&console->printer, TEXT_BUS_IS_OK, cds_bus_line(console->bus));
    return false;
}
