/* status, alarms, clear, settings, save, defaults: the controller itself. */
#include "console/commands.h" // COMMAND_defaults
#include "console/console.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "compiler.h"      // NOINLINE
#include "console/reply.h" // reply_condition()
#include "console/messages.h"

/* ---- settings, save, defaults ---- */

static void say_origin(struct console *console)
{
    printer_line_at(&console->printer, TEXT_ORIGIN_NONE, console->failsafe->store->origin);
}

/* "link_loss_ms = 500 ms" */
static void setting_line(struct console *console, uint8_t index)
{
    const CDS_FLASH struct setting *row = &settings_table[index];
    struct printer *printer = &console->printer;

    printer_flash(printer, row->name);
    printer_equals(printer);
    printer_decimal(printer, settings_get(console->failsafe->settings, index));
    if (*row->unit != '-') {
        printer_char(printer, ' ');
        printer_flash(printer, row->unit);
    }
    printer_end_of_line(printer);
}

uint8_t settings_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t error;

    if (line->numbers == 0)
        return 0;
    error = console_number(console, 0, CDS_UNIT_NUMBER);
    if (error == 0 && !settings_set(console->failsafe->settings, line->to, console->raw))
        error = ERROR_SETTING_RANGE;
    if (error == 0)
        failsafe_follow(console->failsafe);
    return error;
}

uint8_t defaults_begin(struct console *console)
{
    settings_default(console->failsafe->settings);
    failsafe_follow(console->failsafe);
    return 0;
}

/* One; none, if it was set; or all, and where they came from. */
bool settings_poll(struct console *console)
{
    if (console->line.kind == COMMAND_defaults || console->line.words == 3)
        return console->failsafe->unsettled; // in force with the ok
    if (console->line.words == 2) {
        setting_line(console, console->line.to);
        return false;
    }
    if (console->step < SETTINGS_COUNT) {
        setting_line(console, console->step);
        return true;
    }
    say_origin(console);
    return false;
}

uint8_t save_begin(struct console *console)
{
    struct failsafe *failsafe = console->failsafe;

    return settings_save(failsafe->store, failsafe->settings) ? 0 : ERROR_SAVING;
}

bool save_poll(struct console *console)
{
    uint8_t result = console->failsafe->store->result;

    if (result == SETTINGS_FAILED)
        console->error = ERROR_NOT_SAVED;
    return result == SETTINGS_SAVING;
}

/* ---- alarms ---- */

/* Writes the line of the lowest bit, and returns the others. "alarm 3: overheating" */
NOINLINE static uint8_t alarm_line(struct printer *printer, uint8_t id, uint8_t bits)
{
    uint16_t *value = printer->values;

    if (id == CDS_BROADCAST_ID) {
        *value++ = TEXT_OF_OTHERS;
    } else {
        *value++ = TEXT_DECIMAL;
        *value++ = id;
    }
    bits = reply_condition(bits, value);
    printer_line(printer, TEXT_ALARM);
    return bits;
}

/* The alarms of the robot's servo `index`; behind the last one, of those who are not of it. */
static uint8_t alarms_of(const struct cds_servos *servos, uint8_t index)
{
    const struct cds_servo_state *servo = servos->states;
    uint8_t others = servos->alarms;

    if (index < servos->count)
        return servo[index].alarms;
    for (uint8_t left = servos->count; left; left--, servo++)
        others = (uint8_t)(others & ~servo->alarms);
    return others;
}

/* A line a call: `part` is what was told of servo `index`. */
bool alarms_poll(struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;
    uint8_t *index = &console->index, left = 0;

    while (*index <= servos->count &&
           (left = (uint8_t)(alarms_of(servos, *index) & ~console->part)) == 0) {
        (*index)++;
        console->part = 0;
    }
    if (left == 0)
        return false;
    left ^= alarm_line(&console->printer,
                       *index < servos->count ? servos->states[*index].id : CDS_BROADCAST_ID, left);
    console->part |= left;
    return true;
}

uint8_t clear_begin(struct console *console)
{
    return failsafe_clear(console->failsafe) ? 0 : ERROR_STOPPING;
}

bool alarm_tell(struct console *console)
{
    struct failsafe *failsafe = console->failsafe;

    if (!console->printer.text && (!failsafe->alarm || console->editor.length))
        return false;
    if (printer_ready(&console->printer) && failsafe->alarm)
        failsafe->alarm = alarm_line(&console->printer, failsafe->alarm_id, failsafe->alarm);
    return true;
}

