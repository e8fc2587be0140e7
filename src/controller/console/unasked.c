/* SPDX-License-Identifier: MIT */
/* What a person is told without a command; see unasked.h. */
#include "console/unasked.h"

#include <string.h> // memset()

#include "cds55xx/packet.h"           // CDS_ERROR_CHECKSUM
#include "cds55xx/port.h"             // cds_port_now_us()
#include "console/commands/monitor.h" // monitor_clear_table()
#include "console/console.h"
#include "console/errors.h"
#include "console/line_editor.h" // line_editor_redraw()
#include "console/messages.h"
#include "console/noise.h" // struct noise
#include "console/reply.h"
#include "robot/autostart.h" // AUTOSTART_RESET
#include "robot/moves.h"     // struct moves

#define TICK_US 250000ul

/* A fault is over after so many ticks without it. The state check reads a servo once or twice
 * meanwhile; noise comes and goes. */
#define SERVO_TICKS 6
#define LINE_TICKS  8

/* In a window each servo answers the state check, which has a period of 1 s. */
#define WINDOW_US   1500000ul
#define HAS_REPLIED 0x80 // in `seen` and `lasts`, beside the conditions

/* A servo that goes offline with so many damaged replies since it answered well may share its ID.
 */
#define SHARED_DAMAGED 3

#define REMEDY_TICKS 8 // 2 s: until then the remedy is not repeated

#define FAULTS_OF_LINE (FAULT_LINE_LOW | FAULT_NOISE)

static const CDS_FLASH char message_back[] = "servo %u answers again, torque %s; %s";
static const CDS_FLASH char message_alarm_over[] = "servo %u: %s is over, torque %s; %s";
static const CDS_FLASH char message_alarm_over_lost[] = "servo %u: %s is over, torque off; %s";
static const CDS_FLASH char message_acknowledge[] = "'clear' acknowledges it";
static const CDS_FLASH char message_lasts[] = " (now)";
const CDS_FLASH char unasked_is_over[] = " (over)";
static const CDS_FLASH char message_was_disturbed[] = " (while the line was disturbed)";
static const CDS_FLASH char message_line_ok[] = "bus ok again; %s";
static const CDS_FLASH char message_stop_late[] =
    "stop: torque read back as off at all servos; %s%s";
static const CDS_FLASH char message_ids_left[] = "; other IDs are not checked";
static const CDS_FLASH char message_stop_sent[] =
    "stop: sent; no servo is known, so none was read back: 'scan' finds servos; %s";
static const CDS_FLASH char message_may_drive[] = "it may be driven";
/* What to do with a servo without torque, by enum servo_mode. */
static const CDS_FLASH char *const CDS_FLASH steps_of_torque[] = {
    [UNASKED_UNKNOWN] = FLASH_TEXT(
        "'teach off %i' switches it on where the servo is, unless it is in endless turn"),
    [UNASKED_POSITION] = FLASH_TEXT("'teach off %i' switches it on where the servo is"),
    [UNASKED_TURN] = FLASH_TEXT("it is in endless turn: 'torque %i on', 'turn %i SPEED'"),
};
static const CDS_FLASH char message_autostart_failed[] =
    "the sequence of the autostart does not play: 'settings autostart' tells why";
#define LOST_ITS_STATE "it lost its state: "
/* What to do with a servo that has lost its state, by enum servo_mode. */
static const CDS_FLASH char *const CDS_FLASH steps_of_loss[] = {
    [UNASKED_UNKNOWN] = FLASH_TEXT(
        LOST_ITS_STATE "'release %i', then 'teach off %i' holds it where it is, unless it is in "
                       "endless turn"),
    [UNASKED_POSITION] =
        FLASH_TEXT(LOST_ITS_STATE "'release %i', then 'teach off %i' holds it where it is, 'torque "
                                  "%i on' moves it to its goal"),
    [UNASKED_TURN] = FLASH_TEXT(LOST_ITS_STATE "'release %i'; it was in endless turn: 'torque %i "
                                               "on', with speed 0, then 'turn %i SPEED'"),
};
#define LOST_POWER                                                                                 \
    "; without an alarm, so it lost its power or was reset: check its plug and supply, then "      \
    "'release %i'"
