/* From the words of a line to what its command takes; see command.h. */
#include "console/commands.h"

#include <string.h>

#include "cds55xx/control_table.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "compiler.h"       // NOINLINE
#include "robot/settings.h" // settings_named()

#define WORDS(name, group, takes, instruction, begin, poll, arguments, what, details, example)     \
    static const CDS_FLASH char words_##name[] = #name "\0" takes;
COMMANDS(WORDS)
#undef WORDS

const CDS_FLASH struct command commands[COMMAND_COUNT] = {
#define ROW(name, group, takes, instruction, begin, poll, arguments, what, details, example)       \
    {words_##name, begin, poll, instruction},
    COMMANDS(ROW)
#undef ROW
};

static const CDS_FLASH char takes_nothing[] = "";

NOINLINE void command_begin(struct command_line *line)
{
    struct cds_request *request = line->request;

    memset(line, 0, sizeof *line);
    line->request = request;
    request->no_retry = false; // until raw_begin()
    line->takes = takes_nothing;
    line->id = CDS_BROADCAST_ID;
}

static bool ends(char c)
{
    return c == '\0' || c == '|' || c == ')';
}

/* Is the word the text at `name`, which ends at a NUL, '|' or ')'? */
static bool is_word(const struct token *token, const CDS_FLASH char *name)
{
    if (token->length > TOKEN_MAX)
        return false;
    for (uint8_t i = 0; i < token->length; i++, name++)
        if (ends(*name) || token->text[i] != *name)
            return false;
    return ends(*name);
}

/* The first letter decides for nearly all of them: the bus must not wait for a list of names. */
uint8_t command_named(const struct token *token)
{
    const CDS_FLASH struct command *row = commands;
    uint8_t kind = 0;

    for (char first = token->text[0]; kind < COMMAND_COUNT; kind++, row++)
        if (*row->words == first && is_word(token, row->words))
            break;
    return kind;
}

/* The functions below return the error of the line that the word is, or 0. */

static uint8_t take_name(struct command_line *line, const struct token *token)
{
    uint8_t kind = command_named(token);

    if (kind == COMMAND_COUNT)
        return ERROR_UNKNOWN_COMMAND;
    line->kind = kind;
    line->takes = commands[kind].words + token->length + 1;
    return 0;
}

/* A number from 0 to `highest`; *byte is 0 if it is none. */
static uint8_t take_byte(const struct token *token, uint8_t highest, uint8_t *byte)
{
    uint16_t value = 0;
    uint8_t error = number_whole(token, highest, &value);

    *byte = (uint8_t)value;
    return error;
}

/* The register is known: the packet can begin, unless it is a READ, which is built at the end. */
static void begin_packet(struct command_line *line)
{
    uint8_t instruction = commands[line->kind].instruction;

    if (instruction == 0)
        return;
    cds_packet_begin(&line->request->packet, line->id, instruction);
    cds_packet_put(&line->request->packet, line->address);
}

static bool is_letter(char c)
{
    return (c | 0x20) >= 'a' && (c | 0x20) <= 'z';
}

static uint8_t take_register(struct command_line *line, const struct token *token)
{
    struct cds_register found;
    uint8_t error = 0;

    if (token->length == 0 || !is_letter(token->text[0])) {
        error = take_byte(token, CDS_TABLE_SIZE - 1, &line->address);
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

/* A value for the register `next`: a byte, or, where registers go by name, as wide as it is. */
static uint8_t take_value(struct command_line *line, const struct token *token)
{
    struct cds_packet *packet = &line->request->packet;
    struct cds_register at;
    uint16_t value = 0;
    uint8_t error;

    if (!cds_register_at(line->next, &at))
        return ERROR_OUT_OF_RANGE;
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

/* A word of a block: the ID, ended by ':', or a byte, ended by ',' or, the last one, by a space. */
static uint8_t take_block(struct command_line *line, const struct token *token, char separator)
{
    bool is_id = line->remaining == 0;
    uint8_t byte;
    uint8_t error = take_byte(token, is_id ? CDS_ID_MAX : 255, &byte);
    char due = ':';

    if (is_id)
        line->remaining = line->length;
    else
        due = --line->remaining ? ',' : ' ';
    cds_packet_put(&line->request->packet, byte);
    line->values = 1;
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
    if (line->values == COMMAND_LIST_MAX)
        return ERROR_TOO_MANY;
    if (memchr(ids, id, line->values))
        return ERROR_TWICE;
    ids[line->values++] = id;
    return 0;
}

/* An angle of a list, kept there as a word. */
static uint8_t take_angle(struct command_line *line, const struct token *token)
{
    uint8_t *word = line->request->packet.bytes + 2 * line->values;
    struct number number;
    uint16_t raw = 0;
    uint8_t error;

    if (line->values == COMMAND_LIST_MAX)
        return ERROR_TOO_MANY;
    error = number_parse(token, &number);
    if (error == 0)
        error = number_within(&number, CDS_UNIT_MDEG, &raw);
    word[0] = (uint8_t)raw;
    word[1] = (uint8_t)(raw >> 8);
    line->values++;
    return error;
}

/* One of the words between '(' and ')'; `takes` ends up at the ')'. */
static uint8_t take_choice(struct command_line *line, const struct token *token)
{
    uint8_t index = 1;

    for (; *line->takes != ')'; line->takes++) {
        if (*line->takes != '(' && *line->takes != '|')
            continue;
        if (is_word(token, line->takes + 1))
            line->choice = index;
        index++;
    }
    return line->choice ? 0 : ERROR_UNKNOWN_WORD;
}

static uint8_t take_command(struct command_line *line, const struct token *token)
{
    line->to = command_named(token);
    return line->to < COMMAND_COUNT ? 0 : ERROR_UNKNOWN_COMMAND;
}

static uint8_t take_setting(struct command_line *line, const struct token *token)
{
    line->to = settings_named(token->text, token->length); // no name is as long as a token
    return line->to < SETTINGS_COUNT ? 0 : ERROR_UNKNOWN_SETTING;
}

static bool repeats(char letter)
{
    return letter == 'v' || letter == 's' || letter == 'l' || letter == 'p';
}

/* Goes on to the letter that this word is for. */
static void find_letter(struct command_line *line, const struct token *token)
{
    bool is_list = *line->takes == 'l' || *line->takes == 'p';

    if (is_list && line->values && line->takes[1] && is_letter(token->text[0]))
        line->takes++;
    while (*line->takes == '?')
        line->takes++;
}

NOINLINE static uint8_t take_letter(struct command_line *line, const struct token *token,
                                    char separator)
{
    switch (*line->takes) {
    case 'i': return take_byte(token, CDS_ID_MAX, &line->id);
    case 'b': return take_byte(token, CDS_BROADCAST_ID, &line->id);
    case 'j': return take_byte(token, CDS_ID_MAX, &line->to);
    case 'r': return take_register(line, token);
    case 'n': return take_length(line, token);
    case 'u': return number_parse(token, &line->number[line->numbers++]);
    case 'c': return take_command(line, token);
    case 'k': return take_setting(line, token);
    case '(': return take_choice(line, token);
    case 'v': return take_value(line, token);
    case 's': return take_block(line, token, separator);
    case 'l': return take_id(line, token);
    case 'p': return take_angle(line, token);
    default: return ERROR_COUNT;
    }
}

void command_word(struct command_line *line, const struct token *token, char separator)
{
    if (line->error)
        return;
    if (line->words == 0) {
        line->error = take_name(line, token);
    } else {
        find_letter(line, token);
        line->error = take_letter(line, token, separator);
        if (*line->takes && !repeats(*line->takes))
            line->takes++;
    }
    if (line->words < UINT8_MAX)
        line->words++;
}

bool command_in_block(const struct command_line *line)
{
    return line->words && *line->takes == 's';
}

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

NOINLINE uint8_t command_end(struct command_line *line)
{
    uint8_t instruction = commands[line->kind].instruction;
    char letter = *line->takes;

    if (line->error)
        return line->error;
    if (letter && letter != '?' && !(repeats(letter) && line->values))
        line->error = ERROR_COUNT;
    else if (line->remaining)
        line->error = ERROR_BLOCK;
    else if (instruction)
        line->error = (uint8_t)finish_packet(line, instruction);
    return line->error;
}
