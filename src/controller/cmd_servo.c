/* move, turn, torque, led. */
#include "cds55xx/servo.h" // cds_servo_write()
#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "sentences.h"

/* What move looks at first, in one READ. */
#define LOOK_FROM CDS_REG_CW_ANGLE_LIMIT
#define LOOK_SIZE (CDS_REG_TORQUE_ENABLE - CDS_REG_CW_ANGLE_LIMIT + 1)

enum move_phase { MOVE_LOOK, MOVE_WRITE };

/* A number of the line as a register value; an error goes into the console's. */
static uint16_t raw_of(struct console *console, uint8_t index, enum cds_unit unit)
{
    uint16_t raw = 0;
    uint8_t error = number_within(&console->line.number[index], unit, &raw);

    if (console->error == 0)
        console->error = error;
    return raw;
}

static enum cds_result write_goal(struct console *console)
{
    struct command_line *line = &console->line;
    uint16_t goal = raw_of(console, 0, CDS_UNIT_MDEG);
    uint16_t speed = 0;
    uint8_t data[4];

    if (line->numbers == 2)
        speed = raw_of(console, 1, CDS_UNIT_MRPM);
    data[0] = (uint8_t)goal;
    data[1] = (uint8_t)(goal >> 8);
    data[2] = (uint8_t)speed;
    data[3] = (uint8_t)(speed >> 8);
    console->phase = MOVE_WRITE;
    return cds_servo_write(console->bus, line->request, line->id, CDS_REG_GOAL_POSITION, data,
                           line->numbers == 2 ? 4 : 2);
}

uint8_t move_begin(struct console *console)
{
    struct command_line *line = &console->line;
    enum cds_result result;

    raw_of(console, 0, CDS_UNIT_MDEG);
    if (line->numbers == 2)
        raw_of(console, 1, CDS_UNIT_MRPM);
    if (console->error)
        return console->error;
    if (line->id == CDS_BROADCAST_ID)
        return (uint8_t)write_goal(console);
    result = cds_servo_read(console->bus, line->request, line->id, LOOK_FROM, LOOK_SIZE);
    return (uint8_t)(result == CDS_NO_REPLY_DUE ? write_goal(console) : result);
}

/* A servo that could not do it says nothing by itself. */
static void look(struct console *console)
{
    const uint8_t *bytes = console->line.request->packet.bytes;

    if ((bytes[0] | bytes[1] | bytes[2] | bytes[3]) == 0) {
        console->error = ERROR_ENDLESS;
        return;
    }
    if (bytes[LOOK_SIZE - 1] == 0)
        writer_line(&console->writer, TEXT_TORQUE_IS_OFF);
    console->error = (uint8_t)write_goal(console);
}

bool move_poll(struct console *console)
{
    if (console_waits(console))
        return true;
    if (console->phase == MOVE_WRITE || !console_answered(console))
        return false;
    look(console);
    return console->error == 0;
}

/* Both angle limits 0 make it an endless turn (manual 3.2). */
uint8_t turn_begin(struct console *console)
{
    static const uint8_t no_limits[4];
    struct command_line *line = &console->line;

    raw_of(console, 0, CDS_UNIT_SIGNED_MRPM);
    if (console->error)
        return console->error;
    return (uint8_t)cds_setup_write_begin(&console->job.set.setup, console->bus, line->request,
                                          line->id, CDS_REG_CW_ANGLE_LIMIT, no_limits,
                                          sizeof no_limits);
}

bool turn_poll(struct console *console)
{
    struct cds_setup *setup = &console->job.set.setup;
    struct command_line *line = &console->line;

    if (console->phase)
        return console_waits(console);
    if (cds_setup_poll(setup) == CDS_PENDING)
        return true;
    console->error = setup->result;
    console->servo_error = setup->error;
    if (console->error)
        return false;
    if (setup->written)
        writer_line(&console->writer, TEXT_LIMITS_ARE_OFF);
    console->phase = 1;
    console->error = (uint8_t)cds_servo_write_word(
        console->bus, line->request, line->id, CDS_REG_MOVING_SPEED,
        raw_of(console, 0, CDS_UNIT_SIGNED_MRPM));
    return console->error == 0;
}

__attribute__((noinline)) static uint8_t write_switch(struct console *console, uint8_t address)
{
    struct command_line *line = &console->line;

    return (uint8_t)cds_servo_write_byte(console->bus, line->request, line->id, address,
                                         line->choice == 1);
}

uint8_t torque_begin(struct console *console)
{
    return write_switch(console, CDS_REG_TORQUE_ENABLE);
}

uint8_t led_begin(struct console *console)
{
    return write_switch(console, CDS_REG_LED);
}
