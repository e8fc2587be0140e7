/* SPDX-License-Identifier: MIT */
/* The text console: reading lines and running them; see console.h. The end of replies is in
 * reply.c, the commands in commands/. */
#include "console/console.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/motion.h" // CDS_MOTION_TIME_MAX_MS
#include "console/account.h"
#include "console/commands/monitor.h" // monitor_poll()
#include "console/commands/shared.h"  // reset_by_watchdog
#include "console/errors.h"
#include "console/noise.h"   // struct noise
#include "host/host_demux.h" // HOST_MARK_DROPPED
#include "ring_input.h"      // ring_peek(), ring_drop()
#include "compiler.h"        // NOINLINE
#include "console/reply.h"
#include "robot/settings.h" // SETTINGS_ECHO_PERSON
#include "console/typing.h"
#include "console/unasked.h"

/* Bounds of a poll, since the bus must not wait. */
#define KEYS_PER_POLL 4 // with 3 a line of 254 bytes at 1 Mbps is lost
#define FED_PER_POLL  8 // a line of 50 servos comes as fast as the host can send

static const CDS_FLASH char banner[] = "%s%s\r\nhelp lists the commands; Ctrl-X stops all servos";
#define HELP_AND_TAB "help lists the commands, Tab completes them; Ctrl-X stops all servos"
static const CDS_FLASH char banner_typing[] = "%s%s\r\n" HELP_AND_TAB;
static const CDS_FLASH char banner_noting[] = "%s%s\r\n%s%s" HELP_AND_TAB;

static void begin_line(struct console *console)
{
    parse_begin(&console->line);
    console->token.length = 0;
    console->characters = 0;
    console->skipping = false;
    console->error = 0;
    console->servo_error = 0;
    console->state = CONSOLE_READING;
}

_Static_assert(sizeof(((union console_buffer *)0)->command) + PARSE_NAMES_MAX * PARSE_NAME_SIZE <=
                   sizeof(((union console_buffer *)0)->packet),
               "the job and two names must fit behind a short packet");

bool console_is_for_person(const struct console *console)
{
    return console->failsafe->settings->echo == SETTINGS_ECHO_PERSON;
}

void console_prompt(struct console *console)
{
    console->editor.prompt_due = console_is_for_person(console);
}

void console_move_prompt(struct console *console)
{
    console_prompt(console);
    if (command_set.unasked)
        unasked_make_room(console);
    if (console->editor.prompt_due)
        printer_char(&console->printer, '\r');
}

/* Prints version, the cause of a reset that no user wanted, and where help is. A supply that rises
 * slowly sets the flag of a brown-out beside that of power-on. */
static void print_banner(struct console *console)
{
    union printer_value *values = console->printer.values;
    uint8_t cause = console->failsafe->reset_cause;

    values[0].text = message_version;
    values[1].text = message_nothing;
    if (cause == FAILSAFE_RESET_WATCHDOG)
        values[1].text = reset_by_watchdog;
    else if (cause == FAILSAFE_RESET_BROWN_OUT)
        values[1].text = reset_by_brown_out;
    if (command_set.after_reset)
        command_set.after_reset(console);
    printer_line(&console->printer, command_set.after_reset ? banner_noting
                                    : command_set.typing    ? banner_typing
                                                            : banner);
}

void console_open(struct console *console, struct failsafe *failsafe, struct cds_ring *input,
                  struct cds_ring *output)
{
    OPTIMIZER_BARRIER(console);
    console->failsafe = failsafe;
    console->robot = failsafe->robot;
    console->bus = failsafe->robot->bus;
    if (command_set.history)
        console->editor.history = command_set.history;
    console->input = input;
    console->looked = input->tail;
    console->printer.ring = output;
    console->request.packet.bytes = console->buffer.packet;
    console->request.packet.capacity = sizeof console->buffer.packet;
    console->request.reply = console->reply;
    console->request.reply_capacity = sizeof console->reply;
    console->line.request = &console->request;
    begin_line(console);
    console_prompt(console);
    if (console->editor.prompt_due)
        print_banner(console);
}

/* The line is wrong: ignores its remaining characters. At the end of the line the reply is `error`.
 */
static void spoil(struct console *console, uint8_t error)
{
    if (!console->skipping) {
        console->skipping = true;
        console->line.error = error;
    }
}

/* ---- a line ---- */

/* True if the token is the first wrong word of the line: the error names it, and a hint looks for a
 * name near it. */
static bool keeps_word(const struct console *console)
{
    return command_set.explain && console->line.error;
}

