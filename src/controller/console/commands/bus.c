/* SPDX-License-Identifier: MIT */
/* scan, counters, bus. */
#include <stddef.h>
#include <string.h>

#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "compiler.h" // ALWAYS_INLINE, NOINLINE
#include "console/messages.h"
#include "console/noise.h" // struct noise

static const CDS_FLASH char message_found_damaged[] = ": reply damaged: noise, or one ID twice?";
static const CDS_FLASH char message_found_neighbour[] = ", set to another rate";
static const CDS_FLASH char message_found_too_many[] = ": the list is full";
static const CDS_FLASH char message_found_model[] = " model %u";
static const CDS_FLASH char message_found_rate[] = " at %b";
static const CDS_FLASH char message_found[] = "id %u%s%s%s";
static const CDS_FLASH char message_found_in_all[] = "%u found, %u asked";
static const CDS_FLASH char message_counter[] = "%s %u";
static const CDS_FLASH char message_counter_searched[] = "%s %u, of these %u by scan and diagnose";
static const CDS_FLASH char message_counter_searched_or_new[] =
    "%s %u, of these %u by scan, diagnose and new";
static const CDS_FLASH char message_asked[] = "%u of %u asked, now at %b";

/* ---- scan ---- */

enum scan_choice { SCAN_HERE, SCAN_ALL, SCAN_RESCUE } __attribute__((packed));

static enum cds_result begin_scan(struct robot *robot, const void *config)
{
    return cds_scan_begin(&robot->work.scan.scan, config);
}

static enum cds_result poll_scan(struct robot *robot)
{
    return cds_scan_poll(&robot->work.scan.scan);
}

static void abort_scan(struct robot *robot)
{
    cds_scan_abort(&robot->work.scan.scan);
}

static const CDS_FLASH struct robot_operation scan = {
    .begin = begin_scan, .poll = poll_scan, .abort = abort_scan, .changes_rate = true};

static uint8_t scan_begin(struct console *console)
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

    if (console->line.choice == SCAN_HERE) {
        config.baud_regs = &robot->baud_reg; // which robot_start() sets
        config.baud_count = 1;
    }
    if (command_set.account)
        account_begin(console);
    if (command_set.has_room)
        after_scan_job(console)->known = robot->servos.count;
    return robot_start(robot, &scan, &config);
}

/* True if the scan found this ID at the robot's rate. */
static bool is_found_here(const struct robot *robot, uint8_t id)
{
    const struct cds_scan *state = &robot->work.scan.scan;

    for (uint8_t i = 0; i < state->count; i++)
        if (robot->work.scan.found[i].id == id &&
            robot->work.scan.found[i].baud_reg == robot->baud_reg)
            return true;
    return false;
}

/* The scan has ended. A servo of the robot, online or not, that answered well only at another rate
 * has that rate from now on. If the scan found more servos than its list holds, the list may lack
 * the reply at the robot's rate: then no rate changes. */
static void note_rates(struct robot *robot)
{
    const struct cds_scan_found *found = robot->work.scan.found;
    uint16_t left = robot->work.scan.scan.count;

    if (left > ROBOT_SERVOS)
        return;
    for (; left; left--, found++) {
        struct cds_servo_state *servo = cds_servos_find(&robot->servos, found->id);

        if (servo && found->result == CDS_OK && !is_found_here(robot, found->id) &&
            (found->details != CDS_OK || found->own_baud_reg == found->baud_reg))
            servo->baud_reg = found->baud_reg;
    }
}

/* Adds the servo to the robot if it answers well at the robot's rate; console->part counts these
 * servos. Returns what the line of the servo ends with. */
static const CDS_FLASH char *join(struct console *console, const struct cds_scan_found *found)
{
    if (found->result != CDS_OK)
        return message_found_damaged;
    if (found->details == CDS_OK && found->own_baud_reg != found->baud_reg)
        return message_found_neighbour;
    if (found->baud_reg == console->robot->baud_reg) {
        if (!robot_add(console->robot, found->id))
            return message_found_too_many;
        console->part++;
    }
    return message_nothing;
}

/* Adds a found servo to the robot, and prints its line: "id 5 model 1 at 57600bps". */
NOINLINE static void take_found(struct console *console, const struct cds_scan_found *found)
{
    union printer_value *value = console->printer.values;

    (value++)->number = found->id;
    if (found->details == CDS_OK) {
        (value++)->text = message_found_model;
        (value++)->number = found->model;
    } else {
        (value++)->text = message_nothing;
    }
    if (console->line.choice != SCAN_HERE) {
        (value++)->text = message_found_rate;
        (value++)->number = found->baud_reg;
    } else {
        (value++)->text = message_nothing;
    }
    value->text = join(console, found);
    printer_line(&console->printer, message_found);
}

/* True if nothing more will be known of the found servo `index`. */
static bool is_whole(const struct robot *robot, uint8_t index)
{
    const struct cds_scan_found *found = &robot->work.scan.found[index];

    return found->details != CDS_PENDING || found->result != CDS_OK || robot->operation == NULL;
}

