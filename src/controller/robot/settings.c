/* SPDX-License-Identifier: MIT */
/* The controller's settings and their record in the EEPROM; see settings.h. */
#include "robot/settings.h"

#include <stddef.h>
#include <string.h>

#include "avr/eeprom_driver.h"
#include "robot/crc.h"
#include "compiler.h" // OPTIMIZER_BARRIER(), NOINLINE

#define ERASED UINT8_MAX // as version: no record

/* Bytes of a record. The CRC follows the data. */
enum { AT_VERSION, AT_LENGTH, AT_SEQUENCE, AT_DATA, AT_UNKNOWN = AT_DATA + SETTINGS_BYTES };

/* The first step of a save: it takes the version away. A step for each byte behind the version
 * follows, and the last step writes the version. */
#define STEP_FORGET AT_VERSION

#define LENGTH_MAX (SETTINGS_ROOM - 5) // of a record of any version

_Static_assert(SETTINGS_RECORD <= SETTINGS_ROOM, "a record must fit its room");
_Static_assert(sizeof(struct settings) == SETTINGS_BYTES, "memcmp() compares no padding");
_Static_assert(SETTINGS_VERSION > 0 && SETTINGS_VERSION < ERASED, "versions are 1 to 254");

#define NAME(name, bytes, initial, lowest, highest, unit, what)                                    \
    static const CDS_FLASH char name_##name[] = #name;                                             \
    static const CDS_FLASH char unit_##name[] = unit;
SETTINGS(NAME)
#undef NAME

