/* SPDX-License-Identifier: MIT */
/* Settings that outlive power-off, in the EEPROM. One table gives the struct, the record and
 * docs/settings.md.
 *
 * A record is version, length, sequence number, the settings in the order of the table (words low
 * byte first), and a CRC over all of them. A record of another firmware with fewer or more settings
 * is read as far as both know the settings. The EEPROM has two places: a save overwrites the older
 * record and writes its version last, so one whole record remains whenever the power fails.
 *
 * Main context. */
#ifndef CONTROLLER_SETTINGS_H
#define CONTROLLER_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h" // CDS_FLASH

/* X(name, bytes, default, lowest, highest, unit, what). A new row goes to the end; a row that
 * stands here never moves, keeps its number of bytes, and is never removed: records in the field
 * have the order of this table (test_load_record_of_ten_settings_gives_their_values). */
#define SETTINGS(X)                                                                                \
    X(device_id, 1, 253, 0, 254, "ID", "of the virtual device; 254: it is off")                    \
    X(host_baud, 1, 255, 1, 255, "register",                                                       \
      "host link, 2 000 000 / (n + 1) bit/s: 1 is 1 Mbps, 16 is 115200; 255: the board's own")     \
    X(bus_baud, 1, 1, 0, 254, "register", "bus, 2 000 000 / (n + 1) bit/s: 1 is 1 Mbps")           \
    X(return_delay, 1, 254, 0, 254, "x 2us", "the longest return delay of any servo on the bus")   \
    X(repeats, 1, 0, 0, 2, "-",                                                                    \
      "how often a packet is sent again, also of a search, when no good reply came")               \
    X(echo, 1, 2, 0, 2, "-",                                                                       \
      "0: the console gives bare replies (mode program); 1: it echoes what is typed; 2: for "      \
      "people, also a banner after a reset and a prompt (mode person)")                            \
    X(link_loss_ms, 2, 0, 0, 65535, "ms",                                                          \
      "silence of the host that counts as loss of the link; 0: not watched")                       \
    X(link_loss_action, 1, 1, 0, 2, "-",                                                           \
      "then: 0 only show it; 1 inhibit: no driving packet is sent until clear, but a movement "    \
      "that has begun goes on, also one that turns without end; 2 torque off, too")                \
    X(alarm_report, 1, 0, 0, 1, "-",                                                               \
      "1: an alarm of a servo, or that it is offline, is told at once, in each mode; 0: at once "  \
      "in mode person, while the host types lines and sends no packets")                           \
    X(cycle_us, 2, 4000, 2000, 65535, "us", "period of the cycle")

#define SETTINGS_TYPE_1 uint8_t
#define SETTINGS_TYPE_2 uint16_t

/* The settings; ranges and units stand in the table. */
struct settings {
#define SETTINGS_FIELD_(name, bytes, initial, lowest, highest, unit, what)                         \
    SETTINGS_TYPE_##bytes name;
    SETTINGS(SETTINGS_FIELD_)
#undef SETTINGS_FIELD_
};

/* Rows of the table: SETTINGS_AT_bus_baud and so on. */
enum {
#define SETTINGS_AT_(name, bytes, initial, lowest, highest, unit, what) SETTINGS_AT_##name,
    SETTINGS(SETTINGS_AT_)
#undef SETTINGS_AT_
};

enum {
#define SETTINGS_BYTES_(name, bytes, initial, lowest, highest, unit, what) +bytes
    SETTINGS_BYTES = 0 SETTINGS(SETTINGS_BYTES_), // in the record
#undef SETTINGS_BYTES_
#define SETTINGS_ONE_(name, bytes, initial, lowest, highest, unit, what) +1
    SETTINGS_COUNT = 0 SETTINGS(SETTINGS_ONE_),
#undef SETTINGS_ONE_
    SETTINGS_VERSION = 1, // 1 to 254; a new row at the end of the table does not change it
    SETTINGS_RECORD = 3 + SETTINGS_BYTES + 2,
    SETTINGS_PLACE = 16, // of the first record; address 0 is the one that a failing supply damages
    SETTINGS_ROOM = 64,  // for each of the two
};

/* Values of the setting echo. */
enum { SETTINGS_ECHO_OFF, SETTINGS_ECHO_ON, SETTINGS_ECHO_PERSON };

/* A row of the table. */
struct setting {
    const CDS_FLASH char *name;
    const CDS_FLASH char *unit;
    uint8_t offset; // in struct settings
    uint8_t bytes;  // 1 or 2
    uint16_t initial, lowest, highest;
};

extern const CDS_FLASH struct setting settings_table[SETTINGS_COUNT];

/* Where the settings of settings_load() come from: from the newest whole record, or, up to
 * SETTINGS_OTHER_VERSION, from the defaults. */
enum settings_origin {
    SETTINGS_NONE,          // nothing was saved before
    SETTINGS_DAMAGED,       // neither record is whole
    SETTINGS_OTHER_VERSION, // there is a whole record, but of another SETTINGS_VERSION
    SETTINGS_OLDER,         // the record has fewer settings; the others are defaults
    SETTINGS_NEWER,         // the record has settings that this firmware does not know
    SETTINGS_STORED,        // the record has these settings
    SETTINGS_CORRECTED,     // a value of the record was out of range and is its default
} __attribute__((packed));

/* How the last settings_save() went. */
enum settings_result {
    SETTINGS_UNSAVED, // there was none
    SETTINGS_SAVING,  // it goes on
    SETTINGS_SAVED,
    SETTINGS_FAILED, // a byte does not keep what is written: the older record still holds
} __attribute__((packed));

/* Keeps a struct settings in the EEPROM. The fields are to be read only. */
struct settings_store {
    struct settings copy; // what is being saved
    uint16_t crc;         // of the bytes so far
    uint8_t origin;       // enum settings_origin of the newest record
    uint8_t result;       // enum settings_result
    uint8_t slot;         // 0 or 1: where the next record goes
    uint8_t sequence;     // of the newest record
    uint8_t unknown;      // bytes of that record behind the settings that this firmware knows
    uint8_t step;         // of the save: which byte is next
    uint8_t written;      // the byte before it
};

/* All of them as in the table. */
void settings_default(struct settings *settings);

/* The row named by the `length` characters at `name`, in any case; SETTINGS_COUNT if there is none.
 */
uint8_t settings_named(const char *name, uint8_t length);

/* The value of row `index` (0 to SETTINGS_COUNT - 1) of the table. */
uint16_t settings_get(const struct settings *settings, uint8_t index);

/* Sets row `index` (0 to SETTINGS_COUNT - 1) to `value`. False: out of its range, nothing was set.
 */
bool settings_set(struct settings *settings, uint8_t index, uint16_t value);

/* Sets `settings` from the EEPROM, or to the defaults; store->origin says which. Once, at start-up:
 * it waits up to 8.5 ms for a write that a reset found under way. */
void settings_load(struct settings_store *store, struct settings *settings);

/* True if the next start has these settings, out of the EEPROM, or as defaults; or if that cannot
 * be read now, as a byte is being written. */
bool settings_are_kept(const struct settings *settings);

/* Begins to save `settings` as they are now; settings_save_poll() goes on. Settings of the newest
 * record that this firmware does not know are saved with them, unchanged. False: a save is under
 * way, nothing was begun. */
bool settings_save(struct settings_store *store, const struct settings *settings);

/* Goes on with a save: at most one byte, none while the EEPROM is busy. True while there is more to
 * do, up to 0.2 s; then store->result says how it went. */
bool settings_save_poll(struct settings_store *store);

#endif
