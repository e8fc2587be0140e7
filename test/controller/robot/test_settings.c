/* SPDX-License-Identifier: MIT */
/* The settings' table, and their record in the EEPROM, also when the power goes. */
#include "robot/settings.h"

#include <string.h>

#include "robot/crc.h"
#include "eeprom_fake.h"
#include "unity.h"

static struct settings settings;
static struct settings_store store;

void setUp(void)
{
    eeprom_fake_reset();
    memset(&store, 0, sizeof store);
    settings_load(&store, &settings);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, eeprom_fake.breaches);
}

/* Saves until it is over or the power has gone; returns the polls it took. */
static uint16_t save(void)
{
    uint16_t polls = 1;

    TEST_ASSERT_TRUE(settings_save(&store, &settings));
    while (!eeprom_fake.has_no_power && settings_save_poll(&store) && polls < 1000)
        polls++;
    return polls;
}

static void start_again(void)
{
    eeprom_fake_power_up();
    memset(&settings, 0xA5, sizeof settings);
    settings_load(&store, &settings);
}

static uint8_t row(const char *name)
{
    return settings_named(name, (uint8_t)strlen(name));
}

void test_settings_are_kept_if_the_next_start_has_them(void)
{
    TEST_ASSERT_TRUE(settings_are_kept(&settings)); // nothing is saved: the defaults
    settings.repeats = 1;
    TEST_ASSERT_FALSE(settings_are_kept(&settings));
    save();
    TEST_ASSERT_TRUE(settings_are_kept(&settings));
    settings_default(&settings);
    TEST_ASSERT_FALSE(settings_are_kept(&settings));
}

/* All fields are other than those of another `seed`. */
static void fill(uint8_t seed)
{
    for (uint8_t i = 0; i < SETTINGS_COUNT; i++) {
        uint16_t span = (uint16_t)(settings_table[i].highest - settings_table[i].lowest);
        uint16_t part = span > 2 ? (uint16_t)(seed * (span / 4) + i) : (uint16_t)(seed & 1);

        TEST_ASSERT_TRUE(settings_set(&settings, i, (uint16_t)(settings_table[i].lowest + part)));
    }
}

static void assert_default(void)
{
    for (uint8_t i = 0; i < SETTINGS_COUNT; i++)
        TEST_ASSERT_EQUAL_UINT16(settings_table[i].initial, settings_get(&settings, i));
}

void test_each_default_is_in_range(void)
{
    for (uint8_t i = 0; i < SETTINGS_COUNT; i++) {
        TEST_ASSERT_TRUE(settings_table[i].initial >= settings_table[i].lowest);
        TEST_ASSERT_TRUE(settings_table[i].initial <= settings_table[i].highest);
        TEST_ASSERT_TRUE(settings_table[i].bytes == 2 || settings_table[i].highest <= 255);
    }
}

void test_setting_is_found_by_whole_name_only(void)
{
    TEST_ASSERT_EQUAL_UINT8(0, row("device_id"));
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_COUNT - 1, row("cycle_us"));
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_COUNT, row("device_i"));
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_COUNT, row("device_id_"));
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_COUNT, row(""));
}

void test_setting_out_of_range_is_refused(void)
{
    for (uint8_t i = 0; i < SETTINGS_COUNT; i++) {
        uint16_t lowest = settings_table[i].lowest, highest = settings_table[i].highest;

        TEST_ASSERT_TRUE(settings_set(&settings, i, highest));
        TEST_ASSERT_EQUAL_UINT16(highest, settings_get(&settings, i));
        TEST_ASSERT_TRUE(settings_set(&settings, i, lowest));
        if (highest < UINT16_MAX)
            TEST_ASSERT_FALSE(settings_set(&settings, i, (uint16_t)(highest + 1)));
        if (lowest > 0)
            TEST_ASSERT_FALSE(settings_set(&settings, i, (uint16_t)(lowest - 1)));
        TEST_ASSERT_EQUAL_UINT16(lowest, settings_get(&settings, i));
    }
}

void test_crc_is_the_well_known_one(void)
{
    uint16_t crc = CRC_BEGIN;

    for (char c = '1'; c <= '9'; c++)
        crc = crc_add(crc, (uint8_t)c);
    TEST_ASSERT_EQUAL_HEX16(0x6F91, crc);
}

void test_an_erased_eeprom_gives_the_defaults(void)
{
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_NONE, store.origin);
    assert_default();
}

