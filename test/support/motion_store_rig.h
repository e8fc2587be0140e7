/* SPDX-License-Identifier: MIT */
/* A motion store over the EEPROM of eeprom_fake.h, and a model of what it must hold. A suite sets
 * the EEPROM's size with rig_reset(); rig_assert() compares the store with the model. */
#ifndef MOTION_STORE_RIG_H
#define MOTION_STORE_RIG_H

#include <string.h>

#include "cds55xx/motion.h" // CDS_POSE_NONE
#include "robot/motion_store_internal.h"
#include "eeprom_fake.h"
#include "unity.h"

#ifdef __AVR__
enum { RIG_EEPROM = 2048, RIG_POSES = 6, RIG_SEQUENCES = 3 };
#else
enum { RIG_EEPROM = 4096, RIG_POSES = 70, RIG_SEQUENCES = 14 };
#endif

/* A step of a sequence: made from `seed`, to the pose `name` that was the `born`th of all. */
struct rig_step {
    uint8_t name, seed;
    uint16_t born;
};

/* What the store must hold. Pose 3 has the name "p3", sequence 4 "s4"; their content comes from
 * seeds. */
struct rig_model {
    uint8_t joints;               // number of IDs
    uint8_t start;                // delay of the autostart; 0: there is none
    uint8_t start_seed;           // of its name
    uint8_t pose[RIG_POSES];      // seed, 0: there is none
    uint16_t born[RIG_POSES];     // which pose of all that ever were
    uint8_t steps[RIG_SEQUENCES]; // 0: there is none
    struct rig_step step[RIG_SEQUENCES][MOTION_STORE_STEPS];
};

/* What is done to the store. */
enum rig_operation {
    SAVE_POSE,
    DELETE_POSE,
    SAVE_STEPS,
    ADD_STEP,
    DELETE_STEPS,
    SAVE_JOINTS,
    SAVE_START,
    DELETE_START,
    OPERATIONS
};

static uint8_t rig_bytes[RIG_EEPROM];
static struct motion_store store;
static struct settings_store rig_settings; // of a chip on which they are not being saved
static struct rig_model model;
static uint16_t rig_births;

/* What is being saved. */
static struct motion_store_record record;
static char record_name[MOTION_STORE_NAME + 1];
static uint16_t positions[MOTION_STORE_JOINTS];
static uint8_t ids[MOTION_STORE_JOINTS];
static struct motion_store_step steps[MOTION_STORE_STEPS];

static inline void rig_reset(uint16_t size)
{
    eeprom_fake_reset_to(rig_bytes, size);
    memset(&model, 0, sizeof model);
    motion_store_load(&store, &rig_settings);
}

static inline void rig_power_up(void)
{
    eeprom_fake_power_up();
    memset(&store, 0xA5, sizeof store);
    motion_store_load(&store, &rig_settings);
}

/* Goes on until the save is over or the power has gone. */
static inline uint8_t rig_finish(void)
{
    for (uint16_t polls = 0; !eeprom_fake.has_no_power && motion_store_poll(&store); polls++)
        TEST_ASSERT_TRUE(polls < 60000u);
    while (!avr_eeprom_ready()) {
    }
    return store.result;
}

/* --- content ---------------------------------------------------------------------------------- */

static inline void rig_name(uint8_t kind, uint8_t number)
{
    record_name[0] = kind == MOTION_STORE_POSE ? 'p' : 's';
    record_name[1] = (char)('0' + number / 10);
    record_name[2] = (char)('0' + number % 10);
    record_name[3] = '\0';
    record = (struct motion_store_record){.kind = kind, .name = record_name, .length = 3};
}

static inline uint16_t rig_position(uint8_t seed, uint8_t joint)
{
    uint16_t position = (uint16_t)((seed * 211u + joint * 331u) % 1200u);

    return position > POSITION_MAX ? CDS_POSE_NONE : position;
}

static inline struct motion_store_step rig_step(uint8_t seed)
{
    return (struct motion_store_step){.curve = seed % 4,
                                      .passes = seed & 8,
                                      .time_10ms = (uint16_t)(1 + seed * 233u),
                                      .dwell_10ms = (uint16_t)(seed * 25u)};
}

static inline uint8_t rig_id(uint8_t joint)
{
    return (uint8_t)(253 - 5 * joint);
}

/* --- operations ------------------------------------------------------------------------------- */