static const CDS_FLASH char message_lost_power[] = LOST_POWER;
static const CDS_FLASH char message_lost_power_hold[] =
    LOST_POWER "; 'teach off %i' holds it where it is";
static const CDS_FLASH char message_id_shared[] =
    "; check power, wiring; replies came damaged: a loose plug, two servos may have its ID, or it "
    "has another rate: 'diagnose %i'";
#define UNLOAD "; 'torque %i off', unload it; when cool, 'clear', 'release %i'"
/* What to do with a servo that reports load or heat, by enum servo_mode. */
static const CDS_FLASH char *const CDS_FLASH steps_of_load[] = {
    [UNASKED_UNKNOWN] = FLASH_TEXT(UNLOAD),
    [UNASKED_POSITION] =
        FLASH_TEXT(UNLOAD "; then 'torque %i on' moves it to its old goal, 'teach off %i' keeps it "
                          "where it is"),
    [UNASKED_TURN] = FLASH_TEXT(UNLOAD "; then 'torque %i on', with speed 0, 'turn %i SPEED'"),
};
static const CDS_FLASH char message_supply[] =
    "; too low or too high: 'diagnose %i' tells which, and the volts; mend supply or limits, then "
    "'clear'";
/* While a cycle or a motion runs `diagnose` is refused. */
static const CDS_FLASH char message_supply_now[] =
    "; too low or too high: 'get %i PRESENT_VOLTAGE' tells the volts; mend supply or limits, then "
    "'clear'";
static const CDS_FLASH char message_slow[] =
    "; check power, wiring; most of its replies came late: 'diagnose %i'";
static const CDS_FLASH char message_may_share[] = "two servos may have its ID: 'diagnose %i'";
static const CDS_FLASH char message_level_due[] =
    "it answers no READ: 'set %i STATUS_RETURN_LEVEL 1' first";
static const CDS_FLASH char message_release_due[] = "driving is inhibited until 'release'";
static const CDS_FLASH char message_clear_due[] = "driving is inhibited until 'clear'";
static const CDS_FLASH char message_see_servos[] = "'servos' shows their state";
static const CDS_FLASH char clear_line[] = "\r\x1B[K";

/* ---- remedies ---- */

uint16_t unasked_bus_noise(const struct console *console)
{
    struct cds_stats stats;

    cds_bus_stats(console->bus, &stats);
    return stats.noise_bytes;
}

void unasked_begin(struct unasked *unasked, const struct console *console)
{
    unasked->remedied = 0;
    unasked->noise_bytes = unasked_bus_noise(console);
}

uint16_t unasked_noise_bytes(const struct unasked *unasked, const struct console *console)
{
    return (uint16_t)(unasked_bus_noise(console) - unasked->noise_bytes);
}

/* The bits in `remedied` of the conditions against which the remedy of error `number` helps. */
static uint16_t conditions_of(uint8_t number)
{
    uint16_t conditions = 0;

    for (uint8_t i = 0; i < REPLY_CONDITIONS; i++)
        if (reply_remedy_error(i) == number)
            conditions |= (uint16_t)(1u << i);
    return conditions;
}

void unasked_note_error(struct unasked *unasked, uint8_t number)
{
    uint16_t conditions = conditions_of(number);

    if (conditions == 0)
        return;
    unasked->remedied |= conditions;
    unasked->remedied_ticks = 0;
}

static const CDS_FLASH char *remedy_once(struct unasked *unasked, const struct console *console,
                                         uint8_t condition)
{
    if (console_is_for_person(console) && unasked->remedied & (uint16_t)(1u << condition))
        return message_nothing;
    unasked_note_error(unasked, reply_remedy_error(condition));
    return reply_remedy(condition);
}

/* True if the error at the end of the reply has the remedy for `condition`. An alarm of the voltage
 * alone gives error 85 the remedy of error 86 (advice.h). */