static void end_word(struct console *console, char separator)
{
    bool empty = console->token.length == 0;

    if (empty && (separator == ' ' || console->line.words == 0))
        return; // several spaces count as one
    parse_word(&console->line, &console->token, separator);
    if (!keeps_word(console))
        console->token.length = 0;
}

/* Takes a character of the line that the user can no longer delete. */
static void feed(struct console *console, char c)
{
    if (++console->characters > CONSOLE_LINE_MAX) {
        console->characters = CONSOLE_LINE_MAX; // must not wrap
        spoil(console, ERROR_LINE_TOO_LONG);
    }
    if (console->skipping || keeps_word(console))
        return;
    if (c == ' ' || c == '\t')
        end_word(console, ' ');
    else if ((c == ':' || c == ',') && parse_in_block(&console->line))
        end_word(console, c);
    else
        token_add(&console->token, c);
}

uint8_t console_remedied(const struct console *console, uint8_t error)
{
    if ((error != CDS_INHIBITED && error != ERROR_STOPPED) || !robot_is_inhibited(console->robot))
        return error; // CDS_INHIBITED: only this servo is inhibited
    return console->failsafe->link_lost ? ERROR_LINK_LOST : ERROR_STOPPED;
}

NOINLINE static void conclude(struct console *console, uint8_t error)
{
    if (console->error == 0)
        console->error = error;
    console->error = console_remedied(console, console->error);
    console->reply_ended = false;
    if (command_set.store)
        command_set.store->end(console);
    if (command_set.explain)
        console->explained = 0;
    console->state = CONSOLE_ENDING;
    if (command_set.typing)
        console->phase = 0;
}

NOINLINE void console_begin_job(struct console *console)
{
    if (!console->line.command->instruction) // else the packet of the line is in these bytes
        memset(console_job(console), 0, CONSOLE_JOB_SIZE);
    console->step = 0;
    console->phase = 0;
    console->index = 0;
    console->part = 0;
    console->state = CONSOLE_RUNNING;
}

uint8_t console_faults(const struct console *console)
{
    uint8_t faults = console->failsafe->link_lost ? FAULT_LINK_LOST : 0;

    if (command_set.noise && command_set.noise->is_there)
        faults |= FAULT_NOISE; // the line is low at times
    else if (cds_bus_line(console->bus) == CDS_BUS_LINE_FAULT)
        faults |= FAULT_LINE_LOW;
    return faults;
}

bool console_is_noisy(const struct console *console)
{
    return command_set.noise->is_there || (command_set.unasked && console_is_for_person(console) &&
                                           console->faults_told & FAULT_NOISE);
}

/* Faults that may be told again are no longer told: those that are over. Of noise a person first
 * hears that it is over (unasked.h). */
static void forget_faults(struct console *console)
{
    uint8_t last = console_faults(console);

    if (command_set.unasked && console_is_for_person(console))
        last |= FAULT_NOISE;
    console->faults_told &= last;
}

/* Runs the command of console->line. */
static void run(struct console *console)
{
    const CDS_FLASH struct command *command = console->line.command;
    uint8_t error = 0;

    console_begin_job(console);
    console->failsafe->host_types = true;
    if (command_set.explain)
        forget_faults(console);
    if (command_set.unasked)
        unasked_begin(command_set.unasked, console);
    if (command_set.lists)
        error = command_set.lists->begin(console);
    else if (command->begin)
        error = command->begin(console);
    if (error || (command_set.lists == NULL && command->poll == NULL))
        conclude(console, error);
}

static bool is_stop(const CDS_FLASH struct command *command)
{
    return command && command->begin == stop_begin;
}

static void end_line(struct console *console)
{
    uint8_t error;

    editor_end(&console->editor);
    if (!keeps_word(console))
        end_word(console, ' ');
    if (console->line.words == 0 && console->line.error == 0) {
        begin_line(console); // an empty line has no reply
        console_prompt(console);
        return;
    }
    error = parse_end(&console->line);
    if (error && !is_stop(console->line.command)) // "stop now" stops, too
        conclude(console, error);
    else
        run(console);
}

/* Gives some of the locked characters to the parser. The poll ends behind the first word, and the
 * end of the line has a poll of its own: to find a row takes long. */
static void feed_locked(struct console *console)
{
    struct editor *editor = &console->editor;
    bool may_end = console->fed == editor->locked, is_first = console->line.words == 0;

    for (uint8_t left = FED_PER_POLL; left && console->fed < editor->locked; left--) {
        feed(console, editor->text[console->fed++]);
        if (is_first && console->line.words)
            break;
    }
    if (console->fed < editor->locked || (console->line_complete && !may_end))
        return;
    console->fed = 0;
    if (console->line_complete) {
        console->line_complete = false;
        end_line(console);
    } else if (editor->locked) {
        editor_take(editor, editor->locked);
    }
}

