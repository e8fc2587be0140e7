/* scan, counters, bus. */
#include <stddef.h>
#include <string.h>

#include "console.h"
#include "errors.h"
#include "handlers.h"

/* ---- scan ---- */

enum scan_choice { SCAN_HERE, SCAN_ALL, SCAN_RESCUE };

uint8_t scan_begin(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_scan *scan = &robot->work.scan.scan;
    uint8_t error = robot_claim(robot, ROBOT_SCAN);

    if (error)
        return error;
    cds_scan_begin(scan, console->bus, console->line.request, robot->work.scan.found, ROBOT_SERVOS);
    cds_scan_set_details(scan);
    if (console->line.choice == SCAN_HERE)
        cds_scan_set_bauds(scan, &robot->baud, 1);
    if (console->line.choice == SCAN_RESCUE)
        cds_scan_set_rescue(scan);
    return 0;
}

static void tell_rate(struct console *console, uint8_t baud)
{
    WRITER_TEXT(&console->writer, " at ");
    number_write(&console->writer, CDS_UNIT_BPS, baud);
}

/* "id 5 model 1 at 57600bps" */
static void tell_found(struct console *console, const struct cds_scan_found *found)
{
    struct writer *writer = &console->writer;

    WRITER_TEXT(writer, "id ");
    writer_decimal(writer, found->id);
    if (found->details == CDS_OK) {
        WRITER_TEXT(writer, " model ");
        writer_decimal(writer, found->model);
    }
    if (console->line.choice != SCAN_HERE)
        tell_rate(console, found->baud);
    if (found->result != CDS_OK)
        WRITER_TEXT(writer, ": damaged, two of one ID?");
    else if (found->details == CDS_OK && found->own_baud != found->baud)
        WRITER_TEXT(writer, ", a neighbour");
    else if (found->baud == console->robot->baud && !robot_add(console->robot, found->id))
        WRITER_TEXT(writer, ": too many to know");
    writer_end_of_line(writer);
}

/* Is all known of what was found as number `index`? */
static bool is_whole(const struct robot *robot, uint8_t index)
{
    const struct cds_scan_found *found = &robot->work.scan.found[index];

    return found->details != CDS_PENDING || found->result != CDS_OK ||
           robot->operation != ROBOT_SCAN;
}

static bool sum_up(struct console *console)
{
    const struct robot *robot = console->robot;
    const struct cds_scan *scan = &robot->work.scan.scan;

    writer_decimal(&console->writer, scan->count);
    WRITER_TEXT(&console->writer, " found, ");
    writer_fixed(&console->writer, scan->asked, 0);
    WRITER_TEXT(&console->writer, " asked");
    writer_end_of_line(&console->writer);
    console->error = robot->result == CDS_CANCELLED ? ERROR_KEY : robot->result;
    return false;
}

/* Progress is told at each new rate, and whenever somebody was found. */
bool scan_poll(struct console *console)
{
    struct robot *robot = console->robot;
    const struct cds_scan *scan = &robot->work.scan.scan;
    uint8_t *index = &console->index;
    bool over = robot->operation != ROBOT_SCAN;

    if (!over && console_key(console))
        robot_abort(robot);
    if (*index < scan->count && *index < ROBOT_SERVOS && is_whole(robot, *index)) {
        tell_found(console, &robot->work.scan.found[(*index)++]);
        return true;
    }
    if (over)
        return sum_up(console);
    if (console->line.choice != SCAN_HERE && scan->total && scan->baud_index == console->phase) {
        writer_decimal(&console->writer, scan->asked);
        WRITER_TEXT(&console->writer, " of ");
        writer_decimal(&console->writer, scan->total);
        WRITER_TEXT(&console->writer, " asked, now");
        tell_rate(console, scan->bauds ? scan->bauds[scan->baud_index] : scan->baud_index);
        writer_end_of_line(&console->writer);
        console->phase++;
    }
    return true;
}

/* ---- counters ---- */

/* In the order of the structs. */
static const CDS_FLASH char bus_names[] = "sent\0repeated\0ok\0timeouts\0corrupt\0unsent\0refuted\0"
                                          "stray\0late\0extra\0foreign\0framing errors\0"
                                          "overruns\0ring overflows\0echo errors\0";
static const CDS_FLASH char servo_names[] =
    "ok\0timeouts\0corrupt\0late\0extra\0foreign\0echo errors\0";

uint8_t counters_begin(struct console *console)
{
    struct robot *robot = console->robot;

    if (console->line.id != CDS_BROADCAST_ID &&
        cds_roster_find(&robot->crew.roster, console->line.id) == NULL)
        return ERROR_NOT_KNOWN;
    return 0;
}

/* A line: the name number `index` and its counter, the words of a struct. False: it was the last.
 */
static bool tell_counter(struct writer *writer, const CDS_FLASH char *names, const void *counters,
                         uint8_t index)
{
    uint16_t value;

    memcpy(&value, (const uint8_t *)counters + index * sizeof value, sizeof value);
    for (; index; index--) {
        while (*names)
            names++;
        names++;
    }
    writer_flash(writer, names);
    writer_char(writer, ' ');
    writer_decimal(writer, value);
    writer_end_of_line(writer);
    while (*names)
        names++;
    return names[1] != '\0';
}

bool counters_poll(struct console *console)
{
    struct cds_counters counters;
    uint8_t index = console->index++;

    if (console->line.id != CDS_BROADCAST_ID)
        return tell_counter(
            &console->writer, servo_names,
            &cds_roster_find(&console->robot->crew.roster, console->line.id)->counters, index);
    cds_bus_counters(console->bus, &counters);
    return tell_counter(&console->writer, bus_names, &counters, index);
}

/* ---- bus ---- */

uint8_t bus_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint16_t raw = 0;
    uint8_t error;

    if (line->numbers == 0)
        return 0;
    if (console->robot->operation != ROBOT_IDLE)
        return ERROR_CYCLE;
    error = number_register(&line->number[0], CDS_UNIT_BPS, &raw);
    if (error == 0 && raw > CDS_BAUD_MAX)
        error = ERROR_OUT_OF_RANGE;
    line->to = (uint8_t)raw;
    return error;
}

static void tell_state(struct writer *writer, enum cds_bus_state state)
{
    switch (state) {
    case CDS_BUS_OK: WRITER_TEXT(writer, "bus ok"); break;
    case CDS_BUS_BUSY: WRITER_TEXT(writer, "bus busy: others use it"); break;
    default: WRITER_TEXT(writer, "bus held low"); break;
    }
}

/* A request of the state check may be on its way: it changes when that is over. */
bool bus_poll(struct console *console)
{
    if (console->line.numbers && cds_bus_set_baud(console->bus, console->line.to) == CDS_BUSY)
        return true;
    tell_state(&console->writer, cds_bus_state(console->bus));
    tell_rate(console, console->bus->baud);
    writer_end_of_line(&console->writer);
    return false;
}
