/* SPDX-License-Identifier: MIT */
/* move, turn, torque, led. */
#include <string.h> // memcpy()

#include "cds55xx/servo.h" // cds_servo_write()
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "compiler.h" // NOINLINE
#include "console/messages.h"

static const CDS_FLASH char message_limits_are_off[] = "limits are 0: endless turn";
static const CDS_FLASH char message_way_back[] =
    "limits are 0: endless turn; to have the old ones again: 'torque %u off', then 'set %u "
    "CCW_ANGLE_LIMIT %a', 'set %u CW_ANGLE_LIMIT %a'";
static const CDS_FLASH char message_stands_still[] = "endless turn: speed set to 0";
static const CDS_FLASH char message_turn_again[] =
    "torque is off: 'torque " SERVO_ID " on', then 'turn' again";
static const CDS_FLASH char message_kept_speed[] =
    "it moves at %r, the last speed it was given, as by a motion; 'move %u %a 30rpm' gives another";

static const CDS_FLASH char message_way[] = "moves to its goal: %a, from %a";

/* Registers that move, and torque on, read first. */
#define LOOK_FROM CDS_REG_CW_ANGLE_LIMIT
#define LOOK_SIZE (CDS_REG_TORQUE_ENABLE - CDS_REG_CW_ANGLE_LIMIT + 1)

/* The READ goes on to MOVING_SPEED for torque on, since the permit must know goal and speed of a
 * servo with limits, and for a move without SPEED of a person. */
#define LOOK_SPEED_AT   (CDS_REG_MOVING_SPEED - LOOK_FROM)
#define LOOK_SPEED_SIZE (LOOK_SPEED_AT + 2)

/* The READ of `torque on`, for a person, goes on to GOAL_POSITION and PRESENT_POSITION. */
#define LOOK_GOAL_AT       (CDS_REG_GOAL_POSITION - LOOK_FROM)
#define LOOK_POSITION_AT   (CDS_REG_PRESENT_POSITION - LOOK_FROM)
#define LOOK_POSITION_SIZE (LOOK_POSITION_AT + 2)

/* The smallest way to the goal that `torque on` tells, in steps: 5 degrees. */
#define WAY_TOLD_MIN 17

/* A move without SPEED that is slower is told: 10 rpm. A motion leaves the speed of its end. */
#define SLOW_SPEED 165

/* Of torque and led; a move has none. */
#define CHOICE_ON 1

/* What is sent: the READ of look(), or the WRITE of a slow speed, of limits 0, of speed 0. */
enum phase { LOOK, SLOW = SERVO_WRITE_SENT + 1, LIMITS, STILL } __attribute__((packed));

/* Puts number `index` of the line into the data to be written. Returns an error or 0. */
static uint8_t take_raw(struct console *console, uint8_t index, enum cds_unit unit)
{
    uint8_t *data = &set_job(console)->data[2 * index];
    uint8_t error = console_number(console, index, unit);

    data[0] = (uint8_t)console->raw;
    data[1] = (uint8_t)(console->raw >> 8);
    return error;
}

NOINLINE uint8_t servo_read(struct console *console, uint8_t address, uint8_t length)
{
    const struct command_line *line = &console->line;

    return (uint8_t)cds_servo_read(console->bus, line->request, line->id, address, length);
}

uint8_t servo_write(struct console *console, uint8_t address, uint8_t length)
{
    const struct command_line *line = &console->line;

    console->phase = SERVO_WRITE_SENT;
    return (uint8_t)cds_servo_write(console->bus, line->request, line->id, address,
                                    set_job(console)->data, length);
}

uint8_t servo_cycled(const struct console *console)
{
    return robot_cycle_drives(console->robot, console->line.id) ? robot_busy(console->robot) : 0;
}

uint8_t servo_outcome(struct console *console)
{
    uint8_t error = console->error;

    if (error == 0)
        error = error_of_servo(&console->servo_error);
    console->error = 0;
    console->servo_error = 0;
    return console_remedied(console, error);
}

