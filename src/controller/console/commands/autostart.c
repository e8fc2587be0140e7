/* SPDX-License-Identifier: MIT */
/* settings autostart: the sequence that plays after power-up, without a host. */
#include <stddef.h>
#include <string.h>

#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/moves.h"

static const CDS_FLASH char message_no_autostart[] = "autostart: none";
static const CDS_FLASH char message_autostart[] = "autostart: ";
static const CDS_FLASH char message_loop[] = " loop";
static const CDS_FLASH char message_after[] = " after ";
static const CDS_FLASH char message_s[] = " s; ";
static const CDS_FLASH char message_not_begun[] = "not begun: ";

static const CDS_FLASH char message_begins[] = "begins";
static const CDS_FLASH char message_plays_not[] =
    "the sequence does not play: step %u names a deleted pose; 'sequence NAME set N POSE TIME' "
    "mends step N";

static const CDS_FLASH char *const CDS_FLASH state_texts[] = {
    [AUTOSTART_OFF] = FLASH_TEXT("from the next power-up on"),
    // These five are never shown: a byte from the host ends them.
    [AUTOSTART_WAITING] = message_begins,
    [AUTOSTART_CHECKING_SERVOS] = message_begins,
    [AUTOSTART_CHECKING_POSES] = message_begins,
    [AUTOSTART_SWITCHING_ON] = message_begins,
    [AUTOSTART_STARTING_MOTION] = message_begins,
    [AUTOSTART_BEGUN] = FLASH_TEXT("has begun"),
    // After "not begun: ", and after "servo 1: " if a servo is the reason:
    [AUTOSTART_RESET] = FLASH_TEXT("the last reset was not power-on"),
    [AUTOSTART_HOST] = FLASH_TEXT("a byte came from the host"),
    [AUTOSTART_ALARM] = FLASH_TEXT("an alarm, or driving is inhibited"),
    [AUTOSTART_MISSING] = FLASH_TEXT("sequence or poses are missing"),
    [AUTOSTART_POSE_GONE] = FLASH_TEXT("the pose of step %u is deleted"),
    [AUTOSTART_NOT_WELL] = NULL, // the error of the servo
    [AUTOSTART_LIMITS] = FLASH_TEXT("the pose of step %u is beyond its angle limits"),
    [AUTOSTART_REFUSED] = NULL, // the error of the motion
};

struct autostart_job {
    struct motion_store_record record;
    char name[MOTION_STORE_NAME + 1];
    bool is_saving;
};

#define DELAY_DEFAULT_S 3

#define WORDS_OFF 3 // of the line "settings autostart off"

enum set_phase { CHECK_STEPS, SAVE } __attribute__((packed));
enum show_phase { SHOW_SEQUENCE, SHOW_STATE, SHOW_STEPS } __attribute__((packed));

/* Checks step console->part, from 0, of the sequence at `place`, and counts it up. True: more steps
 * follow. False with ERROR_POSE_GONE: the pose of this step is deleted, and console->part is its
 * number from 1. */
static bool check_step(struct console *console, uint8_t place)
{
    struct motion_store_step step;

    if (!motion_store_read_step(console_store(), place, console->part, &step))
        return false;
    console->part++;
    if (motion_store_pose_of(console_store(), step.pose) == MOTION_STORE_NONE)
        console->error = ERROR_POSE_GONE;
    return console->error == 0;
}

/* ---- settings autostart [off] ---- */

static const CDS_FLASH char *text_of_state(const struct autostart *autostart)
{
    if (autostart->state == AUTOSTART_REFUSED)
        return error_text(autostart->outcome.result);
    if (autostart->state == AUTOSTART_NOT_WELL)
        return error_text(torque_on_error(autostart->outcome.result));
    return state_texts[autostart->state];
}

/* Prints the end of the line, from "servo 1: " on. */
static void print_state(struct console *console)
{
    const struct autostart *autostart = &console->robot->moves->autostart;
    struct printer *printer = &console->printer;
    const CDS_FLASH char *text = text_of_state(autostart);
    uint16_t step = (uint16_t)(autostart->outcome.step + 1);

    if (command_set.motion_words && command_set.motion_words->autostart(console))
        return;
    printer->values[2].number = step; // %u in the text of values[1]
    printer_set_id(printer, autostart->outcome.id);
    if (autostart->outcome.id == CDS_NO_ID) {
        printer->values[0].number = step;
        printer_line(printer, text);
        return;
    }
    printer->values[0].number = autostart->outcome.id;
    printer->values[1].text = text;
    printer_line(printer, message_servo);
}

static uint8_t show_or_off_begin(struct console *console)
{
    struct autostart_job *job = console_job(console);
    uint8_t error;

    if (console->robot->moves == NULL)
        return ERROR_OMITTED;
    if (console->line.words < WORDS_OFF)
        return stored_may_read();
    error = stored_may_write(console);
    job->record = (struct motion_store_record){.kind = MOTION_STORE_AUTOSTART};
    if (error || motion_store_delete(console_store(), &job->record) != MOTION_STORE_SAVING)
        return error; // there was none
    job->is_saving = true;
    return 0;
}

/* Behind the line: prints the first step whose pose is deleted. */
static bool show_step(struct console *console)
{
    if (stored_may_read() || check_step(console, stored_autostart()))
        return true;
    if (console->error) {
        console->printer.values[0].number = console->part;
        printer_line(&console->printer, message_plays_not);
    }
    console->error = 0;
    return false;
}