static void drop_line(struct console *console)
{
    console->editor.length = 0;
    editor_end(&console->editor);
    console->fed = 0;
    console->line_complete = false;
    if (command_set.typing)
        console->completing = false;
    begin_line(console);
}

static bool is_mark(uint8_t byte)
{
    return byte == HOST_MARK_DROPPED || byte == HOST_MARK_LOST;
}

/* The demux has put a mark into the text: the unfinished line is lost. */
NOINLINE static void take_mark(struct console *console, uint8_t mark)
{
    drop_line(console);
    if (mark == HOST_MARK_LOST)
        conclude(console, ERROR_INPUT_LOST);
}

static struct printer *echo_of(struct console *console)
{
    return console->failsafe->settings->echo ? &console->printer : NULL;
}

/* A Tab has come. A long line whose begin the parser has cannot be completed. */
NOINLINE static void begin_completion(struct console *console)
{
    if (!command_set.typing || console->editor.longer)
        return;
    command_set.typing->begin(console);
    console->completing = true;
}

/* Returns how much of a full editor goes to the parser: half of it. With echo a person may type:
 * the begin of a word, which Ctrl-W may delete, stays. A program sends too fast for smaller parts.
 * Only line_editor.c, which has a history, has Ctrl-W. */
static uint8_t half_of(const struct editor *editor, const struct printer *echo)
{
    uint8_t half = EDITOR_SIZE / 2;

    while (command_set.history && echo && half && editor->text[half - 1] != ' ')
        half--;
    return half ? half : EDITOR_SIZE / 2;
}

static void take(struct console *console, char c, struct printer *echo)
{
    struct editor *editor = &console->editor;

    switch (editor_key(editor, c, echo)) {
    case EDITOR_END:
        editor->locked = editor->length;
        console->line_complete = true;
        break;
    case EDITOR_DROP:
        drop_line(console);
        console_prompt(console);
        break;
    case EDITOR_COMPLETE: begin_completion(console); break;
    case EDITOR_FULL:
        if (editor->locked == 0)
            editor->locked = half_of(editor, echo);
        break;
    default: break;
    }
}

static bool takes_keys(struct console *console, struct printer *echo)
{
    return console->state == CONSOLE_READING && !console->line_complete &&
           console->editor.length < EDITOR_SIZE &&
           (echo == NULL || editor_show(&console->editor, echo)) && cds_ring_count(console->input);
}

static void read_input(struct console *console)
{
    struct printer *echo = echo_of(console);

    feed_locked(console);
    for (uint8_t left = KEYS_PER_POLL; left && takes_keys(console, echo); left--) {
        uint8_t byte = ring_peek(console->input, 0);

        ring_drop(console->input, 1);
        if (is_mark(byte)) {
            take_mark(console, byte); // takes as long as three keys
            return;
        }
        take(console, (char)byte, echo);
        // The prompt after Ctrl-C takes as long as three keys. The keys behind a Tab wait.
        if (console->editor.length == 0 || (command_set.typing && console->completing))
            return;
    }
}

/* ---- Ctrl-X ---- */

/* Returns the index behind the last Ctrl-X in the input ring, or 0; searches from index `from` on.
 */
NOINLINE static uint8_t behind_stop(const struct console *console, uint8_t from)
{
    uint8_t behind = 0;

    for (uint8_t at = from; at < cds_ring_count(console->input); at++)
        if (ring_peek(console->input, at) == CONSOLE_STOP)
            behind = (uint8_t)(at + 1u);
    return behind;
}

void console_stop(struct console *console)
{
    uint8_t behind = behind_stop(console, 0);

    robot_stop(console->robot);
    ring_drop(console->input, behind ? behind : cds_ring_count(console->input));
    console->looked = console->input->tail;
    console->stop_asked = true;
    if (console->state == CONSOLE_READING)
        drop_line(console);
}

/* Searches all input for Ctrl-X: it must not wait for the input before it. */
static void look_for_stop(struct console *console)
{
    uint8_t count = cds_ring_count(console->input);
    uint8_t from = (uint8_t)(console->looked - console->input->tail);

    if (from > count)
        from = 0; // the searched bytes are no longer in the ring
    if (behind_stop(console, from))
        console_stop(console);
    else
        console->looked = (uint8_t)(console->input->tail + count);
}

/* Ends the running command after Ctrl-X, as soon as its request has ended and no operation needs
 * the bus for itself. */
