/* SPDX-License-Identifier: MIT */
/* Notes before `ok`, and what a reset or another rate means; see advice_notes.h. */
#include "console/advice_notes.h"

#include <stddef.h> // NULL
#include <string.h> // memchr()

#include "console/commands/shared.h" // servo_is_at_other_rate()
#include "console/commands/stored.h" // stored_find()
#include "console/console.h"
#include "console/explain.h" // explain_is_settings()
#include "console/messages.h"
#include "robot/settings.h" // SETTINGS_AT_link_loss_ms

static const CDS_FLASH char message_none_found[] =
    "check power, plugs, wiring; then %s'new 1' with one servo, or 'diagnose'";
static const CDS_FLASH char message_scan_all[] = "'scan all', ";
static const CDS_FLASH char message_missing[] =
    "servos of the list that did not answer: %u; for servo %u: 'diagnose %u'";
static const CDS_FLASH char message_id_twice[] =
    "if two servos had ID %u, both have ID %u now: 'diagnose %u' looks for that";
static const CDS_FLASH char message_of_old_id[] =
    "stored poses still name servo %u: store them again; %s";
static const CDS_FLASH char message_all_told[] =
    "none answers to this: each servo that heard it has ID 1 now; connect one alone, 'id 1 NEW'";
static const CDS_FLASH char message_stop_unconfirmed[] =
    "servos that have not confirmed 'stop': %u, the first: %u; see 'servos'";
static const CDS_FLASH char message_driving_allowed[] = "driving is allowed again%s";
static const CDS_FLASH char message_some_inhibited[] =
    ", but not for servos that lost their state: 'servos' shows them";
static const CDS_FLASH char message_max_torque[] =
    "MAX_TORQUE acts from the servo's next power-up on: switch its power off and on";
static const CDS_FLASH char message_other_rate[] =
    "a servo at another rate does not join the robot: 'bus %b', then 'scan'";
static const CDS_FLASH char message_restarted[] =
    "servos may be moving, and none is watched: Ctrl-X stops those at %b, 'scan' finds them\r\n";
static const CDS_FLASH char message_still_inhibited[] =
    "driving is inhibited: 'release' allows it\r\n";
static const CDS_FLASH char message_rate_changed[] =
    "the bus changed to this rate, 'save' keeps it over power-off; servos of the list here: %u; %s";
static const CDS_FLASH char message_servos_left[] = "at the old rate: %u, until 'bus %b'%s";
static const CDS_FLASH char message_goes_on[] =
    "; one that moves goes on, and 'stop' does not reach it";
static const CDS_FLASH char message_scan_for_others[] = "'scan' looks for others";
static const CDS_FLASH char message_is_new[] =
    "a new sequence: there was none of this name; 'sequence list' lists all";
static const CDS_FLASH char message_typing_is_silence[] =
    "this setting is for a program; if you type nothing for %ums, %s; 'settings link_loss_ms 0' "
    "ends that";
static const CDS_FLASH char message_id_of_servo[] =
    "servo %u of the list has this ID: packets of the host for ID %u now reach the controller, not "
    "the servo";
/* What happens then, by link_loss_action. */
static const CDS_FLASH char *const CDS_FLASH loss_actions[] = {
    FLASH_TEXT("the link counts as lost"),
    FLASH_TEXT("driving is inhibited"),
    FLASH_TEXT("torque goes off, and driving is inhibited"),
};

/* `scan` has found no servo at all. */
static const CDS_FLASH char *note_none(struct console *console)
{
    console->printer.values[0].text = console->line.choice ? message_nothing : message_scan_all;
    return message_none_found;
}

/* Servos of the robot that did not answer the scan at the rate of the bus. */
static const CDS_FLASH char *note_missing(struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;
    const struct after_scan *job = after_scan_job(console);
    union printer_value *values = console->printer.values;

    values[0].number = 0;
    for (uint8_t i = 0; i < servos->count; i++) {
        const struct cds_servo_state *servo = &servos->states[i];

        if (memchr(job->ids, servo->id, job->count) || servo_is_at_other_rate(console, servo))
            continue;
        values[1].number = values[2].number = servo->id;
        values[0].number++;
    }
    return values[0].number ? message_missing : NULL;
}

/* What a scan means if it found no servo, not all of the robot, or a servo at another rate. */
static const CDS_FLASH char *note_scan(struct console *console)
{
    if (!console_is_for_person(console))
        return NULL;
    if (after_scan_job(console)->count == 0 && console->index == 0)
        return note_none(console);
    if (console->line.choice == 0)
        return note_missing(console);
    if (!command_set.has_room || after_scan_job(console)->other_rate == 0)
        return NULL;
    console->printer.values[0].number = (uint16_t)(after_scan_job(console)->other_rate - 1u);
    return message_other_rate;
}

/* A person has given the controller the ID of a servo of the list: bridge.c. */
static const CDS_FLASH char *note_device_id(struct console *console)
{
    uint8_t id = console->failsafe->settings->device_id;

    console->printer.values[0].number = console->printer.values[1].number = id;
    return console->line.setting == SETTINGS_AT_device_id && console->line.numbers &&
                   console_is_for_person(console) && cds_servos_find(&console->robot->servos, id)
               ? message_id_of_servo
               : NULL;
}