void servo_failed(struct console *console, uint8_t error)
{
    console->printer.values[0].number = console->line.id;
    console->printer.values[1].text = error_text(error);
    printer_set_id(&console->printer, console->line.id);
    printer_line(&console->printer, message_servo);
}

/* Submits the READ of mode and torque, and what follows up to `size`. CDS_NO_REPLY_DUE: they cannot
 * be known. */
static uint8_t look(struct console *console, uint8_t size)
{
    if (console->line.id == CDS_BROADCAST_ID)
        return CDS_NO_REPLY_DUE;
    return servo_read(console, LOOK_FROM, size);
}

/* True for a move without SPEED in mode person: a slow speed is told. */
static bool tells_speed(const struct console *console)
{
    return console->line.numbers == 1 && console_is_for_person(console);
}

static uint8_t move_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t result = take_raw(console, 0, CDS_UNIT_MDEG);

    if (result == 0 && line->numbers == 2)
        result = take_raw(console, 1, CDS_UNIT_MRPM);
    if (result == 0)
        result = servo_cycled(console);
    if (result)
        return result;
    result =
        look(console, command_set.has_room && tells_speed(console) ? LOOK_SPEED_SIZE : LOOK_SIZE);
    if (result == CDS_NO_REPLY_DUE) {
        console->part = 1; // its torque is not known
        result = servo_write(console, CDS_REG_GOAL_POSITION, (uint8_t)(2 * line->numbers));
    }
    return result;
}

/* Both angle limits 0 select the endless turn (manual 3.2). Before that the speed is set to 1, 0.1
 * rpm: if a later packet is lost, the servo does not turn at the speed of its last movement. */
static uint8_t turn_begin(struct console *console)
{
    uint8_t *data = set_job(console)->data;
    uint8_t error = take_raw(console, 0, CDS_UNIT_SIGNED_MRPM);

    if (error == 0)
        error = servo_cycled(console);
    if (error)
        return error;
    data[0] = 1;
    data[1] = 0;
    error = servo_write(console, CDS_REG_MOVING_SPEED, 2);
    console->phase = SLOW;
    return error;
}

static void print_limits_are_off(struct console *console)
{
    union printer_value *values = console->printer.values;
    const uint8_t *limits = set_job(console)->limits;
    bool has_old = command_set.has_room && (limits[0] | limits[1] | limits[2] | limits[3]);

    if (has_old) {
        values[0].number = values[1].number = values[3].number = console->line.id;
        values[2].number = register_raw_at(limits + 2, 2);
        values[4].number = register_raw_at(limits, 2);
    }
    printer_line(&console->printer, has_old ? message_way_back : message_limits_are_off);
}

/* Keeps the limits that the setup reads before it writes, for the user to have them again. If the
 * servo is in endless turn already, there are none. */
ALWAYS_INLINE void keep_limits(struct console *console)
{
    struct set_job *job = set_job(console);
    const uint8_t *read = console->line.request->reply;

    if (command_set.has_room && console->phase == LIMITS && !job->setup.is_written &&
        (read[0] | read[1] | read[2] | read[3]))
        memcpy(job->limits, read, sizeof job->limits);
}

/* The next step, after one that went well. Returns an error or 0. */
static uint8_t continue_turn(struct console *console)
{
    uint8_t *data = set_job(console)->data;

    if (console->phase == SLOW) {
        console->phase = LIMITS;
        data[0] = 0; // a job begins zeroed: now all four bytes are 0
        return setup_write(console, CDS_REG_CW_ANGLE_LIMIT, data, 4);
    }
    if (set_job(console)->setup.is_written)
        print_limits_are_off(console);
    take_raw(console, 0, CDS_UNIT_SIGNED_MRPM);
    return servo_write(console, CDS_REG_MOVING_SPEED, 2);
}

/* Tells that the servo does not turn yet, as far as is known. The profile `console` has no flash
 * for it. */
static void tell_torque(struct console *console)
{
    const struct cds_servo_state *servo = console_servo(console);

    if (servo && servo->presence == CDS_PRESENCE_ONLINE && !servo->torque) {
        printer_set_id(&console->printer, servo->id);
        printer_line(&console->printer, message_turn_again);
    }
}