/* A step to any pose of the model, into model and steps[at]; pose 0 if there is no other. */
static inline void rig_add(struct rig_model *new, uint8_t sequence, uint8_t at, uint8_t seed)
{
    uint8_t name = seed % RIG_POSES, place;
    struct rig_step *step = &new->step[sequence][new->steps[sequence]++];

    while (new->pose[name] == 0 && name > 0)
        name--;
    *step = (struct rig_step){.name = name, .seed = seed, .born = new->born[name]};
    steps[at] = rig_step(seed);
    if (new->pose[name] == 0) {
        *step = (struct rig_step){.name = 0, .seed = seed, .born = UINT16_MAX};
        return;
    }
    rig_name(MOTION_STORE_POSE, name);
    place = motion_store_find(&store, MOTION_STORE_POSE, record_name, 3);
    TEST_ASSERT_NOT_EQUAL(MOTION_STORE_NONE, place);
    steps[at].pose = motion_store_number(&store, MOTION_STORE_POSE, place);
}

static inline void rig_prepare_pose(struct rig_model *new, uint8_t name, uint8_t seed)
{
    for (uint8_t i = 0; i < MOTION_STORE_JOINTS; i++)
        positions[i] = rig_position(seed, i);
    rig_name(MOTION_STORE_POSE, name);
    record.positions = positions;
    if (new->pose[name] == 0)
        new->born[name] = ++rig_births;
    new->pose[name] = seed;
}

static inline void rig_prepare_steps(struct rig_model *new, uint8_t name, uint8_t seed,
                                     uint8_t kept, uint8_t count)
{
    new->steps[name] = kept;
    for (uint8_t i = 0; i < count; i++)
        rig_add(new, name, i, (uint8_t)(seed + i));
    rig_name(MOTION_STORE_SEQUENCE, name);
    record.steps = steps;
    record.kept = kept;
    record.count = count;
}

static inline void rig_prepare_joints(struct rig_model *new, uint8_t count)
{
    for (uint8_t i = 0; i < count; i++)
        ids[i] = rig_id(i);
    record = (struct motion_store_record){
        .kind = MOTION_STORE_JOINT_LIST, .name = record_name, .count = count, .ids = ids};
    new->joints = count;
}

static inline void rig_prepare_start(struct rig_model *new, uint8_t seed)
{
    rig_name(MOTION_STORE_SEQUENCE, seed % 100);
    memset(record_name + 3, 0, sizeof record_name - 3);
    new->start = (uint8_t)(seed | 1);
    new->start_seed = seed;
    record = (struct motion_store_record){
        .kind = MOTION_STORE_AUTOSTART, .count = new->start, .sequence = record_name};
}

/* Begins an operation on record `name` (poses: modulo RIG_POSES and so on); `new` becomes what the
 * store must hold after it. False: it was refused, and `new` is as before. */
static inline bool rig_begin(enum rig_operation operation, uint8_t name, uint8_t seed,
                             struct rig_model *new)
{
    uint8_t pose = name % RIG_POSES, sequence = name % RIG_SEQUENCES, kept = model.steps[sequence];
    enum motion_store_result result;

    *new = model;
    switch (operation) {
    case SAVE_POSE: rig_prepare_pose(new, pose, (uint8_t)(seed | 1)); break;
    case DELETE_POSE:
        rig_name(MOTION_STORE_POSE, pose);
        new->pose[pose] = 0;
        break;
    case SAVE_STEPS: rig_prepare_steps(new, sequence, seed, 0, (uint8_t)(1 + seed % 16)); break;
    case ADD_STEP:
        if (kept == MOTION_STORE_STEPS)
            return false;
        rig_prepare_steps(new, sequence, seed, kept, 1);
        break;
    case DELETE_STEPS:
        rig_name(MOTION_STORE_SEQUENCE, sequence);
        new->steps[sequence] = 0;
        break;
    case SAVE_START: rig_prepare_start(new, seed); break;
    case DELETE_START:
        record = (struct motion_store_record){.kind = MOTION_STORE_AUTOSTART};
        new->start = 0;
        break;
    default:
        rig_prepare_joints(new, (uint8_t)(model.joints + (model.joints < MOTION_STORE_JOINTS)));
    }
    result = operation == DELETE_POSE || operation == DELETE_STEPS || operation == DELETE_START
                 ? motion_store_delete(&store, &record)
                 : motion_store_save(&store, &record);
    if (result == MOTION_STORE_SAVING)
        return true;
    TEST_ASSERT_TRUE(result == MOTION_STORE_FULL || result == MOTION_STORE_MISSING ||
                     (result == MOTION_STORE_IN_USE && operation == SAVE_JOINTS));
    *new = model;
    return false;
}

