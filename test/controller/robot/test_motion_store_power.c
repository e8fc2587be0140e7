/* SPDX-License-Identifier: MIT */
/* Poses and sequences in the EEPROM when something goes wrong: the power fails, a save is aborted,
 * a cell is dead, a byte is damaged. Then the old record or the new one is valid, and so are all
 * other records. */
#include "motion_store_rig.h"

/* A test cuts the power at every CUT_STRIDE-th write, and so on. The host tries each write; the
 * simulated AVR, which is slower, tries some. */
#ifdef __AVR__
enum { CUT_STRIDE = 19, ABORT_STRIDE = 43, DAMAGE_STRIDE = 7, HISTORY = 60 };
#else
enum { CUT_STRIDE = 1, ABORT_STRIDE = 1, DAMAGE_STRIDE = 1, HISTORY = 3000 };
#endif

void setUp(void)
{
    rig_reset(RIG_EEPROM);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, eeprom_fake.breaches);
}

/* Records of all kinds, saved, replaced and deleted. */
static void build(void)
{
    rig_reset(RIG_EEPROM);
    rig_do(SAVE_JOINTS, 0, 0);
    rig_do(SAVE_JOINTS, 0, 0);
    for (uint8_t name = 0; name < 4; name++)
        rig_do(SAVE_POSE, name, (uint8_t)(10 * name));
    rig_do(SAVE_STEPS, 0, 3);
    rig_do(SAVE_STEPS, 1, 20);
    rig_do(SAVE_POSE, 1, 70);
    rig_do(DELETE_POSE, 2, 0);
    rig_do(ADD_STEP, 1, 80);
    rig_do(SAVE_START, 0, 3);
    rig_do(SAVE_START, 0, 88);
    TEST_ASSERT_TRUE(rig_is(&model));
}

struct change {
    enum rig_operation operation;
    uint8_t name, seed;
};

/* For each kind of record: save a new one, replace an older one, delete one. */
static const struct change changes[] = {
    {SAVE_POSE, 4, 90},   {SAVE_POSE, 3, 91},  {DELETE_POSE, 1, 0},  {SAVE_STEPS, 2, 14},
    {SAVE_STEPS, 0, 100}, {ADD_STEP, 1, 101},  {ADD_STEP, 2, 102},   {DELETE_STEPS, 1, 0},
    {SAVE_JOINTS, 0, 0},  {SAVE_START, 0, 45}, {DELETE_START, 0, 0},
};
enum { CHANGES = sizeof changes / sizeof changes[0] };

static bool begin(const struct change *change, struct rig_model *new)
{
    return rig_begin(change->operation, change->name, change->seed, new);
}

/* The old records are valid, or the old ones with the new one. */
static bool assert_old_or_new(const struct rig_model *new)
{
    bool is_new = rig_is(new);

    TEST_ASSERT_TRUE(is_new || rig_is(&model));
    if (is_new)
        model = *new;
    return is_new;
}

/* All later saves work. */
static void assert_later_saves_work(void)
{
    rig_do(SAVE_POSE, 3, 200);
    rig_do(SAVE_POSE, 5, 201);
    rig_do(ADD_STEP, 2, 202);
    rig_do(SAVE_JOINTS, 0, 0);
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
}

/* The power fails in write `at` of a change. False: the change was over before. */
static bool cut(const struct change *change, uint16_t at, uint8_t kind)
{
    struct rig_model new;
    bool was_cut, is_new;

    build();
    TEST_ASSERT_TRUE(begin(change, &new));
    eeprom_fake.writes = 0;
    eeprom_fake.cut_at = at;
    eeprom_fake.cut = kind;
    rig_finish();
    was_cut = eeprom_fake.has_no_power;
    rig_power_up();
    is_new = assert_old_or_new(&new);
    TEST_ASSERT_TRUE(was_cut || is_new);
    TEST_ASSERT_EQUAL_UINT8(0, store.damaged);
    assert_later_saves_work();
    return was_cut;
}

/* Returns the number of writes that all changes of the kind have. */
static uint16_t cut_all(enum rig_operation operation)
{
    uint16_t writes = 0;

    for (uint8_t i = 0; i < CHANGES; i++)
        if (changes[i].operation == operation)
            for (uint8_t kind = 0; kind < CUTS; kind++)
                for (uint16_t at = 1u + kind % CUT_STRIDE; cut(&changes[i], at, kind);
                     at = (uint16_t)(at + CUT_STRIDE))
                    writes++;
    return writes;
}

void test_power_lost_at_each_byte_of_saving_a_pose(void)
{
    TEST_ASSERT_TRUE(cut_all(SAVE_POSE) >= 2 * 38 * CUTS / CUT_STRIDE);
}

void test_power_lost_at_each_byte_of_deleting_a_pose(void)
{
    TEST_ASSERT_TRUE(cut_all(DELETE_POSE) * CUT_STRIDE >= CUTS);
}

