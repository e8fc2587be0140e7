/* SPDX-License-Identifier: MIT */
/* Poses and sequences in the EEPROM: names, ranges, room, lists, and the wear of the places. */
#include "motion_store_rig.h"

void setUp(void)
{
    rig_reset(RIG_EEPROM);
    memset(positions, 0, sizeof positions);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, eeprom_fake.breaches);
}

static uint8_t save_named(const char *name, uint8_t length)
{
    record = (struct motion_store_record){
        .kind = MOTION_STORE_POSE, .name = name, .length = length, .positions = positions};
    return motion_store_save(&store, &record);
}

static uint8_t delete_named(uint8_t kind, const char *name)
{
    record =
        (struct motion_store_record){.kind = kind, .name = name, .length = (uint8_t)strlen(name)};
    return motion_store_delete(&store, &record);
}

static uint8_t find(uint8_t kind, const char *name)
{
    return motion_store_find(&store, kind, name, (uint8_t)strlen(name));
}

static void assert_name(const char *name, uint8_t length, uint8_t result)
{
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(result, save_named(name, length), name);
    if (result == MOTION_STORE_SAVING) {
        char read[MOTION_STORE_NAME + 1];
        uint8_t place;

        TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVED, rig_finish());
        place = motion_store_find(&store, MOTION_STORE_POSE, name, length);
        TEST_ASSERT_TRUE(motion_store_read_name(&store, MOTION_STORE_POSE, place, read));
        TEST_ASSERT_EQUAL_STRING_LEN(name, read, length);
        TEST_ASSERT_EQUAL_UINT8(length, strlen(read));
    }
}

void test_save_name_is_letter_then_letters_and_digits(void)
{
    static const char *const names[] = {"a", "Z", "zA09", "abcdefgh", "a1234567"};

    for (uint8_t i = 0; i < sizeof names / sizeof names[0]; i++)
        assert_name(names[i], (uint8_t)strlen(names[i]), MOTION_STORE_SAVING);
    assert_name("abcdefghi", 8, MOTION_STORE_SAVING); // as many characters as `length` says
}

void test_save_name_of_other_characters_is_refused(void)
{
    static const char *const names[] = {"abcdefghi", "",   "1a", "a_b", "a b", "@",
                                        "a[",        "a`", "a{", "a/",  "a:",  "\xC3\xA4"};

    for (uint8_t i = 0; i < sizeof names / sizeof names[0]; i++)
        assert_name(names[i], (uint8_t)strlen(names[i]), MOTION_STORE_BAD);
    assert_name("a\0b", 3, MOTION_STORE_BAD);
}

void test_find_takes_whole_names_in_their_case_only(void)
{
    assert_name("stand", 5, MOTION_STORE_SAVING);
    TEST_ASSERT_NOT_EQUAL(MOTION_STORE_NONE, find(MOTION_STORE_POSE, "stand"));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, find(MOTION_STORE_POSE, "stan"));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, find(MOTION_STORE_POSE, "stand1"));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, find(MOTION_STORE_POSE, "Stand"));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, find(MOTION_STORE_POSE, "standstill"));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, find(MOTION_STORE_POSE, ""));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, find(MOTION_STORE_SEQUENCE, "stand"));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_MISSING, delete_named(MOTION_STORE_SEQUENCE, "stand"));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_MISSING, delete_named(MOTION_STORE_POSE, "standstill"));
}

void test_erased_and_zeroed_eeprom_have_no_records(void)
{
    for (uint8_t pass = 0; pass < 2; pass++) {
        TEST_ASSERT_TRUE(rig_is(&model));
        TEST_ASSERT_EQUAL_UINT8(0, store.damaged);
        TEST_ASSERT_EQUAL_UINT32(0, store.saves);
        memset(rig_bytes, 0, sizeof rig_bytes);
        rig_power_up();
    }
}

