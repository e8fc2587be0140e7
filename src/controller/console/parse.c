/* SPDX-License-Identifier: MIT */
/* From the words of a line to what its command takes; see parse.h. */
#include "console/parse.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/control_table.h"
#include "compiler.h" // NOINLINE
#include "console/errors.h"
#include "console/servo_list.h" // servo_list_is_all()
#include "robot/letter.h"
#include "robot/settings.h" // settings_named()

static const CDS_FLASH struct argument_name {
    const CDS_FLASH char *name;
    uint8_t argument;
} arguments[] = {
    {FLASH_TEXT("ID"), ARGUMENT_ID},
    {FLASH_TEXT("OLD"), ARGUMENT_ID},
    {FLASH_TEXT("ID|254"), ARGUMENT_ID_OR_ALL},
    {FLASH_TEXT("NEW"), ARGUMENT_NEW_ID},
    {FLASH_TEXT("REG"), ARGUMENT_REGISTER},
    {FLASH_TEXT("LENGTH"), ARGUMENT_LENGTH},
    {FLASH_TEXT("COMMAND"), ARGUMENT_COMMAND},
    {FLASH_TEXT("SETTING"), ARGUMENT_SETTING},
    {FLASH_TEXT("NAME"), ARGUMENT_NAME},
    {FLASH_TEXT("POSE"), ARGUMENT_NAME},
    {FLASH_TEXT("VALUE..."), ARGUMENT_VALUES},
    {FLASH_TEXT("ID:BYTE,..."), ARGUMENT_BLOCKS},
    {FLASH_TEXT("ID..."), ARGUMENT_IDS},
    {FLASH_TEXT("ANGLE..."), ARGUMENT_ANGLES},
};

#define ARGUMENTS (sizeof arguments / sizeof arguments[0])

NOINLINE void parse_begin(struct command_line *line)
{
    struct cds_request *request = line->request;

    memset(line, 0, sizeof *line);
    line->request = request;
    request->no_retry = false; // raw_begin() sets it
    line->usage = message_nothing;
    line->id = line->new_id = CDS_BROADCAST_ID;
}

/* ---- the usage string ---- */

/* True at the end of an argument. */
static bool ends(char c)
{
    return c == '\0' || c == ' ' || c == ']';
}

static bool is_capital(char c)
{
    return c >= 'A' && c <= 'Z';
}

/* The words of usage strings have small letters and '-', which this bit makes of capitals and
 * keeps: so a token may have any case. */
#define SMALL 0x20

NOINLINE uint8_t parse_choice(const CDS_FLASH char *usage, const struct token *token)
{
    uint8_t index = 1, same = 0; // characters of the token that the word begins with

    for (;; usage++) {
        char c = *usage;

        if (c == '|' || ends(c)) {
            if (same == token->length)
                return index;
            if (c != '|')
                return 0;
            index++;
            same = 0;
        } else if (same < TOKEN_MAX && (token->text[same] | SMALL) == c) {
            same++;
        } else {
            same = UINT8_MAX; // another word
        }
    }
}

bool parse_has_name(const CDS_FLASH char *usage, const CDS_FLASH char *name)
{
    while (*name && *usage == *name) {
        usage++;
        name++;
    }
    return *name == '\0' && ends(*usage);
}

uint8_t parse_argument_at(const CDS_FLASH char *usage)
{
    while (*usage == '[')
        usage++;
    if (!is_capital(*usage))
        return ARGUMENT_NONE;
    for (const CDS_FLASH struct argument_name *row = arguments; row < arguments + ARGUMENTS; row++)
        if (parse_has_name(usage, row->name))
            return row->argument;
    return ARGUMENT_NUMBER;
}

/* The argument behind the one at `usage`, or the end. */
static const CDS_FLASH char *behind(const CDS_FLASH char *usage)
{
    while (!ends(*usage))
        usage++;
    while (*usage == ' ' || *usage == ']')
        usage++;
    return usage;
}

const CDS_FLASH char *parse_number_name(const struct command_line *line, uint8_t index)
{
    const CDS_FLASH char *usage = line->command->usage;

    while (*usage) {
        if (parse_argument_at(usage) == ARGUMENT_NUMBER && index-- == 0)
            break;
        usage = behind(usage);
    }
    while (*usage == '[')
        usage++;
    return usage;
}

void parse_next_argument(struct command_line *line)
{
    line->usage = behind(line->usage);
    line->argument = parse_argument_at(line->usage);
}

