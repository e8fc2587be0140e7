/* SPDX-License-Identifier: MIT */
/* status, alarms, clear, settings, save, defaults: the controller itself. */
#include <stddef.h>

#include "cds55xx/port.h"          // cds_port_line_is_high()
#include "console/advice_alarms.h" // advice_alarm_remedy()
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h" // servos_line_is_low(), bus_print_change()
#include "compiler.h"                // ALWAYS_INLINE, NOINLINE
#include "console/reply.h"           // reply_condition()
#include "console/messages.h"
#include "console/noise.h"
#include "console/number_format.h" // number_print()
#include "console/unasked.h"

static const CDS_FLASH char message_origin[] = "settings at start: %s";
static const CDS_FLASH char message_saves[] = "saved settings: %s%s";
static const CDS_FLASH char message_saved_since[] = "the next start has those of the last 'save'";
static const CDS_FLASH char message_saving[] = "a 'save' is under way";
static const CDS_FLASH char message_save_failed[] =
    "the last 'save' failed; the next start has the older ones";
static const CDS_FLASH char message_origin_advised[] = "settings at start: %s%s";
static const CDS_FLASH char message_present_unsaved[] = "; the present ones are not saved";
static const CDS_FLASH char message_others[] = "others: ";
static const CDS_FLASH char message_of_unlisted[] =
    "a servo that was not in the list, or left it: ";
static const CDS_FLASH char message_alarm[] = "alarm of %s%s%s";
static const CDS_FLASH char message_reset[] = "reset by%s%s%s%s%s";
static const CDS_FLASH char message_link[] = "host link: %s";
static const CDS_FLASH char message_link_lost[] = "lost";
static const CDS_FLASH char message_link_off[] = "not watched";
static const CDS_FLASH char message_torque_pending[] = "last stop: under way";
static const CDS_FLASH char message_torque_never[] = "last stop: none";
static const CDS_FLASH char message_torque_forgotten[] =
    "last stop: sent; its servos are no longer in the list";
static const CDS_FLASH char message_torque_read[] =
    "last stop: %u of %u servos read back as off%s%s";
static const CDS_FLASH char message_some_on[] = ", some are on";
static const CDS_FLASH char message_inhibit_off[] = "driving: allowed";
static const CDS_FLASH char message_inhibit_some[] = "driving: allowed; inhibited: %u";
static const CDS_FLASH char message_inhibit_on[] = "driving: inhibited until '%s'";
static const CDS_FLASH char message_delays[] = "RETURN_DELAY refused: %u; lowest %u";
static const CDS_FLASH char message_delays_us[] = "RETURN_DELAY refused: %u; lowest %u (%uus)";
static const CDS_FLASH char message_lowest_delay[] =
    "lowest RETURN_DELAY allowed: %u (%uus); lower ones refused: %u times";
static const CDS_FLASH char message_stops[] = "Ctrl-X in damaged packets: %u";
static const CDS_FLASH char message_and_more[] = " and more";
static const CDS_FLASH char message_servos[] = "servos: %u%s, offline %u";
static const CDS_FLASH char message_servos_elsewhere[] =
    "servos: %u%s, offline %u, at another rate %u: state unknown";
static const CDS_FLASH char message_servos_not_asked[] = "servos: %u%s, offline %u, as last known";
static const CDS_FLASH char message_servos_with_alarms[] =
    "servos: %u%s, offline %u, with alarms since 'clear' %u";
static const CDS_FLASH char message_host_rate[] =
    "the host link has the new rate after 'ok'; without 'save' a reset undoes it";
static const CDS_FLASH char message_stack[] = "stack: %u of %u bytes unused";

/* ---- settings, save, defaults ---- */

