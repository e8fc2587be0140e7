/* From the words of a line to what its command takes; see command.h. */
#include "commands.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/control_table.h"
#include "errors.h"
#include "handlers.h"

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

void command_begin(struct command_line *line)
{
    struct cds_request *request = line->request;

    memset(line, 0, offsetof(struct command_line, number));
    line->word.length = 0;
    line->request = request;
    line->takes = takes_nothing;
    line->id = CDS_BROADCAST_ID;
}

static void fail(struct command_line *line, uint8_t error)
{
    if (line->error == 0)
        line->error = error;
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

static void take_name(struct command_line *line, const struct token *token)
{
    uint8_t kind = command_named(token);

    if (kind == COMMAND_COUNT) {
        fail(line, ERROR_UNKNOWN_COMMAND);
        return;
    }
    line->kind = kind;
    line->takes = commands[kind].words + token->length + 1;
}

/* A number from 0 to `highest`; anything else is an error of the line. */
static uint16_t whole(struct command_line *line, const struct token *token, uint16_t highest)
{
    uint16_t value = 0;

    fail(line, number_whole(token, highest, &value));
    return value;
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

static void take_register(struct command_line *line, const struct token *token)
{
    struct cds_register found;
    uint16_t address;

    if (token->length == 0 || !is_letter(token->text[0])) {
        address = whole(line, token, CDS_TABLE_SIZE - 1);
        line->length = 1;
    } else if (token->length <= TOKEN_MAX &&
               cds_register_named(token->text, token->length, &found)) {
        address = found.address;
        line->length = found.width;
        line->named = true;
    } else {
        fail(line, ERROR_UNKNOWN_REGISTER);
        return;
    }
    line->address = line->next = (uint8_t)address;
    begin_packet(line);
}

/* A value for the register `next`: a byte, or, where registers go by name, as wide as it is. */
static void take_value(struct command_line *line, const struct token *token)
{
    struct cds_packet *packet = &line->request->packet;
    struct cds_register at = {.width = 1, .highest = 255};
    uint16_t value;

    if (!cds_register_at(line->next, &at)) {
        fail(line, ERROR_OUT_OF_RANGE);
        return;
    }
    if (!line->named) {
        at.width = 1;
        at.highest = 255;
    }
    value = whole(line, token, at.highest);
    cds_packet_put(packet, (uint8_t)value);
    if (at.width == 2)
        cds_packet_put(packet, (uint8_t)(value >> 8));
    line->next = (uint8_t)(line->next + at.width);
    line->values++;
}

/* LENGTH of a READ, or of a SYNC WRITE, whose packet says it after the address. */
static void take_length(struct command_line *line, const struct token *token)
{
    line->length = (uint8_t)whole(line, token, (uint16_t)(CDS_TABLE_SIZE - line->address));
    if (line->length == 0)
        fail(line, ERROR_OUT_OF_RANGE);
    cds_packet_put(&line->request->packet, line->length);
}

/* A word of a block: the ID, ended by ':', or a byte, ended by ',' or, the last one, by a space. */
static void take_block(struct command_line *line, const struct token *token, char separator)
{
    bool is_id = line->remaining == 0;
    char due;

    if (is_id) {
        line->remaining = line->length;
        due = ':';
    } else {
        due = --line->remaining ? ',' : ' ';
    }
    if (separator != due)
        fail(line, ERROR_BLOCK);
    cds_packet_put(&line->request->packet, (uint8_t)whole(line, token, is_id ? CDS_ID_MAX : 255));
    line->values = 1;
}

/* An ID of a list, kept in the request's buffer. */
static void take_id(struct command_line *line, const struct token *token)
{
    uint8_t *ids = line->request->packet.bytes;
    uint8_t id = (uint8_t)whole(line, token, CDS_ID_MAX);

    if (line->values == COMMAND_LIST_MAX) {
        fail(line, ERROR_TOO_MANY);
        return;
    }
    for (uint8_t i = 0; i < line->values; i++)
        if (ids[i] == id)
            fail(line, ERROR_TWICE);
    ids[line->values++] = id;
}

/* An angle of a list, kept there as a word. */
static void take_angle(struct command_line *line, const struct token *token)
{
    uint8_t *words = line->request->packet.bytes;
    struct number number;
    uint16_t raw = 0;

    if (line->values == COMMAND_LIST_MAX) {
        fail(line, ERROR_TOO_MANY);
        return;
    }
    fail(line, number_parse(token, &number));
    if (line->error == 0)
        fail(line, number_register(&number, CDS_UNIT_MDEG, &raw));
    if (raw > CDS_VALUE_MAX)
        fail(line, ERROR_OUT_OF_RANGE);
    words[2 * line->values] = (uint8_t)raw;
    words[2 * line->values + 1] = (uint8_t)(raw >> 8);
    line->values++;
}

/* One of the words between '(' and ')'; `takes` ends up at the ')'. */
static void take_choice(struct command_line *line, const struct token *token)
{
    uint8_t index = 1;

    for (; *line->takes != ')'; line->takes++) {
        if (*line->takes != '(' && *line->takes != '|')
            continue;
        if (is_word(token, line->takes + 1))
            line->choice = index;
        index++;
    }
    if (line->choice == 0)
        fail(line, ERROR_UNKNOWN_WORD);
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

static void take_argument(struct command_line *line, const struct token *token, char separator)
{
    find_letter(line, token);
    switch (*line->takes) {
    case 'i': line->id = (uint8_t)whole(line, token, CDS_ID_MAX); break;
    case 'b': line->id = (uint8_t)whole(line, token, CDS_BROADCAST_ID); break;
    case 'j': line->to = (uint8_t)whole(line, token, CDS_ID_MAX); break;
    case 'r': take_register(line, token); break;
    case 'n': take_length(line, token); break;
    case 'u': fail(line, number_parse(token, &line->number[line->numbers++])); break;
    case 'w': line->word = *token; break;
    case '(': take_choice(line, token); break;
    case 'v': take_value(line, token); break;
    case 's': take_block(line, token, separator); break;
    case 'l': take_id(line, token); break;
    case 'p': take_angle(line, token); break;
    default: fail(line, ERROR_COUNT); return;
    }
    if (!repeats(*line->takes))
        line->takes++;
}

void command_word(struct command_line *line, const struct token *token, char separator)
{
    if (line->error)
        return;
    if (line->words == 0)
        take_name(line, token);
    else
        take_argument(line, token, separator);
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

uint8_t command_end(struct command_line *line)
{
    uint8_t instruction = commands[line->kind].instruction;
    char letter = *line->takes;

    if (line->error == 0) {
        if (letter && letter != '?' && !(repeats(letter) && line->values))
            fail(line, ERROR_COUNT);
        else if (line->remaining)
            fail(line, ERROR_BLOCK);
    }
    if (line->error == 0 && instruction)
        line->error = (uint8_t)finish_packet(line, instruction);
    return line->error;
}
