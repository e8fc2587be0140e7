/* status, alarms, clear, settings, save, defaults: the controller itself. */
#include "commands.h" // COMMAND_defaults
#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "reply.h" // reply_condition()
#include "sentences.h"

/* ---- settings, save, defaults ---- */

static void say(struct console *console, uint8_t sentence)
{
    writer_text_line(&console->writer, sentences[sentence]);
}

static void say_origin(struct console *console)
{
    say(console, (uint8_t)(SENTENCE_ORIGIN_NONE + console->keeper->store->origin));
}

/* "link_loss_ms = 500 ms" */
static void setting_line(struct console *console, uint8_t index)
{
    const CDS_FLASH struct setting *row = &settings_table[index];
    struct writer *writer = &console->writer;

    writer_flash(writer, row->name);
    WRITER_TEXT(writer, " = ");
    writer_decimal(writer, settings_get(console->keeper->settings, index));
    if (*row->unit != '-') {
        writer_char(writer, ' ');
        writer_flash(writer, row->unit);
    }
    writer_end_of_line(writer);
}

uint8_t settings_begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint16_t value = 0;
    uint8_t error;

    if (line->words == 1)
        return 0;
    line->next = SETTINGS_COUNT;
    if (line->word.length <= TOKEN_MAX)
        line->next = settings_named(line->word.text, line->word.length);
    if (line->next == SETTINGS_COUNT)
        return ERROR_UNKNOWN_SETTING;
    if (line->words == 2)
        return 0;
    error = number_register(&line->number[0], CDS_UNIT_NUMBER, &value);
    if (error == 0 && !settings_set(console->keeper->settings, line->next, value))
        error = ERROR_SETTING_RANGE;
    if (error == 0)
        keeper_follow(console->keeper);
    return error;
}

uint8_t defaults_begin(struct console *console)
{
    settings_default(console->keeper->settings);
    keeper_follow(console->keeper);
    return 0;
}

/* One; none, if it was set; or all, and where they came from. */
bool settings_poll(struct console *console)
{
    if (console->line.kind == COMMAND_defaults || console->line.words == 3)
        return console->keeper->unsettled; // in force with the ok
    if (console->line.words == 2) {
        setting_line(console, console->line.next);
        return false;
    }
    if (console->step < SETTINGS_COUNT) {
        setting_line(console, console->step);
        return true;
    }
    say_origin(console);
    return false;
}

uint8_t save_begin(struct console *console)
{
    struct keeper *keeper = console->keeper;

    return settings_save(keeper->store, keeper->settings) ? 0 : ERROR_SAVING;
}

bool save_poll(struct console *console)
{
    uint8_t result = console->keeper->store->result;

    if (result == SETTINGS_FAILED)
        console->error = ERROR_NOT_SAVED;
    return result == SETTINGS_SAVING;
}

/* ---- alarms ---- */

/* Writes the line of the lowest bit, and returns the others. "alarm 3: overheating" */
static uint8_t alarm_line(struct console *console, uint8_t id, uint8_t bits)
{
    struct writer *writer = &console->writer;

    WRITER_TEXT(writer, "alarm ");
    if (id == CDS_BROADCAST_ID)
        WRITER_TEXT(writer, "of others");
    else
        writer_decimal(writer, id);
    WRITER_TEXT(writer, ": ");
    bits = reply_condition(writer, bits);
    writer_end_of_line(writer);
    return bits;
}

/* The alarms of the robot's servo `index`; behind the last one, of those who are not of it. */
static uint8_t alarms_of(const struct cds_roster *roster, uint8_t index)
{
    uint8_t others = roster->alarms;

    if (index < roster->count)
        return roster->servos[index].alarms;
    for (uint8_t i = 0; i < roster->count; i++)
        others = (uint8_t)(others & ~roster->servos[i].alarms);
    return others;
}

uint8_t alarms_begin(struct console *console)
{
    console->line.next = console->line.length = 0;
    return 0;
}

