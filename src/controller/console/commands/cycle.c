/* SPDX-License-Identifier: MIT */
/* cycle: goals and feedback of the group at a fixed rate. */
#include <stddef.h>
#include <string.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/messages.h"
#include "robot/group_cycle.h"

static const CDS_FLASH char message_inhibited[] = " inhibited";
static const CDS_FLASH char message_was_inhibited[] =
    " was inhibited: gets no goal until the next 'pose'";
static const CDS_FLASH char message_offline[] = " offline";
static const CDS_FLASH char message_unknown_yet[] = " not read yet";
static const CDS_FLASH char message_cycle_servo[] = "servo %u:%s";
static const CDS_FLASH char message_cycle_servo_known[] = "servo %u: %a %r %v %c%s";
static const CDS_FLASH char message_cycle_bus[] = ", bus ";

enum cycle_choice { CHOICE_NONE, CHOICE_EVERY, CHOICE_OFF } __attribute__((packed));
enum cycle_phase { CYCLE_TELL, CYCLE_READ, CYCLE_GOALS, CYCLE_END } __attribute__((packed));

/* The period of the line or of the settings, in us, into console->raw. Returns an error or 0. */
static uint8_t period(struct console *console)
{
    uint8_t error;

    if (console->line.numbers == 0) {
        console->raw = console->failsafe->settings->cycle_us;
        return 0;
    }
    error = console_ms(console);
    if (error == 0 && (console->raw < CYCLE_MS_MIN || console->raw > CYCLE_MS_MAX))
        error = ERROR_OUT_OF_RANGE;
    console->raw = (uint16_t)(console->raw * 1000u);
    return error;
}

uint8_t cycle_start(struct console *console, uint16_t period_us)
{
    struct robot *robot = console->robot;

    if (robot->group_count == 0)
        return ERROR_NO_GROUP;
    move_job(console)->begun_us = cds_port_now_us();
    return robot_start(robot, command_set.cycle, &period_us);
}

/* The first servo of the group whose position is not known. Only if there is one. */
static uint8_t id_not_known(const struct robot *robot)
{
    uint8_t index = 0;

    while (robot->work.cycle.feedback[index].known)
        index++;
    return robot->group[index];
}

enum cds_result cycle_known(struct console *console)
{
    struct robot *robot = console->robot;
    enum cds_result result = CDS_CANCELLED;

    if (robot->cycle == NULL) {
        console->error = ERROR_STOPPED;
        return result;
    }
    result = group_cycle_await_positions(robot, move_job(console)->begun_us);
    if (result != CDS_OK && result != CDS_PENDING) {
        console->error = (uint8_t)result;
        if (command_set.advise) // the error names the servo
            console->line.id = id_not_known(robot);
        robot_abort(robot);
    }
    return result;
}

static uint8_t cycle_begin(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t error;

    if (console->line.choice == CHOICE_EVERY) {
        console->phase = CYCLE_READ;
        error = period(console);
        return error ? error : cycle_start(console, console->raw);
    }
    if (console->line.numbers)
        return ERROR_COUNT;
    if (robot->cycle == NULL)
        return ERROR_NO_CYCLE;
    if (console->line.choice == CHOICE_OFF) {
        robot_abort(robot);
        console->phase = CYCLE_END;
    }
    return 0;
}

/* ---- starting ---- */

/* The first goals are the present positions: none is sent until all servos have answered. */
static bool read_poll(struct console *console)
{
    enum cds_result result = cycle_known(console);

    if (console->error)
        console->phase = CYCLE_END;
    else if (result == CDS_OK)
        console->phase = CYCLE_GOALS;
    return true;
}

static bool goals_poll(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    for (; *index < robot->group_count; (*index)++)
        if (cds_cycle_goal(&robot->work.cycle.cycle, *index,
                           robot->work.cycle.feedback[*index].position, 0) == CDS_BUSY)
            return true;
    cds_cycle_commit(&robot->work.cycle.cycle);
    return false;
}

/* ---- printing ---- */

/* The values of an offline servo are old. Only the profile `full`, which has command_set.explain,
 * has flash for this remark and for message_unknown_yet. */
static bool is_offline(struct robot *robot, uint8_t index)
{
    const struct cds_servo_state *servo =
        command_set.explain ? cds_servos_find(&robot->servos, robot->group[index]) : NULL;

    return servo && servo->presence == CDS_PRESENCE_OFFLINE;
}

