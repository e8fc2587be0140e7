/* SPDX-License-Identifier: MIT */
/* Saves and deletes poses and sequences in the EEPROM, one byte in a poll; see motion_store.h.
 *
 * A save writes a free place of its kind:
 *
 *   1. erase the version of the stale record that an interrupted save has left, if there is one
 *   2. erase the version of the place
 *   3. write the other bytes
 *   4. write the version: the new record is valid, the older record is stale
 *   5. erase the version of the stale record
 *
 * A delete does steps 1 and 2 in the place of the record. */
#include "robot/motion_store_internal.h"

#include <string.h>

#include "cds55xx/motion.h" // CDS_POSE_NONE
#include "robot/crc.h"
#include "robot/letter.h"
#include "compiler.h" // OPTIMIZER_BARRIER()

/* --- what may be saved ------------------------------------------------------------------------ */

bool motion_store_is_name(const char *name, uint8_t length)
{
    if (length == 0 || length > MOTION_STORE_NAME || !is_letter(name[0]))
        return false;
    while (--length > 0)
        if (!is_letter(name[length]) && !(name[length] >= '0' && name[length] <= '9'))
            return false;
    return true;
}

static bool are_joints(const struct motion_store_record *record)
{
    if (record->length > 0 || record->count == 0 || record->count > MOTION_STORE_JOINTS)
        return false;
    for (uint8_t i = 0; i < record->count; i++) {
        if (record->ids[i] > 253)
            return false;
        for (uint8_t other = 0; other < i; other++)
            if (record->ids[other] == record->ids[i])
                return false;
    }
    return true;
}

static bool are_positions(const uint16_t *positions)
{
    for (uint8_t i = 0; i < MOTION_STORE_JOINTS; i++)
        if (positions[i] > POSITION_MAX && positions[i] != CDS_POSE_NONE)
            return false;
    return true;
}

static bool are_steps(const struct motion_store_record *record)
{
    uint8_t steps = (uint8_t)(record->kept + record->count);

    if (record->kept > MOTION_STORE_STEPS || record->count > MOTION_STORE_STEPS || steps == 0 ||
        steps > MOTION_STORE_STEPS)
        return false;
    for (uint8_t i = 0; i < record->count; i++) {
        const struct motion_store_step *step = &record->steps[i];

        if (step->time_10ms == 0 || step->time_10ms > MOTION_STORE_TIME_MAX ||
            step->dwell_10ms > MOTION_STORE_DWELL_MAX || step->curve > CDS_MOTION_BY_SERVO)
            return false;
    }
    return true;
}

static bool is_good(const struct motion_store_record *record)
{
    if (record->kind == MOTION_STORE_JOINT_LIST)
        return are_joints(record);
    if (record->kind == MOTION_STORE_AUTOSTART)
        return record->length == 0 && record->count > 0;
    if (!motion_store_is_name(record->name, record->length))
        return false;
    return record->kind == MOTION_STORE_POSE ? are_positions(record->positions) : are_steps(record);
}

/* True if each joint that a stored pose uses keeps its place in the list. */
static bool keeps_joints(const struct motion_store *store, const struct motion_store_record *record)
{
    uint8_t ids[MOTION_STORE_JOINTS], count = motion_store_read_joints(store, ids);
    uint8_t joints = count ? count : MOTION_STORE_JOINTS; // without a list no position has a servo

    for (uint8_t joint = 0; joint < joints; joint++) {
        bool is_kept = count && joint < record->count && ids[joint] == record->ids[joint];

        if (!is_kept && motion_store_uses_joint(store, joint))
            return false;
    }
    return true;
}

/* --- beginning -------------------------------------------------------------------------------- */

static enum motion_store_result begin(struct motion_store *store,
                                      const struct motion_store_record *record, bool is_delete)
{
    store->record = record;
    store->size = motion_store_area(record->kind)->size;
    store->is_delete = is_delete;
    store->has_place = is_delete;
    store->has_number = is_delete;
    store->is_written = false;
    return store->result = MOTION_STORE_SAVING;
}

