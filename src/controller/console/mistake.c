/* SPDX-License-Identifier: MIT */
/* Mistakes that have a text of their own; see mistake.h. */
#include "console/mistake.h"

#include <string.h> // memchr(), size_t

#include "cds55xx/control_table.h"   // CDS_REG_GOAL_POSITION
#include "cds55xx/diagnose.h"        // CDS_FINDING_LINE_LOW
#include "cds55xx/packet.h"          // CDS_AT_PARAMETERS
#include "console/commands/shared.h" // register_raw_at(), servos_line_is_low()
#include "console/console.h"
#include "console/errors.h"
#include "console/explain.h"
#include "console/messages.h"
#include "console/noise.h"      // struct noise
#include "console/servo_list.h" // servo_list_is_all()
#include "console/unasked.h"    // unasked_note_error()

static const CDS_FLASH char message_one_servo[] = "one servo here, no list; send a line for each";
static const CDS_FLASH char message_all_is_254[] =
    "this command has no 'all'; ID 254 means all servos on the bus: '%m 254'";
static const CDS_FLASH char message_blank[] = "no space after a comma: 1,2,3";
static const CDS_FLASH char message_reversed[] =
    "the range begins with the larger ID; write the smaller one first";
static const CDS_FLASH char message_comma[] = "write a point, not a comma: ";
static const CDS_FLASH char message_or_spaces[] = ", or spaces between angles";
static const CDS_FLASH char message_no_unit[] =
    "not a unit of this setting; 'settings' shows its unit";
static const CDS_FLASH char message_known_id[] =
    "ID %u is in the robot's list; choose another ID, or 'servos forget'";
static const CDS_FLASH char message_limits[] =
    "its limits are %a to %a and %r; 'turn': set no limits; 'torque on': its goal is beyond "
    "them, or not read: 'info " SERVO_ID "'";
static const CDS_FLASH char message_beyond_angles[] =
    "the angle is not within its limits, %a to %a";
static const CDS_FLASH char message_beyond_speed[] = "'move' needs a SPEED above 0, up to %r";
static const CDS_FLASH char message_its_limits[] = "its limits are %a to %a and %r";
static const CDS_FLASH char message_limit_of_one[] =
    "%s; nothing was sent; 'limits %i LOW HIGH' changes them";
static const CDS_FLASH char message_group_due[] = "no group chosen; 'group";
static const CDS_FLASH char message_not_driven[] =
    "not driven, as it gives no good answer; check its power, plug and rate";

/* Reads digits from *at on, which it moves behind them. Returns the number, or UINT16_MAX if there
 * is none from 0 to 253. */
static uint16_t take_id(const struct token *token, uint8_t *at)
{
    uint8_t begin = *at;
    uint16_t id = 0;

    for (; *at < token->length && (uint8_t)(token->text[*at] - '0') <= 9; ++*at)
        if (id <= CDS_ID_MAX)
            id = (uint16_t)(10 * id + (uint8_t)(token->text[*at] - '0'));
    return *at > begin && id <= CDS_ID_MAX ? id : UINT16_MAX;
}

/* The mistake in a word that should be one ID or a list of IDs. */
static enum mistake mistake_in_list(const struct token *token)
{
    enum mistake mistake = MISTAKE_NONE;

    if (servo_list_is_all(token))
        return MISTAKE_LIST;
    for (uint8_t at = 0; at < token->length; at++) { // the loop leaves ',' out
        uint16_t first = take_id(token, &at), last = first;
        bool is_range = at < token->length && token->text[at] == '-';

        if (is_range) {
            at++;
            last = take_id(token, &at);
        }
        if (first == UINT16_MAX || last == UINT16_MAX ||
            (at < token->length && token->text[at] != ','))
            return MISTAKE_NONE;
        if (first > last)
            return MISTAKE_REVERSED;
        if (is_range || at < token->length)
            mistake = MISTAKE_LIST;
    }
    return mistake;
}

/* True if the word has one comma, digits around it, and at most a minus in front. */
static bool has_decimal_comma(const struct token *token)
{
    uint8_t at = token->text[0] == '-', begin = at;

    while (at < token->length && (uint8_t)(token->text[at] - '0') <= 9)
        at++;
    return at > begin && at + 1 < token->length && token->text[at] == ',' &&
           (uint8_t)(token->text[at + 1] - '0') <= 9 &&
           memchr(token->text + at + 1, ',', (size_t)(token->length - at - 1)) == NULL;
}