static bool turn_poll(struct console *console)
{
    keep_limits(console);
    if (console->phase == LIMITS ? setup_waits(console) : console_waits(console))
        return true;
    if (command_set.explain && console->phase == SERVO_WRITE_SENT && console_answered(console))
        tell_torque(console);
    if (console->phase == SERVO_WRITE_SENT || console->error)
        return false;
    console->error = continue_turn(console);
    return console->error == 0;
}

NOINLINE static uint8_t write_switch(struct console *console, uint8_t address)
{
    set_job(console)->data[0] = console->line.choice == CHOICE_ON;
    return servo_write(console, address, 1);
}

static uint8_t torque_begin(struct console *console)
{
    /* Torque on is refused if the servo does not reply: it may be in endless turn. */
    if (console->line.choice == CHOICE_ON && console->line.id != CDS_BROADCAST_ID)
        return look(console, command_set.has_room && console_is_for_person(console)
                                 ? LOOK_POSITION_SIZE
                                 : LOOK_SPEED_SIZE);
    return write_switch(console, CDS_REG_TORQUE_ENABLE);
}

static uint8_t led_begin(struct console *console)
{
    return write_switch(console, CDS_REG_LED);
}

/* A move of all servos: prints the next servo that is known to be in endless turn. False: there is
 * none. The profile `console` has no flash for it. */
static bool tell_endless(struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;

    while (console->line.request->packet.bytes[CDS_AT_ID] == CDS_BROADCAST_ID &&
           console->index < servos->count) {
        const struct cds_servo_state *servo = &servos->states[console->index++];

        if (cds_servo_is_endless(servo)) {
            console->line.id = servo->id;
            servo_failed(console, ERROR_ENDLESS);
            return true;
        }
    }
    return false;
}

/* True if look() has read a servo in endless turn. */
static bool looks_endless(const uint8_t *bytes)
{
    return (bytes[0] | bytes[1] | bytes[2] | bytes[3]) == 0;
}

/* Tells the speed that the servo keeps, if it is a slow one. */
static void tell_slow(struct console *console)
{
    union printer_value *values = console->printer.values;
    const struct set_job *job = set_job(console);

    if (job->kept_speed == 0 || job->kept_speed >= SLOW_SPEED)
        return;
    values[0].number = job->kept_speed;
    values[1].number = console->line.id;
    values[2].number = register_raw_at(job->data, 2);
    printer_line(&console->printer, message_kept_speed);
}

/* A servo in endless turn, or with torque off, accepts a goal without moving. */
static bool move_poll(struct console *console)
{
    const uint8_t *bytes = console->line.request->reply;

    if (console_waits(console))
        return true;
    if (!console_answered(console))
        return false;
    if (console->phase == SERVO_WRITE_SENT) {
        if (!console->part)
            printer_line(&console->printer, message_torque_is_off);
        else if (command_set.has_room && tells_speed(console))
            tell_slow(console);
        if (command_set.explain && tell_endless(console))
            return true;
        if (command_set.has_room &&
            console->line.request->packet.bytes[CDS_AT_ID] == CDS_BROADCAST_ID)
            servos_tell_torque(console, NULL, 0);
        return false;
    }
    console->part = bytes[LOOK_SIZE - 1]; // torque
    if (command_set.has_room)
        memcpy(set_job(console)->limits, bytes, sizeof set_job(console)->limits);
    if (command_set.has_room && tells_speed(console))
        set_job(console)->kept_speed = register_raw_at(&bytes[LOOK_SPEED_AT], 2);
    console->error = looks_endless(bytes) ? ERROR_ENDLESS
                                          : servo_write(console, CDS_REG_GOAL_POSITION,
                                                        (uint8_t)(2 * console->line.numbers));
    return console->error == 0;
}

