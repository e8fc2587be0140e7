/* The console's commands: one row of a table in flash for each (commands.h), and turning the words
 * of a line, as they arrive, into what the row takes. No line is ever stored whole, so a SYNC WRITE
 * may be as long as its packet. */
#ifndef CONTROLLER_COMMAND_H
#define CONTROLLER_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"    // struct cds_request
#include "flash.h"          // CDS_FLASH
#include "console/number.h" // struct number
#include "console/lexer.h"  // struct token

#define COMMAND_LIST_MAX 50 // IDs or angles in a line

struct console;

/* A row. What it takes, a letter for each word; `line` has what was taken:
 *   i  ID, 0 to 253                 -> line.id
 *   b  ID, or 254, all servos       -> line.id, which is 254 where none is given
 *   j  ID, 0 to 253                 -> line.to
 *   r  register, by name or address -> line.address, line.length (of the register, in bytes)
 *   n  number of bytes              -> line.length
 *   u  number, with a unit or none  -> line.number[0], then [1], [2]
 *   c  command                      -> line.to: its row
 *   k  setting                      -> line.to: its row
 *   (one|two)  one of these words   -> line.choice: 1, 2, ...; 0 if it is left out
 * and these, which take one word or more, up to a word that begins with a letter:
 *   v  values of registers, s  blocks ID:BYTE,BYTE,...: straight into the packet
 *   l  IDs, 0 to 253                -> the first line.values bytes of the request's buffer
 *   p  angles                       -> words there, low byte first; line.values of them
 * ?  what follows may be left out */
struct command {
    const CDS_FLASH char *words; // name, NUL, what it takes, NUL
    /* Starts the command: 0, or the number of the error that it ends with at once: an enum
     * cds_result or a CONSOLE_ERRORS. NULL: there is nothing to start. */
    uint8_t (*begin)(struct console *console);
    /* Called in turns of the main loop, whenever a piece of text may be written
     * (console->printer), until it returns false; console->step counts these calls, from 0 on, up
     * to 255. It never waits. An error is left in console->error. NULL: there is nothing more to
     * do.
     */
    bool (*poll)(struct console *console);
    uint8_t instruction; // of the packet that the line is, or 0
};

/* X(name, heading in the list) */
#define COMMAND_GROUPS(X)                                                                          \
    X(CONSOLE, "The console")                                                                      \
    X(SERVO, "One servo")                                                                          \
    X(MANY, "Many servos")                                                                         \
    X(CARE, "Safety")                                                                              \
    X(SETUP, "Set-up of servos")                                                                   \
    X(BUS, "The bus")                                                                              \
    X(RAW, "Instructions of the manual")                                                           \
    X(KEEPER, "The controller")

enum command_group {
#define COMMAND_GROUP_ENUM_(name, heading) COMMAND_GROUP_##name,
    COMMAND_GROUPS(COMMAND_GROUP_ENUM_)
#undef COMMAND_GROUP_ENUM_
        COMMAND_GROUP_COUNT,
} __attribute__((packed));

/* A line being read. */
struct command_line {
    struct cds_request *request; // the packet grows in its buffer
    uint8_t id;
    uint8_t to;
    uint8_t address;             // of the register named first
    uint8_t length;              // bytes to read, or for each servo
    uint8_t choice;              // which of several words, from 1 on
    uint8_t numbers;             // taken of `number`
    uint8_t values;              // words taken by a letter that repeats
    uint8_t words;               // so far, the command's name included
    uint8_t kind;                // row of the command
    uint8_t error;               // number of the first error, 0 if none so far
    uint8_t next;                // register the next value goes to
    bool named;                  // the register was given by its name
    uint8_t remaining;           // bytes still due in a block of SYNC WRITE
    const CDS_FLASH char *takes; // letter of the next word
    struct number number[3];
};

/* The row of the command named by `token`, or COMMAND_COUNT of commands.h. */
uint8_t command_named(const struct token *token);

/* Forgets the line and begins a new one. */
void command_begin(struct command_line *line);

/* Takes the next word, and the character that ended it (space, or ':' or ',' within a block). */
void command_word(struct command_line *line, const struct token *token, char separator);

/* The line is complete: returns its error, or 0. Then, if the command has an instruction, the
 * packet in line->request is ready to be submitted. */
uint8_t command_end(struct command_line *line);

/* Are ':' and ',' separators where the line now is? */
bool command_in_block(const struct command_line *line);

#endif