static bool is_in_error(const struct console *console, uint8_t condition)
{
    const struct cds_servo_state *servo = console_servo(console);
    uint8_t number = reply_remedy_error(condition);

    return console->error == number || (console->error == ERROR_ALARM && number == ERROR_VOLTAGE &&
                                        servo && servo->alarms == CDS_ERROR_VOLTAGE);
}

/* The servo whose reply has the warning: `id` and `factory` have given it another ID. */
static uint8_t servo_of_warning(const struct console *console)
{
    static const CDS_FLASH char id[] = "id", factory[] = "factory";
    const struct command_line *line = &console->line;

    if (console->error == 0 && parse_is_command(line, id))
        return line->new_id;
    if (console->error == 0 && parse_is_command(line, factory))
        return CONSOLE_FACTORY_ID;
    return line->id;
}

const CDS_FLASH char *unasked_warning_remedy(struct unasked *unasked, struct console *console,
                                             uint8_t condition)
{
    printer_set_id(&console->printer, servo_of_warning(console));
    return is_in_error(console, condition) ? message_nothing
                                           : remedy_once(unasked, console, condition);
}

/* True if noise has made an instruction that the servo does not know: a motion sends none, and a
 * servo with a checksum error has received damaged packets. */
static bool is_damaged(const struct console *console)
{
    const struct failsafe *failsafe = console->failsafe;

    return robot_is_in_motion(console->robot) ||
           failsafe->reported[failsafe->next] & CDS_ERROR_CHECKSUM;
}

/* True if a servo has switched its torque off, and not by an alarm, which its replies would tell.
 */
static bool has_lost_power(const struct console *console, uint8_t condition)
{
    const struct failsafe *failsafe = console->failsafe;

    return condition == REPLY_TORQUE_LOST &&
           !(failsafe->reported[failsafe->next] & CDS_ERRORS_OF_CONDITION);
}

/* The damaged replies of a servo since it last answered well. */
static uint8_t damaged_replies(const struct unasked *unasked, const struct console *console,
                               uint8_t index)
{
    return (uint8_t)(console->robot->states[index].counters.corrupt -
                     unasked->alarms[index].damaged);
}

/* True if only this servo replies with damaged bytes. If others do, too, it is the line. */
static bool is_damaged_alone(const struct unasked *unasked, const struct console *console)
{
    uint8_t index = console->failsafe->next;

    if (damaged_replies(unasked, console, index) < SHARED_DAMAGED || console_is_noisy(console))
        return false;
    for (uint8_t i = 0; i < console->robot->servos.count; i++)
        if (i != index && damaged_replies(unasked, console, i))
            return false;
    return true;
}

/* The remedy of an offline servo whose replies came damaged or late; NULL: they did not. */
static const CDS_FLASH char *remedy_of_offline(const struct unasked *unasked,
                                               const struct console *console)
{
    uint8_t index = console->failsafe->next;
    const struct cds_servo_counters *counters = &console->robot->states[index].counters;
    uint8_t stale = (uint8_t)(counters->stale_replies - unasked->alarms[index].stale);
    uint8_t timeouts = (uint8_t)(counters->timeouts - unasked->alarms[index].timeouts);

    if (is_damaged_alone(unasked, console))
        return message_id_shared;
    return 2u * stale > timeouts ? message_slow : NULL;
}

/* The remedy of an alarm whose cause is known; NULL: it is not known. */
static const CDS_FLASH char *remedy_of_cause(const struct unasked *unasked,
                                             const struct console *console, uint8_t condition)
{
    uint8_t index = console->failsafe->next, mode = unasked->alarms[index].mode;

    if (has_lost_power(console, condition))
        return mode == UNASKED_POSITION ? message_lost_power_hold : message_lost_power;
    if (1 << condition == CDS_ERROR_VOLTAGE)
        return robot_busy(console->robot) ? message_supply_now : message_supply;
    if (reply_remedy_error(condition) == ERROR_ALARM)
        return steps_of_load[mode];
    return condition == REPLY_OFFLINE ? remedy_of_offline(unasked, console) : NULL;
}

/* A servo is told as offline. If replies of two servos came damaged, neither shares its ID: it is
 * the line. */