bool parse_at_register(const struct command_line *line)
{
    return line->argument == ARGUMENT_REGISTER;
}

bool parse_at_number(const struct command_line *line)
{
    return line->argument == ARGUMENT_NUMBER || line->argument == ARGUMENT_NEW_ID;
}

/* True if the argument at `usage`, an enum argument, may be the token. Of the arguments in capitals
 * only a name begins with a letter where another row has something else. */
static bool takes(const CDS_FLASH char *usage, uint8_t argument, const struct token *token)
{
    while (*usage == '[')
        usage++;
    if (argument == ARGUMENT_NONE)
        return parse_choice(usage, token);
    if (argument < ARGUMENT_SETTING) // no row has anything else at its place: saves the search
        return true;
    return is_letter(token->text[0]) == (argument == ARGUMENT_NAME);
}

/* The first row whose usage begins with the text from `begin` to `end` (NULL: no text) and takes
 * the token next, or NULL. Compares two letters first, because a full comparison of each row delays
 * the bus. */
static const CDS_FLASH struct command *
find_row(const CDS_FLASH char *begin, const CDS_FLASH char *end, const struct token *token)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;
    char first = end ? begin[0] : (char)(token->text[0] | SMALL);
    char second = end ? begin[1] : (char)(token->text[1] | SMALL); // of a token of one letter: any

    for (; *group; group++) {
        const CDS_FLASH struct command *row = (*group)->rows;

        for (uint8_t left = (*group)->count; left; left--, row++) {
            const CDS_FLASH char *usage = row->usage, *other = begin;

            if (usage[0] != first || usage[1] != second)
                continue;
            for (; other < end && *usage == *other; usage++)
                other++;
            if (other == end && takes(usage, parse_argument_at(usage), token))
                return row;
        }
    }
    return NULL;
}

const CDS_FLASH struct command *parse_command(const struct token *token)
{
    return find_row(NULL, NULL, token);
}

bool parse_is_keyword(const CDS_FLASH char *usage, const struct token *token)
{
    while (*usage) {
        while (*usage == '[')
            usage++;
        if (!is_capital(*usage) && parse_choice(usage, token))
            return true;
        usage = behind(usage);
    }
    return false;
}

/* ---- words: these functions return the error of the line that the word is, or 0 ---- */

static uint8_t take_command(struct command_line *line, const struct token *token)
{
    line->command = parse_command(token);
    if (token->length == 1 && *token->text == '?')
        line->command = &command_set.groups[0]->rows[0]; // help: the first row of each set
    if (line->command == NULL)
        return ERROR_UNKNOWN_COMMAND;
    line->usage = line->command->usage;
    parse_next_argument(line);
    return 0;
}

/* A number from 0 to `highest`; *byte is 0 if it is none. */
static uint8_t take_byte(const struct token *token, uint8_t highest, uint8_t *byte)
{
    uint16_t value = 0;
    uint8_t error;

    /* A long SYNC WRITE has many digits: this saves 7 % of the time to read it. The profile
     * `console` has no flash for it. */
    if (command_set.typing && token->length == 1 && highest >= 9 &&
        (uint8_t)(token->text[0] - '0') <= 9) {
        *byte = (uint8_t)(token->text[0] - '0');
        return 0;
    }
    error = number_whole(token, highest, &value);
    *byte = (uint8_t)value;
    return error;
}

/* An ID. In a profile with lists of servos the ID may be a list, but not in a packet. */
static uint8_t take_servo(struct command_line *line, const struct token *token, uint8_t highest)
{
    if (command_set.lists && !line->command->instruction)
        return command_set.lists->take(line, token, highest);
    return take_byte(token, highest, &line->id);
}

/* The register is known: begins the packet. A READ is built anew at the end of the line. */
static void begin_packet(struct command_line *line)
{
    uint8_t instruction = line->command->instruction;

    if (instruction == 0)
        return;
    cds_packet_begin(&line->request->packet, line->id, instruction);
    cds_packet_put(&line->request->packet, line->address);
}

static uint8_t take_register(struct command_line *line, const struct token *token)
{
    struct cds_register found;
    uint8_t error = 0;

    if (token->length == 0 || !is_letter(token->text[0])) {
        error = take_byte(token, CDS_TABLE_SIZE - 1, &line->address);
        if (error == ERROR_NOT_A_NUMBER)
            return ERROR_UNKNOWN_REGISTER;
        line->length = 1;
    } else if (token->length <= TOKEN_MAX &&
               cds_register_named(token->text, token->length, &found)) {
        line->address = found.address;
        line->length = found.width;
        line->named = true;
    } else {
        return ERROR_UNKNOWN_REGISTER;
    }
    line->next = line->address;
    begin_packet(line);
    return error;
}