void test_what_was_saved_is_there_after_power_up(void)
{
    for (uint8_t seed = 1; seed <= 3; seed++) { // both places, and the first one again
        struct settings before;

        fill(seed);
        before = settings;
        save();
        TEST_ASSERT_EQUAL_UINT8(SETTINGS_SAVED, store.result);
        start_again();
        TEST_ASSERT_EQUAL_UINT8(SETTINGS_STORED, store.origin);
        TEST_ASSERT_EQUAL_MEMORY(&before, &settings, sizeof before);
    }
}

void test_the_newer_record_is_found_over_all_sequence_numbers(void)
{
    for (uint16_t i = 0; i < 260; i++) {
        settings.cycle_us = (uint16_t)(3000 + i);
        save();
        start_again();
        TEST_ASSERT_EQUAL_UINT16(3000 + i, settings.cycle_us);
    }
}

void test_poll_writes_one_byte_if_eeprom_is_ready(void)
{
    uint16_t polls = 0;

    eeprom_fake.slow = 5;
    fill(1);
    settings_save(&store, &settings);
    for (bool more = true; more; polls++) {
        uint16_t before = eeprom_fake.writes;

        more = settings_save_poll(&store);
        TEST_ASSERT_TRUE(eeprom_fake.writes - before <= 1);
    }
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_SAVED, store.result);
    TEST_ASSERT_TRUE(polls > 5 * eeprom_fake.writes);
}

void test_a_byte_that_is_right_already_is_not_written(void)
{
    save();
    save();
    eeprom_fake.writes = 0;
    save(); // over the first one: version off and on, sequence number, CRC
    TEST_ASSERT_EQUAL_UINT16(5, eeprom_fake.writes);
}

void test_only_one_save_at_a_time(void)
{
    settings_save(&store, &settings);
    settings_save_poll(&store);
    TEST_ASSERT_FALSE(settings_save(&store, &settings));
    while (settings_save_poll(&store)) {
    }
    TEST_ASSERT_TRUE(settings_save(&store, &settings));
}

void test_change_during_save_is_not_saved(void)
{
    fill(1);
    settings_save(&store, &settings);
    settings_save_poll(&store);
    fill(2);
    while (settings_save_poll(&store)) {
    }
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_STORED, store.origin);
    TEST_ASSERT_EQUAL_UINT16(1 * (65535 / 4) + row("link_loss_ms"), settings.link_loss_ms);
}

/* Saves settings filled from `seed`; the power goes within the write `at`. False: the save ended
 * before. The old settings are stored behind it, or the new ones (`is_new`). */
static bool save_until_cut(uint8_t seed, uint16_t at, uint8_t cut, bool *is_new)
{
    struct settings old = settings, new;
    bool was_cut;

    fill(seed);
    new = settings;
    eeprom_fake.writes = 0;
    eeprom_fake.cut_at = at;
    eeprom_fake.cut = cut;
    save();
    was_cut = eeprom_fake.has_no_power;
    start_again();
    *is_new = memcmp(&settings, &new, sizeof new) == 0;
    if (!*is_new)
        TEST_ASSERT_EQUAL_MEMORY(&old, &settings, sizeof old);
    TEST_ASSERT_TRUE(was_cut || *is_new);
    if (was_cut && cut != CUT_NEW)
        TEST_ASSERT_FALSE(*is_new);
    return was_cut;
}

/* The power goes within the write `at` of a save over an older one, or two. */
static bool cut_save(uint16_t at, uint8_t cut, uint8_t saves)
{
    struct settings new;
    bool was_cut, is_new;

    eeprom_fake_reset();
    start_again();
    for (uint8_t i = 1; i <= saves; i++) {
        fill(i);
        save();
    }
    start_again();
    was_cut = save_until_cut((uint8_t)(saves + 1), at, cut, &is_new);
    TEST_ASSERT_EQUAL_UINT8(saves || is_new ? SETTINGS_STORED : store.origin, store.origin);
    fill(0); // and the next save is as good as any
    new = settings;
    save();
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_STORED, store.origin);
    TEST_ASSERT_EQUAL_MEMORY(&new, &settings, sizeof new);
    return was_cut;
}

static uint16_t cut_saves(uint8_t saves)
{
    uint16_t at = 1;

    for (uint8_t cut = 0; cut < CUTS; cut++)
        for (at = 1; cut_save(at, cut, saves); at++) {
        }
    return at;
}