/* ---- status ---- */

static void tell_reset(struct printer *printer, uint8_t causes)
{
    for (uint8_t i = 0; i < 5; i++, causes >>= 1)
        printer->values[i] = causes & 1 ? printer_text_at(TEXT_RESET_POWER, i) : TEXT_NOTHING;
    printer_line(printer, TEXT_RESET);
}

static uint16_t link_text(const struct failsafe *failsafe)
{
    if (failsafe->link_lost)
        return TEXT_LINK_LOST;
    return failsafe->settings->link_loss_ms ? TEXT_LINK_ON : TEXT_LINK_OFF;
}

static uint16_t stop_text(const struct robot *robot)
{
    if (robot_is_stopping(robot))
        return TEXT_TORQUE_PENDING;
    if (!robot->stop.servos)
        return TEXT_TORQUE_NEVER;
    return robot->stop.steps.result == CDS_REFUSED ? TEXT_TORQUE_SOME_ON : TEXT_TORQUE_READ;
}

/* "last stop: 2 of 3 servos read back as off; up to 251 more were not looked at". A servo that
 * joined the robot after the stop is not among those that were read back. */
static void tell_torque(struct printer *printer, const struct robot *robot)
{
    const struct cds_servo_state *servo = robot->states;
    uint8_t strangers = robot_strangers(robot), off = 0;

    for (uint8_t left = robot->servos.count; left; left--, servo++)
        if (servo->torque_off == CDS_TORQUE_OFF_OFF)
            off++;
    printer->values[0] = off;
    printer->values[1] = robot->servos.count;
    printer->values[2] = strangers ? TEXT_STRANGERS : TEXT_NOTHING;
    printer->values[3] = strangers;
    printer_line(printer, stop_text(robot));
}

static uint16_t inhibit_text(const struct failsafe *failsafe)
{
    if (!robot_is_inhibited(failsafe->robot))
        return TEXT_INHIBIT_OFF;
    return failsafe->link_lost ? TEXT_INHIBIT_LINK : TEXT_INHIBIT_ON;
}

static void tell_delays(struct printer *printer, const struct cds_servos *servos)
{
    printer->values[0] = servos->too_early;
    printer->values[1] = servos->shortest_delay;
    printer_line(printer, TEXT_DELAYS);
}

static void tell_stops(struct printer *printer, const struct failsafe *failsafe)
{
    printer->values[0] = *failsafe->damaged_stops;
    printer_line(printer, TEXT_STOPS);
}

/* "servos: 18, held 0, away 1" */
static void tell_servos(struct printer *printer, const struct cds_servos *servos)
{
    const struct cds_servo_state *servo = servos->states;
    uint8_t held = 0, away = 0;

    for (uint8_t left = servos->count; left; left--, servo++) {
        if (cds_servos_inhibits(servos, servo))
            held++;
        if (servo->presence == CDS_PRESENCE_OFFLINE)
            away++;
    }
    printer->values[0] = servos->count;
    printer->values[1] = servos->is_full ? TEXT_AND_MORE : TEXT_NOTHING;
    printer->values[2] = held;
    printer->values[3] = away;
    printer_line(printer, TEXT_SERVOS);
}

static void tell_stack(struct printer *printer, const struct failsafe *failsafe)
{
    printer->values[0] = failsafe->spare_bytes;
    printer->values[1] = failsafe->room_bytes;
    printer_line(printer, TEXT_STACK);
}

bool status_poll(struct console *console)
{
    struct printer *printer = &console->printer;

    switch (console->step) {
    case 0:
        console->failsafe->counts_stack = true;
        tell_reset(printer, console->failsafe->reset_cause);
        return true;
    case 1: say_origin(console); return true;
    case 2: printer_line(printer, link_text(console->failsafe)); return true;
    case 3: printer_line(printer, inhibit_text(console->failsafe)); return true;
    case 4: tell_torque(printer, console->robot); return true;
    case 5: tell_stops(printer, console->failsafe); return true;
    case 6: printer_line_at(printer, TEXT_BUS_OK, cds_bus_line(console->bus)); return true;
    case 7: tell_servos(printer, &console->robot->servos); return true;
    case 8: tell_delays(printer, &console->robot->servos); return true;
    default:
        if (console->failsafe->counts_stack) {
            console->step--; // this step once more
            return true;
        }
        tell_stack(printer, console->failsafe);
        return false;
    }
}
