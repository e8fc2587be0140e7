/* Commands about the controller itself; see cmd_keeper.h. */
#include "cmd_keeper.h"

#include "console.h"
#include "errors.h"

#define ALARMS 7 // CDS_ERROR_* bits

static void flash_string(struct writer *writer, const CDS_FLASH char *text)
{
    while (*text)
        writer_char(writer, *text++);
}

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
    writer_string(&console->writer, "settings at start: ");
    writer_text_line(&console->writer, origins[console->keeper->store->origin]);
}

/* "link_loss_ms = 500 ms" */
static void setting_line(struct console *console, uint8_t index)
{
    const CDS_FLASH struct setting *row = &settings_table[index];
    struct writer *writer = &console->writer;

    flash_string(writer, row->name);
    writer_string(writer, " = ");
    writer_decimal(writer, settings_get(console->keeper->settings, index));
    if (*row->unit != '-') {
        writer_char(writer, ' ');
        flash_string(writer, row->unit);
    }
    writer_end_of_line(writer);
}

static uint8_t settings_begin(struct console *console)
{
    struct command_line *line = &console->line;

    if (line->words == 1)
        return 0;
    if (line->word.length > TOKEN_MAX)
        return ERROR_UNKNOWN_SETTING;
    line->next = settings_named(line->word.text, line->word.length);
    if (line->next == SETTINGS_COUNT)
        return ERROR_UNKNOWN_SETTING;
    if (line->words == 3 && !settings_set(console->keeper->settings, line->next, line->number))
        return ERROR_SETTING_RANGE;
    return 0;
}

/* One; none, if it was set; or all, and where they came from. */
static bool settings_list(struct console *console)
{
    if (console->line.words == 2)
        setting_line(console, console->line.next);
    if (console->line.words > 1)
        return false;
    if (console->step < SETTINGS_COUNT) {
        setting_line(console, console->step);
        return true;
    }
    origin_line(console);
    return false;
}

static uint8_t save_begin(struct console *console)
{
    struct keeper *keeper = console->keeper;

    return settings_save(keeper->store, keeper->settings) ? 0 : ERROR_SAVING;
}

static bool save_wait(struct console *console)
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
    static const struct {
        char text[19];
    } CDS_FLASH names[ALARMS] = {{"input voltage"}, {"angle limit"}, {"overheating"}, {"range"},
                                 {"checksum"},      {"overload"},    {"instruction"}};
    uint8_t bit = 0;

    while (bit < ALARMS - 1 && !(bits & 1 << bit))
        bit++;
    writer_string(&console->writer, "alarm ");
    if (id == CDS_BROADCAST_ID)
        writer_string(&console->writer, "of others");
    else
        writer_decimal(&console->writer, id);
    writer_string(&console->writer, ": ");
    writer_text_line(&console->writer, names[bit].text);
    return (uint8_t)(bits & ~(1 << bit));
}

/* The alarms of the crew's servo `index`; behind the last one, of those who are not of it. */
static uint8_t alarms_of(const struct cds_roster *roster, uint8_t index)
{
    uint8_t others = roster->alarms;

    if (index < roster->count)
        return roster->servos[index].alarms;
    for (uint8_t i = 0; i < roster->count; i++)
        others = (uint8_t)(others & ~roster->servos[i].alarms);
    return others;
}

/* A line a call: line.next is the servo, line.length what was told of it. */
static bool alarms_list(struct console *console)
{
    const struct cds_roster *roster = &console->keeper->crew->roster;
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

void cmd_keeper_tell(struct console *console)
{
    struct keeper *keeper = console->keeper;

    if (console_idle(console) && writer_ready(&console->writer) && keeper->alarm)
        keeper->alarm = alarm_line(console, keeper->alarm_id, keeper->alarm);
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

    writer_string(&console->writer, "reset by");
    for (uint8_t i = 0; i < sizeof causes / sizeof causes[0]; i++)
        if (console->keeper->reset_cause & causes[i].bit)
            flash_string(&console->writer, causes[i].text);
    writer_end_of_line(&console->writer);
}

static void link_line(struct console *console)
{
    static const CDS_FLASH char off[] = "not watched";
    static const CDS_FLASH char on[] = "watched";
    static const CDS_FLASH char lost[] = "lost";
    const struct keeper *keeper = console->keeper;

    writer_string(&console->writer, "host link: ");
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
    const struct keeper *keeper = console->keeper;
    const CDS_FLASH char *text = unknown;

    if (!keeper->stop.roster)
        text = never;
    else if (keeper->stop.result == CDS_PENDING)
        text = on_its_way;
    else if (keeper->stop.result == CDS_OK)
        text = all;
    else if (keeper->stop.result == CDS_REFUSED)
        text = some_on;
    writer_string(&console->writer, "torque off: ");
    writer_text_line(&console->writer, text);
}

static void bus_line(struct console *console)
{
    static const CDS_FLASH char states[][6] = {
        [CDS_BUS_OK] = "ok", [CDS_BUS_BUSY] = "busy", [CDS_BUS_FAULT] = "fault"};

    writer_string(&console->writer, "bus: ");
    writer_text_line(&console->writer, states[cds_bus_state(console->bus)]);
}

/* "servos: 18, of them held 0, away 1" */
static void servos_line(struct console *console)
{
    const struct crew *crew = console->keeper->crew;
    uint8_t held = 0, away = 0;

    for (uint8_t i = 0; i < crew->roster.count; i++) {
        held = (uint8_t)(held + (crew->roster.servos[i].held != 0));
        away = (uint8_t)(away + (crew->roster.servos[i].presence == CDS_PRESENCE_AWAY));
    }
    writer_string(&console->writer, "servos: ");
    writer_decimal(&console->writer, crew->roster.count);
    writer_string(&console->writer, crew->crowded ? " and more" : "");
    writer_string(&console->writer, ", held ");
    writer_decimal(&console->writer, held);
    writer_string(&console->writer, ", away ");
    writer_decimal(&console->writer, away);
    writer_end_of_line(&console->writer);
}

/* "RAM: 812 of 1290 bytes never used" */
static void ram_line(struct console *console)
{
    writer_string(&console->writer, "stack: ");
    writer_decimal(&console->writer, console->keeper->spare_bytes);
    writer_string(&console->writer, " of ");
    writer_decimal(&console->writer, console->keeper->room_bytes);
    writer_string(&console->writer, " bytes never used");
    writer_end_of_line(&console->writer);
}

static bool status_list(struct console *console)
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

/* ---- all of them ---- */

uint8_t cmd_keeper_begin(struct console *console)
{
    switch (console->line.kind) {
    case COMMAND_settings: return settings_begin(console);
    case COMMAND_save: return save_begin(console);
    case COMMAND_defaults: settings_default(console->keeper->settings); return 0;
    case COMMAND_alarms: console->line.next = console->line.length = 0; return 0;
    case COMMAND_clear: return keeper_clear(console->keeper) ? 0 : ERROR_STOPPING;
    default: return 0;
    }
}

bool cmd_keeper_poll(struct console *console)
{
    switch (console->line.kind) {
    case COMMAND_settings: return settings_list(console);
    case COMMAND_save: return save_wait(console);
    case COMMAND_status: return status_list(console);
    case COMMAND_alarms: return alarms_list(console);
    default: return false;
    }
}