void test_power_lost_at_any_byte_of_the_first_save(void)
{
    TEST_ASSERT_TRUE(cut_saves(0) > SETTINGS_COUNT);
}

void test_power_lost_at_any_byte_of_the_second_save(void)
{
    TEST_ASSERT_TRUE(cut_saves(1) > SETTINGS_COUNT);
}

void test_power_lost_at_any_byte_of_a_save_over_the_older_record(void)
{
    TEST_ASSERT_TRUE(cut_saves(2) > SETTINGS_COUNT);
}

void test_any_byte_damaged_gives_the_other_record(void)
{
    for (uint8_t i = 0; i < SETTINGS_RECORD; i++) {
        uint8_t *byte = &eeprom_fake.bytes[SETTINGS_PLACE + SETTINGS_ROOM + i];

        eeprom_fake_reset();
        start_again();
        settings.cycle_us = 5001;
        save();
        settings.cycle_us = 5002;
        save();
        *byte ^= 0x10;
        start_again();
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(5001, settings.cycle_us, "byte of the record");
        TEST_ASSERT_EQUAL_UINT8(SETTINGS_STORED, store.origin);
        TEST_ASSERT_EQUAL_UINT8(1, store.slot);
    }
}

void test_two_damaged_records_give_defaults(void)
{
    fill(1);
    save();
    fill(2);
    save();
    eeprom_fake.bytes[SETTINGS_PLACE + 5] ^= 1;
    eeprom_fake.bytes[SETTINGS_PLACE + SETTINGS_ROOM + 5] ^= 1;
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_DAMAGED, store.origin);
    assert_default();
}

static uint8_t *place(uint8_t slot)
{
    return &eeprom_fake.bytes[SETTINGS_PLACE + slot * SETTINGS_ROOM];
}

/* Makes a whole record of the bytes that stand in a place: the header and the CRC. */
static void put_record(uint8_t slot, uint8_t version, uint8_t length, uint8_t sequence)
{
    uint8_t *record = place(slot);
    uint16_t crc = CRC_BEGIN;

    record[0] = version;
    record[1] = length;
    record[2] = sequence;
    for (uint8_t i = 0; i < 3 + length; i++)
        crc = crc_add(crc, record[i]);
    record[3 + length] = (uint8_t)crc;
    record[4 + length] = (uint8_t)(crc >> 8);
}

#define MORE 5 // bytes of settings that only a newer firmware knows

/* A newer firmware has saved the settings as they are now, and the bytes 0xE0 ... behind them. */
static void put_longer_record(void)
{
    save();
    for (uint8_t i = 0; i < MORE; i++)
        place(0)[3 + SETTINGS_BYTES + i] = (uint8_t)(0xE0 + i);
    put_record(0, SETTINGS_VERSION, SETTINGS_BYTES + MORE, 1);
}

/* The newest record is longer than this firmware knows, and holds the bytes of put_longer_record().
 */
static void assert_rest_is_kept(void)
{
    const uint8_t *newest = place(!store.slot);

    TEST_ASSERT_EQUAL_UINT8(SETTINGS_NEWER, store.origin);
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_BYTES + MORE, newest[1]);
    for (uint8_t i = 0; i < MORE; i++)
        TEST_ASSERT_EQUAL_HEX8(0xE0 + i, newest[3 + SETTINGS_BYTES + i]);
}

void test_load_record_of_another_version_gives_defaults(void)
{
    fill(1);
    save();
    put_record(0, SETTINGS_VERSION + 1, SETTINGS_BYTES, 1);
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_OTHER_VERSION, store.origin);
    assert_default();
}

/* The bytes that the firmware wrote when there were ten settings. Records in the field are like
 * these: this test fails if a setting moves in the table or changes its size. A setting that is
 * added at the end of the table leaves it as it is. */