/* What the line of a servo ends with. */
static const CDS_FLASH char *remark_of(struct robot *robot, uint8_t index)
{
    if (is_offline(robot, index))
        return message_offline;
    if (cds_cycle_is_dropped(&robot->work.cycle.cycle, index))
        return command_set.advise && cds_servos_may_drive(&robot->servos, robot->group[index])
                   ? message_was_inhibited
                   : message_inhibited;
    return command_set.explain && !robot->work.cycle.feedback[index].known ? message_unknown_yet
                                                                           : message_nothing;
}

/* "servo 1: 150.147deg 0rpm 12V 32C" */
static void print_servo(struct console *console, uint8_t index)
{
    struct robot *robot = console->robot;
    const struct cds_feedback *feedback = &robot->work.cycle.feedback[index];
    struct printer *printer = &console->printer;
    const CDS_FLASH char *remark = remark_of(robot, index);

    printer->values[0].number = robot->group[index];
    printer->values[1].text = remark;
    if (!feedback->known || remark == message_offline) {
        printer_line(printer, message_cycle_servo);
        return;
    }
    printer->values[1].number = feedback->position;
    printer->values[2].number = feedback->speed;
    printer->values[3].number = feedback->voltage;
    printer->values[4].number = feedback->temperature;
    printer->values[5].text = remark;
    printer_line(printer, message_cycle_servo_known);
}

static const CDS_FLASH char *const CDS_FLASH counter_texts[] = {
    FLASH_TEXT("periods %l"), FLASH_TEXT(", missed %l"), FLASH_TEXT(", unsent %l"),
    FLASH_TEXT("reads %l"),   FLASH_TEXT(", failed %l"), FLASH_TEXT("oldest us %l"),
};

/* In the order of counter_texts. */
static const CDS_FLASH uint8_t counters[] = {
    offsetof(struct cds_cycle_counters, periods), offsetof(struct cds_cycle_counters, missed),
    offsetof(struct cds_cycle_counters, unsent),  offsetof(struct cds_cycle_counters, reads),
    offsetof(struct cds_cycle_counters, failed),  offsetof(struct cds_cycle_counters, oldest_us),
};

#define COUNTERS (sizeof counters)

static void print_counter(struct printer *printer, const struct cds_cycle *state, uint8_t index)
{
    uint32_t value;

    memcpy(&value, (const uint8_t *)&state->counters + counters[index], sizeof value);
    printer->values[0].number = (uint16_t)value;
    printer->values[1].number = (uint16_t)(value >> 16);
    printer_line(printer, counter_texts[index]);
    printer->ends = index == 2 || index == 4; // these end a line
}

/* Prints the counters, the load of the bus, then one line for each servo. False after the last. */
static bool print_line(struct console *console, uint8_t index)
{
    const struct cds_cycle *state = &console->robot->work.cycle.cycle;
    struct printer *printer = &console->printer;

    if (index < COUNTERS) {
        print_counter(printer, state, index);
    } else if (index == COUNTERS) {
        printer_text(printer, message_cycle_bus);
    } else if (index == COUNTERS + 1) {
        printer_fixed(printer, cds_cycle_utilisation_permille(state), 1);
        printer_char(printer, '%');
        printer_end_of_line(printer);
    } else {
        print_servo(console, (uint8_t)(index - COUNTERS - 2));
        return index - COUNTERS - 1 < state->count;
    }
    return true;
}

static bool cycle_poll(struct console *console)
{
    switch (console->phase) {
    case CYCLE_READ: return read_poll(console);
    case CYCLE_GOALS: return goals_poll(console);
    case CYCLE_END:
        if (console->robot->cycle)
            return true;
        if (console->error)
            return false;
        console->phase = CYCLE_TELL;
        return true;
    default: return print_line(console, console->index++);
    }
}

static const CDS_FLASH struct command cycle_rows[] = {
    {
        .usage = FLASH_TEXT("cycle [every|off [MS]]"),
        .what = FLASH_TEXT("goals at a fixed rate"),
        .details =
            COMMAND_DETAILS("For the group; MS: 2 to 65ms, only with every; default: the setting "
                            "cycle_us. Goals: the present positions until pose sets others"),
        .example = COMMAND_DETAILS("cycle every 4ms"),
        .begin = cycle_begin,
        .poll = cycle_poll,
    },
};

const CDS_FLASH struct command_group cycle_commands = {
    .rows = cycle_rows,
    .count = sizeof cycle_rows / sizeof cycle_rows[0],
};