static void interrupt(struct console *console)
{
    if (console->line.request->result == CDS_PENDING || robot_is_exclusive(console->robot))
        return;
    if (!printer_ready(&console->printer))
        return;
    if (command_set.monitor && console->line.command->poll == monitor_poll)
        command_set.monitor(console, MONITOR_LEAVE);
    if (console->printer.within)
        printer_end_of_line(&console->printer);
    if (command_set.store)
        command_set.store->abort(command_set.store->motions);
    conclude(console, CDS_INHIBITED); // by a stop or a lost link
}

/* ---- a command ---- */

NOINLINE uint8_t console_number(struct console *console, uint8_t index, enum cds_unit unit)
{
    return number_within(&console->line.number[index], unit, &console->raw);
}

uint8_t console_ms(struct console *console)
{
    uint32_t ms = console->raw;
    uint8_t error = number_ms(&console->line.number[0], UINT16_MAX, &ms);

    console->raw = (uint16_t)ms;
    return error;
}

uint8_t console_move_ms(struct console *console, uint8_t index, uint32_t *ms)
{
    uint8_t error = number_ms(&console->line.number[index], CDS_MOTION_TIME_MAX_MS, ms);

    return error == ERROR_OUT_OF_RANGE || (error == 0 && *ms == 0) ? (uint8_t)ERROR_TIME : error;
}

bool console_waits(struct console *console)
{
    const struct cds_request *request = console->line.request;

    if (request->result == CDS_PENDING)
        return true;
    console->error = request->result;
    if (request->result == CDS_OK)
        console->servo_error = request->error;
    return false;
}

NOINLINE bool console_answered(const struct console *console)
{
    return console->error == 0 && !(console->servo_error & CDS_ERRORS_OF_PACKET);
}

bool console_key(struct console *console)
{
    for (; cds_ring_count(console->input); ring_drop(console->input, 1)) {
        uint8_t byte = ring_peek(console->input, 0);

        if (!(byte == '\n' && console->editor.after_cr) && byte != HOST_MARK_DROPPED)
            return true;
        console->editor.after_cr = false;
    }
    return false;
}

bool console_operates(struct console *console)
{
    struct robot *robot = console->robot;

    if (robot->operation) {
        if (console_key(console))
            robot_abort(robot);
        return true;
    }
    console->error = robot->result == CDS_CANCELLED ? (uint8_t)ERROR_KEY : robot->result;
    return false;
}

NOINLINE struct cds_servo_state *console_servo(const struct console *console)
{
    return cds_servos_find(&console->robot->servos, console->line.id);
}

static void poll_command(struct console *console)
{
    if (!printer_ready(&console->printer))
        return;
    if (command_set.lists ? !command_set.lists->poll(console)
                          : !console->line.command->poll(console))
        conclude(console, 0);
    else if (console->step < UINT8_MAX)
        console->step++;
}

static void answer_stop(struct console *console)
{
    console->stop_asked = false;
    if (console_is_for_person(console))
        printer_end_of_line(&console->printer); // behind the prompt and the dropped line
    parse_begin(&console->line);
    console->line.command = command_set.on_stop;
    console_begin_job(console);
}

static void read_keys(struct console *console)
{
    if (!command_set.report(console))
        read_input(console);
}

static void read_line(struct console *console)
{
    if (console->stop_asked)
        answer_stop(console);
    else if (command_set.typing && console->completing)
        console->completing = command_set.typing->complete(console);
    else
        read_keys(console);
}

static void go_on(struct console *console)
{
    if (console->stop_asked && console->line.command != command_set.on_stop)
        interrupt(console);
    else
        poll_command(console);
}

static void end_reply(struct console *console)
{
    if (!printer_ready(&console->printer) ||
        (command_set.typing && command_set.typing->search(console)))
        return;
    if (reply_piece(console))
        return;
    begin_line(console);
    console_prompt(console);
}

void console_poll(struct console *console)
{
    static void (*const CDS_FLASH states[])(struct console *) = {
        [CONSOLE_READING] = read_line,
        [CONSOLE_RUNNING] = go_on,
        [CONSOLE_ENDING] = end_reply,
    };

    look_for_stop(console);
    if (command_set.account && cds_ring_count(console->input) == 0) // else a long line comes in
        account_tick();
    states[console->state](console);
}

bool console_say(struct console *console, const CDS_FLASH char *line)
{
    if (!printer_ready(&console->printer))
        return false;
    console_move_prompt(console);
    printer_line(&console->printer, line);
    return true;
}

bool console_idle(const struct console *console)
{
    return console->state == CONSOLE_READING && cds_ring_count(console->input) == 0 &&
           !console->stop_asked && !(command_set.typing && console->completing) &&
           !console->line_complete && console->editor.locked == 0 &&
           (!console->failsafe->settings->echo || editor_is_shown(&console->editor)) &&
           !console->printer.text && !console->failsafe->alarm;
}