static const CDS_FLASH char *const CDS_FLASH origins[] = {
    [SETTINGS_NONE] = FLASH_TEXT("defaults: nothing saved"),
    [SETTINGS_DAMAGED] = FLASH_TEXT("defaults: saved ones damaged"),
    [SETTINGS_OTHER_VERSION] = FLASH_TEXT("defaults: of another version"),
    [SETTINGS_OLDER] = FLASH_TEXT("older firmware; new ones: defaults"),
    [SETTINGS_NEWER] = FLASH_TEXT("saved by a newer firmware"),
    [SETTINGS_STORED] = FLASH_TEXT("as saved"),
    [SETTINGS_CORRECTED] = FLASH_TEXT("as saved; one out of range: default"),
};

/* The text of a save since the start, by enum settings_result; NULL: there was none. */
static const CDS_FLASH char *const CDS_FLASH saves[] = {
    [SETTINGS_UNSAVED] = NULL,
    [SETTINGS_SAVING] = message_saving,
    [SETTINGS_SAVED] = message_saved_since,
    [SETTINGS_FAILED] = message_save_failed,
};

/* Prints what the next start will have after a save since this start, or else what this start had;
 * for a person also that the settings in force will be lost. A program changes echo for its
 * session, so this text would nearly always be there. */
static void print_saves(struct console *console)
{
    const struct settings_store *store = console->failsafe->store;
    union printer_value *values = console->printer.values;
    bool is_unsaved = console_is_for_person(console) && store->result != SETTINGS_SAVING &&
                      !settings_are_kept(console->failsafe->settings);

    values[0].text = saves[store->result];
    values[1].text = is_unsaved ? message_present_unsaved : message_nothing;
    if (values[0].text) {
        printer_line(&console->printer, message_saves);
        return;
    }
    values[0].text = origins[store->origin];
    printer_line(&console->printer, message_origin_advised);
}

/* "settings at start: as saved" */
static void print_origin(struct console *console)
{
    if (command_set.advise) { // the flash has room
        print_saves(console);
        return;
    }
    console->printer.values[0].text = origins[console->failsafe->store->origin];
    printer_line(&console->printer, message_origin);
}

/* " (mode person)"; nothing without a meaning. */
static void print_meaning(struct printer *printer, const CDS_FLASH char *meaning)
{
    if (meaning == NULL)
        return;
    printer_char(printer, ' ');
    printer_char(printer, '(');
    printer_flash(printer, meaning);
    printer_char(printer, ')');
}

/* "link_loss_ms = 500 ms", "bus_baud = 1 register, 1000000bps", "host_baud = 255 register,
 * 115200bps, the board's own" */
static void setting_line(struct console *console, uint8_t index)
{
    const CDS_FLASH struct setting *row = &settings_table[index];
    uint16_t value = settings_get(console->failsafe->settings, index);
    struct printer *printer = &console->printer;

    printer_flash(printer, row->name);
    printer_equals(printer);
    printer_decimal(printer, value);
    if (*row->unit != '-') {
        printer_char(printer, ' ');
        printer_flash(printer, row->unit);
    }
    if (command_set.explain && *row->unit == 'r' && value <= CDS_BAUD_MAX) {
        printer_char(printer, ',');
        printer_char(printer, ' ');
        number_print(printer, CDS_UNIT_BPS, value);
    } else if (command_set.advise && *row->unit == 'r') {
        printer_flash(printer, message_own_rate);
    }
    if (command_set.has_room && console_is_for_person(console))
        print_meaning(printer, setting_meaning(index, value));
    printer_end_of_line(printer);
}

/* Returns the error of a command that changes the rate of the bus while a cycle or a motion needs
 * it, or 0. Only the profile `full`, which has command_set.explain, has flash for this check. */
ALWAYS_INLINE uint8_t error_of_rate(const struct console *console)
{
    return command_set.explain ? robot_busy(console->robot) : 0;
}

/* Returns ERROR_MOTION while a motion is under way, else 0. A motion may read the EEPROM, and needs
 * the settings of the bus. ALWAYS_INLINE: the comparison drops the rest, 50 bytes, in a firmware
 * without motions. */
ALWAYS_INLINE uint8_t error_in_motion(const struct console *console)
{
    return command_set.moves && robot_is_in_motion(console->robot) ? (uint8_t)ERROR_MOTION : 0;
}