void test_save_twice_under_a_name_replaces_the_pose(void)
{
    uint8_t number;

    rig_do(SAVE_POSE, 1, 11);
    number = motion_store_number(&store, MOTION_STORE_POSE, find(MOTION_STORE_POSE, "p01"));
    rig_do(SAVE_POSE, 1, 13);
    TEST_ASSERT_EQUAL_UINT8(
        number, motion_store_number(&store, MOTION_STORE_POSE, find(MOTION_STORE_POSE, "p01")));
    TEST_ASSERT_TRUE(rig_is(&model));
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
    TEST_ASSERT_EQUAL_UINT32(2, store.saves);
}

/* --- ranges ----------------------------------------------------------------------------------- */

static uint8_t save_position(uint16_t position)
{
    positions[MOTION_STORE_JOINTS - 1] = position;
    return save_named("a", 1);
}

void test_save_position_in_range_is_read_back(void)
{
    static const uint16_t good[] = {0, 1, 255, 256, 1023, CDS_POSE_NONE};
    uint16_t read[MOTION_STORE_JOINTS];

    for (uint8_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_position(good[i]));
        rig_finish();
        TEST_ASSERT_TRUE(motion_store_read_pose(&store, find(MOTION_STORE_POSE, "a"), read));
        TEST_ASSERT_EQUAL_UINT16(good[i], read[MOTION_STORE_JOINTS - 1]);
        TEST_ASSERT_EQUAL_UINT16(0, read[MOTION_STORE_JOINTS - 2]);
    }
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_position(1024));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_position(CDS_POSE_NONE - 1));
}

static uint8_t save_step(struct motion_store_step step)
{
    steps[0] = step;
    record = (struct motion_store_record){
        .kind = MOTION_STORE_SEQUENCE, .name = "s", .length = 1, .steps = steps, .count = 1};
    return motion_store_save(&store, &record);
}

static void assert_step(struct motion_store_step step)
{
    struct motion_store_step read;

    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_step(step));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVED, rig_finish());
    TEST_ASSERT_TRUE(motion_store_read_step(&store, find(MOTION_STORE_SEQUENCE, "s"), 0, &read));
    TEST_ASSERT_EQUAL_UINT8(step.pose, read.pose);
    TEST_ASSERT_EQUAL_UINT8(step.curve, read.curve);
    TEST_ASSERT_EQUAL_UINT8(step.passes, read.passes);
    TEST_ASSERT_EQUAL_UINT16(step.time_10ms, read.time_10ms);
    TEST_ASSERT_EQUAL_UINT16(step.dwell_10ms, read.dwell_10ms);
}

void test_save_step_in_range_is_read_back(void)
{
    assert_step((struct motion_store_step){.time_10ms = 1});
    assert_step((struct motion_store_step){.pose = 254,
                                           .curve = CDS_MOTION_BY_SERVO,
                                           .passes = true,
                                           .time_10ms = MOTION_STORE_TIME_MAX,
                                           .dwell_10ms = MOTION_STORE_DWELL_MAX});
    assert_step((struct motion_store_step){
        .curve = CDS_MOTION_LINEAR, .time_10ms = 256, .dwell_10ms = 256});
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_step((struct motion_store_step){0}));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_step((struct motion_store_step){
                                                  .time_10ms = MOTION_STORE_TIME_MAX + 1}));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD,
                            save_step((struct motion_store_step){
                                .time_10ms = 1, .dwell_10ms = MOTION_STORE_DWELL_MAX + 1}));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD,
                            save_step((struct motion_store_step){.time_10ms = 1, .curve = 4}));
}

static uint8_t save_steps(uint8_t kept, uint8_t count)
{
    for (uint8_t i = 0; i < MOTION_STORE_STEPS; i++)
        steps[i] = (struct motion_store_step){.time_10ms = (uint16_t)(1 + i)};
    record = (struct motion_store_record){.kind = MOTION_STORE_SEQUENCE,
                                          .name = "s",
                                          .length = 1,
                                          .steps = steps,
                                          .kept = kept,
                                          .count = count};
    return motion_store_save(&store, &record);
}

void test_save_sequence_has_one_to_sixteen_steps(void)
{
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_steps(0, 0));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_steps(0, 17));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_steps(255, 2));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_steps(2, 255));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_MISSING, save_steps(1, 1));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_steps(0, 16));
    rig_finish();
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_steps(16, 1));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_steps(17, 0));
}