void test_load_record_of_ten_settings_gives_their_values(void)
{
    static const uint8_t record[] = {0x01, 0x0C, 0x01, 0x11, 0x10, 0x03, 0x64, 0x01, 0x01,
                                     0xFF, 0xFF, 0x00, 0x01, 0x34, 0x12, 0xA6, 0x87};

    static const char *const names[] = {
        "device_id", "host_baud",    "bus_baud",         "return_delay", "repeats",
        "echo",      "link_loss_ms", "link_loss_action", "alarm_report", "cycle_us"};

    for (uint8_t i = 0; i < 10; i++)
        TEST_ASSERT_EQUAL_UINT8(i, row(names[i]));
    memcpy(place(0), record, sizeof record);
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_BYTES > 12 ? SETTINGS_OLDER : SETTINGS_STORED, store.origin);
    TEST_ASSERT_EQUAL_UINT8(17, settings.device_id);
    TEST_ASSERT_EQUAL_UINT8(16, settings.host_baud);
    TEST_ASSERT_EQUAL_UINT8(3, settings.bus_baud);
    TEST_ASSERT_EQUAL_UINT8(100, settings.return_delay);
    TEST_ASSERT_EQUAL_UINT8(1, settings.repeats);
    TEST_ASSERT_EQUAL_UINT8(1, settings.echo);
    TEST_ASSERT_EQUAL_UINT16(0xFFFF, settings.link_loss_ms);
    TEST_ASSERT_EQUAL_UINT8(0, settings.link_loss_action);
    TEST_ASSERT_EQUAL_UINT8(1, settings.alarm_report);
    TEST_ASSERT_EQUAL_UINT16(0x1234, settings.cycle_us);
    for (uint8_t i = 10; i < SETTINGS_COUNT; i++)
        TEST_ASSERT_EQUAL_UINT16(settings_table[i].initial, settings_get(&settings, i));
}

/* As a firmware with nine settings writes it: without cycle_us. */
void test_load_record_without_last_setting_gives_default(void)
{
    static const uint8_t record[] = {0x01, 0x0A, 0x01, 0x11, 0x10, 0x03, 0x64, 0x01,
                                     0x01, 0xFF, 0xFF, 0x00, 0x01, 0x7A, 0x35};

    memcpy(place(0), record, sizeof record);
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_OLDER, store.origin);
    TEST_ASSERT_EQUAL_UINT8(17, settings.device_id);
    TEST_ASSERT_EQUAL_UINT8(1, settings.alarm_report);
    TEST_ASSERT_EQUAL_UINT16(4000, settings.cycle_us);
    TEST_ASSERT_EQUAL_UINT8(1, store.slot);
    TEST_ASSERT_EQUAL_UINT8(1, store.sequence);
}

/* A word of which only one byte is there is its default, too. */
void test_load_record_of_any_shorter_length_gives_whole_values(void)
{
    for (uint8_t length = 0; length < SETTINGS_BYTES; length++) {
        struct settings saved;
        uint8_t end = 0;

        eeprom_fake_reset();
        start_again();
        fill(1);
        saved = settings;
        save();
        put_record(0, SETTINGS_VERSION, length, 1);
        start_again();
        TEST_ASSERT_EQUAL_UINT8(SETTINGS_OLDER, store.origin);
        for (uint8_t i = 0; i < SETTINGS_COUNT; i++) {
            end = (uint8_t)(end + settings_table[i].bytes);
            TEST_ASSERT_EQUAL_UINT16(end <= length ? settings_get(&saved, i)
                                                   : settings_table[i].initial,
                                     settings_get(&settings, i));
        }
    }
}

void test_load_older_record_with_bad_value_is_corrected(void)
{
    settings.echo = 1;
    save();
    place(0)[3 + 4] = 3; // repeats
    put_record(0, SETTINGS_VERSION, SETTINGS_BYTES - 2, 1);
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_CORRECTED, store.origin);
    TEST_ASSERT_EQUAL_UINT8(0, settings.repeats);
    TEST_ASSERT_EQUAL_UINT8(1, settings.echo);
}

void test_save_after_older_record_writes_all_settings(void)
{
    struct settings before;

    fill(1);
    save();
    put_record(0, SETTINGS_VERSION, SETTINGS_BYTES - 2, 1);
    start_again();
    before = settings;
    save();
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_STORED, store.origin);
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_BYTES, place(1)[1]);
    TEST_ASSERT_EQUAL_MEMORY(&before, &settings, sizeof before);
}

void test_load_longer_record_gives_known_settings(void)
{
    struct settings before;

    fill(1);
    before = settings;
    put_longer_record();
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_NEWER, store.origin);
    TEST_ASSERT_EQUAL_MEMORY(&before, &settings, sizeof before);
}

void test_save_after_longer_record_keeps_unknown_settings(void)
{
    put_longer_record();
    for (uint8_t seed = 1; seed <= 3; seed++) { // both places, and the first one again
        struct settings before;

        start_again();
        fill(seed);
        before = settings;
        save();
        TEST_ASSERT_EQUAL_UINT8(SETTINGS_SAVED, store.result);
        start_again();
        TEST_ASSERT_EQUAL_MEMORY(&before, &settings, sizeof before);
        assert_rest_is_kept();
    }
}