static uint8_t settings_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t error;

    if (line->numbers == 0)
        return 0;
    error = line->setting == SETTINGS_AT_bus_baud ? error_of_rate(console) : 0;
    console->part = console->failsafe->settings->bus_baud;
    if (error)
        return error;
    error = command_set.setting_number ? command_set.setting_number(console)
                                       : console_number(console, 0, CDS_UNIT_NUMBER);
    if (error == 0 && !settings_set(console->failsafe->settings, line->setting, console->raw))
        error = ERROR_OUT_OF_RANGE;
    if (error == 0)
        failsafe_apply_settings(console->failsafe);
    return error;
}

static uint8_t defaults_begin(struct console *console)
{
    const uint8_t *baud_reg = &console->failsafe->settings->bus_baud;
    uint8_t error = error_in_motion(console);

    if (error == 0 && *baud_reg != CDS_BAUD_1M) // the default
        error = error_of_rate(console);
    if (error)
        return error;
    settings_default(console->failsafe->settings);
    failsafe_apply_settings(console->failsafe);
    return 0;
}

/* Prints what a person must know of a rate that was set. Returns false if there is nothing. */
static bool print_note_of_rate(struct console *console)
{
    uint8_t setting = console->line.setting, old = console->part;

    if (setting == SETTINGS_AT_host_baud)
        printer_line(&console->printer, message_host_rate);
    else if (setting == SETTINGS_AT_bus_baud && console->failsafe->settings->bus_baud != old)
        bus_print_change(console, old);
    else
        return false;
    return true;
}

/* Behind the settings: prints a part of the line of `settings autostart` for a person, as its poll
 * does; nothing while the EEPROM is being written. Returns false behind the line. */
static bool print_autostart(struct console *console)
{
    if (console->index || !console_is_for_person(console))
        return false;
    if (!command_set.motion_words->show_autostart(console)) {
        console->index = 1;
        console->error = 0;
    }
    return true;
}

/* Prints one setting, a note at most if it was set, or all settings and their origin. */
static bool settings_poll(struct console *console)
{
    if (command_set.explain && console_is_for_person(console) && console->line.words == 3 &&
        console->step == 0 && print_note_of_rate(console))
        return true;
    if (console->line.words == 3)
        return console->failsafe->unsettled; // `ok` means that the setting is in force
    if (console->line.words == 2) {
        setting_line(console, console->line.setting);
        return false;
    }
    if (console->step < SETTINGS_COUNT) {
        setting_line(console, console->step);
        return true;
    }
    if (command_set.motion_words && print_autostart(console))
        return true;
    print_origin(console);
    return false;
}

/* `ok` means that the settings are in force. */
static bool defaults_poll(struct console *console)
{
    return console->failsafe->unsettled;
}

static uint8_t save_begin(struct console *console)
{
    struct failsafe *failsafe = console->failsafe;
    uint8_t error = error_in_motion(console);

    if (error)
        return error;
    return settings_save(failsafe->store, failsafe->settings) ? 0 : ERROR_SAVING;
}

static bool save_poll(struct console *console)
{
    uint8_t result = console->failsafe->store->result;

    if (result == SETTINGS_FAILED)
        console->error = ERROR_NOT_SAVED;
    return result == SETTINGS_SAVING;
}

/* ---- alarms ---- */

static const CDS_FLASH char message_was_released[] = " (released)";
static const CDS_FLASH char message_unread[] = "its replies were lost, its state is unknown";
static const CDS_FLASH char message_unread_due[] = "; look for noise, 'release %u'";

/* Bits of `kind`; others are ignored. */
enum alarm_kind {
    ALARM_LATCHED = 0,
    ALARM_NEW = 1,                   // the line ends with the remedy
    ALARM_OFFLINE = FAILSAFE_OFFLINE // this bit of the alarm is not FAILSAFE_TORQUE_LOST
} __attribute__((packed));

/* For a person, " (now)", " (over)", or " (while the line was disturbed)" behind a latched alarm of
 * the servo console->index; "" if that is not known. */