void test_save_kept_steps_stay_in_front_of_new_steps(void)
{
    struct motion_store_step read;
    uint8_t place;

    save_steps(0, 5);
    rig_finish();
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_MISSING, save_steps(6, 1));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_steps(3, 1));
    rig_finish();
    place = find(MOTION_STORE_SEQUENCE, "s");
    TEST_ASSERT_EQUAL_UINT8(4, motion_store_number(&store, MOTION_STORE_SEQUENCE, place));
    for (uint8_t i = 0; i < 4; i++) {
        TEST_ASSERT_TRUE(motion_store_read_step(&store, place, i, &read));
        TEST_ASSERT_EQUAL_UINT16(i < 3 ? 1 + i : 1, read.time_10ms);
    }
    TEST_ASSERT_FALSE(motion_store_read_step(&store, place, 4, &read));
}

static uint8_t save_ids(const uint8_t *list, uint8_t count)
{
    record =
        (struct motion_store_record){.kind = MOTION_STORE_JOINT_LIST, .ids = list, .count = count};
    return motion_store_save(&store, &record);
}

void test_save_joints_are_one_to_eighteen_ids_each_once(void)
{
    static uint8_t list[MOTION_STORE_JOINTS + 1];
    uint8_t read[MOTION_STORE_JOINTS];

    for (uint8_t i = 0; i <= MOTION_STORE_JOINTS; i++)
        list[i] = (uint8_t)(253 - i);
    TEST_ASSERT_EQUAL_UINT8(0, motion_store_read_joints(&store, read));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_ids(list, 0));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_ids(list, MOTION_STORE_JOINTS + 1));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_ids(list, MOTION_STORE_JOINTS));
    rig_finish();
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_JOINTS, motion_store_read_joints(&store, read));
    TEST_ASSERT_EQUAL_MEMORY(list, read, sizeof read);
    list[17] = 254;
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_ids(list, MOTION_STORE_JOINTS));
    list[17] = 253;
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, save_ids(list, MOTION_STORE_JOINTS));
}

void test_save_joints_keeps_positions_of_stored_poses(void)
{
    static const uint8_t first[] = {5, 7}, more[] = {5, 7, 9}, other[] = {5, 8, 9};

    save_ids(other, 3);
    rig_finish();
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_ids(first, 2)); // there is no pose yet
    rig_finish();
    assert_name("a", 1, MOTION_STORE_SAVING);
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_IN_USE, save_ids(other, 3));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_IN_USE, save_ids(first, 1));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_ids(more, 3));
    rig_finish();
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_IN_USE, save_ids(first, 2));
    delete_named(MOTION_STORE_POSE, "a");
    rig_finish();
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_ids(other, 3));
}

/* A joint that no pose uses is a free place, and no servo of the stored poses. */
void test_joint_that_no_pose_uses_gives_its_place_away(void)
{
    static const uint8_t first[] = {5, 7, 9}, other[] = {5, 8, 9};
    uint8_t servos[MOTION_STORE_JOINTS];

    save_ids(first, 3);
    rig_finish();
    TEST_ASSERT_EQUAL_UINT8(0, motion_store_read_servos(&store, servos));
    memset(positions, UINT8_MAX, sizeof positions); // CDS_POSE_NONE
    positions[0] = 0;
    positions[2] = POSITION_MAX;
    record = (struct motion_store_record){
        .kind = MOTION_STORE_POSE, .name = "b", .length = 1, .positions = positions};
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, motion_store_save(&store, &record));
    rig_finish();
    TEST_ASSERT_TRUE(motion_store_uses_joint(&store, 0));
    TEST_ASSERT_FALSE(motion_store_uses_joint(&store, 1));
    TEST_ASSERT_TRUE(motion_store_uses_joint(&store, 2));
    TEST_ASSERT_EQUAL_UINT8(2, motion_store_read_servos(&store, servos));
    TEST_ASSERT_EQUAL_MEMORY("\5\11", servos, 2);
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_IN_USE, save_ids(other, 2));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, save_ids(other, 3));
    rig_finish();
}