/* A value for the register `next`: a byte, or, if registers go by name, as wide as the register. */
static uint8_t take_value(struct command_line *line, const struct token *token)
{
    struct cds_packet *packet = &line->request->packet;
    struct cds_register at;
    uint16_t value = 0;
    uint8_t error;

    if (!cds_register_at(line->next, &at))
        return ERROR_COUNT;
    if (!line->named) {
        at.width = 1;
        at.highest = 255;
    }
    error = number_whole(token, at.highest, &value);
    cds_packet_put(packet, (uint8_t)value);
    if (at.width == 2)
        cds_packet_put(packet, (uint8_t)(value >> 8));
    line->next = (uint8_t)(line->next + at.width);
    line->values++;
    return error;
}

/* LENGTH of a READ, or of a SYNC WRITE, whose packet says it after the address. */
static uint8_t take_length(struct command_line *line, const struct token *token)
{
    uint8_t error = take_byte(token, (uint8_t)(CDS_TABLE_SIZE - line->address), &line->length);

    cds_packet_put(&line->request->packet, line->length);
    return error == 0 && line->length == 0 ? (uint8_t)ERROR_OUT_OF_RANGE : error;
}

/* True if a block before this one has the ID. */
static bool is_twice(const struct command_line *line, uint8_t id)
{
    const uint8_t *begin = line->request->packet.bytes + CDS_AT_PARAMETERS + 2;
    const uint8_t *end = begin + CDS_LENGTH_MAX - CDS_AT_PARAMETERS;

    for (uint8_t left = line->values; left && begin < end; left--) {
        if (*begin == id)
            return true;
        begin += line->length + 1;
    }
    return false;
}

/* A word of a block: the ID, ended by ':', or a byte, ended by ',' or, the last one, by a space. */
static uint8_t take_block(struct command_line *line, const struct token *token, char separator)
{
    bool is_id = line->remaining == 0;
    uint8_t byte;
    uint8_t error = take_byte(token, is_id ? CDS_ID_MAX : 255, &byte);
    char due = ':';

    if (is_id) {
        if (command_set.explain &&
            is_twice(line, byte)) // the profile `console` has no flash for it
            error = ERROR_TWICE;
        line->remaining = line->length;
        line->values++;
    } else {
        due = --line->remaining ? ',' : ' ';
    }
    cds_packet_put(&line->request->packet, byte);
    return separator == due ? error : (uint8_t)ERROR_BLOCK;
}

/* An ID of a list, kept in the request's buffer. */
static uint8_t take_id(struct command_line *line, const struct token *token)
{
    uint8_t *ids = line->request->packet.bytes;
    uint8_t id;
    uint8_t error = take_byte(token, CDS_ID_MAX, &id);

    if (error)
        return error;
    if (line->values == PARSE_LIST_MAX)
        return ERROR_TOO_MANY;
    if (memchr(ids, id, line->values))
        return ERROR_TWICE;
    ids[line->values++] = id;
    return 0;
}

/* An angle of a list, kept in the request's buffer as a word. */
static uint8_t take_angle(struct command_line *line, const struct token *token)
{
    uint8_t *word = line->request->packet.bytes + 2 * line->values;
    struct number number;
    uint16_t raw = 0;
    uint8_t error;

    if (line->values == PARSE_LIST_MAX)
        return ERROR_TOO_MANY;
    error = number_parse(token, &number);
    if (error == 0)
        error = number_within(&number, CDS_UNIT_MDEG, &raw);
    word[0] = (uint8_t)raw;
    word[1] = (uint8_t)(raw >> 8);
    line->values++;
    return error;
}

/* One of the words at line->usage. */
static uint8_t take_choice(struct command_line *line, const struct token *token)
{
    uint8_t choice = parse_choice(line->usage, token);

    if (line->choice == 0)
        line->choice = choice;
    return choice ? 0 : ERROR_UNKNOWN_WORD;
}

/* True if the token is one of the words of the heading, in any case. parse_choice() has other ends
 * of words: one function for both costs the profile `console` 12 bytes. */