static void note_shared_id(struct unasked *unasked, const struct console *console, bool may_share)
{
    uint8_t index = console->failsafe->next;

    if (damaged_replies(unasked, console, index) >= SHARED_DAMAGED)
        for (uint8_t i = 0; i < ROBOT_SERVOS; i++)
            unasked->alarms[i].may_share_id = false;
    unasked->alarms[index].may_share_id = may_share;
}

const CDS_FLASH char *unasked_alarm_remedy(struct unasked *unasked, struct console *console,
                                           uint8_t condition)
{
    const CDS_FLASH char *remedy, *known;

    if (1 << condition == CDS_ERROR_INSTRUCTION && is_damaged(console))
        condition = reply_condition(CDS_ERROR_CHECKSUM);
    remedy = remedy_once(unasked, console, condition);
    known = remedy_of_cause(unasked, console, condition);
    if (condition == REPLY_OFFLINE)
        note_shared_id(unasked, console, known == message_id_shared);
    return remedy == message_nothing || !known ? remedy : known;
}

/* ---- faults that are over ---- */

void unasked_note_offline(struct unasked *unasked, uint8_t index)
{
    unasked->away[index] = 1;
}

void unasked_note_fault(struct unasked *unasked)
{
    unasked->line_ticks = 1;
}

void unasked_note_stop(struct unasked *unasked)
{
    unasked->stop_failed = unasked->stop_is_late = false;
}

void unasked_silence(const struct unasked *unasked, const struct console *console)
{
    struct failsafe *failsafe = console->failsafe;
    uint8_t index = failsafe->next;

    bool is_loss = !(failsafe->reported[index] & FAILSAFE_OFFLINE);
    bool is_stopped = is_loss && console->robot->stop_begun; // torque is off by the stop

    if (!(failsafe->alarm & FAILSAFE_OFFLINE) || // or FAILSAFE_TORQUE_LOST: one bit
        !failsafe->host_types || !console_is_for_person(console) ||
        (unasked->away[index] == 0 && !is_stopped))
        return;
    failsafe->alarm &= (uint8_t)~FAILSAFE_OFFLINE;
    if (is_loss && !is_stopped)
        console->robot->states[index].held &= (uint8_t)~CDS_HELD_LOSS_TOLD;
}

/* Counts one tick without the fault; 1 again if the fault is back. */
static void count_tick(uint8_t *ticks, bool is_over)
{
    if (*ticks == 0)
        return;
    if (!is_over)
        *ticks = 1;
    else if (*ticks < UINT8_MAX)
        ++*ticks;
}

static void look_at_stop(struct unasked *unasked, const struct robot *robot,
                         struct failsafe *failsafe)
{
    if (robot_is_stopping(robot))
        return;
    if (!robot->stop_begun) {
        unasked_note_stop(unasked);
        failsafe->stop_is_repeated = false;
    } else if (robot->stop.steps.result != CDS_OK) {
        unasked->stop_failed = true;
    } else if (unasked->stop_failed || failsafe->stop_is_repeated) {
        unasked->stop_failed = failsafe->stop_is_repeated = false;
        unasked->stop_is_late = true;
    }
}

void unasked_move_servo(struct unasked *unasked, uint8_t from, uint8_t to)
{
    unasked->away[to] = unasked->away[from];
    unasked->away[from] = 0;
    unasked->alarms[to] = unasked->alarms[from];
    unasked->alarms[from] = (struct unasked_alarms){0};
}

void unasked_forget(struct unasked *unasked)
{
    memset(unasked->away, 0, sizeof unasked->away);
    memset(unasked->alarms, 0, sizeof unasked->alarms);
}

/* ---- alarms that are over ---- */

void unasked_note_alarm(struct unasked *unasked, uint8_t index, uint8_t condition)
{
    struct unasked_alarms *alarms = &unasked->alarms[index];
    uint8_t bit = (uint8_t)(1u << condition) & CDS_ERRORS_OF_CONDITION;

    alarms->told |= bit;
    alarms->seen |= bit;
    alarms->ended &= (uint8_t)~bit;
    if (condition < REPLY_TORQUE_LOST)
        alarms->silenced &= (uint8_t) ~(1u << condition);
    if (condition == REPLY_TORQUE_LOST)
        alarms->was_lost = true;
    if (condition == REPLY_OFFLINE)
        alarms->was_offline = true;
}