/* Keeps goal and position of a servo without torque, for tell_way(). */
static void keep_way(struct console *console)
{
    struct set_job *job = set_job(console);
    const uint8_t *bytes = console->line.request->reply;

    job->goal = register_raw_at(&bytes[LOOK_GOAL_AT], 2);
    job->from = register_raw_at(&bytes[LOOK_POSITION_AT], 2);
}

/* Tells that the servo goes to its goal now; nothing if keep_way() has kept no goal. */
static void tell_way(struct console *console)
{
    const struct set_job *job = set_job(console);

    if ((job->goal > job->from ? job->goal - job->from : job->from - job->goal) < WAY_TOLD_MIN)
        return;
    console->printer.values[0].number = job->goal;
    console->printer.values[1].number = job->from;
    printer_line(&console->printer, message_way);
}

/* Torque must not start an endless turn: a servo without torque gets speed 0 before it. */
static bool torque_poll(struct console *console)
{
    const uint8_t *bytes = console->line.request->reply;
    bool is_off;

    if (console_waits(console))
        return true;
    if (!console_answered(console) || console->phase == SERVO_WRITE_SENT) {
        if (command_set.has_room && console_answered(console))
            tell_way(console);
        return false;
    }
    is_off = console->phase == LOOK && !bytes[LOOK_SIZE - 1];
    if (command_set.explain && is_off && console->servo_error & CDS_ERRORS_OF_CONDITION) {
        console->error = ERROR_ALARM; // it may have shut down: torque would not come on
    } else if (is_off && looks_endless(bytes)) {
        console->error = servo_write(console, CDS_REG_MOVING_SPEED, 2); // the job is zeroed
        console->phase = STILL;
    } else {
        if (console->phase == STILL)
            printer_line(&console->printer, message_stands_still);
        else if (command_set.has_room && is_off && console_is_for_person(console))
            keep_way(console);
        console->error = write_switch(console, CDS_REG_TORQUE_ENABLE);
    }
    return console->error == 0;
}

static const CDS_FLASH struct command servo_rows[] = {
    {
        .usage = FLASH_TEXT("move ID|254 ANGLE [SPEED]"),
        .what = FLASH_TEXT("go to an angle"),
        .details =
            COMMAND_DETAILS("ANGLE: 0 to 300deg. SPEED: 0 to 62rpm, 0 the "
                            "fastest; without it the speed stays; needed if 'limits' has one. "
                            "ID 254: all"),
        .example = COMMAND_DETAILS("move 1 90deg 30rpm"),
        .begin = move_begin,
        .poll = move_poll,
    },
    {
        .usage = FLASH_TEXT("turn ID SPEED"),
        .what = FLASH_TEXT("turn without end"),
        .details = COMMAND_DETAILS(
            "SPEED: -62 to 62rpm, positive CCW, 0 stands still. Sets both angle limits to 0, so "
            "not while locked. To end it: 'torque ID off', 'set ID CCW_ANGLE_LIMIT 300'"),
        .example = COMMAND_DETAILS("turn 1 -20rpm"),
        .begin = turn_begin,
        .poll = turn_poll,
    },
    {
        .usage = FLASH_TEXT("torque ID|254 on|off"),
        .what = FLASH_TEXT("torque on or off"),
        .details = COMMAND_DETAILS("on: the servo moves to its last goal; 'teach off ID' keeps it "
                                   "where it is. A turn begins with speed 0. off: "
                                   "the output turns freely. ID 254: all; a turn may begin"),
        .example = COMMAND_DETAILS("torque 1 on"),
        .begin = torque_begin,
        .poll = torque_poll,
    },
    {
        .usage = FLASH_TEXT("led ID|254 on|off"),
        .what = FLASH_TEXT("LED on or off"),
        .details = COMMAND_DETAILS("ID 254: all"),
        .example = COMMAND_DETAILS("led 1 on"),
        .begin = led_begin,
        .poll = console_waits,
    },
};

const CDS_FLASH struct command_group servo_commands = {
    .heading = FLASH_TEXT("One servo:"),
    .rows = servo_rows,
    .count = sizeof servo_rows / sizeof servo_rows[0],
};
