/* SPDX-License-Identifier: MIT */
/* Poses and sequences in the EEPROM: where they stand, and how they are read; see motion_store.h.
 */
#include "robot/motion_store_internal.h"

#include <stddef.h>

#include "cds55xx/motion.h" // CDS_POSE_NONE
#include "robot/crc.h"
#include "compiler.h" // OPTIMIZER_BARRIER()

#define JOINTS_DATA   MOTION_STORE_JOINTS
#define POSE_DATA     (POSE_HIGH_AT + MOTION_STORE_JOINTS / 2)
#define SEQUENCE_DATA (MOTION_STORE_STEPS * STEP_BYTES)
#define START_DATA    MOTION_STORE_NAME

#define RECORD(data) (AT_DATA + (data) + 2)

/* The areas lie one behind the other, behind the settings. AREAS() has the number of places of each
 * area. */
#define BEGIN                        144
#define JOINT_PLACES                 2
#define START_PLACES                 2
#define POSES_AT                     (BEGIN + JOINT_PLACES * RECORD(JOINTS_DATA))
#define SEQUENCES_AT(poses)          (POSES_AT + (poses)*RECORD(POSE_DATA))
#define START_AT(poses, sequences)   (SEQUENCES_AT(poses) + (sequences)*RECORD(SEQUENCE_DATA))
#define START_BYTE(poses, sequences) (1 + ((poses) + 7) / 8 + ((sequences) + 7) / 8)
#define AREAS(poses, sequences)                                                                    \
    {                                                                                              \
        {BEGIN, RECORD(JOINTS_DATA), JOINT_PLACES, 0}, {POSES_AT, RECORD(POSE_DATA), poses, 1},    \
            {SEQUENCES_AT(poses), RECORD(SEQUENCE_DATA), sequences, 1 + ((poses) + 7) / 8},        \
            {START_AT(poses, sequences), RECORD(START_DATA), START_PLACES,                         \
             START_BYTE(poses, sequences)},                                                        \
            {.first_byte = START_BYTE(poses, sequences) + 1},                                      \
    }
#define BITMAP(poses, sequences) (START_BYTE(poses, sequences) + 1)
#define END(poses, sequences)    (START_AT(poses, sequences) + START_PLACES * RECORD(START_DATA))

enum { POSES_4K = 61, SEQUENCES_4K = 11, POSES_2K = 21, SEQUENCES_2K = 9 };

_Static_assert(END(POSES_4K, SEQUENCES_4K) <= 4096, "places must fit 4 KB");
_Static_assert(END(POSES_2K, SEQUENCES_2K) <= 2048, "places must fit 2 KB");
_Static_assert(BITMAP(POSES_4K, SEQUENCES_4K) <= MOTION_STORE_BITMAP, "a bit for each place");
_Static_assert(POSES_4K + SEQUENCES_4K * MOTION_STORE_STEPS <= UINT8_MAX, "a number must be free");

const CDS_FLASH struct motion_store_area *motion_store_area(uint8_t kind)
{
    static const CDS_FLASH struct motion_store_area areas_4k[] = AREAS(POSES_4K, SEQUENCES_4K);
    static const CDS_FLASH struct motion_store_area areas_2k[] = AREAS(POSES_2K, SEQUENCES_2K);

    return (avr_eeprom_size() < 4096 ? areas_2k : areas_4k) + kind;
}

uint16_t motion_store_address(uint8_t kind, uint8_t place)
{
    const CDS_FLASH struct motion_store_area *area = motion_store_area(kind);

    return (uint16_t)(area->address + (uint16_t)(area->size * place));
}

void motion_store_read(uint16_t address, void *to, uint8_t count)
{
    uint8_t *byte = to;

    do
        *byte++ = avr_eeprom_read(address++);
    while (--count > 0);
}

/* --- the places that have a record ------------------------------------------------------------ */