bool autostart_show_or_off_poll(struct console *console)
{
    struct autostart_job *job = console_job(console);
    struct printer *printer = &console->printer;
    uint8_t delay;

    if (console->line.words == WORDS_OFF)
        return job->is_saving && stored_save_poll(console);
    if (command_set.has_room && console->phase == SHOW_STEPS)
        return show_step(console);
    if (console->phase == SHOW_STATE) {
        print_state(console);
        if (!command_set.has_room)
            return false;
        console->phase = SHOW_STEPS;
        console->part = 0;
        return console->robot->moves->autostart.state !=
               AUTOSTART_POSE_GONE; // else the line tells it
    }
    console->error = stored_may_read();
    if (console->error)
        return false;
    delay = motion_store_read_autostart(console_store(), job->name);
    if (delay == 0) {
        printer_line(printer, message_no_autostart);
        return false;
    }
    printer_flash(printer, message_autostart);
    printer_string(printer, job->name);
    if (delay & AUTOSTART_LOOP)
        printer_flash(printer, message_loop);
    printer_flash(printer, message_after);
    printer_decimal(printer, delay & AUTOSTART_DELAY_MAX);
    printer_flash(printer, message_s);
    if (console->robot->moves->autostart.state >= AUTOSTART_RESET)
        printer_flash(printer, message_not_begun);
    console->phase = SHOW_STATE;
    return true;
}

/* ---- settings autostart NAME ---- */

/* Takes the delay of the line, whole seconds, to *delay. Returns an error or 0. */
static uint8_t take_delay(struct console *console, uint8_t *delay)
{
    uint32_t ms;
    uint8_t error = number_ms(&console->line.number[0], AUTOSTART_DELAY_MAX * (uint32_t)1000, &ms);

    if (error)
        return error;
    *delay = (uint8_t)(ms / 1000);
    return ms % 1000 || ms == 0 ? (uint8_t)ERROR_OUT_OF_RANGE : 0;
}

static uint8_t save(struct console *console)
{
    struct autostart_job *job = console_job(console);

    if (stored_save(console, &job->record))
        console->robot->moves->autostart.state = AUTOSTART_OFF; // until the next power-up
    return console->error;
}

/* `loop`: 0 or AUTOSTART_LOOP. */
static uint8_t set(struct console *console, uint8_t loop)
{
    struct autostart_job *job = console_job(console);
    uint8_t delay = DELAY_DEFAULT_S, place;
    uint8_t error = console->line.numbers ? take_delay(console, &delay) : 0;

    if (console->robot->moves == NULL)
        return ERROR_OMITTED;
    if (error == 0)
        error = stored_may_write(console);
    if (error)
        return error;
    place = stored_find(console, MOTION_STORE_SEQUENCE, 0);
    if (place == MOTION_STORE_NONE)
        return ERROR_NO_SEQUENCE;
    console->index = place;
    memcpy(job->name, parse_name(&console->line, 0), stored_length(console, 0));
    job->record = (struct motion_store_record){
        .kind = MOTION_STORE_AUTOSTART, .count = (uint8_t)(delay | loop), .sequence = job->name};
    return command_set.has_room ? 0 : save(console); // else set_poll() saves
}

/* Chips with room refuse a sequence that cannot play. */
static bool set_poll(struct console *console)
{
    if (!command_set.has_room || console->phase == SAVE)
        return stored_save_poll(console);
    if (stored_may_read() || check_step(console, console->index))
        return true;
    console->phase = SAVE;
    return console->error == 0 && save(console) == 0;
}

static uint8_t once_begin(struct console *console)
{
    return set(console, 0);
}

static uint8_t loop_begin(struct console *console)
{
    return set(console, AUTOSTART_LOOP);
}

static const CDS_FLASH struct command autostart_rows[] = {
    {
        .usage = FLASH_TEXT("settings autostart [off]"),
        .what = FLASH_TEXT("show the autostart and its state; off: delete it"),
        .details = COMMAND_DETAILS("Kept at once, without save"),
        .example = COMMAND_DETAILS("settings autostart"),
        .begin = show_or_off_begin,
        .poll = autostart_show_or_off_poll,
    },
    {
        .usage = FLASH_TEXT("settings autostart NAME [DELAY]"),
        .what = FLASH_TEXT("play a sequence after power-up"),
        .details = COMMAND_DETAILS(
            "DELAY: 1s to 127s, default 3s. Only after power-on, if no byte comes before it "
            "and every servo passes its check"),
        .example = COMMAND_DETAILS("settings autostart walk 5s"),
        .begin = once_begin,
        .poll = set_poll,
    },
    {
        .usage = FLASH_TEXT("settings autostart NAME loop [DELAY]"),
        .what = FLASH_TEXT("play a sequence again and again after power-up"),
        .details = COMMAND_DETAILS("Until motion off or stop"),
        .example = COMMAND_DETAILS("settings autostart walk loop"),
        .begin = loop_begin,
        .poll = set_poll,
    },
};

const CDS_FLASH struct command_group autostart_commands = {
    .heading = FLASH_TEXT("Without a PC:"),
    .rows = autostart_rows,
    .count = sizeof autostart_rows / sizeof autostart_rows[0],
};