static const CDS_FLASH char *text_of_alarm_state(const struct console *console, uint8_t condition)
{
    if (!command_set.unasked || !console_is_for_person(console) ||
        console->index >= console->robot->servos.count || condition >= REPLY_TORQUE_LOST)
        return message_nothing;
    return unasked_alarm_state(command_set.unasked, console->index, (uint8_t)(1u << condition));
}

/* What to do about an alarm, with "; " in front, or "". `kind`: enum alarm_kind bits. */
static const CDS_FLASH char *remedy_of(struct console *console, uint8_t condition, uint8_t kind)
{
    const CDS_FLASH char *text = message_nothing;

    if (!(kind & ALARM_NEW))
        return text_of_alarm_state(console, condition);
    if (command_set.unasked)
        text = unasked_alarm_remedy(command_set.unasked, console, condition);
    else if (command_set.advise)
        text = advice_alarm_remedy(console, condition);
    else
        text = reply_remedy(condition);
    return text;
}

/* True if the servo of the alarm is taken for lost only because it has answered PING and no READ,
 * as one of status return level 0, or any servo in noise: its torque was not read as off. */
static bool is_unread(const struct console *console, uint8_t kind)
{
    const struct cds_servo_state *servo =
        &console->robot->states[kind & ALARM_NEW ? console->failsafe->next : console->index];

    return servo->torque || servo->status_return_level == 0;
}

/* Prints the line of the lowest bit, "alarm of servo 3: overheating", and returns the other bits.
 * `kind`: enum alarm_kind bits. */
NOINLINE static uint8_t alarm_line(struct console *console, uint8_t id, uint8_t bits, uint8_t kind)
{
    struct printer *printer = &console->printer;
    uint8_t condition = reply_condition(bits);
    union printer_value *value = printer->values;

    if (id == CDS_BROADCAST_ID) {
        (value++)->text = command_set.has_room && console_is_for_person(console)
                              ? message_of_unlisted
                              : message_others;
    } else {
        (value++)->text = message_of_servo;
        (value++)->number = id;
    }
    if (condition == REPLY_TORQUE_LOST && kind & ALARM_OFFLINE)
        condition = REPLY_OFFLINE;
    if (command_set.unasked && condition == REPLY_OFFLINE && kind & ALARM_NEW)
        unasked_note_offline(command_set.unasked, console->failsafe->next);
    if (command_set.unasked && kind & ALARM_NEW)
        unasked_note_alarm(command_set.unasked, console->failsafe->next, condition);
    value->text = reply_conditions[condition];
    value[1].text = remedy_of(console, condition, kind);
    if (command_set.advise && condition == REPLY_TORQUE_LOST && is_unread(console, kind)) {
        value->text = message_unread;
        if (kind & ALARM_NEW)
            value[1].text = message_unread_due;
        value[2].number = id;
    }
    printer_set_id(printer, id);
    printer_line(printer, message_alarm);
    return (uint8_t)(bits & (bits - 1u));
}

static bool is_offline(const struct cds_servo_state *servo)
{
    return servo->presence == CDS_PRESENCE_OFFLINE;
}

/* The alarms of the robot's servo `index`, with FAILSAFE_OFFLINE or else FAILSAFE_TORQUE_LOST;
 * behind the last servo: alarms of unknown servos. */
static uint8_t alarms_of(const struct cds_servos *servos, uint8_t index)
{
    const struct cds_servo_state *servo = servos->states;
    uint8_t others = servos->alarms;

    if (index < servos->count) {
        servo += index;
        return is_offline(servo) || servo->inhibits & CDS_INHIBIT_STATE_LOST
                   ? servo->alarms | FAILSAFE_TORQUE_LOST
                   : servo->alarms;
    }
    for (uint8_t left = servos->count; left; left--, servo++)
        others = (uint8_t)(others & ~servo->alarms);
    return others;
}

/* For a person: prints what was told of servo `index` and is over, "alarm of servo 2: offline
 * (over)" or "torque went off by itself (released)". False: there is nothing left to print of this
 * servo. `phase`: the next condition. */