void scan_sum_up(struct console *console)
{
    struct robot *robot = console->robot;
    const struct cds_scan *state = &robot->work.scan.scan;

    if (console->error == 0 && console->line.choice == SCAN_HERE)
        robot->unlisted = (uint8_t)(state->count - console->part);
    if (command_set.advise && console->error == 0)
        note_rates(robot);
    console->printer.values[0].number = state->count;
    console->printer.values[1].number = state->asked;
    printer_line(&console->printer, message_found_in_all);
}

/* Prints progress at each new rate, and each servo found. */
static bool scan_poll(struct console *console)
{
    struct robot *robot = console->robot;
    const struct cds_scan *state = &robot->work.scan.scan;
    uint8_t *index = &console->index;
    bool over;

    if (command_set.after_scan && after_scan_job(console)->phase)
        return command_set.after_scan(console);
    if (command_set.after_scan && robot->operation)
        after_scan_note(console);
    over = !console_operates(console);
    if (*index < state->count && *index < ROBOT_SERVOS && is_whole(robot, *index)) {
        take_found(console, &robot->work.scan.found[(*index)++]);
        return true;
    }
    if (over && command_set.account)
        account_end(console);
    if (over && command_set.after_scan)
        return command_set.after_scan(console);
    if (over) {
        scan_sum_up(console);
        return false;
    }
    if (console->line.choice != SCAN_HERE && state->total && state->baud_index == console->phase) {
        console->printer.values[0].number = state->asked;
        console->printer.values[1].number = state->total;
        console->printer.values[2].number = state->config.tries_every_rate
                                                ? state->baud_index
                                                : state->config.baud_regs[state->baud_index];
        printer_line(&console->printer, message_asked);
        console->phase++;
    }
    return true;
}

/* ---- counters ---- */

static const CDS_FLASH char *const CDS_FLASH counter_names[] = {
    FLASH_TEXT("sent"),
    FLASH_TEXT("retried"),
    FLASH_TEXT("ok"),
    FLASH_TEXT("timeouts"),
    FLASH_TEXT("corrupt"),
    FLASH_TEXT("line busy"),
    FLASH_TEXT("malformed"),
    FLASH_TEXT("noise bytes"),
    FLASH_TEXT("stale replies"),
    FLASH_TEXT("duplicate replies"),
    FLASH_TEXT("unexpected packets"),
    FLASH_TEXT("framing errors"),
    FLASH_TEXT("overruns"),
    FLASH_TEXT("ring overflows"),
    FLASH_TEXT("echo errors"),
};

/* The counters of a servo, in the order of their struct: index of their name in counter_names. */
static const CDS_FLASH uint8_t servo_counters[] = {2, 3, 4, 8, 9, 10, 14};

#define SERVO_COUNTERS (sizeof servo_counters)
#define BUS_COUNTERS   (sizeof(struct cds_stats) / sizeof(uint16_t))
#define SERVO_BYTES_AT offsetof(struct cds_servo_counters, stale_replies) // bytes, behind the words

_Static_assert(sizeof(struct cds_servo_counters) == SERVO_COUNTERS + SERVO_BYTES_AT / 2,
               "each has a name");

static uint8_t counters_begin(struct console *console)
{
    return console->line.id == CDS_BROADCAST_ID || console_servo(console) ? 0 : ERROR_NOT_KNOWN;
}

/* Counter `index` of a servo, a word or a byte. */
static uint16_t servo_counter(const struct cds_servo_counters *counters, uint8_t index)
{
    const uint8_t *byte = (const uint8_t *)counters + SERVO_BYTES_AT / 2 + index;
    uint16_t word;

    if (index >= SERVO_BYTES_AT / 2)
        return *byte;
    memcpy(&word, (const uint8_t *)counters + 2 * index, sizeof word);
    return word;
}

/* Prints one counter in each call. */
static bool counters_poll(struct console *console)
{
    struct cds_stats counters;
    uint8_t index, name, count = BUS_COUNTERS;
    uint16_t *value = &console->printer.values[1].number;
    const CDS_FLASH char *message = message_counter;

    if (command_set.account && console->part++ == 0) {
        account_print_since(console);
        return true;
    }
    index = name = console->index++;
    if (console->line.id != CDS_BROADCAST_ID) {
        const struct cds_servo_state *servo = console_servo(console);

        if (servo == NULL) { // the servo has another ID now
            console->error = ERROR_NOT_KNOWN;
            return false;
        }
        *value = servo_counter(&servo->counters, index);
        name = servo_counters[index];
        count = SERVO_COUNTERS;
    } else {
        cds_bus_stats(console->bus, &counters);
        memcpy(value, (const uint8_t *)&counters + 2 * index, sizeof *value);
        if (command_set.account && account_searched(index)) {
            console->printer.values[2].number = account_searched(index);
            message =
                command_set.has_room ? message_counter_searched_or_new : message_counter_searched;
            if (command_set.advise && console->printer.values[2].number > *value)
                console->printer.values[2].number = *value; // bytes that a total has missed
        }
    }
    console->printer.values[0].text = counter_names[name];
    printer_line(&console->printer, message);
    return console->index < count;
}