/* --- comparing -------------------------------------------------------------------------------- */

/* These return false if the store differs from the model: a test may allow one of two models. */
static inline bool rig_pose_is(const struct rig_model *as, uint8_t name)
{
    uint16_t read[MOTION_STORE_JOINTS];
    uint8_t place;

    rig_name(MOTION_STORE_POSE, name);
    place = motion_store_find(&store, MOTION_STORE_POSE, record_name, 3);
    if (place == MOTION_STORE_NONE || as->pose[name] == 0)
        return place == MOTION_STORE_NONE && as->pose[name] == 0;
    if (!motion_store_read_pose(&store, place, read))
        return false;
    for (uint8_t i = 0; i < MOTION_STORE_JOINTS; i++)
        if (read[i] != rig_position(as->pose[name], i))
            return false;
    return true;
}

/* A step names the pose that it was made for, or none if that was deleted. */
static inline bool rig_step_is(const struct rig_model *as, const struct rig_step *step,
                               uint8_t number)
{
    char name[MOTION_STORE_NAME + 1];
    uint8_t place;

    if (step->born == UINT16_MAX)
        return true;
    place = motion_store_pose_of(&store, number);
    if (as->pose[step->name] == 0 || as->born[step->name] != step->born)
        return place == MOTION_STORE_NONE;
    rig_name(MOTION_STORE_POSE, step->name);
    return motion_store_read_name(&store, MOTION_STORE_POSE, place, name) &&
           strcmp(name, record_name) == 0;
}

static inline bool rig_sequence_is(const struct rig_model *as, uint8_t name)
{
    struct motion_store_step read;
    uint8_t place;

    rig_name(MOTION_STORE_SEQUENCE, name);
    place = motion_store_find(&store, MOTION_STORE_SEQUENCE, record_name, 3);
    if (place == MOTION_STORE_NONE || as->steps[name] == 0)
        return place == MOTION_STORE_NONE && as->steps[name] == 0;
    for (uint8_t i = 0; i < as->steps[name]; i++) {
        const struct rig_step *step = &as->step[name][i];
        struct motion_store_step due = rig_step(step->seed);

        if (!motion_store_read_step(&store, place, i, &read) || read.curve != due.curve ||
            read.passes != due.passes || read.time_10ms != due.time_10ms ||
            read.dwell_10ms != due.dwell_10ms || !rig_step_is(as, step, read.pose))
            return false;
    }
    return !motion_store_read_step(&store, place, as->steps[name], &read);
}

static inline bool rig_joints_are(const struct rig_model *as)
{
    uint8_t read[MOTION_STORE_JOINTS], count = motion_store_read_joints(&store, read);

    for (uint8_t i = 0; i < count; i++)
        if (read[i] != rig_id(i))
            return false;
    return count == as->joints;
}

static inline bool rig_start_is(const struct rig_model *as)
{
    char name[MOTION_STORE_NAME + 1];
    uint8_t delay = motion_store_read_autostart(&store, name);

    if (delay == 0 || as->start == 0)
        return delay == as->start;
    rig_name(MOTION_STORE_SEQUENCE, as->start_seed % 100);
    return delay == as->start && strcmp(name, record_name) == 0;
}

static inline bool rig_is(const struct rig_model *as)
{
    uint8_t poses = 0, sequences = 0;

    for (uint8_t name = 0; name < RIG_POSES; name++) {
        if (!rig_pose_is(as, name))
            return false;
        poses = (uint8_t)(poses + (as->pose[name] != 0));
    }
    for (uint8_t name = 0; name < RIG_SEQUENCES; name++) {
        if (!rig_sequence_is(as, name))
            return false;
        sequences = (uint8_t)(sequences + (as->steps[name] != 0));
    }
    return rig_joints_are(as) && rig_start_is(as) &&
           motion_store_room(&store, MOTION_STORE_POSE) ==
               motion_store_capacity(MOTION_STORE_POSE) - poses &&
           motion_store_room(&store, MOTION_STORE_SEQUENCE) ==
               motion_store_capacity(MOTION_STORE_SEQUENCE) - sequences;
}

/* Does an operation to its end, and checks its effect. */
static inline void rig_do(enum rig_operation operation, uint8_t name, uint8_t seed)
{
    struct rig_model new;

    TEST_ASSERT_TRUE(rig_begin(operation, name, seed, &new));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVED, rig_finish());
    model = new;
}

#endif