static bool print_ended(struct console *console)
{
    union printer_value *values = console->printer.values;
    uint8_t condition = REPLY_CONDITIONS;

    if (console_is_for_person(console) && console->index < console->robot->servos.count)
        condition =
            unasked_next_ended(command_set.unasked, console, console->index, console->phase);
    console->phase = (uint8_t)(condition + 1);
    if (condition == REPLY_CONDITIONS)
        return false;
    values[0].text = message_of_servo;
    values[1].number = console->robot->states[console->index].id;
    values[2].text = reply_conditions[condition];
    values[3].text =
        condition == REPLY_TORQUE_LOST && !console->robot->states[console->index].torque
            ? message_was_released
            : unasked_is_over;
    printer_line(&console->printer, message_alarm);
    return true;
}

/* Prints one line in each call. `part`: the alarms printed of servo `index`. */
static bool alarms_poll(struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;
    uint8_t *index = &console->index, left = 0, id = CDS_BROADCAST_ID, kind = ALARM_LATCHED;

    while (*index <= servos->count &&
           (left = (uint8_t)(alarms_of(servos, *index) & ~console->part)) == 0) {
        if (command_set.unasked && print_ended(console))
            return true;
        (*index)++;
        console->part = 0;
        if (command_set.unasked)
            console->phase = 0;
    }
    if (left == 0)
        return false;
    if (*index < servos->count) {
        const struct cds_servo_state *servo = &servos->states[*index];

        id = servo->id;
        kind = is_offline(servo) ? ALARM_OFFLINE : ALARM_LATCHED;
    }
    left ^= alarm_line(console, id, left, kind);
    console->part |= left;
    return true;
}

static uint8_t clear_begin(struct console *console)
{
    if (command_set.has_room)
        console->part = robot_is_inhibited(console->robot); // advice_note() tells that it ended
    if (!failsafe_clear(console->failsafe))
        return ERROR_STOPPING;
    if (command_set.unasked)
        unasked_clear(command_set.unasked);
    return 0;
}

static const CDS_FLASH char message_bytes_unasked[] =
    "noise on the line, a loose plug, or a servo that sends without end; 'diagnose ID' tells which";

/* The text of a fault of console_faults(). */
static const CDS_FLASH char *fault_text(struct console *console, uint8_t fault)
{
    if (command_set.noise && fault == FAULT_NOISE)
        return message_bytes_unasked;
    if (fault == FAULT_LINE_LOW)
        return diagnose_findings[CDS_FINDING_LINE_LOW];
    return command_set.link_lost ? command_set.link_lost(console) : error_text(ERROR_LINK_LOST);
}

#define LOW_FOR_LONG (4 * FAULT_LOW_LOOK)

/* Counts, in the upper bits of faults_told since the RAM of an ATmega128 is full, how often in a
 * row the line was low. True: 4 times, so it is held low: in noise the bus meets a low bit now and
 * then. `is_found`: the bus has found it low. */
static bool count_low(struct console *console, bool is_found)
{
    if (!is_found || cds_port_line_is_high(console->bus->port))
        console->faults_told &= FAULT_LOW_LOOK - 1;
    else if (console->faults_told < LOW_FOR_LONG)
        console->faults_told = (uint8_t)(console->faults_told + FAULT_LOW_LOOK);
    return console->faults_told >= LOW_FOR_LONG;
}

/* In mode person: prints a fault of the whole robot, once until a command finds it over. Returns
 * false if there is none to print. */
static bool report_fault(struct console *console)
{
    uint8_t untold = console_faults(console) & (uint8_t)~console->faults_told, fault;

    if (command_set.advise && !count_low(console, untold & FAULT_LINE_LOW))
        untold &= (uint8_t)~FAULT_LINE_LOW;
    fault = untold & FAULT_LINE_LOW ? FAULT_LINE_LOW : FAULT_LINK_LOST;
    if (command_set.noise && untold & FAULT_NOISE)
        fault = FAULT_NOISE;
    if (!untold || !console_is_for_person(console))
        return false;
    if (!printer_ready(&console->printer))
        return true;
    console_say(console, fault_text(console, fault));
    console->faults_told |= fault;
    if (command_set.unasked && fault != FAULT_LINK_LOST)
        unasked_note_fault(command_set.unasked);
    return true;
}