/* --- numbers of poses ------------------------------------------------------------------------- */

void test_new_pose_never_takes_number_of_pose_in_sequence(void)
{
    uint8_t number;

    rig_do(SAVE_POSE, 1, 1);
    rig_do(SAVE_STEPS, 0, 33); // two steps
    number = motion_store_number(&store, MOTION_STORE_POSE, find(MOTION_STORE_POSE, "p01"));
    rig_do(DELETE_POSE, 1, 0);
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, motion_store_pose_of(&store, number));
    for (uint16_t i = 0; i < 300; i++) { // all numbers are tried
        store.saves = i;
        rig_do(SAVE_POSE, 1, 3);
        TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, motion_store_pose_of(&store, number));
        rig_do(DELETE_POSE, 1, 0);
    }
    rig_do(DELETE_STEPS, 0, 0);
    store.saves = number;
    rig_do(SAVE_POSE, 1, 3); // now the number is free
    TEST_ASSERT_NOT_EQUAL(MOTION_STORE_NONE, motion_store_pose_of(&store, number));
}

/* --- room ------------------------------------------------------------------------------------- */

/* Fills the EEPROM, replaces all, deletes one. */
static void assert_full(uint16_t size, uint8_t poses, uint8_t sequences)
{
    struct rig_model new;

    rig_reset(size);
    for (uint8_t name = 0; name < poses; name++)
        rig_do(SAVE_POSE, name, name);
    for (uint8_t name = 0; name < sequences; name++)
        rig_do(SAVE_STEPS, name, (uint8_t)(15 + 16 * name));
    TEST_ASSERT_EQUAL_UINT8(0, motion_store_room(&store, MOTION_STORE_POSE));
    TEST_ASSERT_EQUAL_UINT8(0, motion_store_room(&store, MOTION_STORE_SEQUENCE));
    TEST_ASSERT_FALSE(rig_begin(SAVE_POSE, poses, 1, &new));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_FULL, motion_store_save(&store, &record));
    TEST_ASSERT_FALSE(rig_begin(SAVE_STEPS, sequences, 1, &new));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_FULL, motion_store_save(&store, &record));
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
    for (uint8_t name = 0; name < poses; name++)
        rig_do(SAVE_POSE, name, (uint8_t)(100 + name)); // replaces
    for (uint8_t name = 0; name < sequences; name++)
        rig_do(SAVE_STEPS, name, (uint8_t)(31 + 16 * name));
    rig_power_up();
    TEST_ASSERT_TRUE(rig_is(&model));
    rig_do(DELETE_POSE, 3, 0);
    rig_do(SAVE_POSE, poses, 1);
    TEST_ASSERT_TRUE(rig_is(&model));
}

/* The RAM of an AVR has no room for so many records of a model: there only the capacity is tested.
 */
static void assert_capacity(uint16_t size, uint8_t poses, uint8_t sequences)
{
    eeprom_fake.size = size;
    TEST_ASSERT_EQUAL_UINT8(poses, motion_store_capacity(MOTION_STORE_POSE));
    TEST_ASSERT_EQUAL_UINT8(sequences, motion_store_capacity(MOTION_STORE_SEQUENCE));
    if (poses < RIG_POSES)
        assert_full(size, poses, sequences);
}

void test_capacity_4_kb_is_60_poses_and_10_sequences(void)
{
    assert_capacity(4096, 60, 10);
}

void test_capacity_2_kb_is_20_poses_and_8_sequences(void)
{
    assert_capacity(2048, 20, 8);
}

/* The settings end at 143. */
void test_saves_write_no_byte_of_the_settings(void)
{
    rig_do(SAVE_JOINTS, 0, 0);
    for (uint8_t name = 0; name < 5; name++)
        rig_do(SAVE_POSE, name, name);
    rig_do(SAVE_STEPS, 0, 15);
    for (uint8_t i = 0; i < 144; i++)
        TEST_ASSERT_EQUAL_UINT8(UINT8_MAX, rig_bytes[i]);
    TEST_ASSERT_EQUAL_UINT16(144, motion_store_address(MOTION_STORE_JOINT_LIST, 0));
}

