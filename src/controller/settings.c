/* The controller's settings and their record in the EEPROM; see settings.h. */
#include "settings.h"

#include <stddef.h>

#include "../avr/eeprom.h" // by its path: the simulator has an eeprom.h too
#include "crc.h"
#include "opaque.h" // CDS_OPAQUE(), CDS_APART

#define ERASED UINT8_MAX // as version: no record

/* Bytes of a record. */
enum { AT_VERSION, AT_LENGTH, AT_SEQUENCE, AT_DATA, AT_CRC = AT_DATA + SETTINGS_BYTES };

/* Steps of a save: the version goes first of all and comes back last. */
enum { STEP_FORGET, STEP_VERSION = SETTINGS_RECORD, STEP_DONE };

#define LENGTH_MAX (SETTINGS_ROOM - 5) // of a record of any version

_Static_assert(SETTINGS_RECORD <= SETTINGS_ROOM, "a record must fit its room");
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

        while (same < length && of[same] == name[same])
            same++; // ends at the \0 of `of` at the latest
        if (same == length && of[same] == '\0')
            break;
    }
    return index;
}

CDS_APART uint16_t settings_get(const struct settings *settings, uint8_t index)
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

CDS_APART static uint16_t add(uint16_t crc, uint8_t byte)
{
    return crc_add(crc, byte);
}

/* SETTINGS_STORED: a whole record of this version. */
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
    return version == SETTINGS_VERSION && length == SETTINGS_BYTES ? SETTINGS_STORED
                                                                   : SETTINGS_OTHER_VERSION;
}

/* Takes what a whole record says. False: one of its values was out of range and is left alone. */
static bool take(uint8_t slot, struct settings *settings)
{
    uint8_t at = AT_DATA;
    bool good = true;

    for (uint8_t i = 0; i < SETTINGS_COUNT; i++) {
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
    slot = origins[0] == origins[1] ? newer_slot() : origins[1] > origins[0];
    store->origin = origins[slot];
    if (store->origin != SETTINGS_STORED)
        return;
    if (!take(slot, settings))
        store->origin = SETTINGS_CORRECTED;
    store->sequence = stored(slot, AT_SEQUENCE);
    store->slot = !slot;
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

/* Which byte of the record a step writes. */
static uint8_t index_of(uint8_t step)
{
    return step == STEP_VERSION ? AT_VERSION : step;
}

static uint8_t byte_of(const struct settings_store *store, uint8_t step)
{
    switch (step) {
    case STEP_FORGET: return ERASED;
    case STEP_VERSION: return SETTINGS_VERSION;
    case AT_LENGTH: return SETTINGS_BYTES;
    case AT_SEQUENCE: return (uint8_t)(store->sequence + 1);
    case AT_CRC: return (uint8_t)store->crc;
    case AT_CRC + 1: return (uint8_t)(store->crc >> 8);
    default: return data_byte(&store->copy, (uint8_t)(step - AT_DATA));
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
}

/* A byte that is there already is left alone: a cell bears 100 000 writes. */
static void write_byte(struct settings_store *store)
{
    uint8_t index = index_of(store->step);
    uint8_t byte = byte_of(store, store->step);

    if (stored(store->slot, index) != byte)
        avr_eeprom_write((uint16_t)(SETTINGS_PLACE + store->slot * SETTINGS_ROOM + index), byte);
    if (store->step > AT_VERSION && store->step < AT_CRC)
        store->crc = add(store->crc, byte);
    store->written = byte;
    store->step++;
}

bool settings_save_poll(struct settings_store *store)
{
    CDS_OPAQUE(store);
    if (store->result != SETTINGS_SAVING)
        return false;
    if (!avr_eeprom_ready())
        return true;
    if (store->step > STEP_FORGET &&
        stored(store->slot, index_of((uint8_t)(store->step - 1))) != store->written)
        store->result = SETTINGS_FAILED;
    else if (store->step == STEP_DONE)
        end_save(store);
    else
        write_byte(store);
    return store->result == SETTINGS_SAVING;
}
