/* SPDX-License-Identifier: MIT */
/* What a person is told without a command; see unasked.h. */
#include "console/unasked.h"

#include "cds55xx/packet.h"           // CDS_ERROR_CHECKSUM
#include "cds55xx/port.h"             // cds_port_now_us()
#include "console/commands/monitor.h" // monitor_clear_table()
#include "console/console.h"
#include "console/line_editor.h" // line_editor_redraw()
#include "console/messages.h"
#include "console/reply.h"
#include "robot/autostart.h" // AUTOSTART_RESET
#include "robot/moves.h"     // struct moves

#define TICK_US 250000ul

/* A fault is over after so many ticks without it. The state check reads a servo once or twice
 * meanwhile; noise comes and goes. */
#define SERVO_TICKS 6
#define LINE_TICKS  8

#define REMEDY_TICKS 8 // a person has read the remedy so lately

#define FAULTS_OF_LINE (FAULT_LINE_LOW | FAULT_NOISE)

static const CDS_FLASH char message_back[] = "servo %u answers again, torque %s; %s";
static const CDS_FLASH char message_line_ok[] = "bus ok again; %s";
static const CDS_FLASH char message_stop_late[] = "stop: torque read back as off at all servos; %s";
static const CDS_FLASH char message_may_drive[] = "it may be driven";
static const CDS_FLASH char message_has_no_torque[] =
    "'teach off %u' switches it on where the servo is";
static const CDS_FLASH char message_no_autostart[] =
    "the sequence of the autostart does not play: 'settings autostart' tells why";
static const CDS_FLASH char message_torque_on[] = "on";
static const CDS_FLASH char message_torque_off[] = "off";
static const CDS_FLASH char message_torque_not_read[] = "unknown";
static const CDS_FLASH char message_back_lost[] =
    "it lost its state: 'release %u', then 'teach off %u' holds it where it is, 'torque %u on' "
    "moves it to its goal";
static const CDS_FLASH char message_release_due[] = "driving is inhibited until 'release'";
static const CDS_FLASH char message_clear_due[] = "driving is inhibited until 'clear'";
static const CDS_FLASH char message_see_servos[] = "'servos' shows their state";
static const CDS_FLASH char clear_line[] = "\r\x1B[K";

static struct unasked *state(void)
{
    return command_set.unasked;
}

/* ---- remedies ---- */

void unasked_begin(void)
{
    state()->remedied = 0;
}

/* Notes that the remedy of error `number` is printed. False: it was printed just before. */
static bool is_new_remedy(uint8_t number)
{
    uint16_t bit = 1;

    for (uint8_t i = 0; i < REPLY_CONDITIONS && reply_remedy_error(i) != number; i++)
        bit = (uint16_t)(bit << 1);
    if (state()->remedied & bit)
        return false;
    state()->remedied |= bit;
    state()->remedied_ticks = 0;
    return true;
}

void unasked_note_error(uint8_t number)
{
    is_new_remedy(number);
}

const CDS_FLASH char *unasked_remedy(const struct console *console, uint8_t condition)
{
    return !console_is_for_person(console) || is_new_remedy(reply_remedy_error(condition))
               ? reply_remedy(condition)
               : message_nothing;
}

/* True if noise has made an instruction that the servo does not know: a motion sends none, and a
 * servo with a checksum error has received damaged packets. */
static bool is_damaged(const struct console *console)
{
    const struct failsafe *failsafe = console->failsafe;

    return robot_is_in_motion(console->robot) ||
           failsafe->reported[failsafe->next] & CDS_ERROR_CHECKSUM;
}

const CDS_FLASH char *unasked_alarm_remedy(const struct console *console, uint8_t condition,
                                           bool is_offline)
{
    if (is_offline && condition == REPLY_OFFLINE)
        state()->away[console->failsafe->next] = 1;
    if (1 << condition == CDS_ERROR_INSTRUCTION && is_damaged(console))
        condition = reply_condition(CDS_ERROR_CHECKSUM);
    return unasked_remedy(console, condition);
}

/* ---- faults that are over ---- */

void unasked_note_fault(void)
{
    state()->line_ticks = 1;
}