void test_autostart_has_a_delay(void)
{
    static const char name[MOTION_STORE_NAME] = "walk";
    char read[MOTION_STORE_NAME + 1];

    TEST_ASSERT_EQUAL_UINT8(0, motion_store_read_autostart(&store, read));
    record = (struct motion_store_record){.kind = MOTION_STORE_AUTOSTART, .sequence = name};
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BAD, motion_store_save(&store, &record));
    record.count = 3;
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVING, motion_store_save(&store, &record));
    TEST_ASSERT_EQUAL_UINT8(0, motion_store_read_autostart(&store, read));
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVED, rig_finish());
    TEST_ASSERT_EQUAL_UINT8(3, motion_store_read_autostart(&store, read));
    TEST_ASSERT_EQUAL_STRING("walk", read);
}

void test_places_do_not_overlap_and_end_within_eeprom(void)
{
    uint16_t address = 144, byte = 0;

    for (uint8_t kind = 0; kind < MOTION_STORE_KINDS; kind++) {
        TEST_ASSERT_EQUAL_UINT16(address, motion_store_address(kind, 0));
        TEST_ASSERT_EQUAL_UINT16(byte, motion_store_area(kind)->first_byte);
        byte = (uint16_t)(byte + (motion_store_area(kind)->places + 7u) / 8);
        address = motion_store_address(kind, motion_store_area(kind)->places);
    }
    TEST_ASSERT_TRUE(address <= RIG_EEPROM);
    TEST_ASSERT_TRUE(byte <= MOTION_STORE_BITMAP);
}

void test_next_lists_each_record_once(void)
{
    uint8_t place = 0, count = 0;
    char name[MOTION_STORE_NAME + 1];
    uint16_t seen = 0;

    for (uint8_t i = 0; i < 5; i++)
        rig_do(SAVE_POSE, i, i);
    rig_do(DELETE_POSE, 2, 0);
    for (; (place = motion_store_next(&store, MOTION_STORE_POSE, place)) != MOTION_STORE_NONE;
         place++, count++) {
        TEST_ASSERT_TRUE(motion_store_read_name(&store, MOTION_STORE_POSE, place, name));
        seen |= (uint16_t)(1u << (name[2] - '0'));
    }
    TEST_ASSERT_EQUAL_UINT8(4, count);
    TEST_ASSERT_EQUAL_HEX16(0x1B, seen);
}

/* Records in the field are like this one: this test fails if the layout changes. */
void test_saved_bytes_are_those_of_motion_store_md(void)
{
    static const uint8_t pose[] = {1,    1,    0,    0,    0,    'u',  'p',  0,    0,    0,
                                   0,    0,    0,    0xFF, 0x01, 0x00, 0xFF, 0x05, 0x05, 0x05,
                                   0x05, 0x05, 0x05, 0x05, 0x05, 0x05, 0x05, 0x05, 0x05, 0x05,
                                   0x05, 0x13, 0xF2, 0,    0,    0,    0,    0,    0,    0};
    static const uint8_t step[] = {9, 0x34, 0x12, 0x99, 0x99};

    positions[0] = 0x3FF;
    positions[1] = 0x101;
    positions[2] = 0x200;
    positions[3] = CDS_POSE_NONE;
    for (uint8_t i = 4; i < MOTION_STORE_JOINTS; i++)
        positions[i] = 5;
    save_named("up", 2);
    rig_finish();
    TEST_ASSERT_EQUAL_MEMORY(pose, rig_bytes + 210 + 42, sizeof pose);
    save_step((struct motion_store_step){
        .pose = 9, .curve = 0, .passes = true, .time_10ms = 0x1234, .dwell_10ms = 0x1999});
    rig_finish();
    TEST_ASSERT_EQUAL_MEMORY(step, rig_bytes + motion_store_address(MOTION_STORE_SEQUENCE, 1) + 13,
                             sizeof step);
}

/* --- writing ---------------------------------------------------------------------------------- */

