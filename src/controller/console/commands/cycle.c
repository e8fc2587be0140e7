/* cycle: goals and feedback of the group at a fixed rate. */
#include <stddef.h>
#include <string.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "console/console.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "console/messages.h"

#define PERIOD_MIN_MS 2
#define PERIOD_MAX_MS 65
#define KNOWN_US      1000000 // within which each servo must have said where it is

enum cycle_choice { CHOICE_NONE, CHOICE_EVERY, CHOICE_OFF } __attribute__((packed));
enum cycle_phase { CYCLE_TELL, CYCLE_LOOK, CYCLE_GOALS, CYCLE_END } __attribute__((packed));

/* As said, or as set: 0 and console->raw in us, or an error. */
static uint8_t period(struct console *console)
{
    uint8_t error;

    if (console->line.numbers == 0) {
        console->raw = console->failsafe->settings->cycle_us;
        return 0;
    }
    error = console_ms(console);
    if (error == 0 && (console->raw < PERIOD_MIN_MS || console->raw > PERIOD_MAX_MS))
        error = ERROR_OUT_OF_RANGE;
    console->raw = (uint16_t)(console->raw * 1000u);
    return error;
}

static uint8_t start(struct console *console)
{
    struct robot *robot = console->robot;
    union robot_work *work = &robot->work;
    uint8_t error = period(console);

    if (error)
        return error;
    if (robot->group_count == 0)
        return ERROR_NO_GROUP;
    error = robot_claim(robot, ROBOT_CYCLE);
    if (error)
        return error;
    memset(work, 0, sizeof *work);
    console->phase = CYCLE_LOOK;
    console_job(console)->since_us = cds_port_now_us();
    return robot_begun(robot,
                       cds_cycle_begin(&work->cycle.cycle,
                                       &(struct cds_cycle_config){.bus = console->bus,
                                                                  .ids = robot->group,
                                                                  .packets = work->cycle.packets,
                                                                  .feedback = work->cycle.feedback,
                                                                  .count = robot->group_count,
                                                                  .period_us = console->raw}));
}

uint8_t cycle_begin(struct console *console)
{
    struct robot *robot = console->robot;

    if (console->line.choice == CHOICE_EVERY)
        return start(console);
    if (robot->operation != ROBOT_CYCLE)
        return ERROR_NO_CYCLE;
    if (console->line.choice == CHOICE_OFF) {
        if (console->line.numbers)
            return ERROR_COUNT;
        robot_abort(robot);
        console->phase = CYCLE_END;
    }
    return 0;
}

/* ---- starting ---- */

/* Its goals are where the servos are; until all have said so, none is sent. */
static bool look_poll(struct console *console)
{
    struct robot *robot = console->robot;
    const struct cds_feedback *feedback = robot->work.cycle.feedback;

    if (robot->operation != ROBOT_CYCLE) {
        console->error = ERROR_STOPPED;
        return false;
    }
    for (uint8_t left = robot->group_count; left; left--, feedback++) {
        if (feedback->known)
            continue;
        if (cds_port_now_us() - console_job(console)->since_us > KNOWN_US) {
            console->error = feedback->result;
            robot_abort(robot);
            console->phase = CYCLE_END;
        }
        return true;
    }
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
    console->error = (uint8_t)cds_cycle_commit(&robot->work.cycle.cycle);
    return false;
}

/* ---- telling ---- */

/* "servo 1: 150.147deg 0rpm 12V 32C" */
static void tell_servo(struct console *console, uint8_t index)
{
    const struct robot *robot = console->robot;
    const struct cds_feedback *feedback = &robot->work.cycle.feedback[index];
    struct printer *printer = &console->printer;
    uint16_t held =
        cds_cycle_is_dropped(&robot->work.cycle.cycle, index) ? TEXT_HELD : TEXT_NOTHING;

    printer->values[0] = robot->group[index];
    printer->values[1] = held;
    if (!feedback->known) {
        printer_line(printer, TEXT_CYCLE_SERVO);
        return;
    }
    printer->values[1] = feedback->position;
    printer->values[2] = feedback->speed;
    printer->values[3] = feedback->voltage;
    printer->values[4] = feedback->temperature;
    printer->values[5] = held;
    printer_line(printer, TEXT_CYCLE_SERVO_KNOWN);
}

/* In the order of the sentences. */
static const CDS_FLASH uint8_t counters[] = {
    offsetof(struct cds_cycle_counters, periods), offsetof(struct cds_cycle_counters, missed),
    offsetof(struct cds_cycle_counters, unsent),  offsetof(struct cds_cycle_counters, reads),
    offsetof(struct cds_cycle_counters, failed),  offsetof(struct cds_cycle_counters, oldest_us),
};

#define COUNTERS (sizeof counters)

static void tell_counter(struct printer *printer, const struct cds_cycle *cycle, uint8_t index)
{
    memcpy(printer->values, (const uint8_t *)&cycle->counters + counters[index], sizeof(uint32_t));
    printer_line_at(printer, TEXT_CYCLE_PERIODS, index);
    printer->ends = index == 2 || index == 4; // the last ones of their lines
}

/* Counters, the share of the bus, then a servo a line; false when there are no more. */
static bool tell(struct console *console, uint8_t index)
{
    const struct cds_cycle *cycle = &console->robot->work.cycle.cycle;
    struct printer *printer = &console->printer;

    if (index < COUNTERS) {
        tell_counter(printer, cycle, index);
    } else if (index == COUNTERS) {
        printer_text(printer, TEXT_CYCLE_BUS);
    } else if (index == COUNTERS + 1) {
        printer_fixed(printer, cds_cycle_utilisation_permille(cycle), 1);
        printer_char(printer, '%');
        printer_end_of_line(printer);
    } else {
        tell_servo(console, (uint8_t)(index - COUNTERS - 2));
        return index - COUNTERS - 1 < cycle->count;
    }
    return true;
}

bool cycle_poll(struct console *console)
{
    switch (console->phase) {
    case CYCLE_LOOK: return look_poll(console);
    case CYCLE_GOALS: return goals_poll(console);
    case CYCLE_END:
        if (console->robot->operation == ROBOT_CYCLE)
            return true;
        if (console->error)
            return false;
        console->phase = CYCLE_TELL;
        return true;
    default: return tell(console, console->index++);
    }
}