/* While a told fault of the line lasts, alarms that the fault causes are not printed. `alarms`
 * still lists them. */
static void silence_alarms_of_line(const struct console *console)
{
    struct failsafe *failsafe = console->failsafe;
    uint8_t told = console->faults_told, caused = CDS_ERROR_INSTRUCTION | CDS_ERROR_CHECKSUM;

    if (failsafe->reported[failsafe->next] & FAILSAFE_OFFLINE)
        caused |= FAILSAFE_OFFLINE; // else the bit is FAILSAFE_TORQUE_LOST
    if ((told & FAULT_NOISE && command_set.noise->is_there) ||
        (told & FAULT_LINE_LOW && servos_line_is_low(&console->robot->servos))) {
        if (command_set.unasked)
            unasked_note_silenced(command_set.unasked, failsafe->next,
                                  failsafe->alarm & caused & (uint8_t)~FAILSAFE_OFFLINE);
        failsafe->alarm &= (uint8_t)~caused;
    }
}

bool controller_report(struct console *console)
{
    struct failsafe *failsafe = console->failsafe;

    if (command_set.noise) {
        noise_poll(command_set.noise, console->bus);
        silence_alarms_of_line(console);
    }
    if (command_set.unasked) {
        unasked_check_alarms(command_set.unasked, console);
        unasked_silence(command_set.unasked, console);
    }
    if (!console->printer.text) { // else a report is being printed
        if (console->editor.length && !(command_set.unasked && unasked_may_redraw(console)))
            return false;
        if (command_set.moves && play_report(console))
            return true;
        if (command_set.explain && failsafe->host_types && report_fault(console))
            return true;
        if (command_set.unasked && failsafe->host_types &&
            unasked_report(command_set.unasked, console))
            return true;
        if (!failsafe->alarm)
            return false;
    }
    if (printer_ready(&console->printer) && failsafe->alarm) {
        console_move_prompt(console);
        failsafe->alarm = alarm_line(console, failsafe->alarm_id, failsafe->alarm,
                                     (uint8_t)(failsafe->reported[failsafe->next] | ALARM_NEW));
    }
    return true;
}

/* ---- status ---- */

const CDS_FLASH char reset_by_brown_out[] = "; reset by brown-out";
const CDS_FLASH char reset_by_watchdog[] = "; reset by watchdog";

/* In the order of enum failsafe_reset. */
static const CDS_FLASH char *const CDS_FLASH reset_causes[] = {
    FLASH_TEXT(" power"),         FLASH_TEXT(" external"), reset_by_brown_out + RESET_BY,
    reset_by_watchdog + RESET_BY, FLASH_TEXT(" JTAG"),
};

static void print_reset(struct printer *printer, uint8_t causes)
{
    for (uint8_t i = 0; i < 5; i++, causes >>= 1)
        printer->values[i].text = causes & 1 ? reset_causes[i] : message_nothing;
    printer_line(printer, message_reset);
}

static const CDS_FLASH char *link_text(const struct failsafe *failsafe)
{
    if (failsafe->link_lost)
        return message_link_lost;
    return message_link_off + (failsafe->settings->link_loss_ms ? sizeof "not " - 1 : 0);
}

static const CDS_FLASH char *stop_text(const struct robot *robot)
{
    if (robot_is_stopping(robot))
        return message_torque_pending;
    if (command_set.has_room && !robot->stop.servos && robot->stop_begun)
        return message_torque_forgotten;
    if (!robot->stop.servos)
        return message_torque_never;
    return message_torque_read;
}

bool joined_since_stop(const struct robot *robot, const struct cds_servo_state *servo)
{
    return command_set.advise && servo->torque_off == CDS_TORQUE_OFF_UNKNOWN &&
           robot->stop.steps.result != CDS_LINE_BUSY;
}