void test_power_lost_at_each_byte_of_saving_a_sequence(void)
{
    TEST_ASSERT_TRUE(cut_all(SAVE_STEPS) >= 2 * 30 * CUTS / CUT_STRIDE);
}

void test_power_lost_at_each_byte_of_adding_a_step(void)
{
    TEST_ASSERT_TRUE(cut_all(ADD_STEP) >= 2 * 15 * CUTS / CUT_STRIDE);
}

void test_power_lost_at_each_byte_of_deleting_a_sequence(void)
{
    TEST_ASSERT_TRUE(cut_all(DELETE_STEPS) * CUT_STRIDE >= CUTS);
}

void test_power_lost_at_each_byte_of_saving_joints(void)
{
    TEST_ASSERT_TRUE(cut_all(SAVE_JOINTS) >= 8 * CUTS / CUT_STRIDE);
}

void test_power_lost_at_each_byte_of_saving_an_autostart(void)
{
    TEST_ASSERT_TRUE(cut_all(SAVE_START) >= 6 * CUTS / CUT_STRIDE);
}

void test_power_lost_at_each_byte_of_deleting_an_autostart(void)
{
    TEST_ASSERT_TRUE(cut_all(DELETE_START) * CUT_STRIDE >= CUTS);
}

/* A change is aborted after so many polls. False: it was over before. In the session, and after
 * power-up, the same records stand. */
static bool abort_after(const struct change *change, uint16_t polls, uint8_t slow)
{
    struct rig_model new;
    bool was_over = false;

    build();
    eeprom_fake.slow = slow;
    TEST_ASSERT_TRUE(begin(change, &new));
    while (polls-- > 0 && !was_over)
        was_over = !motion_store_poll(&store);
    motion_store_abort(&store);
    TEST_ASSERT_EQUAL_UINT8(was_over ? MOTION_STORE_SAVED : MOTION_STORE_IDLE, store.result);
    while (motion_store_is_saving(&store)) {
    }
    TEST_ASSERT_TRUE(assert_old_or_new(&new) || !was_over);
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
    assert_later_saves_work();
    return !was_over;
}

/* Aborts `change` after 0, ABORT_STRIDE, ... polls, until it is over before the abort. Returns how
 * many aborts came before its end. `slow` is that of the EEPROM. */
static uint16_t abort_all(const struct change *change, uint8_t slow)
{
    uint16_t aborts = 0;

    while (abort_after(change, (uint16_t)(aborts * ABORT_STRIDE), slow))
        aborts++;
    return aborts;
}

void test_abort_at_any_poll_leaves_old_or_new_record(void)
{
    uint16_t aborts = 0;

    for (uint8_t i = 0; i < CHANGES; i++)
        aborts = (uint16_t)(aborts + abort_all(&changes[i], 0));
    TEST_ASSERT_TRUE(aborts * ABORT_STRIDE >= 800);
}

void test_abort_while_eeprom_writes_leaves_old_or_new(void)
{
    uint16_t aborts = abort_all(&changes[1], 2);

    TEST_ASSERT_TRUE(aborts * ABORT_STRIDE >= 150);
}

/* The cell at `offset` of the place that the next save takes is dead. */
static void save_over_dead_cell(uint8_t offset)
{
    struct rig_model new;
    uint8_t result;

    build();
    TEST_ASSERT_TRUE(rig_begin(SAVE_POSE, 3, 91, &new));
    while (!store.has_place)
        motion_store_poll(&store);
    eeprom_fake.dead = (uint16_t)(motion_store_address(MOTION_STORE_POSE, store.place) + offset);
    eeprom_fake.bytes[eeprom_fake.dead] = 0x55;
    result = rig_finish();
    TEST_ASSERT_TRUE(result == MOTION_STORE_FAILED || result == MOTION_STORE_SAVED);
    if (result == MOTION_STORE_SAVED)
        model = new; // 0x55 is what was to be written
    TEST_ASSERT_TRUE(rig_is(&model));
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
    if (!rig_begin(SAVE_POSE, 3, 93, &new) || rig_finish() == MOTION_STORE_FAILED) {
        TEST_ASSERT_TRUE(
            rig_begin(SAVE_POSE, 3, 93, &new)); // one attempt after a power-up may fail
        rig_finish();
    }
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVED, store.result);
    model = new;
    TEST_ASSERT_TRUE(rig_is(&model));
}

void test_dead_cell_fails_save_and_next_save_works(void)
{
    for (uint8_t offset = 0; offset < motion_store_area(MOTION_STORE_POSE)->size;
         offset = (uint8_t)(offset + DAMAGE_STRIDE))
        save_over_dead_cell(offset);
}

/* The version of the older record cannot be taken away: the new record counts, also after power-up.
 */
void test_old_version_that_stays_does_not_count(void)
{
    struct rig_model new;
    uint16_t address;

    build();
    TEST_ASSERT_TRUE(rig_begin(SAVE_POSE, 3, 91, &new));
    address = motion_store_address(MOTION_STORE_POSE, store.old);
    while (motion_store_poll(&store))
        eeprom_fake.bytes[address] = MOTION_STORE_VERSION;
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVED, store.result);
    model = new;
    TEST_ASSERT_TRUE(rig_is(&model));
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
    assert_later_saves_work();
}