static bool is_id_argument(uint8_t argument)
{
    return argument == ARGUMENT_ID || argument == ARGUMENT_ID_OR_ALL || argument == ARGUMENT_IDS ||
           argument == ARGUMENT_NEW_ID;
}

/* True if the servo that the error is about is OFFLINE. */
static bool concerns_offline_servo(const struct console *console)
{
    const struct cds_servo_state *servo =
        cds_servos_find(&console->robot->servos, explain_servo(console));

    return servo && servo->presence == CDS_PRESENCE_OFFLINE;
}

bool mistake_is_noise(uint8_t error)
{
    return command_set.noise->is_there &&
           (error == CDS_TIMEOUT || error == CDS_CORRUPT || error == CDS_LINE_BUSY ||
            error == CDS_NO_REPLY_DUE); // lost replies made its level 0: health.c
}

const CDS_FLASH char *mistake_noise_text(uint8_t error)
{
    return diagnose_findings[error == CDS_LINE_BUSY ? CDS_FINDING_BABBLE : CDS_FINDING_NOISE];
}

/* The mistakes whose text is not in advice.h. */
static enum mistake seen_mistake(const struct console *console, bool is_of_word)
{
    const struct command_line *line = &console->line;
    const struct token *token = &console->token;
    const struct cds_servo_state *servo = console_servo(console);
    enum mistake mistake;

    if (command_set.noise && mistake_is_noise(console->error))
        return MISTAKE_NOISE;
    if (command_set.motion_words && console->error == ERROR_NO_GROUP &&
        command_set.motion_words->has_poses())
        return MISTAKE_GROUP;
    if ((console->error == CDS_TIMEOUT ||
         (command_set.advise && console->error == ERROR_PLACE_TAKEN &&
          !line->command->instruction)) && // an instruction: refused by the permit
        servo &&
        servo_is_at_other_rate(console, servo))
        return MISTAKE_RATE;
    if (console->error == CDS_INHIBITED && concerns_offline_servo(console)) {
        if (command_set.noise && mistake_is_noise(CDS_TIMEOUT))
            return MISTAKE_NOISE;
        return servos_line_is_low(&console->robot->servos) ? MISTAKE_LINE : MISTAKE_OFFLINE;
    }
    if (console->error == CDS_LINE_BUSY && servos_line_is_low(&console->robot->servos))
        return MISTAKE_LINE;
    if (console->error == CDS_LIMIT && line->id != line->new_id &&
        cds_servos_find(&console->robot->servos, line->new_id))
        return MISTAKE_KNOWN_ID;
    if (console->error == CDS_LIMIT) {
        servo = explain_limited(console);
        if (servo && servo->has_limits)
            return MISTAKE_LIMITS;
    }
    if (console->error == ERROR_COUNT && line->command)
        return MISTAKE_COUNT;
    if (!command_set.advise && console->error == ERROR_UNIT && line->command &&
        explain_is_settings(line))
        return MISTAKE_UNIT;
    if (!is_of_word || token->length > TOKEN_MAX || line->command == NULL)
        return MISTAKE_NONE;
    if (is_id_argument(line->argument)) {
        mistake = mistake_in_list(token);
        if (mistake == MISTAKE_LIST && (line->is_repeated || line->argument == ARGUMENT_IDS))
            return token->text[token->length - 1] == ',' ? MISTAKE_BLANK : MISTAKE_NONE;
        return console->error == (mistake == MISTAKE_LIST ? ERROR_NOT_A_NUMBER : ERROR_OUT_OF_RANGE)
                   ? mistake
                   : MISTAKE_NONE;
    }
    return (console->error == ERROR_UNIT || console->error == ERROR_NOT_A_NUMBER) &&
                   (line->argument == ARGUMENT_NUMBER || line->argument == ARGUMENT_ANGLES) &&
                   has_decimal_comma(token)
               ? MISTAKE_COMMA
               : MISTAKE_NONE;
}

enum mistake mistake_of(struct console *console, bool is_of_word)
{
    enum mistake mistake = seen_mistake(console, is_of_word);

    return command_set.advise &&
                   (mistake == MISTAKE_NONE || mistake == MISTAKE_COUNT ||
                    mistake == MISTAKE_LIMITS ||
                    (command_set.has_room && mistake == MISTAKE_BLANK &&
                     console->line.argument != ARGUMENT_IDS)) &&
                   command_set.advise(console)
               ? MISTAKE_ADVISED
               : mistake;
}