void unasked_note_stop(void)
{
    state()->stop_failed = state()->stop_is_late = false;
}

void unasked_silence(const struct console *console)
{
    struct failsafe *failsafe = console->failsafe;

    if (console_is_for_person(console) && state()->away[failsafe->next])
        failsafe->alarm &= (uint8_t)~FAILSAFE_OFFLINE; // or FAILSAFE_TORQUE_LOST: one bit
}

/* Counts the ticks without a fault that was told. */
static void count_tick(uint8_t *ticks, bool is_over)
{
    if (*ticks == 0)
        return;
    if (!is_over)
        *ticks = 1;
    else if (*ticks < UINT8_MAX)
        ++*ticks;
}

static void look_at_stop(const struct robot *robot)
{
    if (robot_is_stopping(robot))
        return;
    if (!robot->stop_begun) {
        unasked_note_stop();
    } else if (robot->stop.steps.result != CDS_OK) {
        state()->stop_failed = true;
    } else if (state()->stop_failed) {
        state()->stop_failed = false;
        state()->stop_is_late = true;
    }
}

void unasked_move_servo(uint8_t from, uint8_t to)
{
    state()->away[to] = state()->away[from];
    state()->away[from] = 0;
}

static bool is_online(const struct cds_servo_state *servo)
{
    return servo->presence == CDS_PRESENCE_ONLINE && servo->misses == 0;
}

static void tick(const struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;

    for (uint8_t i = 0; i < ROBOT_SERVOS; i++) {
        if (i < servos->count)
            count_tick(&state()->away[i], is_online(&servos->states[i]));
        else
            state()->away[i] = 0;
    }
    count_tick(&state()->line_ticks, !(console_faults(console) & FAULTS_OF_LINE));
    look_at_stop(console->robot);
    if (state()->remedied_ticks++ >= REMEDY_TICKS)
        state()->remedied = 0;
    state()->is_looking = true;
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

/* "servo 2 answers again, torque on; it may be driven" */
static void say_back(struct console *console, const struct cds_servo_state *servo)
{
    union printer_value *values = console->printer.values;
    const CDS_FLASH char *text = servo->torque ? message_may_drive : message_has_no_torque;

    values[0].number = values[3].number = values[4].number = values[5].number = servo->id;
    values[1].text = servo->torque ? message_torque_on : message_torque_off;
    if (servo->status_return_level == 0) // no READ
        values[1].text = message_torque_not_read;
    values[2].text = next_step(console, servo->inhibits ? message_back_lost : text);
    say_line(console, message_back);
}

/* Prints the return of a servo. False: none has returned. */
static bool report_back(struct console *console)
{
    for (uint8_t i = 0; i < ROBOT_SERVOS; i++) {
        if (state()->away[i] <= SERVO_TICKS)
            continue;
        state()->away[i] = 0;
        say_back(console, &console->robot->states[i]);
        return true;
    }
    return false;
}

/* Prints once that the autostart has not begun. False: it has, or there is none. */
static bool report_autostart(struct console *console)
{
    bool is_news = !state()->autostart_told;

    state()->autostart_told = console->robot->moves->autostart.state >= AUTOSTART_RESET;
    if (!is_news || !state()->autostart_told)
        return false;
    say_line(console, message_no_autostart);
    return true;
}

bool unasked_report(struct console *console)
{
    uint32_t now_us = cds_port_now_us();

    if (!console_is_for_person(console))
        return false;
    if (now_us - state()->tick_us >= TICK_US) {
        state()->tick_us = now_us;
        tick(console);
    }
    if (!state()->is_looking || !printer_ready(&console->printer))
        return false;
    if (state()->line_ticks > LINE_TICKS) {
        state()->line_ticks = 0;
        console->faults_told &= (uint8_t)~FAULTS_OF_LINE;
        say_over(console, message_line_ok);
    } else if (state()->stop_is_late) {
        state()->stop_is_late = false;
        say_over(console, message_stop_late);
    } else {
        state()->is_looking = report_back(console) || report_autostart(console);
    }
    return state()->is_looking;
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