void test_two_saves_after_longer_record_keep_unknown(void)
{
    put_longer_record();
    start_again();
    save();
    save();
    start_again();
    assert_rest_is_kept();
}

void test_longest_record_is_loaded_and_saved(void)
{
    struct settings before;

    fill(1);
    before = settings;
    save();
    memset(place(0) + 3 + SETTINGS_BYTES, 0x77, SETTINGS_ROOM - 5 - SETTINGS_BYTES);
    put_record(0, SETTINGS_VERSION, SETTINGS_ROOM - 5, 1);
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_NEWER, store.origin);
    save();
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_NEWER, store.origin);
    TEST_ASSERT_EQUAL_UINT8(0, store.slot);
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_ROOM - 5, place(1)[1]);
    TEST_ASSERT_EQUAL_MEMORY(&before, &settings, sizeof before);
}

/* Of two whole records the later one, whatever their lengths. */
void test_load_of_records_of_any_lengths_takes_later_one(void)
{
    static const uint8_t lengths[] = {SETTINGS_BYTES - 2, SETTINGS_BYTES, SETTINGS_BYTES + 2};

    for (uint8_t i = 0; i < 9; i++) {
        for (uint8_t later = 0; later < 2; later++) {
            eeprom_fake_reset();
            start_again();
            settings.echo = later == 0;
            save();
            settings.echo = later == 1;
            save();
            put_record(0, SETTINGS_VERSION, lengths[i / 3], later == 0);
            put_record(1, SETTINGS_VERSION, lengths[i % 3], later == 1);
            start_again();
            TEST_ASSERT_EQUAL_UINT8(1, settings.echo);
            TEST_ASSERT_EQUAL_UINT8(!later, store.slot);
        }
    }
}

/* The power goes within the write `at` of a save behind a record of another length. */
static bool cut_save_after(uint8_t length, uint16_t at, uint8_t cut)
{
    bool was_cut, is_new;

    eeprom_fake_reset();
    start_again();
    fill(1);
    put_longer_record();
    put_record(0, SETTINGS_VERSION, length, 1);
    start_again();
    was_cut = save_until_cut(2, at, cut, &is_new);
    if (length == SETTINGS_BYTES + MORE)
        assert_rest_is_kept();
    return was_cut;
}

static void cut_saves_after(uint8_t length)
{
    for (uint8_t cut = 0; cut < CUTS; cut++) {
        uint16_t at = 1;

        while (cut_save_after(length, at, cut))
            at++;
        TEST_ASSERT_TRUE(at > SETTINGS_COUNT);
    }
}

void test_power_lost_in_save_after_longer_record(void)
{
    cut_saves_after(SETTINGS_BYTES + MORE);
}

void test_power_lost_in_save_after_shorter_record(void)
{
    cut_saves_after(SETTINGS_BYTES - 2);
}

void test_a_length_that_leads_out_of_the_record_is_damage(void)
{
    eeprom_fake.bytes[SETTINGS_PLACE] = SETTINGS_VERSION;
    start_again(); // length 255, beyond the fake's EEPROM: a breach, if it were followed
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_DAMAGED, store.origin);
}

void test_stored_value_out_of_range_is_default(void)
{
    settings.cycle_us = 5000;
    settings.repeats = 2;
    save();
    place(0)[3 + 4] = 3; // repeats
    put_record(0, SETTINGS_VERSION, SETTINGS_BYTES, 1);
    start_again();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_CORRECTED, store.origin);
    TEST_ASSERT_EQUAL_UINT8(0, settings.repeats);
    TEST_ASSERT_EQUAL_UINT16(5000, settings.cycle_us);
}

void test_dead_cell_fails_save_and_keeps_older_record(void)
{
    fill(1);
    save();
    eeprom_fake.dead = SETTINGS_PLACE + SETTINGS_ROOM + SETTINGS_RECORD - 1;
    fill(2);
    save();
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_FAILED, store.result);
    fill(1);
    {
        struct settings old = settings;

        start_again();
        TEST_ASSERT_EQUAL_MEMORY(&old, &settings, sizeof old);
    }
}

void test_loading_waits_for_a_write_that_a_reset_found_under_way(void)
{
    fill(1);
    save();
    eeprom_fake.busy = 7;
    settings_load(&store, &settings);
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_STORED, store.origin);
}