void mistake_print_with_point(struct console *console)
{
    const struct token *token = &console->token;

    for (uint8_t i = 0; i < token->length; i++)
        printer_char(&console->printer, token->text[i] == ',' ? '.' : token->text[i]);
    printer_line(&console->printer,
                 console->line.argument == ARGUMENT_ANGLES ? message_or_spaces : message_nothing);
}

/* Prints which limit a goal of `move` or `set` breaks, or all limits for another packet. */
static void print_limits(struct console *console)
{
    const struct cds_servo_state *servo = explain_limited(console);
    const uint8_t *bytes = console->line.request->packet.bytes;
    bool is_other_servo = command_set.has_room && servo->id != console->line.id;
    union printer_value *values = console->printer.values + is_other_servo;
    const CDS_FLASH char *message = is_other_servo ? message_its_limits : message_limits;
    uint16_t goal = register_raw_at(bytes + CDS_AT_PARAMETERS + 1, 2);

    values[0].number = servo->lowest;
    values[1].number = servo->highest;
    values[2].number = servo->fastest;
    if (console->line.numbers && bytes[CDS_AT_PARAMETERS] == CDS_REG_GOAL_POSITION) {
        message = message_beyond_angles;
        if (goal >= servo->lowest && goal <= servo->highest) {
            message = message_beyond_speed;
            values[0].number = servo->fastest;
        }
    }
    if (is_other_servo) {
        console->printer.values[0].text = message;
        message = message_limit_of_one;
    }
    printer_set_id(&console->printer, servo->id);
    printer_line(&console->printer, message);
}

static const CDS_FLASH char *const CDS_FLASH mistake_texts[] = {
    [MISTAKE_LIST] = message_one_servo,    [MISTAKE_BLANK] = message_blank,
    [MISTAKE_REVERSED] = message_reversed, [MISTAKE_UNIT] = message_no_unit,
    [MISTAKE_KNOWN_ID] = message_known_id, [MISTAKE_COUNT] = message_usage_due,
    [MISTAKE_RATE] = message_at_rate,      [MISTAKE_OFFLINE] = message_not_driven,
};

/* The advice for these errors has a remedy: an alarm behind it need not repeat one. */
static void print_advice(struct console *console)
{
    bool is_told = console->error == CDS_TIMEOUT || console->error == ERROR_SERVO_RANGE ||
                   console->error == ERROR_SERVO_ANGLE;

    if (command_set.unasked && is_told)
        unasked_note_error(command_set.unasked, console->error);
    printer_line(&console->printer, command_set.advise(console));
}

/* `write all LED 1`. The servos that answer `ping 254` disturb each other. */
static bool means_254(const struct console *console)
{
    const struct command_line *line = &console->line;

    return line->argument == ARGUMENT_ID_OR_ALL && line->command->instruction != CDS_PING &&
           servo_list_is_all(&console->token);
}

void mistake_print(struct console *console, enum mistake mistake)
{
    union printer_value *values = console->printer.values;

    if (command_set.has_room && mistake == MISTAKE_LIST && means_254(console)) {
        printer_line(&console->printer, message_all_is_254);
        return;
    }
    if (mistake == MISTAKE_COUNT) {
        values[0].text = console->line.command->usage;
        values[1].text = console->line.is_repeated && console->line.numbers > 1 ? message_one_word
                                                                                : message_nothing;
    } else if (mistake == MISTAKE_RATE) {
        values[0].number = console_servo(console)->baud_reg;
    } else {
        values[0].number = console->line.new_id;
    }
    if (command_set.motion_words && mistake == MISTAKE_GROUP)
        printer_text(&console->printer, message_group_due);
    else if (mistake == MISTAKE_COMMA)
        printer_text(&console->printer, message_comma);
    else if (mistake == MISTAKE_LIMITS)
        print_limits(console);
    else if (command_set.advise && mistake == MISTAKE_ADVISED)
        print_advice(console);
    else if (command_set.noise && mistake == MISTAKE_NOISE)
        printer_line(&console->printer, mistake_noise_text(console->error));
    else
        printer_line(&console->printer, mistake == MISTAKE_LINE
                                            ? diagnose_findings[CDS_FINDING_LINE_LOW]
                                            : mistake_texts[mistake]);
}