static bool is_in_heading(const CDS_FLASH char *heading, const struct token *token)
{
    uint8_t same = 0; // characters of the token that the word begins with

    do {
        if (*heading == ' ' || *heading == ':') {
            if (same == token->length)
                return true;
            same = 0;
        } else if (same < TOKEN_MAX && ((*heading ^ token->text[same]) & ~SMALL) == 0) {
            same++;
        } else {
            same = UINT8_MAX; // another word
        }
    } while (*heading++ != ':');
    return false;
}

/* `help safety` lists the rows below this heading: the topic is the first row. `help the bus`: the
 * first heading that contains all words so far. */
static uint8_t take_heading(struct command_line *line, const struct token *token)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;
    const CDS_FLASH struct command *found = NULL;
    uint8_t *contains = line->request->packet.bytes; // all words so far: of each group

    for (; *group; group++, contains++) {
        *contains = (*group)->heading && (line->choice != TOPIC_HEADING || *contains) &&
                    is_in_heading((*group)->heading, token);
        if (*contains && !found)
            found = (*group)->rows;
    }
    if (!found)
        return ERROR_COUNT;
    line->topic = found;
    line->choice = TOPIC_HEADING;
    return 0;
}

/* What is no command: a heading, the units, the keys, or all commands. */
static void take_other_topic(struct command_line *line, const struct token *token)
{
    static const CDS_FLASH char units[] = "units|unit|degrees|deg|steps|raw|rpm";
    static const CDS_FLASH char keys[] = "keys|key|tab";
    uint8_t topic = TOPIC_COMMAND;

    if (command_set.has_room && parse_choice(keys, token))
        topic = TOPIC_KEYS;
    else if (command_set.has_room && servo_list_is_all(token))
        topic = TOPIC_ALL;
    else if (parse_choice(units, token))
        topic = TOPIC_UNITS;
    else
        take_heading(line, token);
    if (topic) {
        line->topic = line->command;
        line->choice = topic;
    }
}

static uint8_t take_topic(struct command_line *line, const struct token *token)
{
    line->topic = parse_command(token);
    if (command_set.advise && !line->topic)
        take_other_topic(line, token);
    return line->topic ? 0 : ERROR_UNKNOWN_COMMAND;
}

/* A word behind the end of the usage: one more of a heading, or too many. */
static uint8_t take_more(struct command_line *line, const struct token *token)
{
    return command_set.advise && line->choice == TOPIC_HEADING && line->topic
               ? take_heading(line, token)
               : (uint8_t)ERROR_COUNT;
}

static uint8_t take_setting(struct command_line *line, const struct token *token)
{
    line->setting = settings_named(token->text, token->length); // no name is as long as a token
    return line->setting < SETTINGS_COUNT ? 0 : ERROR_UNKNOWN_SETTING;
}

/* A name that the user gives, kept at the end of the request's buffer. */
static uint8_t take_name(struct command_line *line, const struct token *token)
{
    char *name = parse_name(line, line->names++);

    memcpy(name, token->text, PARSE_NAME_SIZE);
    if (token->length < PARSE_NAME_SIZE)
        name[token->length] = '\0';
    return 0;
}

NOINLINE static uint8_t take_argument(struct command_line *line, const struct token *token,
                                      char separator)
{
    switch (line->argument) {
    case ARGUMENT_ID: return take_servo(line, token, CDS_ID_MAX);
    case ARGUMENT_ID_OR_ALL: return take_servo(line, token, CDS_BROADCAST_ID);
    case ARGUMENT_NEW_ID: return take_byte(token, CDS_ID_MAX, &line->new_id);
    case ARGUMENT_REGISTER: return take_register(line, token);
    case ARGUMENT_LENGTH: return take_length(line, token);
    case ARGUMENT_COMMAND: return take_topic(line, token);
    case ARGUMENT_SETTING: return take_setting(line, token);
    case ARGUMENT_NAME: return take_name(line, token);
    case ARGUMENT_NUMBER: return number_parse(token, &line->number[line->numbers++]);
    case ARGUMENT_VALUES: return take_value(line, token);
    case ARGUMENT_BLOCKS: return take_block(line, token, separator);
    case ARGUMENT_IDS:
        return command_set.lists ? command_set.lists->take_word(line, token) : take_id(line, token);
    case ARGUMENT_ANGLES: return take_angle(line, token);
    default: return *line->usage ? take_choice(line, token) : take_more(line, token);
    }
}

static bool repeats(const struct command_line *line)
{
    return line->argument >= ARGUMENT_VALUES;
}

/* Goes on with the first row that takes this word, if the present one does not. Up to here the two
 * read the same. */