/* A person has set a link_loss_ms: what it does to one who types. */
static const CDS_FLASH char *note_link_loss(struct console *console)
{
    const struct settings *settings = console->failsafe->settings;
    union printer_value *values = console->printer.values;

    if (console->line.setting != SETTINGS_AT_link_loss_ms || !console->line.numbers ||
        !settings->link_loss_ms || !console_is_for_person(console))
        return NULL;
    values[0].number = settings->link_loss_ms;
    values[1].text = loss_actions[settings->link_loss_action];
    return message_typing_is_silence;
}

/* `sequence walk add ...` begins a sequence if there is none of that name: it may be misspelt. */
static const CDS_FLASH char *note_sequence(const struct console *console)
{
    const struct command_line *line = &console->line;
    uint8_t place = stored_find(console, MOTION_STORE_SEQUENCE, 0);

    return console_is_for_person(console) && line->names == 2 && line->choice == 2 &&
                   place != MOTION_STORE_NONE &&
                   motion_store_number(console_store(), MOTION_STORE_SEQUENCE, place) == 1
               ? message_is_new
               : NULL;
}

/* `release` has ended a stop (console->part): how many servos have not confirmed it, and the first
 * of them. */
static const CDS_FLASH char *note_release(struct console *console)
{
    const struct robot *robot = console->robot;
    const struct cds_servo_state *servo = robot->states;
    union printer_value *values = console->printer.values;
    uint8_t count = 0;

    for (uint8_t left = robot->servos.count; left; left--, servo++) {
        if (servo->torque_off == CDS_TORQUE_OFF_OFF || joined_since_stop(robot, servo))
            continue;
        if (count++ == 0)
            values[1].number = servo->id;
    }
    values[0].number = count;
    return console->part && count && console_is_for_person(console) ? message_stop_unconfirmed
                                                                    : NULL;
}

/* `clear` has ended an inhibit of all servos (console->part). */
static const CDS_FLASH char *note_clear(struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;
    uint8_t inhibits = 0;

    for (uint8_t i = 0; i < servos->count; i++)
        inhibits = (uint8_t)(inhibits | servos->states[i].inhibits);
    console->printer.values[0].text =
        inhibits & CDS_INHIBIT_STATE_LOST ? message_some_inhibited : message_nothing;
    return console->part && console_is_for_person(console) ? message_driving_allowed : NULL;
}

/* `id` has given a servo another ID. */
static const CDS_FLASH char *note_id(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;

    if (command_set.has_room && command_set.motion_words->uses_servo(line->id)) {
        (values++)->number = line->id;
        (values++)->text = message_id_twice;
    }
    values[0].number = line->id;
    values[1].number = values[2].number = line->new_id;
    return values == console->printer.values ? message_id_twice : message_of_old_id;
}

const CDS_FLASH char *advice_note(struct console *console)
{
    static const CDS_FLASH char id[] = "id", factory[] = "factory", set[] = "set", scan[] = "scan",
                                sequence[] = "sequence";
    const struct command_line *line = &console->line;

    if (command_set.has_room && explain_is_settings(line) && note_device_id(console))
        return message_id_of_servo;
    if (explain_is_settings(line))
        return note_link_loss(console);
    if (parse_is_command(line, scan))
        return note_scan(console);
    if (parse_is_command(line, message_release))
        return note_release(console);
    if (command_set.has_room && parse_is_command(line, message_clear))
        return note_clear(console);
    if (parse_is_command(line, factory))
        return line->id == CDS_BROADCAST_ID ? message_all_told : NULL;
    if (parse_is_command(line, set))
        return (line->address | 1) == (CDS_REG_MAX_TORQUE | 1) ? message_max_torque : NULL;
    if (parse_is_command(line, sequence))
        return note_sequence(console);
    if (!parse_is_command(line, id) || line->id == line->new_id || !console_is_for_person(console))
        return NULL;
    return note_id(console);
}

/* Count of the servos that are known to answer at this rate. */
static uint8_t count_at_rate(const struct console *console, uint8_t baud_reg)
{
    const struct cds_servos *servos = &console->robot->servos;
    uint8_t count = 0;

    for (uint8_t i = 0; i < servos->count; i++)
        count = (uint8_t)(count + (servos->states[i].baud_reg == baud_reg &&
                                   servo_answers(&servos->states[i])));
    return count;
}

/* True if a servo that is left at the rate of this register value may move. */
static bool may_move_at_rate(const struct console *console, uint8_t baud_reg)
{
    const struct cds_servos *servos = &console->robot->servos;

    for (uint8_t i = 0; i < servos->count; i++)
        if (servos->states[i].baud_reg == baud_reg && servos->states[i].torque)
            return true;
    return false;
}

const CDS_FLASH char *advice_bus_changed(struct console *console, uint8_t old)
{
    const struct failsafe *failsafe = console->failsafe;
    union printer_value *values = console->printer.values;

    values[0].number = count_at_rate(console, failsafe->unsettled ? failsafe->settings->bus_baud
                                                                  : console->bus->baud_reg);
    values[2].number = count_at_rate(console, old);
    values[1].text = values[2].number ? message_servos_left : message_scan_for_others;
    values[3].number = old;
    values[4].text = may_move_at_rate(console, old) ? message_goes_on : message_nothing;
    return message_rate_changed;
}

void advice_after_reset(struct console *console)
{
    union printer_value *values = console->printer.values;

    values[2].text = robot_is_inhibited(console->robot) ? message_still_inhibited : message_nothing;
    values[3].text =
        console->failsafe->reset_cause & FAILSAFE_RESET_POWER ? message_nothing : message_restarted;
    values[4].number = console->bus->baud_reg;
}
