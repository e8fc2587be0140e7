/* The console's commands: their names, what they take, and turning the words of a line, as they
 * arrive, into the packet to be sent. No line is ever stored, so a SYNC WRITE may be as long as its
 * packet. */
#ifndef CONTROLLER_COMMAND_H
#define CONTROLLER_COMMAND_H

#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_request
#include "flash.h"       // CDS_FLASH
#include "token.h"       // struct token

/* What a command takes, a letter for each word:
 *   i  ID, 0 to 253           b  ID or 254, all servos       r  register, by name or address
 *   n  number of bytes        v  values, one or more         s  blocks ID:BYTE,BYTE,..., one or
 * more w  any word               u  number, 0 to 65535          ?  what follows may be left out
 * X(name, takes, instruction or 0, arguments, what it does) */
#define COMMANDS(X)                                                                                \
    X(help, "", 0, "", "this list")                                                                \
    X(version, "", 0, "", "version and board")                                                     \
    X(ping, "b", CDS_PING, " ID", "is it there? (254: who is there?)")                             \
    X(read, "ir?n", CDS_READ, " ID REG [LENGTH]", "read a register, or LENGTH bytes from it on")   \
    X(write, "brv", CDS_WRITE, " ID REG VALUE...", "write a register and those that follow it")    \
    X(regwrite, "brv", CDS_REG_WRITE, " ID REG VALUE...",                                          \
      "the same, kept by the servo until action")                                                  \
    X(action, "?b", CDS_ACTION, " [ID]", "carry out what was kept (no ID: all servos)")            \
    X(reset, "i", CDS_RESET, " ID", "factory values: it is ID 1 at 1 Mbps afterwards")             \
    X(sync, "rns", CDS_SYNC_WRITE, " REG LENGTH ID:BYTE,BYTE,... ...",                             \
      "write many servos at once")                                                                 \
    /* cmd_keeper.c */                                                                             \
    X(settings, "?w?u", 0, " [NAME [VALUE]]",                                                      \
      "the controller's settings; or one; or change it, until power-off if it is not saved")       \
    X(save, "", 0, "", "keep the settings in the EEPROM")                                          \
    X(defaults, "", 0, "", "the settings as they were at first, until power-off if not saved")     \
    X(status, "", 0, "", "reset, settings, host link, torque off, bus, servos, RAM")               \
    X(alarms, "", 0, "", "of all servos, in any reply since they were cleared")                    \
    X(clear, "", 0, "",                                                                            \
      "alarms and loss of the host link are seen to; servos held for it may be driven")

enum command_kind {
#define COMMAND_ENUM_(name, takes, instruction, arguments, what) COMMAND_##name,
    COMMANDS(COMMAND_ENUM_)
#undef COMMAND_ENUM_
        COMMAND_COUNT,
};

struct command {
    const CDS_FLASH char *name;
    const CDS_FLASH char *takes;
    const CDS_FLASH char *usage; // "name arguments: what it does"
    uint8_t instruction;
};

extern const CDS_FLASH struct command commands[COMMAND_COUNT];

/* A line being read. */
struct command_line {
    struct cds_request *request; // the packet grows in its buffer
    uint8_t words;               // so far, the command's name included
    uint8_t kind;                // enum command_kind
    uint8_t error;               // number of the first error, 0 if none so far
    const CDS_FLASH char *takes; // letter of the next word
    uint8_t values;              // words taken by a letter that repeats
    uint8_t id;
    uint8_t address;   // of the register named first
    uint8_t length;    // bytes to read, or for each servo
    uint8_t next;      // register the next value goes to
    bool named;        // the register was given by its name
    uint8_t remaining; // bytes still due in a block of SYNC WRITE
    struct token word; // of w
    uint16_t number;   // of u
};

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