bool motion_store_is_used(const struct motion_store *store, uint8_t kind, uint8_t place)
{
    return store->used[motion_store_area(kind)->first_byte + place / 8] >> place % 8 & 1;
}

void motion_store_set_used(struct motion_store *store, uint8_t kind, uint8_t place, bool is_used)
{
    uint8_t *byte = &store->used[motion_store_area(kind)->first_byte + place / 8];
    uint8_t mask = (uint8_t)(1 << place % 8);

    *byte = (uint8_t)(is_used ? *byte | mask : *byte & ~mask);
}

uint8_t motion_store_next(const struct motion_store *store, enum motion_store_kind kind,
                          uint8_t place)
{
    for (uint8_t places = motion_store_area(kind)->places; place < places; place++)
        if (motion_store_is_used(store, kind, place))
            return place;
    return MOTION_STORE_NONE;
}

uint8_t motion_store_capacity(enum motion_store_kind kind)
{
    return (uint8_t)(motion_store_area(kind)->places - 1);
}

uint8_t motion_store_room(const struct motion_store *store, enum motion_store_kind kind)
{
    const uint8_t *byte = &store->used[motion_store_area(kind)->first_byte],
                  *end = &store->used[motion_store_area((uint8_t)(kind + 1))->first_byte];
    uint8_t room = motion_store_capacity(kind);

    while (byte < end)
        for (uint8_t bits = *byte++; bits != 0; bits &= (uint8_t)(bits - 1)) // clears a bit
            room--;
    return room;
}

/* --- finding ---------------------------------------------------------------------------------- */

/* The CRC covers MOTION_STORE_VERSION, whatever stands there: that of a deleted record is right. */
static bool crc_is_right(uint8_t kind, uint16_t address)
{
    uint16_t crc = crc_add(CRC_BEGIN, MOTION_STORE_VERSION);

    for (uint8_t left = motion_store_area(kind)->size; --left > 0;)
        crc = crc_add(crc, avr_eeprom_read(++address));
    return crc == 0; // that of all bytes, and of the CRC behind them
}

static bool has_version(uint16_t address)
{
    return avr_eeprom_read(address) == MOTION_STORE_VERSION;
}

bool motion_store_is_whole(const struct motion_store *store, uint8_t kind, uint8_t place)
{
    uint16_t address = motion_store_address(kind, place);

    return place != MOTION_STORE_NONE && motion_store_is_used(store, kind, place) &&
           has_version(address) && crc_is_right(kind, address);
}

static bool is_readable(const struct motion_store *store, uint8_t kind, uint8_t place)
{
    return !motion_store_is_saving(store) && motion_store_is_whole(store, kind, place);
}

uint8_t motion_store_search(const struct motion_store *store, uint8_t kind, uint8_t offset,
                            const uint8_t *bytes, uint8_t count)
{
    uint16_t address = (uint16_t)(motion_store_address(kind, 0) + offset);
    uint8_t places = motion_store_area(kind)->places, size = motion_store_area(kind)->size;

    for (uint8_t place = 0; place < places; place++) {
        uint8_t same = 0;

        while (same < count && avr_eeprom_read((uint16_t)(address + same)) == bytes[same])
            same++;
        if (same == count && motion_store_is_used(store, kind, place))
            return place;
        address = (uint16_t)(address + size);
    }
    return MOTION_STORE_NONE;
}

uint8_t motion_store_place_of(const struct motion_store *store, uint8_t kind, const char *name,
                              uint8_t length)
{
    uint8_t whole[MOTION_STORE_NAME];

    if (length > MOTION_STORE_NAME)
        return MOTION_STORE_NONE;
    for (uint8_t i = 0; i < MOTION_STORE_NAME; i++)
        whole[i] = i < length ? (uint8_t)name[i] : 0;
    return motion_store_search(store, kind, AT_NAME, whole, MOTION_STORE_NAME);
}