enum motion_store_result motion_store_save(struct motion_store *store,
                                           const struct motion_store_record *record)
{
    uint8_t kind = record->kind, old;

    OPTIMIZER_BARRIER(store);
    if (motion_store_is_saving(store))
        return MOTION_STORE_BUSY;
    if (!is_good(record))
        return MOTION_STORE_BAD;
    old = motion_store_place_of(store, kind, record->name, record->length);
    if (old == MOTION_STORE_NONE && motion_store_room(store, kind) == 0)
        return MOTION_STORE_FULL;
    if (kind == MOTION_STORE_SEQUENCE && record->kept > 0 &&
        (!motion_store_is_whole(store, kind, old) ||
         record->kept > motion_store_number(store, kind, old)))
        return MOTION_STORE_MISSING;
    if (kind == MOTION_STORE_JOINT_LIST && !keeps_joints(store, record))
        return MOTION_STORE_IN_USE;
    store->old = old;
    store->place = store->last[kind];
    return begin(store, record, false);
}

enum motion_store_result motion_store_delete(struct motion_store *store,
                                             const struct motion_store_record *record)
{
    uint8_t place;

    OPTIMIZER_BARRIER(store);
    if (motion_store_is_saving(store))
        return MOTION_STORE_BUSY;
    place = motion_store_place_of(store, record->kind, record->name, record->length);
    if (place == MOTION_STORE_NONE)
        return MOTION_STORE_MISSING;
    store->place = place;
    store->step = motion_store_area(record->kind)->size;
    return begin(store, record, true);
}

/* --- place and number ------------------------------------------------------------------------- */

/* The number of a pose is that of the older record. Else search_number() looks for one. */
static void begin_number(struct motion_store *store)
{
    const struct motion_store_record *record = store->record;

    store->step = 0;
    store->crc = crc_add(CRC_BEGIN, MOTION_STORE_VERSION);
    store->number = (uint8_t)(record->kept + record->count);
    store->has_number = record->kind != MOTION_STORE_POSE;
    if (store->has_number)
        return;
    store->number = (uint8_t)store->saves; // most likely free
    if (motion_store_is_whole(store, MOTION_STORE_POSE, store->old)) {
        store->number = avr_eeprom_read(
            (uint16_t)(motion_store_address(MOTION_STORE_POSE, store->old) + AT_NUMBER));
        store->has_number = true;
    }
}

/* Looks at the next place in each poll, from the last save on, round all places. So no place is
 * written twice before each other free place was. One place is always free. */
static void search_place(struct motion_store *store)
{
    uint8_t kind = store->record->kind;

    if (++store->place >= motion_store_area(kind)->places)
        store->place = 0;
    store->last[kind] = store->place;
    store->has_place = !motion_store_is_used(store, kind, store->place);
    if (store->has_place)
        begin_number(store);
}

static bool sequence_has(uint8_t place, uint8_t number)
{
    uint16_t address = motion_store_address(MOTION_STORE_SEQUENCE, place);
    uint8_t steps = avr_eeprom_read((uint16_t)(address + AT_NUMBER));

    address = (uint16_t)(address + AT_DATA);
    for (; steps > 0; steps--, address = (uint16_t)(address + STEP_BYTES))
        if (avr_eeprom_read(address) == number)
            return true;
    return false;
}

/* Looks at all poses, then at one sequence in each poll. A number that a sequence has is not free,
 * even if its pose is gone. */
static void search_number(struct motion_store *store)
{
    uint8_t step = store->step++, sequence = (uint8_t)(step - 1);
    bool is_taken = step == 0 ? motion_store_search(store, MOTION_STORE_POSE, AT_NUMBER,
                                                    &store->number, 1) != MOTION_STORE_NONE
                              : motion_store_is_used(store, MOTION_STORE_SEQUENCE, sequence) &&
                                    sequence_has(sequence, store->number);

    if (is_taken)
        store->number++;
    store->has_number = !is_taken && step == motion_store_area(MOTION_STORE_SEQUENCE)->places;
    if (is_taken || store->has_number)
        store->step = 0;
}

/* --- the bytes of a record -------------------------------------------------------------------- */

static uint8_t pose_byte(const uint16_t *positions, uint8_t index)
{
    if (index < POSE_HIGH_AT)
        return (uint8_t)positions[index];
    positions += 2 * (index - POSE_HIGH_AT);
    return (uint8_t)((positions[0] >> 8 & 15) | (uint8_t)(positions[1] >> 8 << 4));
}

static uint8_t step_byte(const struct motion_store_step *step, uint8_t index)
{
    switch (index) {
    case 0: return step->pose;
    case 1: return (uint8_t)step->time_10ms;
    case 2: return (uint8_t)(step->time_10ms >> 8);
    case 3: return (uint8_t)step->dwell_10ms;
    default:
        return (uint8_t)((uint8_t)(step->dwell_10ms >> 8) |
                         (uint8_t)(step->curve << STEP_CURVE_SHIFT) |
                         (step->passes ? STEP_PASSES : 0));
    }
}