void unasked_note_silenced(struct unasked *unasked, uint8_t index, uint8_t bits)
{
    unasked->alarms[index].silenced |= bits;
}

void unasked_clear(struct unasked *unasked)
{
    for (uint8_t i = 0; i < ROBOT_SERVOS; i++) {
        unasked->alarms[i].silenced = 0;
        unasked->alarms[i].was_lost = unasked->alarms[i].was_offline = false;
    }
}

uint8_t unasked_next_ended(const struct unasked *unasked, const struct console *console,
                           uint8_t index, uint8_t condition)
{
    const struct unasked_alarms *alarms = &unasked->alarms[index];
    const struct cds_servo_state *servo = &console->robot->states[index];

    if (condition <= REPLY_TORQUE_LOST && alarms->was_lost &&
        !(servo->inhibits & CDS_INHIBIT_STATE_LOST))
        return REPLY_TORQUE_LOST;
    if (condition <= REPLY_OFFLINE && alarms->was_offline &&
        servo->presence != CDS_PRESENCE_OFFLINE)
        return REPLY_OFFLINE;
    return REPLY_CONDITIONS;
}

enum servo_mode unasked_mode(const struct unasked *unasked, uint8_t index)
{
    return (enum servo_mode)unasked->alarms[index].mode;
}

const CDS_FLASH char *unasked_alarm_state(const struct unasked *unasked, uint8_t index, uint8_t bit)
{
    const struct unasked_alarms *alarms = &unasked->alarms[index];

    if (alarms->silenced & bit)
        return message_was_disturbed;
    if (!(bit & CDS_ERRORS_OF_CONDITION) || !(alarms->lasts & HAS_REPLIED))
        return message_nothing;
    return (alarms->lasts | alarms->seen) & bit ? message_lasts : unasked_is_over;
}

/* The state check has just ended: stores what its reply tells. */
static void take_reply(struct unasked *unasked, const struct console *console)
{
    const struct robot *robot = console->robot;
    const struct cds_request *request = &robot->health.request;
    struct failsafe *failsafe = console->failsafe;
    uint8_t index = request->servo_index, error = request->error & CDS_ERRORS_OF_CONDITION;
    struct unasked_alarms *alarms = &unasked->alarms[index];

    if (request->result != CDS_OK || index >= robot->servos.count ||
        robot->states[index].id != request->packet.bytes[CDS_AT_ID])
        return;
    alarms->seen |= error | HAS_REPLIED;
    if (!failsafe->alarm) // else one that is not told yet
        failsafe->reported[index] &= (uint8_t) ~(error & (uint8_t)~alarms->told);
}

/* The window of one servo ends. `is_late`: nothing was looked at for a while. */
static void end_window(struct unasked_alarms *alarms, uint8_t latched, bool is_late)
{
    bool has_replied = alarms->seen & HAS_REPLIED && !is_late;

    alarms->lasts = has_replied ? alarms->seen : 0;
    alarms->told &= latched;
    alarms->ended &= latched;
    if (has_replied) {
        uint8_t ended = alarms->told & (uint8_t)~alarms->seen;

        alarms->told ^= ended;
        alarms->ended |= ended;
    }
    alarms->seen = 0;
}

/* Notes the mode of one servo in each call: in each mode of the console, as a person may read it
 * later. */
static void note_mode(struct unasked *unasked, const struct cds_servos *servos)
{
    uint8_t index = unasked->next_mode;

    unasked->next_mode = (uint8_t)(index + 1u) < servos->count ? (uint8_t)(index + 1u) : 0;
    if (index >= servos->count)
        return;
    if (cds_servo_is_endless(&servos->states[index]))
        unasked->alarms[index].mode = UNASKED_TURN;
    else if (servos->states[index].held & (CDS_HELD_CW_SET | CDS_HELD_CCW_SET))
        unasked->alarms[index].mode = UNASKED_POSITION;
}

