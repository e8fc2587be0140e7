/* SPDX-License-Identifier: MIT */
/* From the words of a line, as they arrive, to what the usage string of its command asks for. No
 * line is ever stored whole, so a SYNC WRITE may be as long as its packet. */
#ifndef CONTROLLER_PARSE_H
#define CONTROLLER_PARSE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"          // struct cds_request
#include "compiler.h"             // ALWAYS_INLINE
#include "console/command.h"      // struct command
#include "console/token.h"        // struct token
#include "console/number_parse.h" // struct number

#define PARSE_LIST_MAX  50 // IDs or angles in a line
#define PARSE_NAME_SIZE 9  // bytes of a name: its first 9 characters, or all of them and a zero
#define PARSE_NAMES_MAX 2  // names in a line

/* What an argument in capitals is. */
enum argument {
    ARGUMENT_NONE, // there is none, or it is one of several words
    ARGUMENT_ID,
    ARGUMENT_ID_OR_ALL,
    ARGUMENT_NEW_ID,
    ARGUMENT_REGISTER,
    ARGUMENT_LENGTH,
    ARGUMENT_COMMAND,
    ARGUMENT_SETTING,
    ARGUMENT_NAME,
    ARGUMENT_NUMBER, // and all names that are not below
    ARGUMENT_VALUES, // from here on: one word or more
    ARGUMENT_BLOCKS,
    ARGUMENT_IDS,
    ARGUMENT_ANGLES,
} __attribute__((packed));

/* What `help` is asked for: `choice` of the line. */
enum topic {
    TOPIC_COMMAND,
    TOPIC_HEADING,
    TOPIC_UNITS,
    TOPIC_KEYS,
    TOPIC_ALL
} __attribute__((packed));

/* A line being read. */
struct command_line {
    struct cds_request *request;             // its packet is built here, and a list is kept here
    const CDS_FLASH struct command *command; // NULL: not known yet
    const CDS_FLASH struct command *topic;   // the command whose help is wanted
    const CDS_FLASH char *usage;             // the next argument, or the one that is wrong
    uint8_t argument;                        // kind of the argument at `usage`: enum argument
    uint8_t id;
    uint8_t new_id;
    uint8_t setting; // row of settings_table
    uint8_t address; // of the register named first
    uint8_t length;  // bytes to read, or for each servo
    uint8_t choice;  // which of several words, from 1 on; 0: none. The first such word decides
    uint8_t names;   // count of names
    uint8_t numbers; // count of `number`
    uint8_t values;  // count of a list, or of values of registers
    uint8_t words;   // so far, the command's name included
    uint8_t error;   // number of the first error, 0 if none so far
    uint8_t next;    // register the next value goes to
    bool named;      // the register was given by its name
    // bit fields: save 3 bytes of RAM
    bool list_is_open : 1; // the next word may belong to the list of servos in front of it
    bool takes_all : 1;    // the list is all servos of the robot: `all`
    bool is_repeated : 1;  // the command runs for each servo of the list
    uint8_t singles : 2;   // of the last words of the list, how many are one ID: up to 3
    uint8_t remaining;     // bytes still due in a block of SYNC WRITE
    struct number number[3];
};

/* The command named by `token`; NULL: there is none. */
const CDS_FLASH struct command *parse_command(const struct token *token);

/* Name `index`, 0 or 1, of the line: PARSE_NAME_SIZE bytes at the end of the request's buffer. */
static inline char *parse_name(const struct command_line *line, uint8_t index)
{
    const struct cds_packet *packet = &line->request->packet;

    return (char *)packet->bytes + packet->capacity - PARSE_NAME_SIZE * (index + 1);
}

/* True if the token is a word in small letters of this usage string. */
bool parse_is_keyword(const CDS_FLASH char *usage, const struct token *token);

/* The first argument at `usage`, or behind a bracket: enum argument. */
uint8_t parse_argument_at(const CDS_FLASH char *usage);

/* If the line has a list that a word may end, goes on to the argument behind the list. */
void parse_end_list(struct command_line *line);

/* Forgets the line and begins a new one. */
void parse_begin(struct command_line *line);

/* Takes the next word, and the character that ended it (space, or ':' or ',' within a block). */
void parse_word(struct command_line *line, const struct token *token, char separator);

/* The line is complete: returns its error, or 0. Then, if the command has an instruction, the
 * packet in line->request is ready to be submitted. */
uint8_t parse_end(struct command_line *line);

/* Goes on to the argument behind the present one. */
void parse_next_argument(struct command_line *line);

/* Number `index` of the line, 0 to 2: its name in the usage string, up to a space, a ']' or the
 * end. */
const CDS_FLASH char *parse_number_name(const struct command_line *line, uint8_t index);

/* Which of the words at `usage`, as in a|b, the token is, from 1 on; 0: none of them. */
uint8_t parse_choice(const CDS_FLASH char *usage, const struct token *token);

/* True if the argument at `usage` has the name `name`. */
bool parse_has_name(const CDS_FLASH char *usage, const CDS_FLASH char *name);

/* True if both usages begin with the same command. No command has one form without arguments and
 * another one with them. ALWAYS_INLINE: saves 36 bytes in the profile `console`, which has one
 * call. */
ALWAYS_INLINE bool parse_have_same_name(const CDS_FLASH char *a, const CDS_FLASH char *b)
{
    for (; *a == *b; a++, b++)
        if (*a == ' ' || *a == '\0')
            return true;
    return false;
}

/* True if the line has a command, and its name is `name`. */
static inline bool parse_is_command(const struct command_line *line, const CDS_FLASH char *name)
{
    return line->command && parse_has_name(line->command->usage, name);
}

/* True if the present argument is a REG. */
bool parse_at_register(const struct command_line *line);

/* True if the present argument is a number or a NEW. */
bool parse_at_number(const struct command_line *line);

/* True if ':' and ',' are separators where the line now is. */
bool parse_in_block(const struct command_line *line);

#endif