/* ---- bus ---- */

static const CDS_FLASH char *const CDS_FLASH bus_lines[] = {
    [CDS_BUS_LINE_QUIET] = FLASH_TEXT("bus ok at %b"),
    [1] = FLASH_TEXT("bus busy: noise or others, at %b"),
    [2] = FLASH_TEXT("bus held low at %b"),
};

static uint8_t bus_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t error;

    if (line->numbers == 0)
        return 0;
    error = robot_busy(console->robot);
    if (command_set.bus_changed)
        console->part = console->bus->baud_reg;
    return error ? error : console_number(console, 0, CDS_UNIT_BPS);
}

static const CDS_FLASH char message_none_answers[] =
    "no servo answers at %b: check their supply, the cable, and the data line, which may be held "
    "high";

/* The line is quiet between two bytes of noise: noise that was found at this rate counts, too. */
ALWAYS_INLINE enum cds_bus_line line_state(const struct console *console)
{
    bool is_noisy = command_set.noise && console_is_noisy(console) && !console->line.numbers;

    return is_noisy && cds_bus_line(console->bus) == CDS_BUS_LINE_QUIET
               ? CDS_BUS_LINE_SUSPECT
               : cds_bus_line(console->bus);
}

/* True if a person asks for the state of a quiet line on which no servo of the list answers: a line
 * that is held high looks as one at rest. At a new rate no servo has been asked. */
static bool is_line_in_doubt(const struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;

    if (!console_is_for_person(console) || console->line.numbers ||
        line_state(console) != CDS_BUS_LINE_QUIET)
        return false;
    for (uint8_t i = 0; i < servos->count; i++)
        if (servos->states[i].presence != CDS_PRESENCE_OFFLINE)
            return false;
    return servos->count;
}

enum cds_bus_line bus_line_state(const struct console *console)
{
    return line_state(console);
}

void bus_print_line(struct console *console)
{
    console->printer.values[0].number = console->bus->baud_reg;
    printer_line(&console->printer, command_set.has_room && is_line_in_doubt(console)
                                        ? message_none_answers
                                        : bus_lines[line_state(console)]);
}

void bus_print_change(struct console *console, uint8_t old)
{
    console->printer.values[0].number = old;
    printer_line(&console->printer, command_set.bus_changed ? command_set.bus_changed(console, old)
                                                            : message_bus_changed);
}

/* True if a person must hear which servos are known at the new rate and at the old one. */
static bool must_tell_change(const struct console *console)
{
    return command_set.bus_changed && console->line.numbers &&
           console->bus->baud_reg != console->part && console_is_for_person(console);
}

/* Noise that was found at another rate tells nothing of this one: it is found and told again. */
static void forget_noise(struct console *console)
{
    command_set.noise->is_there = false;
    command_set.noise->polls = 0;
    console->faults_told &= (uint8_t)~FAULT_NOISE;
}

/* While a request of the state check is under way, the rate cannot change yet. */
static bool bus_poll(struct console *console)
{
    if (command_set.bus_changed && console->index) {
        bus_print_change(console, console->part);
        return false;
    }
    if (console->line.numbers && cds_bus_set_baud(console->bus, (uint8_t)console->raw) == CDS_BUSY)
        return true;
    if (command_set.noise && console->line.numbers && console->raw != console->part)
        forget_noise(console);
    bus_print_line(console);
    console->index = must_tell_change(console);
    return console->index;
}

static const CDS_FLASH struct command bus_rows[] = {
    {
        .usage = FLASH_TEXT("scan [all|rescue]"),
        .what = FLASH_TEXT("find servos on the bus"),
        .details =
            COMMAND_DETAILS("At the rate of the bus; servos found join the robot. all: at six "
                            "rates, 4.2 s. rescue: at all 255 rates, 11 minutes. A key ends it"),
        .example = COMMAND_DETAILS("scan"),
        .begin = scan_begin,
        .poll = scan_poll,
    },
    {
        .usage = FLASH_TEXT("counters [ID]"),
        .what = FLASH_TEXT("packets sent and lost"),
        .details = COMMAND_DETAILS("Of the bus since reset, of a servo since it joined. "
                                   "Modulo 65536, some to 255"),
        .example = COMMAND_DETAILS("counters"),
        .begin = counters_begin,
        .poll = counters_poll,
    },
    {
        .usage = FLASH_TEXT("bus [RATE]"),
        .what = FLASH_TEXT("baud rate of the bus"),
        .details = COMMAND_DETAILS("RATE: 7843 to 2000000bps. No RATE: shows it"),
        .example = COMMAND_DETAILS("bus 1000000bps"),
        .begin = bus_begin,
        .poll = bus_poll,
    },
};

const CDS_FLASH struct command_group bus_commands = {
    .heading = FLASH_TEXT("The bus:"),
    .rows = bus_rows,
    .count = sizeof bus_rows / sizeof bus_rows[0],
};