void unasked_check_alarms(struct unasked *unasked, const struct console *console)
{
    const struct robot *robot = console->robot;
    uint32_t elapsed_us = cds_port_now_us() - unasked->window_us;
    bool is_checking = robot->health.request.result == CDS_PENDING;

    note_mode(unasked, &robot->servos);
    if (unasked->is_checking && !is_checking)
        take_reply(unasked, console);
    unasked->is_checking = is_checking;
    if (elapsed_us < WINDOW_US)
        return;
    unasked->window_us += elapsed_us;
    for (uint8_t i = 0; i < robot->servos.count; i++)
        end_window(&unasked->alarms[i], robot->states[i].alarms, elapsed_us >= 2 * WINDOW_US);
}

/* ---- ticks ---- */

static bool is_online(const struct cds_servo_state *servo)
{
    return servo->presence == CDS_PRESENCE_ONLINE && servo->misses == 0;
}

static void note_counters(struct unasked_alarms *alarms, const struct cds_servo_counters *counters)
{
    alarms->damaged = (uint8_t)counters->corrupt;
    alarms->stale = counters->stale_replies;
    alarms->timeouts = (uint8_t)counters->timeouts;
}

static void tick(struct unasked *unasked, const struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;

    for (uint8_t i = 0; i < ROBOT_SERVOS; i++) {
        if (i >= servos->count) { // also of servos that left the list
            unasked->away[i] = 0;
            unasked->alarms[i] = (struct unasked_alarms){0};
            continue;
        }
        if (is_online(&servos->states[i]))
            note_counters(&unasked->alarms[i], &servos->states[i].counters);
        count_tick(&unasked->away[i], is_online(&servos->states[i]));
    }
    count_tick(&unasked->line_ticks, !(console_faults(console) & FAULTS_OF_LINE));
    look_at_stop(unasked, console->robot, console->failsafe);
    if (unasked->remedied_ticks++ >= REMEDY_TICKS)
        unasked->remedied = 0;
    unasked->is_looking = true;
}

/* What ends the inhibit of all servos; otherwise `text`. */
static const CDS_FLASH char *next_step(const struct console *console, const CDS_FLASH char *text)
{
    if (!robot_is_inhibited(console->robot))
        return text;
    return console->failsafe->link_lost ? message_clear_due : message_release_due;
}

static void say_line(struct console *console, const CDS_FLASH char *message)
{
    console_move_prompt(console);
    printer_line(&console->printer, message);
}

/* Prints `message`, with what to do next in it. */
static void say_over(struct console *console, const CDS_FLASH char *message)
{
    console->printer.values[0].text = next_step(console, message_see_servos);
    say_line(console, message);
}

/* Prints that a stop that had failed has succeeded. */
static void say_stop(struct console *console)
{
    union printer_value *values = console->printer.values;
    const struct robot *robot = console->robot;

    values[1].text = robot->unlisted || robot->servos.is_full ? message_ids_left : message_nothing;
    say_over(console, robot->servos.count ? message_stop_late : message_stop_sent);
}

/* What to do with a servo that answers again. */
static const CDS_FLASH char *step_of_servo(const struct cds_servo_state *servo, uint8_t mode)
{
    if (servo->status_return_level == 0) // no READ
        return message_level_due;
    if (servo->inhibits)
        return steps_of_loss[mode];
    return servo->torque ? message_may_drive : steps_of_torque[mode];
}

static const CDS_FLASH char *text_of_torque(const struct cds_servo_state *servo)
{
    if (servo->status_return_level == 0) // no READ
        return message_torque_unknown;
    return servo->torque ? message_on : message_off;
}

/* The lost state of the servo is told if `step` names it, and not the inhibit of all servos: then
 * its alarm tells it. */
static void note_loss(struct cds_servo_state *servo, const CDS_FLASH char *step)
{
    if (servo->inhibits & CDS_INHIBIT_STATE_LOST && step != message_clear_due &&
        step != message_release_due)
        servo->held |= CDS_HELD_LOSS_TOLD;
}

/* "servo 2 answers again, torque on; it may be driven". Servos that share an ID answer as one while
 * their states agree, as after a stop: `may_share_id`. */