/* "last stop: 2 of 3 servos read back as off; IDs not checked: 251". Where the flash has room, a
 * servo that joined the robot after the stop does not count; elsewhere it was not read back. */
static void print_torque(struct printer *printer, const struct robot *robot)
{
    const struct cds_servo_state *servo = robot->states;
    uint8_t unlisted = robot_unlisted(robot), off = 0, count = robot->servos.count;

    for (uint8_t left = count; left; left--, servo++) {
        if (servo->torque_off == CDS_TORQUE_OFF_OFF)
            off++;
        if (joined_since_stop(robot, servo))
            count--;
    }
    printer->values[0].number = off;
    printer->values[1].number = count;
    printer->values[2].text =
        robot->stop.steps.result == CDS_REFUSED ? message_some_on : message_nothing;
    printer->values[3].text = unlisted ? message_unlisted : message_nothing;
    printer->values[4].number = unlisted;
    printer_line(printer, stop_text(robot));
}

/* The servos that have inhibits of their own. */
static uint8_t inhibited_servos(const struct cds_servos *servos)
{
    const struct cds_servo_state *servo = servos->states;
    uint8_t count = 0;

    for (uint8_t left = servos->count; left; left--, servo++)
        count = (uint8_t)(count + (servo->inhibits != 0));
    return count;
}

/* The control panel compares the line "driving: allowed": after it, `clear` ends no inhibit. */
static void print_inhibit(struct printer *printer, const struct failsafe *failsafe)
{
    const CDS_FLASH char *message = message_inhibit_on;

    if (robot_is_inhibited(failsafe->robot)) {
        printer->values[0].text = failsafe->link_lost ? message_clear : message_release;
    } else {
        printer->values[0].number = inhibited_servos(&failsafe->robot->servos);
        message = printer->values[0].number ? message_inhibit_some : message_inhibit_off;
    }
    printer_line(printer, message);
}

static void print_delays(struct console *console, const struct cds_servos *servos)
{
    struct printer *printer = &console->printer;

    if (command_set.has_room && console_is_for_person(console)) {
        printer->values[0].number = servos->shortest_delay;
        printer->values[1].number = (uint16_t)(2u * servos->shortest_delay);
        printer->values[2].number = servos->too_early;
        printer_line(printer, message_lowest_delay);
        return;
    }
    printer->values[0].number = servos->too_early;
    printer->values[1].number = servos->shortest_delay;
    printer->values[2].number = (uint16_t)(2u * servos->shortest_delay);
    printer_line(printer, command_set.advise ? message_delays_us : message_delays);
}

static void print_stops(struct printer *printer, const struct failsafe *failsafe)
{
    printer->values[0].number = *failsafe->damaged_stops;
    printer_line(printer, message_stops);
}

/* True if the line is not quiet; where the flash has room, as the line before tells. */
ALWAYS_INLINE bool is_suspect(const struct console *console)
{
    return (command_set.has_room ? console->part : (uint8_t)cds_bus_line(console->bus)) ==
           CDS_BUS_LINE_SUSPECT;
}

/* "servos: 18, offline 1, at another rate 2: state unknown". A servo that is known to be at another
 * rate counts as that only: the state check does not reach it. On a line that is not quiet no servo
 * can be asked. */
static void print_servos(struct console *console, const struct cds_servos *servos)
{
    const struct cds_servo_state *servo = servos->states;
    struct printer *printer = &console->printer;
    const CDS_FLASH char *message = message_servos;
    uint8_t offline = 0, elsewhere = 0, alarmed = 0;

    for (uint8_t left = servos->count; left; left--, servo++) {
        if (command_set.has_room && servo_is_at_other_rate(console, servo))
            elsewhere++;
        else if (is_offline(servo))
            offline++;
        if (command_set.has_room && servo->alarms & CDS_ERRORS_OF_CONDITION)
            alarmed++;
    }
    printer->values[0].number = servos->count;
    printer->values[1].text = servos->is_full ? message_and_more : message_nothing;
    if (servos_line_is_low(servos))
        offline = servos->count;
    printer->values[2].number = offline;
    if (command_set.advise && is_suspect(console)) {
        message = message_servos_not_asked;
    } else if (command_set.has_room && elsewhere && !servos_line_is_low(servos)) {
        printer->values[3].number = elsewhere;
        message = message_servos_elsewhere;
    } else if (command_set.has_room && alarmed && console_is_for_person(console)) {
        printer->values[3].number = alarmed;
        message = message_servos_with_alarms;
    }
    printer_line(printer, message);
}