/* Deleting takes also the older record away, which a lost power left behind. */
void test_delete_after_power_cut_leaves_no_older_record(void)
{
    struct rig_model new;

    build();
    TEST_ASSERT_TRUE(rig_begin(SAVE_POSE, 3, 91, &new));
    while (store.stale == 0 && motion_store_poll(&store)) {
    }
    TEST_ASSERT_NOT_EQUAL(0, store.stale); // the new version stands
    rig_power_up();
    model = new;
    TEST_ASSERT_TRUE(rig_is(&model));
    rig_do(DELETE_POSE, 3, 0);
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
}

void test_delete_after_abort_leaves_no_older_record(void)
{
    struct rig_model new;

    build();
    TEST_ASSERT_TRUE(rig_begin(SAVE_POSE, 3, 91, &new));
    while (store.stale == 0 && motion_store_poll(&store)) {
    }
    motion_store_abort(&store);
    model = new;
    TEST_ASSERT_TRUE(rig_is(&model));
    rig_do(DELETE_POSE, 3, 0);
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
}

/* --- damage ----------------------------------------------------------------------------------- */

/* Forgets in `model` what the record at a place has. */
static void forget(uint8_t kind, uint8_t place)
{
    char name[MOTION_STORE_NAME + 1];
    uint8_t number;

    TEST_ASSERT_TRUE(motion_store_read_name(&store, kind, place, name));
    number = (uint8_t)((name[1] - '0') * 10 + name[2] - '0');
    if (kind == MOTION_STORE_JOINT_LIST)
        model.joints = 0;
    else if (kind == MOTION_STORE_AUTOSTART)
        model.start = 0;
    else if (kind == MOTION_STORE_POSE)
        model.pose[number] = 0;
    else
        model.steps[number] = 0;
}

static void damage(uint8_t kind, uint8_t place, uint8_t offset, uint8_t mask)
{
    uint8_t *byte = &eeprom_fake.bytes[motion_store_address(kind, place) + offset];
    struct rig_model before = model;
    char name[MOTION_STORE_NAME + 1];

    forget(kind, place);
    *byte ^= mask;
    TEST_ASSERT_FALSE(motion_store_read_name(&store, kind, place, name));
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
    TEST_ASSERT_EQUAL_UINT8(offset > 0, store.damaged);
    *byte ^= mask;
    rig_power_up();
    model = before;
}

void test_damaged_byte_of_a_record_removes_only_the_record(void)
{
    static const uint8_t masks[] = {0x01, 0x10, 0x80, UINT8_MAX};

    build();
    for (uint8_t kind = 0; kind < MOTION_STORE_KINDS; kind++) {
        uint8_t place = 0;

        for (; (place = motion_store_next(&store, kind, place)) != MOTION_STORE_NONE; place++)
            for (uint8_t offset = 0; offset < motion_store_area(kind)->size;
                 offset = (uint8_t)(offset + DAMAGE_STRIDE))
                for (uint8_t i = 0; i < sizeof masks; i++)
                    damage(kind, place, offset, masks[i]);
    }
    TEST_ASSERT_TRUE(rig_is(&model));
}

/* --- random histories ------------------------------------------------------------------------- */

static uint32_t seed = 1;

static uint16_t any(uint16_t below)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint16_t)((seed >> 16) % below);
}

/* A change that ends well, is aborted, or loses the power. */
static void change_anything(void)
{
    struct change change = {any(OPERATIONS), (uint8_t)any(256), (uint8_t)any(256)};
    struct rig_model new;
    uint8_t fate = (uint8_t)any(8);

    if (change.operation >= DELETE_POSE && any(2))
        change.operation = SAVE_POSE;
    eeprom_fake.slow = (uint8_t)any(3);
    if (!begin(&change, &new))
        return;
    if (fate < 2) {
        eeprom_fake.writes = 0;
        eeprom_fake.cut_at = (uint16_t)(1 + any(60));
        eeprom_fake.cut = (uint8_t)any(CUTS);
    }
    for (uint16_t polls = any(400); fate == 2 && polls > 0; polls--)
        motion_store_poll(&store);
    if (fate == 2)
        motion_store_abort(&store);
    rig_finish();
    if (eeprom_fake.has_no_power || any(16) == 0)
        rig_power_up();
    eeprom_fake.cut_at = 0;
    TEST_ASSERT_TRUE(assert_old_or_new(&new) || fate <= 2);
}

static void live(uint16_t size, uint16_t count)
{
    rig_reset(size);
    while (count-- > 0)
        change_anything();
}

void test_random_histories_keep_each_record_whole(void)
{
    live(RIG_EEPROM, HISTORY);
}

void test_random_histories_on_2_kb_keep_each_record_whole(void)
{
    live(2048, HISTORY);
}