static void say_back(struct console *console, struct cds_servo_state *servo,
                     const struct unasked_alarms *alarms)
{
    union printer_value *values = console->printer.values;

    values[0].number = servo->id;
    values[1].text = text_of_torque(servo);
    values[2].text = alarms->may_share_id ? message_may_share
                                          : next_step(console, step_of_servo(servo, alarms->mode));
    printer_set_id(&console->printer, servo->id);
    say_line(console, message_back);
    note_loss(servo, values[2].text);
}

/* Prints the return of a servo. False: none has returned. */
static bool report_back(struct unasked *unasked, struct console *console)
{
    for (uint8_t i = 0; i < console->robot->servos.count; i++) {
        if (unasked->away[i] <= SERVO_TICKS)
            continue;
        unasked->away[i] = 0;
        say_back(console, &console->robot->states[i], &unasked->alarms[i]);
        return true;
    }
    return false;
}

/* "servo 2: overload is over, torque on; 'clear' acknowledges it" */
static void say_alarm_over(struct console *console, struct cds_servo_state *servo, uint8_t bit,
                           uint8_t mode)
{
    union printer_value *values = console->printer.values;

    values[0].number = servo->id;
    values[1].text = reply_conditions[reply_condition(bit)];
    if (servo->inhibits & CDS_INHIBIT_STATE_LOST) {
        values[2].text = next_step(console, steps_of_loss[mode] + sizeof LOST_ITS_STATE - 1);
        printer_set_id(&console->printer, servo->id);
        say_line(console, message_alarm_over_lost);
        note_loss(servo, values[2].text);
    } else {
        values[2].text = text_of_torque(servo);
        values[3].text = next_step(console, message_acknowledge);
        say_line(console, message_alarm_over);
    }
}

/* Prints the end of one alarm. False: none has ended. */
static bool report_alarm_over(struct unasked *unasked, struct console *console)
{
    for (uint8_t i = 0; i < console->robot->servos.count; i++) {
        struct unasked_alarms *alarms = &unasked->alarms[i];
        uint8_t bit = alarms->ended & (uint8_t)-alarms->ended;

        if (bit == 0)
            continue;
        alarms->ended ^= bit;
        say_alarm_over(console, &console->robot->states[i], bit, alarms->mode);
        return true;
    }
    return false;
}

/* Prints once that the autostart has not begun. False: it has, or there is none. */
static bool report_autostart(struct unasked *unasked, struct console *console)
{
    bool is_news = !unasked->autostart_told;

    unasked->autostart_told = console->robot->moves->autostart.state >= AUTOSTART_RESET;
    if (!is_news || !unasked->autostart_told)
        return false;
    say_line(console, message_autostart_failed);
    return true;
}

bool unasked_report(struct unasked *unasked, struct console *console)
{
    uint32_t now_us = cds_port_now_us();

    if (!console_is_for_person(console))
        return false;
    if (now_us - unasked->tick_us >= TICK_US) {
        unasked->tick_us = now_us;
        tick(unasked, console);
    }
    if (!unasked->is_looking || !printer_ready(&console->printer))
        return false;
    if (unasked->line_ticks > LINE_TICKS) {
        unasked->line_ticks = 0;
        console->faults_told &= (uint8_t)~FAULTS_OF_LINE;
        say_over(console, message_line_ok);
    } else if (unasked->stop_is_late) {
        unasked->stop_is_late = false;
        say_stop(console);
    } else {
        unasked->is_looking = report_back(unasked, console) ||
                              report_alarm_over(unasked, console) ||
                              report_autostart(unasked, console);
    }
    return unasked->is_looking;
}

/* ---- room for a line ---- */

bool unasked_may_redraw(const struct console *console)
{
    return console_is_for_person(console) && !console->editor.longer && !console->editor.locked &&
           !console->line_complete;
}

void unasked_make_room(struct console *console)
{
    if (console->state == CONSOLE_RUNNING) {
        monitor_clear_table(console);
    } else if (console->editor.length) {
        printer_flash(&console->printer, clear_line);
        line_editor_redraw(&console->editor);
    }
}
