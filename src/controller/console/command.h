/* A command of the console: a row of a table in flash, beside the code that carries the command out
 * (commands/). A profile (profiles/) links the groups of rows that its firmware has; the console
 * itself knows no command. */
#ifndef CONTROLLER_COMMAND_H
#define CONTROLLER_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#include "console/messages.h" // FLASH_TEXT()
#include "flash.h"            // CDS_FLASH

/* `details` and `example` of a row. The profile `console` leaves them to docs/console.md. */
#ifdef COMMANDS_WITHOUT_DETAILS
#define COMMAND_DETAILS(string) NULL
#else
#define COMMAND_DETAILS(string) FLASH_TEXT(string)
#endif

struct console;

struct command {
    /* The name and the arguments. Arguments are checked, shown by help, and written into
     * docs/console.md as they stand here. [ ] may be left out, and so may all behind it; a|b is one
     * of these words; the others are in capitals, and `struct command_line` has what was read:
     *   ID             0 to 253                        id, which is 254 where none is given
     *   ID|254         0 to 254                        id, which is 254 where none is given
     *   NEW            0 to 253                        new_id
     *   REG            name or address of a register   address, length
     *   LENGTH         1 to what the table has         length
     *   COMMAND        name of a command               topic
     *   NAME           name of a setting               setting
     *   VALUE...       values of registers             put into the packet
     *   ID:BYTE,...    blocks of a SYNC WRITE          put into the packet
     *   ID...          0 to 253                        list, a byte each
     *   ANGLE...       angles                          list, a word each, low byte first
     *   any other      a number, with a unit or none   number[0], then [1], [2] */
    const CDS_FLASH char *usage;
    const CDS_FLASH char *what;    // it does
    const CDS_FLASH char *details; // ranges and remarks; NULL: left out of the firmware
    const CDS_FLASH char *example; // a line; NULL: left out of the firmware
    /* Starts the command: 0, or the number of the error that ends it at once: an enum cds_result or
     * a CONSOLE_ERRORS. NULL: there is nothing to start. */
    uint8_t (*begin)(struct console *console);
    /* Called in turns of the main loop, whenever a piece of text may be printed, until it returns
     * false; console->step counts the calls from 0 on, up to 255. Never waits. Leaves an error in
     * console->error. NULL: there is nothing more to do. */
    bool (*poll)(struct console *console);
    uint8_t instruction; // of the packet that the line is, or 0
};

struct command_group {
    const CDS_FLASH char *heading; // in the list; NULL: the group goes on with the one before
    const CDS_FLASH struct command *rows;
    uint8_t count;
};

/* What a profile links. */
struct command_set {
    const CDS_FLASH struct command_group *const CDS_FLASH *groups; // ends with NULL
    const CDS_FLASH struct command *on_stop;                       // run behind a Ctrl-X
    /* Between two lines: prints reports that no command asked for. False: nothing to print. */
    bool (*report)(struct console *console);
};

extern const CDS_FLASH struct command_set command_set;

#endif
