/* monitor: what servos do, as lines that a serial plotter draws: "1deg:150.147,1rpm:0,..." */
#include <stddef.h>
#include <string.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "console.h"
#include "errors.h"
#include "handlers.h"

#define PERIOD_MS     100
#define PERIOD_MIN_MS 10
#define PERIOD_MAX_MS 60000

enum monitor_phase {
    PAUSE, // until the next line is due
    ASK,   // a servo
    TAKE,  // its answer
    TELL,  // what it says
    SUM_UP,
};

uint8_t monitor_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    uint16_t ms = PERIOD_MS;
    uint8_t error = line->numbers ? number_ms(&line->number[0], &ms) : 0;

    if (error)
        return error;
    if (ms < PERIOD_MIN_MS || ms > PERIOD_MAX_MS)
        return ERROR_OUT_OF_RANGE;
    if (line->values > MONITOR_SERVOS)
        return ERROR_TOO_MANY;
    memcpy(console->job.monitor.ids, line->request->packet.bytes, line->values);
    console->job.monitor.count = line->values;
    console->job.monitor.period_us = ms * 1000ul;
    console->job.monitor.next_us = cds_port_now_us();
    return 0;
}

/* Before each label: "1" or ",1" */
static struct writer *label(struct console *console)
{
    if (console->job.monitor.begun)
        writer_char(&console->writer, ',');
    console->job.monitor.begun = true;
    writer_decimal(&console->writer, console->job.monitor.ids[console->job.monitor.index]);
    return &console->writer;
}

#define VALUES 5 // told of each servo, one a turn: a conversion takes 100 us

static void tell(struct console *console, uint8_t value)
{
    const struct cds_feedback *feedback = &console->job.monitor.feedback;
    struct writer *writer = label(console);

    switch (value) {
    case 0:
        WRITER_TEXT(writer, "deg:");
        number_write_bare(writer, CDS_UNIT_MDEG, feedback->position);
        break;
    case 1:
        WRITER_TEXT(writer, "rpm:");
        number_write_bare(writer, CDS_UNIT_SIGNED_MRPM, feedback->speed);
        break;
    case 2:
        WRITER_TEXT(writer, "%:");
        number_write_bare(writer, CDS_UNIT_SIGNED_CPCT, feedback->load);
        break;
    case 3:
        WRITER_TEXT(writer, "V:");
        number_write_bare(writer, CDS_UNIT_MV, feedback->voltage);
        break;
    default:
        WRITER_TEXT(writer, "C:");
        number_write_bare(writer, CDS_UNIT_CELSIUS, feedback->temperature);
        break;
    }
}

static void end_of_line(struct console *console)
{
    uint32_t now_us = cds_port_now_us();

    if (console->job.monitor.begun)
        writer_end_of_line(&console->writer);
    if (console->job.monitor.lines < UINT16_MAX)
        console->job.monitor.lines++;
    console->job.monitor.next_us += console->job.monitor.period_us;
    if ((int32_t)(now_us - console->job.monitor.next_us) > 0)
        console->job.monitor.next_us = now_us; // it takes longer than that
    console->job.monitor.begun = false;
    console->job.monitor.index = 0;
    console->phase = PAUSE;
}

static void next(struct console *console)
{
    console->job.monitor.index++;
    if (console->job.monitor.index < console->job.monitor.count)
        console->phase = ASK;
    else
        end_of_line(console);
}

/* One that fails is left out of the line; in the first one it ends all. */
static void take(struct console *console)
{
    struct cds_feedback *feedback = &console->job.monitor.feedback;

    if (cds_feedback_take(feedback, console->line.request, cds_port_now_us()) == CDS_OK) {
        console->job.monitor.value = 0;
        console->phase = TELL;
    } else if (console->job.monitor.lines == 0) {
        console->error = console->line.request->result;
        console->servo_error = feedback->error;
        console->phase = SUM_UP;
    } else {
        if (console->job.monitor.failed < UINT16_MAX)
            console->job.monitor.failed++;
        next(console);
    }
}

/* "42 lines, 0 answers missing" */
static bool sum_up(struct console *console)
{
    if (console->writer.within) {
        writer_end_of_line(&console->writer);
        return true;
    }
    writer_decimal(&console->writer, console->job.monitor.lines);
    WRITER_TEXT(&console->writer, " lines, ");
    writer_decimal(&console->writer, console->job.monitor.failed);
    WRITER_TEXT(&console->writer, " answers missing");
    writer_end_of_line(&console->writer);
    return false;
}

static void ask(struct console *console)
{
    enum cds_result result = cds_feedback_read(
        console->bus, console->line.request, console->job.monitor.ids[console->job.monitor.index]);

    console->error = (uint8_t)result;
    console->phase = result == CDS_OK ? TAKE : SUM_UP;
}

bool monitor_poll(struct console *console)
{
    bool asked = console->phase == TAKE;

    if (asked && console->line.request->result == CDS_PENDING)
        return true;
    if (console->phase != SUM_UP && console_key(console))
        console->phase = SUM_UP;
    switch (console->phase) {
    case PAUSE:
        if ((int32_t)(cds_port_now_us() - console->job.monitor.next_us) >= 0)
            console->phase = ASK;
        return true;
    case ASK: ask(console); return true;
    case TAKE: take(console); return true;
    case TELL:
        tell(console, console->job.monitor.value++);
        if (console->job.monitor.value == VALUES)
            next(console);
        return true;
    default: return sum_up(console);
    }
}