static void print_stack(struct printer *printer, const struct failsafe *failsafe)
{
    printer->values[0].number = failsafe->spare_bytes;
    printer->values[1].number = failsafe->room_bytes;
    printer_line(printer, message_stack);
}

static bool status_poll(struct console *console)
{
    struct printer *printer = &console->printer;

    switch (console->step) {
    case 0:
        console->failsafe->counts_stack = true;
        print_reset(printer, console->failsafe->reset_cause);
        return true;
    case 1: print_origin(console); return true;
    case 2:
        printer->values[0].text = link_text(console->failsafe);
        printer_line(printer, message_link);
        return true;
    case 3: print_inhibit(printer, console->failsafe); return true;
    case 4: print_torque(printer, console->robot); return true;
    case 5: print_stops(printer, console->failsafe); return true;
    case 6:
        if (command_set.has_room)
            console->part = (uint8_t)bus_line_state(console);
        bus_print_line(console);
        return true;
    case 7: print_servos(console, &console->robot->servos); return true;
    case 8: print_delays(console, &console->robot->servos); return true;
    case 9:
        if (command_set.store)
            command_set.store->room(console);
        return true;
    case 10:
        if (command_set.store)
            command_set.store->wear(console);
        return true;
    default:
        if (console->failsafe->counts_stack) {
            console->step--; // repeats this step
            return true;
        }
        print_stack(printer, console->failsafe);
        return false;
    }
}

static const CDS_FLASH struct command controller_rows[] = {
    {
        .usage = FLASH_TEXT("status"),
        .what = FLASH_TEXT("controller state"),
        .details = COMMAND_DETAILS("Reset, link, driving, bus, servos, EEPROM"),
        .poll = status_poll,
    },
    {
        .usage = FLASH_TEXT("alarms"),
        .what = FLASH_TEXT("alarms since clear"),
        .details = COMMAND_DETAILS("Alarms in replies; offline servos. Mode person or "
                                   "alarm_report 1 prints each at once"),
        .poll = alarms_poll,
    },
    {
        .usage = message_clear,
        .what = FLASH_TEXT("end alarms, lost link"),
        .details =
            COMMAND_DETAILS("Servos inhibited by that or stop may be driven again; nothing moves"),
        .begin = clear_begin,
    },
    {
        .usage = FLASH_TEXT("settings [SETTING [VALUE]]"),
        .what = FLASH_TEXT("all settings, or one"),
        .details = COMMAND_DETAILS("See docs/settings.md. In force at once, kept only if saved"),
        .example = COMMAND_DETAILS("settings repeats 1"),
        .begin = settings_begin,
        .poll = settings_poll,
    },
    {
        .usage = FLASH_TEXT("save"),
        .what = FLASH_TEXT("settings to EEPROM"),
        .details = COMMAND_DETAILS("Outlives power-off; takes 0.2 s, the bus goes on"),
        .begin = save_begin,
        .poll = save_poll,
    },
    {
        .usage = FLASH_TEXT("defaults"),
        .what = FLASH_TEXT("default settings"),
        .details = COMMAND_DETAILS("Kept only by save. Not while a motion is under way"),
        .begin = defaults_begin,
        .poll = defaults_poll,
    },
};

const CDS_FLASH struct command_group controller_commands = {
    .heading = FLASH_TEXT("The controller:"),
    .rows = controller_rows,
    .count = sizeof controller_rows / sizeof controller_rows[0],
};