static void choose_row(struct command_line *line, const struct token *token)
{
    uint8_t same = (uint8_t)(line->usage - line->command->usage);
    const CDS_FLASH struct command *row;

    if (takes(line->usage, line->argument, token))
        return;
    row = find_row(line->command->usage, line->usage, token);
    if (row == NULL)
        return;
    line->command = row;
    line->usage = row->usage + same;
    line->argument = parse_argument_at(line->usage);
}

void parse_end_list(struct command_line *line)
{
    if (line->argument >= ARGUMENT_IDS && line->values)
        parse_next_argument(line);
}

/* Goes on to the argument that this word is for: a word ends a list of numbers. */
static void find_argument(struct command_line *line, const struct token *token)
{
    if (is_letter(token->text[0]))
        parse_end_list(line);
    choose_row(line, token);
    while (*line->usage == '[')
        line->usage++;
}

void parse_word(struct command_line *line, const struct token *token, char separator)
{
    if (line->error)
        return;
    if (line->words == 0) {
        line->error = take_command(line, token);
    } else if (command_set.lists && line->list_is_open && command_set.lists->goes_on(line, token)) {
        line->error = command_set.lists->take_word(line, token);
    } else if (line->error == 0) { // goes_on() may have found one
        find_argument(line, token);
        line->error = take_argument(line, token, separator);
        if (!repeats(line) && !(command_set.explain && line->error)) // it names the argument
            parse_next_argument(line);
    }
    if (line->words < UINT8_MAX)
        line->words++;
}

bool parse_in_block(const struct command_line *line)
{
    return line->argument == ARGUMENT_BLOCKS;
}

/* ---- the end of the line ---- */

/* Number of parameters due in the reply. */
static uint8_t reply_of(const struct command_line *line, uint8_t instruction)
{
    if (instruction == CDS_PING)
        return 0;
    if (line->id == CDS_BROADCAST_ID || instruction == CDS_SYNC_WRITE)
        return CDS_REPLY_NONE;
    return instruction == CDS_READ ? line->length : 0;
}

/* Completes the packet of a command that has one. */
static enum cds_result finish_packet(struct command_line *line, uint8_t instruction)
{
    struct cds_packet *packet = &line->request->packet;

    line->request->reply_parameters = reply_of(line, instruction);
    switch (instruction) {
    case CDS_PING: return cds_packet_ping(packet, line->id);
    case CDS_ACTION: return cds_packet_action(packet, line->id);
    case CDS_RESET: return cds_packet_reset(packet, line->id);
    case CDS_READ: return cds_packet_read(packet, line->id, line->address, line->length);
    default: return cds_packet_end(packet);
    }
}

/* True if no argument is missing. */
static bool is_complete(const struct command_line *line)
{
    char next = *line->usage;

    return next == '\0' || next == '[' || (repeats(line) && line->values);
}

/* True if the usage begins with the arguments that the line has, and needs no more. */
static bool needs_no_more(const CDS_FLASH char *usage, const struct command_line *line)
{
    const CDS_FLASH char *end = line->usage - 1; // the space before the argument that is missing

    for (const CDS_FLASH char *at = line->command->usage; at < end; at++, usage++) {
        while (*usage == '[')
            usage++;
        if (*usage != *at)
            return false;
    }
    return *usage == '\0' || *usage == ']' || (*usage == ' ' && usage[1] == '[');
}

/* `limits 1`: arguments of "limits ID LOW HIGH" are missing, so takes the row "limits [ID]".
 * Searches all rows, though only `limits` has such a row. False: there is none. */
static bool choose_shorter_row(struct command_line *line)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;

    for (; *group; group++) {
        const CDS_FLASH struct command *row = (*group)->rows;

        for (uint8_t left = (*group)->count; left; left--, row++)
            if (needs_no_more(row->usage, line)) {
                line->command = row;
                line->usage = message_nothing;
                return true;
            }
    }
    return false;
}

NOINLINE uint8_t parse_end(struct command_line *line)
{
    if (line->error)
        return line->error;
    if (command_set.lists)
        command_set.lists->end(line);
    if (line->error)
        return line->error;
    if (!is_complete(line) && !(command_set.has_room && choose_shorter_row(line)))
        line->error = ERROR_COUNT;
    else if (line->remaining)
        line->error = ERROR_BLOCK;
    else if (line->command->instruction)
        line->error = (uint8_t)finish_packet(line, line->command->instruction);
    return line->error;
}
