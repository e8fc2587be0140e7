/* status, alarms, clear, settings, save, defaults: the controller itself. */
#include "commands.h" // COMMAND_defaults
#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "reply.h" // reply_condition()

/* ---- settings, save, defaults ---- */

#define ORIGINS(X)                                                                                 \
    X(SETTINGS_NONE, "defaults: nothing was ever saved")                                           \
    X(SETTINGS_DAMAGED, "defaults: what was saved is damaged")                                     \
    X(SETTINGS_OTHER_VERSION, "defaults: what was saved is of another version")                    \
    X(SETTINGS_STORED, "as saved")                                                                 \
    X(SETTINGS_CORRECTED, "as saved, but one was out of range and is its default")

#define ORIGIN(name, text) static const CDS_FLASH char text_##name[] = text;
ORIGINS(ORIGIN)
#undef ORIGIN

static const CDS_FLASH char *const CDS_FLASH origins[] = {
#define ORIGIN(name, text) [name] = text_##name,
    ORIGINS(ORIGIN)
#undef ORIGIN
};

/* "settings at start: as saved" */
static void origin_line(struct console *console)
{
    WRITER_TEXT(&console->writer, "settings at start: ");
    writer_text_line(&console->writer, origins[console->keeper->store->origin]);
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
    origin_line(console);
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

static void link_line(struct console *console)
{
    static const CDS_FLASH char off[] = "not watched";
    static const CDS_FLASH char on[] = "watched";
    static const CDS_FLASH char lost[] = "lost";
    const struct keeper *keeper = console->keeper;

    WRITER_TEXT(&console->writer, "host link: ");
    writer_text_line(&console->writer, keeper->link_lost                ? lost
                                       : keeper->settings->link_loss_ms ? on
                                                                        : off);
}

static void torque_line(struct console *console)
{
    static const CDS_FLASH char never[] = "not asked for";
    static const CDS_FLASH char on_its_way[] = "under way";
    static const CDS_FLASH char all[] = "all";
    static const CDS_FLASH char some_on[] = "not all: some are on";
    static const CDS_FLASH char unknown[] = "not known of all";
    const struct robot *robot = console->robot;
    const CDS_FLASH char *text = unknown;

    if (robot_is_stopping(robot))
        text = on_its_way;
    else if (!robot->stop.roster)
        text = never;
    else if (robot->stop.result == CDS_OK)
        text = all;
    else if (robot->stop.result == CDS_REFUSED)
        text = some_on;
    WRITER_TEXT(&console->writer, "torque off: ");
    writer_text_line(&console->writer, text);
}

static void bus_line(struct console *console)
{
    static const CDS_FLASH char states[][6] = {
        [CDS_BUS_OK] = "ok", [CDS_BUS_BUSY] = "busy", [CDS_BUS_FAULT] = "fault"};

    WRITER_TEXT(&console->writer, "bus: ");
    writer_text_line(&console->writer, states[cds_bus_state(console->bus)]);
}

/* "servos: 18, of them held 0, away 1" */
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

/* "RAM: 812 of 1290 bytes never used" */
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
    case 1: origin_line(console); return true;
    case 2: link_line(console); return true;
    case 3: torque_line(console); return true;
    case 4: bus_line(console); return true;
    case 5: servos_line(console); return true;
    default: ram_line(console); return false;
    }
}
