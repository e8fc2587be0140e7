/* From the words of a line to a packet; see command.h. */
#include "command.h"

#include "cds55xx/control_table.h"
#include "errors.h"

#define STRINGS(name, takes, instruction, arguments, what)                                         \
    static const CDS_FLASH char name_##name[] = #name;                                             \
    static const CDS_FLASH char takes_##name[] = takes;                                            \
    static const CDS_FLASH char usage_##name[] = #name arguments ": " what;
COMMANDS(STRINGS)
#undef STRINGS

const CDS_FLASH struct command commands[COMMAND_COUNT] = {
#define ROW(name, takes, instruction, arguments, what)                                             \
    {name_##name, takes_##name, usage_##name, instruction},
    COMMANDS(ROW)
#undef ROW
};

static const CDS_FLASH char takes_nothing[] = "";

void command_begin(struct command_line *line)
{
    *line = (struct command_line){.request = line->request, .takes = takes_nothing};
}

static void fail(struct command_line *line, uint8_t error)
{
    if (line->error == 0)
        line->error = error;
}

static bool is_named(const struct token *token, const CDS_FLASH char *name)
{
    for (uint8_t i = 0; i < token->length; i++)
        if (token->length > TOKEN_MAX || token->text[i] != *name++)
            return false;
    return *name == '\0';
}

static void take_name(struct command_line *line, const struct token *token)
{
    uint8_t kind = 0;

    while (kind < COMMAND_COUNT && !is_named(token, commands[kind].name))
        kind++;
    if (kind == COMMAND_COUNT) {
        fail(line, ERROR_UNKNOWN_COMMAND);
        return;
    }
    line->kind = kind;
    line->takes = commands[kind].takes;
    line->id = CDS_BROADCAST_ID;
}

/* A number from 0 to `highest`; anything else is an error of the line. */
static uint16_t number(struct command_line *line, const struct token *token, uint16_t highest)
{
    uint16_t value = 0;
    bool too_large;

    if (!token_number(token, &value, &too_large))
        fail(line, ERROR_NOT_A_NUMBER);
    else if (too_large || value > highest)
        fail(line, ERROR_OUT_OF_RANGE);
    return value;
}

/* The register is known: the packet can begin, unless it is a READ, which is built at the end. */
static void begin_packet(struct command_line *line)
{
    struct cds_packet *packet = &line->request->packet;

    cds_packet_begin(packet, line->id, commands[line->kind].instruction);
    cds_packet_put(packet, line->address);
}

static void take_register(struct command_line *line, const struct token *token)
{
    struct cds_register found;
    uint16_t address;
    bool too_large;

    if (token_number(token, &address, &too_large)) {
        address = number(line, token, CDS_TABLE_SIZE - 1);
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
    value = number(line, token, at.highest);
    cds_packet_put(packet, (uint8_t)value);
    if (at.width == 2)
        cds_packet_put(packet, (uint8_t)(value >> 8));
    line->next = (uint8_t)(line->next + at.width);
    line->values++;
}

/* LENGTH of a READ, or of a SYNC WRITE, whose packet says it after the address. */
static void take_length(struct command_line *line, const struct token *token)
{
    line->length = (uint8_t)number(line, token, (uint16_t)(CDS_TABLE_SIZE - line->address));
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
    cds_packet_put(&line->request->packet, (uint8_t)number(line, token, is_id ? CDS_ID_MAX : 255));
    line->values = 1;
}

static void take_argument(struct command_line *line, const struct token *token, char separator)
{
    if (*line->takes == '?')
        line->takes++;
    switch (*line->takes) {
    case 'i': line->id = (uint8_t)number(line, token, CDS_ID_MAX); break;
    case 'b': line->id = (uint8_t)number(line, token, CDS_BROADCAST_ID); break;
    case 'r': take_register(line, token); break;
    case 'n': take_length(line, token); break;
    case 'w': line->word = *token; break;
    case 'u': line->number = number(line, token, UINT16_MAX); break;
    case 'v': take_value(line, token); return; // repeats
    case 's': take_block(line, token, separator); return;
    default: fail(line, ERROR_COUNT); return;
    }
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
    bool repeats = *line->takes == 'v' || *line->takes == 's';

    if (line->error == 0) {
        if (*line->takes && *line->takes != '?' && !(repeats && line->values))
            fail(line, ERROR_COUNT);
        else if (line->remaining)
            fail(line, ERROR_BLOCK);
    }
    if (line->error == 0 && instruction)
        line->error = (uint8_t)finish_packet(line, instruction);
    return line->error;
}