/* Byte `index` of the data. Behind their end the record takes what stands there: `found`. */
static uint8_t data_byte(const struct motion_store *store, uint8_t index, uint8_t found)
{
    const struct motion_store_record *record = store->record;
    uint8_t step = index / STEP_BYTES;

    if (record->kind == MOTION_STORE_POSE)
        return pose_byte(record->positions, index);
    if (record->kind == MOTION_STORE_JOINT_LIST)
        return index < record->count ? record->ids[index] : found;
    if (record->kind == MOTION_STORE_AUTOSTART)
        return (uint8_t)record->sequence[index];
    if (step < record->kept)
        return avr_eeprom_read(
            (uint16_t)(motion_store_address(MOTION_STORE_SEQUENCE, store->old) + AT_DATA + index));
    step = (uint8_t)(step - record->kept);
    return step < record->count ? step_byte(&record->steps[step], index % STEP_BYTES) : found;
}

/* Byte `offset` of the new record, where `found` stands now. */
static uint8_t record_byte(const struct motion_store *store, uint8_t offset, uint8_t found)
{
    const struct motion_store_record *record = store->record;
    uint8_t data_end = (uint8_t)(store->size - 2);

    if (offset == AT_VERSION)
        return MOTION_STORE_ERASED; // until all others stand
    if (offset >= data_end)
        return (uint8_t)(offset == data_end ? store->crc : store->crc >> 8);
    if (offset >= AT_DATA)
        return data_byte(store, (uint8_t)(offset - AT_DATA), found);
    if (offset >= AT_NAME) {
        offset = (uint8_t)(offset - AT_NAME);
        return offset < record->length ? (uint8_t)record->name[offset] : 0;
    }
    if (offset == AT_NUMBER)
        return store->number;
    return (uint8_t)((store->saves + 1) >> 8 * (offset - AT_SERIAL));
}

/* --- going on --------------------------------------------------------------------------------- */

/* The version of the record is written: the new record is valid, or the deleted one is invalid. */
static void decide(struct motion_store *store)
{
    uint8_t kind = store->record->kind;

    motion_store_set_used(store, kind, store->place, !store->is_delete);
    if (store->is_delete)
        return;
    store->saves++;
    if (store->old == MOTION_STORE_NONE)
        return;
    motion_store_set_used(store, kind, store->old, false);
    store->stale = motion_store_address(kind, store->old);
}

static void end_step(struct motion_store *store, uint8_t byte)
{
    uint8_t size = store->size;

    store->is_written = false;
    if (store->stale != 0) {
        store->stale = 0;
    } else {
        if (store->step > AT_VERSION && store->step < size - 2)
            store->crc = crc_add(store->crc, byte);
        if (store->step++ == size)
            decide(store);
    }
    if (store->step > size && store->stale == 0)
        store->result = MOTION_STORE_SAVED;
}

/* Writes the byte of the present step; the next poll reads it back. A byte that is right already is
 * not written. If the version of a stale record cannot be erased, the save goes on: the record with
 * the higher serial number is valid. */
static void go_on(struct motion_store *store)
{
    uint8_t kind = store->record->kind, size = store->size, step = store->step;
    uint16_t address = store->stale;
    uint8_t found, byte = MOTION_STORE_ERASED;

    if (address == 0)
        address = (uint16_t)(motion_store_address(kind, store->place) + (step < size ? step : 0));
    found = avr_eeprom_read(address);
    if (store->stale == 0 && step < size)
        byte = record_byte(store, step, found);
    else if (store->stale == 0 && !store->is_delete)
        byte = MOTION_STORE_VERSION;
    if (found == byte || (store->is_written && store->stale != 0)) {
        end_step(store, byte);
    } else if (store->is_written) {
        store->result = MOTION_STORE_FAILED;
    } else {
        avr_eeprom_write(address, byte);
        store->is_written = true;
    }
}

bool motion_store_poll(struct motion_store *store)
{
    OPTIMIZER_BARRIER(store);
    if (store->result != MOTION_STORE_SAVING)
        return false;
    if (!avr_eeprom_ready())
        return true;
    if (!store->has_place)
        search_place(store);
    else if (!store->has_number)
        search_number(store);
    else
        go_on(store);
    return store->result == MOTION_STORE_SAVING;
}

void motion_store_abort(struct motion_store *store)
{
    if (store->result != MOTION_STORE_SAVING)
        return;
    if (store->is_written && store->stale == 0 && store->step == store->size)
        decide(store);
    store->result = MOTION_STORE_IDLE;
}
