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
    writer_line_at(&console->writer, TEXT_ORIGIN_NONE, console->keeper->store->origin);
}

/* "link_loss_ms = 500 ms" */
static void setting_line(struct console *console, uint8_t index)
{
    const CDS_FLASH struct setting *row = &settings_table[index];
    struct writer *writer = &console->writer;

    writer_flash(writer, row->name);
    writer_equals(writer);
    writer_decimal(writer, settings_get(console->keeper->settings, index));
    if (*row->unit != '-') {
        writer_char(writer, ' ');
        writer_flash(writer, row->unit);
    }
    writer_end_of_line(writer);
}

uint8_t settings_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t error;

    if (line->numbers == 0)
        return 0;
    error = console_number(console, 0, CDS_UNIT_NUMBER);
    if (error == 0 && !settings_set(console->keeper->settings, line->to, console->raw))
        error = ERROR_SETTING_RANGE;
    if (error == 0)
        keeper_follow(console->keeper);
    return error;
}

uint8_t defaults_begin(struct console *console)
{
    settings_default(console->keeper->settings);
    keeper_follow(console->keeper);
    return 0;
}

/* One; none, if it was set; or all, and where they came from. */
bool settings_poll(struct console *console)
{
    if (console->line.kind == COMMAND_defaults || console->line.words == 3)
        return console->keeper->unsettled; // in force with the ok
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
    struct keeper *keeper = console->keeper;

    return settings_save(keeper->store, keeper->settings) ? 0 : ERROR_SAVING;
}

bool save_poll(struct console *console)
{
    uint8_t result = console->keeper->store->result;

    if (result == SETTINGS_FAILED)
        console->error = ERROR_NOT_SAVED;
    return result == SETTINGS_SAVING;
}

/* ---- alarms ---- */

/* Writes the line of the lowest bit, and returns the others. "alarm 3: overheating" */
NOINLINE static uint8_t alarm_line(struct writer *writer, uint8_t id, uint8_t bits)
{
    uint16_t *value = writer->values;

    if (id == CDS_BROADCAST_ID) {
        *value++ = TEXT_OF_OTHERS;
    } else {
        *value++ = TEXT_DECIMAL;
        *value++ = id;
    }
    bits = reply_condition(bits, value);
    writer_line(writer, TEXT_ALARM);
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
    left ^= alarm_line(&console->writer,
                       *index < servos->count ? servos->states[*index].id : CDS_BROADCAST_ID, left);
    console->part |= left;
    return true;
}

uint8_t clear_begin(struct console *console)
{
    return keeper_clear(console->keeper) ? 0 : ERROR_STOPPING;
}

bool alarm_tell(struct console *console)
{
    struct keeper *keeper = console->keeper;

    if (!console->writer.text && (!keeper->alarm || console->editor.length))
        return false;
    if (writer_ready(&console->writer) && keeper->alarm)
        keeper->alarm = alarm_line(&console->writer, keeper->alarm_id, keeper->alarm);
    return true;
}

/* ---- status ---- */

static void tell_reset(struct writer *writer, uint8_t causes)
{
    for (uint8_t i = 0; i < 5; i++, causes >>= 1)
        writer->values[i] = causes & 1 ? writer_text_at(TEXT_RESET_POWER, i) : TEXT_NOTHING;
    writer_line(writer, TEXT_RESET);
}

static uint16_t link_text(const struct keeper *keeper)
{
    if (keeper->link_lost)
        return TEXT_LINK_LOST;
    return keeper->settings->link_loss_ms ? TEXT_LINK_ON : TEXT_LINK_OFF;
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
static void tell_torque(struct writer *writer, const struct robot *robot)
{
    const struct cds_servo_state *servo = robot->states;
    uint8_t strangers = robot_strangers(robot), off = 0;

    for (uint8_t left = robot->servos.count; left; left--, servo++)
        if (servo->torque_off == CDS_TORQUE_OFF_OFF)
            off++;
    writer->values[0] = off;
    writer->values[1] = robot->servos.count;
    writer->values[2] = strangers ? TEXT_STRANGERS : TEXT_NOTHING;
    writer->values[3] = strangers;
    writer_line(writer, stop_text(robot));
}

static uint16_t inhibit_text(const struct keeper *keeper)
{
    if (!robot_is_inhibited(keeper->robot))
        return TEXT_INHIBIT_OFF;
    return keeper->link_lost ? TEXT_INHIBIT_LINK : TEXT_INHIBIT_ON;
}

static void tell_delays(struct writer *writer, const struct cds_servos *servos)
{
    writer->values[0] = servos->too_early;
    writer->values[1] = servos->shortest_delay;
    writer_line(writer, TEXT_DELAYS);
}

static void tell_stops(struct writer *writer, const struct keeper *keeper)
{
    writer->values[0] = *keeper->damaged_stops;
    writer_line(writer, TEXT_STOPS);
}

/* "servos: 18, held 0, away 1" */
static void tell_servos(struct writer *writer, const struct cds_servos *servos)
{
    const struct cds_servo_state *servo = servos->states;
    uint8_t held = 0, away = 0;

    for (uint8_t left = servos->count; left; left--, servo++) {
        if (cds_servos_inhibits(servos, servo))
            held++;
        if (servo->presence == CDS_PRESENCE_OFFLINE)
            away++;
    }
    writer->values[0] = servos->count;
    writer->values[1] = servos->is_full ? TEXT_AND_MORE : TEXT_NOTHING;
    writer->values[2] = held;
    writer->values[3] = away;
    writer_line(writer, TEXT_SERVOS);
}

static void tell_stack(struct writer *writer, const struct keeper *keeper)
{
    writer->values[0] = keeper->spare_bytes;
    writer->values[1] = keeper->room_bytes;
    writer_line(writer, TEXT_STACK);
}

bool status_poll(struct console *console)
{
    struct writer *writer = &console->writer;

    switch (console->step) {
    case 0:
        console->keeper->counts_stack = true;
        tell_reset(writer, console->keeper->reset_cause);
        return true;
    case 1: say_origin(console); return true;
    case 2: writer_line(writer, link_text(console->keeper)); return true;
    case 3: writer_line(writer, inhibit_text(console->keeper)); return true;
    case 4: tell_torque(writer, console->robot); return true;
    case 5: tell_stops(writer, console->keeper); return true;
    case 6: writer_line_at(writer, TEXT_BUS_OK, cds_bus_line(console->bus)); return true;
    case 7: tell_servos(writer, &console->robot->servos); return true;
    case 8: tell_delays(writer, &console->robot->servos); return true;
    default:
        if (console->keeper->counts_stack) {
            console->step--; // this step once more
            return true;
        }
        tell_stack(writer, console->keeper);
        return false;
    }
}