uint8_t motion_store_find(const struct motion_store *store, enum motion_store_kind kind,
                          const char *name, uint8_t length)
{
    uint8_t place;

    if (motion_store_is_saving(store))
        return MOTION_STORE_NONE;
    place = motion_store_place_of(store, kind, name, length);
    return motion_store_is_whole(store, kind, place) ? place : MOTION_STORE_NONE;
}

/* --- loading ---------------------------------------------------------------------------------- */

static uint32_t serial_at(uint16_t address)
{
    uint32_t serial = 0;

    motion_store_read((uint16_t)(address + AT_SERIAL), &serial, AT_NUMBER - AT_SERIAL);
    return serial;
}

/* Of two records of one name the newer one counts: the power failed before the older was deleted.
 */
static void load_record(struct motion_store *store, uint8_t kind, uint8_t place, uint32_t serial)
{
    uint8_t name[MOTION_STORE_NAME], other;

    motion_store_read((uint16_t)(motion_store_address(kind, place) + AT_NAME), name, sizeof name);
    other = motion_store_search(store, kind, AT_NAME, name, sizeof name);
    if (other != MOTION_STORE_NONE) {
        if (serial_at(motion_store_address(kind, other)) > serial) {
            uint8_t older = place;

            place = other;
            other = older;
        }
        motion_store_set_used(store, kind, other, false);
        store->stale = motion_store_address(kind, other);
    }
    motion_store_set_used(store, kind, place, true);
}

#define SERIAL_ERASED ((uint32_t)0xFFFFFF)

static void load_kind(struct motion_store *store, uint8_t kind)
{
    uint8_t places = motion_store_area(kind)->places;
    uint32_t newest = 0;

    for (uint8_t place = 0; place < places; place++) {
        uint16_t address = motion_store_address(kind, place);
        bool is_record = has_version(address);
        uint32_t serial = serial_at(address);

        if (!is_record && serial == SERIAL_ERASED)
            continue; // never written: a new chip starts at once
        if (!crc_is_right(kind, address)) {
            store->damaged = (uint8_t)(store->damaged + is_record);
            continue;
        }
        if (serial > newest) {
            newest = serial;
            store->last[kind] = place;
        }
        if (is_record)
            load_record(store, kind, place, serial);
    }
    if (newest > store->saves)
        store->saves = newest;
}

void motion_store_load(struct motion_store *store, const struct settings_store *settings)
{
    OPTIMIZER_BARRIER(store);
    *store = (struct motion_store){.settings = settings};
    while (!avr_eeprom_ready()) {
    }
    for (uint8_t kind = 0; kind < MOTION_STORE_KINDS; kind++)
        load_kind(store, kind);
}

/* --- reading ---------------------------------------------------------------------------------- */

bool motion_store_read_name(const struct motion_store *store, enum motion_store_kind kind,
                            uint8_t place, char name[MOTION_STORE_NAME + 1])
{
    if (!is_readable(store, kind, place))
        return false;
    motion_store_read((uint16_t)(motion_store_address(kind, place) + AT_NAME), name,
                      MOTION_STORE_NAME);
    name[MOTION_STORE_NAME] = '\0';
    return true;
}

uint8_t motion_store_number(const struct motion_store *store, enum motion_store_kind kind,
                            uint8_t place)
{
    return motion_store_is_saving(store)
               ? 0
               : avr_eeprom_read((uint16_t)(motion_store_address(kind, place) + AT_NUMBER));
}

uint8_t motion_store_pose_of(const struct motion_store *store, uint8_t number)
{
    return motion_store_is_saving(store)
               ? MOTION_STORE_NONE
               : motion_store_search(store, MOTION_STORE_POSE, AT_NUMBER, &number, 1);
}

