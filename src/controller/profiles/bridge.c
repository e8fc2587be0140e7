/* SPDX-License-Identifier: MIT */
/* Firmware profile `bridge`: the functions of console.h for a firmware without a console. They drop
 * text of the host, except Ctrl-X, which stops the robot; a host releases the robot by the virtual
 * device. */
#include "console/console.h"
#include "host/device_registers.h" // device_registers_ops
#include "ring_input.h"

const CDS_FLASH struct command_set command_set = {.device = &device_registers_ops};

void console_open(struct console *console, struct failsafe *failsafe, struct cds_ring *input,
                  struct cds_ring *output)
{
    console->failsafe = failsafe;
    console->robot = failsafe->robot;
    console->input = input;
    console->printer.ring = output;
}

void console_poll(struct console *console)
{
    bool stop = false;

    for (; cds_ring_count(console->input); ring_drop(console->input, 1))
        if (ring_peek(console->input, 0) == CONSOLE_STOP)
            stop = true;
    if (stop)
        console_stop(console);
}

bool console_say(struct console *console, const CDS_FLASH char *line)
{
    if (cds_ring_count(console->printer.ring)) // an empty ring has room for a line
        return false;
    printer_flash(&console->printer, line);
    printer_end_of_line(&console->printer);
    return true;
}

void console_stop(struct console *console)
{
    ring_drop(console->input, cds_ring_count(console->input)); // with the Ctrl-X, if it is there
    robot_stop(console->robot);
}

bool console_idle(const struct console *console)
{
    return cds_ring_count(console->input) == 0;
}
