/* The text console: reading lines and running them; see console.h. Replies are in reply.c. */
#include "console.h"

#include "cmd_keeper.h"
#include "errors.h"
#include "reply.h"

static void begin_line(struct console *console)
{
    command_begin(&console->line);
    console->token.length = 0;
    console->characters = 0;
    console->skipping = false;
    console->state = CONSOLE_READING;
}

void console_open(struct console *console, struct cds_bus *bus, struct cds_request *request,
                  struct cds_ring *input, struct cds_ring *output)
{
    console->bus = bus;
    console->input = input;
    console->writer.ring = output;
    console->line.request = request;
    begin_line(console);
}

/* The line cannot be trusted any more; it still ends, and is answered, at its end. */
static void spoil(struct console *console, uint8_t error)
{
    if (!console->skipping) {
        console->skipping = true;
        console->line.error = error;
    }
}

static void reply(struct console *console, uint8_t error)
{
    console->error = error;
    console->servo_error = 0;
    console->phase = REPLY_BODY;
    console->step = 0;
    console->state = CONSOLE_REPLYING;
}

static void end_word(struct console *console, char separator)
{
    bool empty = console->token.length == 0;

    if (empty && (separator == ' ' || console->line.words == 0))
        return; // several spaces count as one
    command_word(&console->line, &console->token, separator);
    console->token.length = 0;
}

static void end_line(struct console *console)
{
    uint8_t error;

    end_word(console, ' ');
    if (console->line.words == 0 && console->line.error == 0) {
        begin_line(console); // an empty line asks for nothing
        return;
    }
    error = command_end(&console->line);
    if (error == 0 && commands[console->line.kind].instruction) {
        error = (uint8_t)cds_bus_submit(console->bus, console->line.request);
        console->state = CONSOLE_WAITING;
    }
    if (error == 0)
        error = cmd_keeper_begin(console);
    if (error || console->state != CONSOLE_WAITING)
        reply(console, error);
}

static void take(struct console *console, char c)
{
    if (c == '\r' || c == '\n') {
        end_line(console);
        return;
    }
    if (++console->characters > CONSOLE_LINE_MAX)
        spoil(console, ERROR_LINE_TOO_LONG);
    if (console->skipping) {
        if (console->characters > CONSOLE_LINE_MAX)
            console->characters = CONSOLE_LINE_MAX; // must not wrap
        return;
    }
    if (c == ' ' || c == '\t')
        end_word(console, ' ');
    else if ((c == ':' || c == ',') && command_in_block(&console->line))
        end_word(console, c);
    else
        token_add(&console->token, c);
}

void console_input_lost(struct console *console)
{
    spoil(console, ERROR_INPUT_LOST);
}

/* The exchange has ended: what has the servo said? */
static void note_outcome(struct console *console)
{
    const struct cds_request *request = console->line.request;

    reply(console, request->result);
    if (request->result == CDS_OK)
        console->servo_error = request->error;
}

void console_poll(struct console *console)
{
    switch (console->state) {
    case CONSOLE_READING:
        while (console->state == CONSOLE_READING && cds_ring_count(console->input)) {
            char c = (char)cds_ring_peek(console->input, 0);

            cds_ring_drop(console->input, 1);
            take(console, c);
        }
        break;
    case CONSOLE_WAITING:
        if (console->line.request->result != CDS_PENDING)
            note_outcome(console);
        break;
    default:
        if (writer_ready(&console->writer) && !reply_piece(console))
            begin_line(console);
        break;
    }
}

bool console_idle(const struct console *console)
{
    return console->state == CONSOLE_READING && cds_ring_count(console->input) == 0;
}
