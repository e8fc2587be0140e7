/* SPDX-License-Identifier: MIT */
/* What a person is told of settings that are not saved, and of a link_loss_ms; why limits refuse an
 * angle limit. */
#include "console_rig.h"
#include "eeprom_fake.h"

void setUp(void)
{
    begin_console();
    eeprom_fake_reset();
    settings_load(&store, &settings);
    settings.echo = SETTINGS_ECHO_OFF;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_settings_tells_a_person_what_is_not_saved(void)
{
    static const char unsaved[] = "; the present ones are not saved\r\nok";

    settings.repeats = 1;
    TEST_ASSERT_NULL(strstr(reply_to("settings"), unsaved)); // a program reads the line
    settings.echo = SETTINGS_ECHO_PERSON;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("settings"), unsaved));
    reply_to("save");
    while (settings_save_poll(&store)) {
    }
    reply_to("");
    TEST_ASSERT_NULL(strstr(reply_to("settings"), unsaved));
    reply_to("defaults");
    TEST_ASSERT_NOT_NULL(strstr(reply_to("settings"), "the last 'save'; the present ones are not"));
}

/* A `pose save` writes: settings_are_kept() must not wait. */
void test_settings_waits_for_no_byte_that_is_written(void)
{
    settings.repeats = 1;
    settings.echo = SETTINGS_ECHO_PERSON;
    eeprom_fake.busy = 200;
    TEST_ASSERT_NULL(strstr(reply_to("settings"), "; the present ones are not saved"));
    TEST_ASSERT_EQUAL_UINT8(198,
                            eeprom_fake.busy); // asked once for the settings, once for autostart
    TEST_ASSERT_NULL(strstr(said, "autostart"));
}

void test_settings_tells_that_a_save_failed(void)
{
    store.result = SETTINGS_FAILED;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("settings"), "saved settings: the last 'save' failed; the "
                                                      "next start has the older ones\r\n"));
}

void test_link_loss_warns_a_person_who_types(void)
{
    static const char *const lines[] = {
        "\nthis setting is for a program; if you type nothing for 500ms, the link counts as lost; ",
        "\nthis setting is for a program; if you type nothing for 500ms, driving is inhibited; ",
        "\nthis setting is for a program; if you type nothing for 500ms, torque goes off, and ",
    };

    TEST_ASSERT_EQUAL_STRING("ok\r\n", reply_to("settings link_loss_ms 500"));
    settings.echo = SETTINGS_ECHO_PERSON;
    for (uint8_t i = 0; i < 3; i++) {
        settings.link_loss_action = i;
        TEST_ASSERT_NOT_NULL(strstr(reply_to("settings link_loss_ms 500"), lines[i]));
        TEST_ASSERT_NOT_NULL(strstr(said, "; 'settings link_loss_ms 0' ends that\r\nok"));
    }
    TEST_ASSERT_NULL(strstr(reply_to("settings link_loss_ms"), "if you type"));
    TEST_ASSERT_NULL(strstr(reply_to("settings link_loss_ms 0"), "if you type"));
}

void test_lost_link_tells_a_person_how_to_type_on(void)
{
    static const char way[] = "; to work by hand: 'settings link_loss_ms 0', 'clear'\r\n";

    settings.link_loss_ms = 500;
    failsafe.link_lost = true;
    console.faults_told = FAULT_LINK_LOST;
    robot_inhibit(&robot);
    assert_reply(
        "error 65: the host link was lost; no byte for link_loss_ms: driving is inhibited, "
        "torque stays as it is; 'clear' when it is back\r\n",
        "release");
    settings.echo = SETTINGS_ECHO_PERSON;
    TEST_ASSERT_NOT_NULL(strstr(reply_to("release"), way));
    settings.link_loss_ms = 0; // the half of it is done
    TEST_ASSERT_NOT_NULL(strstr(reply_to("release"), "; 'clear' when it is back\r\n"));
}

/* Servo 4 is in endless turn, its torque is off. */
static void write_in_endless_turn(uint8_t held, const char *line)
{
    robot.states[0].held = (uint8_t)(CDS_HELD_CW_0 | CDS_HELD_CCW_0 | held);
    reply_to(line);
}

void test_refusal_of_an_angle_limit_names_its_reason(void)
{
    static const char goal[] = "error 11: servo 4: it would leave the endless turn for its goal, "
                               "not read yet or beyond its limits, 60.117deg to 200deg: 'set 4 "
                               "GOAL_POSITION ANGLE', 'get 4 GOAL_POSITION' reads it, then send "
                               "this line again\r\n";

    robot_add(&robot, 4);
    reply_to("limits 4 60 200");
    write_in_endless_turn(0, "write 4 CCW_ANGLE_LIMIT 255 3");
    TEST_ASSERT_EQUAL_STRING(goal, said);
    write_in_endless_turn(CDS_HELD_GOAL, "write 4 CCW_ANGLE_LIMIT 0 0");
    TEST_ASSERT_NOT_NULL(strstr(said, "first, since an endless turn would leave them\r\n"));
    write_in_endless_turn(CDS_HELD_GOAL, "write 4 8 0 0 80"); // 80 is no angle limit
    TEST_ASSERT_NOT_NULL(strstr(said, "first, since an endless turn would leave them\r\n"));
    reply_to("limits 4 0 300 30rpm");
    write_in_endless_turn(CDS_HELD_GOAL | CDS_HELD_SPEED | CDS_HELD_SPEED_0,
                          "write 4 CCW_ANGLE_LIMIT 255 3");
    TEST_ASSERT_NOT_NULL(strstr(said, "its speed is 0, as fast as it can, and its limit is "));
}