void test_poll_writes_one_byte_if_eeprom_is_ready(void)
{
    struct rig_model new;
    bool more = true;

    eeprom_fake.slow = 5;
    rig_begin(SAVE_POSE, 1, 1, &new);
    while (more) {
        uint16_t before = eeprom_fake.writes;

        more = motion_store_poll(&store);
        TEST_ASSERT_TRUE(eeprom_fake.writes - before <= 1);
    }
    TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_SAVED, store.result);
}

void test_reads_while_saving_are_refused(void)
{
    uint16_t read[MOTION_STORE_JOINTS];
    struct motion_store_step step;
    struct rig_model new;
    char name[MOTION_STORE_NAME + 1];
    uint8_t pose, sequence, number;

    rig_do(SAVE_JOINTS, 0, 0);
    rig_do(SAVE_POSE, 1, 1);
    rig_do(SAVE_STEPS, 0, 1);
    pose = find(MOTION_STORE_POSE, "p01");
    sequence = find(MOTION_STORE_SEQUENCE, "s00");
    number = motion_store_number(&store, MOTION_STORE_POSE, pose);
    rig_begin(SAVE_POSE, 1, 3, &new);
    for (uint8_t aborted = 0; aborted < 2; aborted++) {
        TEST_ASSERT_TRUE(motion_store_is_saving(&store));
        TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, find(MOTION_STORE_POSE, "p01"));
        TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_NONE, motion_store_pose_of(&store, number));
        TEST_ASSERT_FALSE(motion_store_read_pose(&store, pose, read));
        TEST_ASSERT_FALSE(motion_store_read_name(&store, MOTION_STORE_POSE, pose, name));
        TEST_ASSERT_FALSE(motion_store_read_step(&store, sequence, 0, &step));
        TEST_ASSERT_EQUAL_UINT8(0, motion_store_read_joints(&store, ids));
        TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BUSY, motion_store_save(&store, &record));
        TEST_ASSERT_EQUAL_UINT8(MOTION_STORE_BUSY, motion_store_delete(&store, &record));
        eeprom_fake.busy = 100;
        motion_store_abort(&store);
    }
}

void test_load_waits_for_write_that_a_reset_found_under_way(void)
{
    rig_do(SAVE_POSE, 1, 1);
    eeprom_fake.busy = 7;
    motion_store_load(&store, &rig_settings);
    TEST_ASSERT_TRUE(rig_is(&model));
}

/* --- wear ------------------------------------------------------------------------------------- */

enum { TURNS = 3 };

/* Saves one pose again and again, with others that stay. */
void test_saves_go_round_all_free_places(void)
{
    uint8_t written[8 * MOTION_STORE_BITMAP] = {0}, places, others = 7;

    rig_reset(2048);
    places = motion_store_area(MOTION_STORE_POSE)->places;
    for (uint8_t i = 0; i < others; i++) {
        record_name[0] = (char)('a' + i);
        save_named(record_name, 1);
        rig_finish();
    }
    for (uint8_t i = 0; i < TURNS * (places - others); i++) {
        save_named("x", 1);
        rig_finish();
        written[store.place]++;
        if (i % 5 == 0)
            rig_power_up();
    }
    for (uint8_t place = 0; place < places; place++)
        TEST_ASSERT_TRUE(written[place] == 0 || written[place] == TURNS);
}

void test_saves_with_delete_and_power_off_go_round(void)
{
    uint32_t seen = 0;

    rig_reset(2048);
    for (uint8_t i = 0; i < motion_store_area(MOTION_STORE_POSE)->places; i++) {
        rig_do(SAVE_POSE, 1, 1);
        seen |= (uint32_t)1 << store.place;
        rig_do(DELETE_POSE, 1, 0);
        rig_power_up();
    }
    TEST_ASSERT_EQUAL_HEX32(((uint32_t)1 << motion_store_area(MOTION_STORE_POSE)->places) - 1,
                            seen);
}

void test_sequence_does_not_write_steps_it_does_not_have(void)
{
    save_steps(0, 1);
    eeprom_fake.writes = 0;
    rig_finish();
    TEST_ASSERT_TRUE(eeprom_fake.writes <= AT_DATA + STEP_BYTES + 2);
}