/* A line a call: line.next is the servo, line.length what was told of it. */
bool alarms_poll(struct console *console)
{
    const struct cds_roster *roster = &console->robot->crew.roster;
    struct command_line *line = &console->line;
    uint8_t left = 0;

    while (line->next <= roster->count &&
           (left = (uint8_t)(alarms_of(roster, line->next) & ~line->length)) == 0) {
        line->next++;
        line->length = 0;
    }
    if (left == 0)
        return false;
    left ^= alarm_line(
        console, line->next < roster->count ? roster->servos[line->next].id : CDS_BROADCAST_ID,
        left);
    line->length |= left;
    return true;
}

uint8_t clear_begin(struct console *console)
{
    return keeper_clear(console->keeper) ? 0 : ERROR_STOPPING;
}

bool alarm_tell(struct console *console)
{
    struct keeper *keeper = console->keeper;

    if (!keeper->alarm || console->editor.length)
        return false;
    if (writer_ready(&console->writer))
        keeper->alarm = alarm_line(console, keeper->alarm_id, keeper->alarm);
    return true;
}

/* ---- status ---- */

static void reset_line(struct console *console)
{
    static const struct {
        uint8_t bit;
        char text[11];
    } CDS_FLASH causes[] = {
        {KEEPER_RESET_POWER, " power"},         {KEEPER_RESET_EXTERNAL, " external"},
        {KEEPER_RESET_BROWN_OUT, " brown-out"}, {KEEPER_RESET_WATCHDOG, " watchdog"},
        {KEEPER_RESET_JTAG, " JTAG"},
    };

    WRITER_TEXT(&console->writer, "reset by");
    for (uint8_t i = 0; i < sizeof causes / sizeof causes[0]; i++)
        if (console->keeper->reset_cause & causes[i].bit)
            writer_flash(&console->writer, causes[i].text);
    writer_end_of_line(&console->writer);
}

static uint8_t link_sentence(const struct keeper *keeper)
{
    if (keeper->link_lost)
        return SENTENCE_LINK_LOST;
    return keeper->settings->link_loss_ms ? SENTENCE_LINK_ON : SENTENCE_LINK_OFF;
}

static uint8_t stop_sentence(const struct robot *robot)
{
    if (robot_is_stopping(robot))
        return SENTENCE_STOP_PENDING;
    if (!robot->stop.roster)
        return SENTENCE_STOP_NEVER;
    switch (robot->stop.result) {
    case CDS_OK: return SENTENCE_STOP_ALL;
    case CDS_REFUSED: return SENTENCE_STOP_SOME_ON;
    default: return SENTENCE_STOP_UNKNOWN;
    }
}

/* "servos: 18, held 0, away 1" */
static void servos_line(struct console *console)
{
    const struct crew *crew = &console->robot->crew;
    uint8_t held = 0, away = 0;

    for (uint8_t i = 0; i < crew->roster.count; i++) {
        held = (uint8_t)(held + (crew->roster.servos[i].held != 0));
        away = (uint8_t)(away + (crew->roster.servos[i].presence == CDS_PRESENCE_AWAY));
    }
    WRITER_TEXT(&console->writer, "servos: ");
    writer_decimal(&console->writer, crew->roster.count);
    if (crew->crowded)
        WRITER_TEXT(&console->writer, " and more");
    WRITER_TEXT(&console->writer, ", held ");
    writer_decimal(&console->writer, held);
    WRITER_TEXT(&console->writer, ", away ");
    writer_decimal(&console->writer, away);
    writer_end_of_line(&console->writer);
}

/* "stack: 812 of 1290 bytes never used" */
static void ram_line(struct console *console)
{
    WRITER_TEXT(&console->writer, "stack: ");
    writer_decimal(&console->writer, console->keeper->spare_bytes);
    WRITER_TEXT(&console->writer, " of ");
    writer_decimal(&console->writer, console->keeper->room_bytes);
    WRITER_TEXT(&console->writer, " bytes never used");
    writer_end_of_line(&console->writer);
}

bool status_poll(struct console *console)
{
    switch (console->step) {
    case 0: reset_line(console); return true;
    case 1: say_origin(console); return true;
    case 2: say(console, link_sentence(console->keeper)); return true;
    case 3: say(console, stop_sentence(console->robot)); return true;
    case 4: say(console, (uint8_t)(SENTENCE_BUS_OK + cds_bus_state(console->bus))); return true;
    case 5: servos_line(console); return true;
    default: ram_line(console); return false;
    }
}
