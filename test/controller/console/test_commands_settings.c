/* SPDX-License-Identifier: MIT */
/* settings, save, defaults. */
#include "saving_rig.h"

void setUp(void)
{
    begin_controller();
}

void tearDown(void)
{
    end_controller();
}

void test_settings_prints_values_units_and_origin(void)
{
    reply_to("settings");
    TEST_ASSERT_EQUAL_STRING_LEN(
        "device_id = 253 ID\r\nhost_baud = 255 register, 115200bps, the board's own\r\n", said, 74);
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nbus_baud = 1 register, 1000000bps\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nrepeats = 0\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\ncycle_us = 4000 us\r\nsettings at start: defaults: "
                                      "nothing saved\r\nok\r\n"));
}

void test_settings_tells_a_person_meanings_and_autostart(void)
{
    settings.echo = SETTINGS_ECHO_PERSON;
    reply_to("settings");
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nrepeats = 0 (never)\r\necho = 2 (mode person)\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nlink_loss_action = 1 (inhibit driving)\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\ncycle_us = 4000 us\r\nautostart: none\r\nsettings at"));
    reply_to("settings alarm_report");
    TEST_ASSERT_NOT_NULL(strstr(said, "alarm_report = 0 (only in mode person)\r\nok\r\n"));
}

void test_a_setting_is_shown_changed_and_brought_back(void)
{
    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("settings cycle_us 5000"));
    TEST_ASSERT_EQUAL_UINT16(5000, settings.cycle_us);
    TEST_ASSERT_EQUAL_STRING("cycle_us = 5000 us\r\nok\r\n", reply_to("settings cycle_us"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n\r> ", reply_to("defaults")); // mode person again
    TEST_ASSERT_EQUAL_UINT16(4000, settings.cycle_us);
}

void test_errors_of_settings_change_nothing(void)
{
    assert_error("60", "settings cycle 1");
    assert_error("60", "settings a_name_that_is_much_longer_than_any 1");
    assert_error("33", "settings repeats 3");
    assert_error("33", "settings repeats 65536");
    assert_error("32", "settings repeats one");
    assert_error("31", "settings repeats 1 1");
    TEST_ASSERT_EQUAL_UINT8(0, settings.repeats);
}

void test_save_replies_when_record_is_written(void)
{
    eeprom_fake.slow = 10;
    TEST_ASSERT_EQUAL_STRING("", reply_to("save"));
    turns(400);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    TEST_ASSERT_EQUAL_UINT8(SETTINGS_SAVED, store.result);
    TEST_ASSERT_NOT_NULL(strstr(reply_to("settings"),
                                "\r\nsaved settings: the next start has those of the last "
                                "'save'\r\nok"));
}

void test_a_save_that_fails_is_an_error(void)
{
    eeprom_fake.dead = SETTINGS_PLACE + 3;
    assert_error("62", "save");
}

void test_a_save_during_another_ones_is_an_error(void)
{
    eeprom_fake.slow = 100;
    settings_save(&store, &settings); // the virtual device's
    assert_error("63", "save");
}