const CDS_FLASH struct setting settings_table[SETTINGS_COUNT] = {
#define ROW(name, bytes, initial, lowest, highest, unit, what)                                     \
    {name_##name, unit_##name, offsetof(struct settings, name), bytes, initial, lowest, highest},
    SETTINGS(ROW)
#undef ROW
};

uint8_t settings_named(const char *name, uint8_t length)
{
    uint8_t index = 0;

    for (; index < SETTINGS_COUNT; index++) {
        const CDS_FLASH char *of = settings_table[index].name;
        uint8_t same = 0;

        while (same < length && ((of[same] ^ name[same]) & ~0x20) == 0)
            same++; // ends at the \0 of `of` at the latest
        if (same == length && of[same] == '\0')
            break;
    }
    return index;
}

NOINLINE uint16_t settings_get(const struct settings *settings, uint8_t index)
{
    const CDS_FLASH struct setting *row = &settings_table[index];
    const uint8_t *field = (const uint8_t *)settings + row->offset;

    return row->bytes == 1 ? *field : *(const uint16_t *)(const void *)field;
}

static void put(struct settings *settings, uint8_t index, uint16_t value)
{
    const CDS_FLASH struct setting *row = &settings_table[index];
    uint8_t *field = (uint8_t *)settings + row->offset;

    if (row->bytes == 1)
        *field = (uint8_t)value;
    else
        *(uint16_t *)(void *)field = value;
}

bool settings_set(struct settings *settings, uint8_t index, uint16_t value)
{
    if (value < settings_table[index].lowest || value > settings_table[index].highest)
        return false;
    put(settings, index, value);
    return true;
}

void settings_default(struct settings *settings)
{
    for (uint8_t i = 0; i < SETTINGS_COUNT; i++)
        put(settings, i, settings_table[i].initial);
}

/* --- reading ---------------------------------------------------------------------------------- */

static uint8_t stored(uint8_t slot, uint8_t index)
{
    return avr_eeprom_read((uint16_t)(SETTINGS_PLACE + slot * SETTINGS_ROOM + index));
}

NOINLINE static uint16_t add(uint16_t crc, uint8_t byte)
{
    return crc_add(crc, byte);
}

/* SETTINGS_OLDER and above: a whole record that can be read. */
static enum settings_origin examine(uint8_t slot)
{
    uint8_t version = stored(slot, AT_VERSION);
    uint8_t length = stored(slot, AT_LENGTH);
    uint16_t crc = CRC_BEGIN;
    uint8_t end;

    if (version == ERASED)
        return SETTINGS_NONE;
    if (length > LENGTH_MAX)
        return SETTINGS_DAMAGED;
    end = (uint8_t)(AT_DATA + length + 2);
    for (uint8_t i = 0; i < end; i++)
        crc = add(crc, stored(slot, i));
    if (crc) // that of all, and of its own CRC behind it, is 0
        return SETTINGS_DAMAGED;
    if (version != SETTINGS_VERSION)
        return SETTINGS_OTHER_VERSION;
    if (length < SETTINGS_BYTES)
        return SETTINGS_OLDER;
    return length == SETTINGS_BYTES ? SETTINGS_STORED : SETTINGS_NEWER;
}

/* Takes what a whole record says, as far as it goes. False: one of its values was out of range and
 * is left alone. */
static bool take(uint8_t slot, struct settings *settings)
{
    uint8_t at = AT_DATA, end = (uint8_t)(AT_DATA + stored(slot, AT_LENGTH));
    bool good = true;

    for (uint8_t i = 0; i < SETTINGS_COUNT && at + settings_table[i].bytes <= end; i++) {
        uint16_t value = stored(slot, at++);

        if (settings_table[i].bytes == 2)
            value = (uint16_t)(value | (uint16_t)stored(slot, at++) << 8);
        good = settings_set(settings, i, value) && good;
    }
    return good;
}

/* The slot with the newer of two whole records. */
static uint8_t newer_slot(void)
{
    return (int8_t)(stored(1, AT_SEQUENCE) - stored(0, AT_SEQUENCE)) > 0;
}

void settings_load(struct settings_store *store, struct settings *settings)
{
    enum settings_origin origins[2];
    uint8_t slot;

    *store = (struct settings_store){.origin = SETTINGS_NONE};
    settings_default(settings);
    while (!avr_eeprom_ready()) {
    }
    origins[0] = examine(0);
    origins[1] = examine(1);
    slot = origins[0] >= SETTINGS_OLDER && origins[1] >= SETTINGS_OLDER ? newer_slot()
                                                                        : origins[1] > origins[0];
    store->origin = origins[slot];
    if (store->origin < SETTINGS_OLDER)
        return;
    if (store->origin == SETTINGS_NEWER)
        store->unknown = (uint8_t)(stored(slot, AT_LENGTH) - SETTINGS_BYTES);
    if (!take(slot, settings))
        store->origin = SETTINGS_CORRECTED;
    store->sequence = stored(slot, AT_SEQUENCE);
    store->slot = !slot;
}

bool settings_are_kept(const struct settings *settings)
{
    struct settings_store store;
    struct settings next;

    if (!avr_eeprom_ready()) // settings_load() would wait
        return true;
    settings_load(&store, &next);
    return memcmp(&next, settings, sizeof next) == 0; // a struct settings has no padding
}

/* --- saving ----------------------------------------------------------------------------------- */

/* Byte `at` of the settings in the record. */
static uint8_t data_byte(const struct settings *settings, uint8_t at)
{
    uint8_t index = 0;

    while (at >= settings_table[index].bytes)
        at = (uint8_t)(at - settings_table[index++].bytes);
    return (uint8_t)(settings_get(settings, index) >> (8 * at));
}

/* What a save does next, by the number of steps that are left before the CRC; all numbers above
 * NEXT_CRC_LOW are bytes before the CRC. */
enum { NEXT_END = -3, NEXT_VERSION, NEXT_CRC_HIGH, NEXT_CRC_LOW };

static int8_t next_of(const struct settings_store *store)
{
    return (int8_t)(AT_UNKNOWN + store->unknown - store->step);
}

/* Returns byte `index` of the new record, before its CRC. The settings that this firmware does not
 * know come from the newest record, in the other place. */
static uint8_t byte_before_crc(const struct settings_store *store, uint8_t index)
{
    switch (index) {
    case AT_VERSION: return ERASED; // for now
    case AT_LENGTH: return (uint8_t)(SETTINGS_BYTES + store->unknown);
    case AT_SEQUENCE: return (uint8_t)(store->sequence + 1);
    default:
        return index < AT_UNKNOWN ? data_byte(&store->copy, (uint8_t)(index - AT_DATA))
                                  : stored(!store->slot, index);
    }
}

bool settings_save(struct settings_store *store, const struct settings *settings)
{
    if (store->result == SETTINGS_SAVING)
        return false;
    store->copy = *settings;
    store->crc = crc_add(CRC_BEGIN, SETTINGS_VERSION);
    store->step = STEP_FORGET;
    store->result = SETTINGS_SAVING;
    return true;
}

/* The new record stands: the other one is the next to go. */
static void end_save(struct settings_store *store)
{
    store->sequence++;
    store->slot = !store->slot;
    store->result = SETTINGS_SAVED;
    store->origin = store->unknown ? SETTINGS_NEWER : SETTINGS_STORED;
}

/* A byte that is there already is left alone: a cell bears 100 000 writes. */
static void write(struct settings_store *store, uint8_t index, uint8_t byte)
{
    if (stored(store->slot, index) != byte)
        avr_eeprom_write((uint16_t)(SETTINGS_PLACE + store->slot * SETTINGS_ROOM + index), byte);
    store->written = byte;
    store->step++;
}

static void write_next(struct settings_store *store, int8_t next)
{
    uint8_t index = store->step, byte;

    switch (next) {
    case NEXT_VERSION:
        index = AT_VERSION;
        byte = SETTINGS_VERSION;
        break;
    case NEXT_CRC_HIGH: byte = (uint8_t)(store->crc >> 8); break;
    case NEXT_CRC_LOW: byte = (uint8_t)store->crc; break;
    default:
        byte = byte_before_crc(store, index);
        if (index > AT_VERSION)
            store->crc = add(store->crc, byte);
    }
    write(store, index, byte);
}

bool settings_save_poll(struct settings_store *store)
{
    uint8_t before; // where the last step has written
    int8_t next;

    OPTIMIZER_BARRIER(store);
    if (store->result != SETTINGS_SAVING)
        return false;
    if (!avr_eeprom_ready())
        return true;
    next = next_of(store);
    before = next == NEXT_END ? AT_VERSION : (uint8_t)(store->step - 1);
    if (store->step > STEP_FORGET && stored(store->slot, before) != store->written)
        store->result = SETTINGS_FAILED;
    else if (next == NEXT_END)
        end_save(store);
    else
        write_next(store, next);
    return store->result == SETTINGS_SAVING;
}