bool motion_store_read_pose(const struct motion_store *store, uint8_t place,
                            uint16_t positions[MOTION_STORE_JOINTS])
{
    uint8_t bytes[POSE_DATA];

    if (!is_readable(store, MOTION_STORE_POSE, place))
        return false;
    motion_store_read((uint16_t)(motion_store_address(MOTION_STORE_POSE, place) + AT_DATA), bytes,
                      sizeof bytes);
    for (uint8_t i = 0; i < MOTION_STORE_JOINTS; i++) {
        uint8_t high = bytes[POSE_HIGH_AT + i / 2];

        high = i % 2 ? high >> 4 : high & 15;
        positions[i] = (uint16_t)(high << 8 | bytes[i]);
        if (positions[i] > POSITION_MAX)
            positions[i] = CDS_POSE_NONE;
    }
    return true;
}

bool motion_store_read_step(const struct motion_store *store, uint8_t place, uint8_t index,
                            struct motion_store_step *step)
{
    uint16_t address = motion_store_address(MOTION_STORE_SEQUENCE, place);
    uint8_t bytes[STEP_BYTES];

    if (place == MOTION_STORE_NONE || !motion_store_is_used(store, MOTION_STORE_SEQUENCE, place) ||
        index >= motion_store_number(store, MOTION_STORE_SEQUENCE, place))
        return false;
    motion_store_read((uint16_t)(address + AT_DATA + (uint8_t)(index * STEP_BYTES)), bytes,
                      sizeof bytes);
    step->pose = bytes[0];
    step->time_10ms = (uint16_t)(bytes[1] | bytes[2] << 8);
    step->dwell_10ms = (uint16_t)(bytes[3] | (bytes[4] & STEP_DWELL_MASK) << 8);
    step->curve = bytes[4] >> STEP_CURVE_SHIFT & 3;
    step->passes = bytes[4] & STEP_PASSES;
    return true;
}

uint8_t motion_store_read_joints(const struct motion_store *store, uint8_t ids[MOTION_STORE_JOINTS])
{
    uint8_t place = motion_store_find(store, MOTION_STORE_JOINT_LIST, NULL, 0);

    if (place == MOTION_STORE_NONE)
        return 0;
    motion_store_read((uint16_t)(motion_store_address(MOTION_STORE_JOINT_LIST, place) + AT_DATA),
                      ids, MOTION_STORE_JOINTS);
    return motion_store_number(store, MOTION_STORE_JOINT_LIST, place);
}

bool motion_store_uses_joint(const struct motion_store *store, uint8_t joint)
{
    uint8_t offset = (uint8_t)(AT_DATA + POSE_HIGH_AT + joint / 2), place = 0;

    for (; (place = motion_store_next(store, MOTION_STORE_POSE, place)) != MOTION_STORE_NONE;
         place++) {
        uint8_t high =
            avr_eeprom_read((uint16_t)(motion_store_address(MOTION_STORE_POSE, place) + offset));

        if ((joint % 2 ? high >> 4 : high & 15) <= POSITION_MAX >> 8)
            return true;
    }
    return false;
}

uint8_t motion_store_read_servos(const struct motion_store *store, uint8_t ids[MOTION_STORE_JOINTS])
{
    uint8_t count = motion_store_read_joints(store, ids), used = 0;

    for (uint8_t joint = 0; joint < count; joint++)
        if (motion_store_uses_joint(store, joint))
            ids[used++] = ids[joint];
    return used;
}

uint8_t motion_store_read_autostart(const struct motion_store *store,
                                    char name[MOTION_STORE_NAME + 1])
{
    uint8_t place = motion_store_find(store, MOTION_STORE_AUTOSTART, NULL, 0);

    if (place == MOTION_STORE_NONE)
        return 0;
    motion_store_read((uint16_t)(motion_store_address(MOTION_STORE_AUTOSTART, place) + AT_DATA),
                      name, MOTION_STORE_NAME);
    name[MOTION_STORE_NAME] = '\0';
    return motion_store_number(store, MOTION_STORE_AUTOSTART, place);
}
