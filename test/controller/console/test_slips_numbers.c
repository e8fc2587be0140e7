/* SPDX-License-Identifier: MIT */
/* Numbers that are nearly right: the error names the line to type. */
#include "console/slips.h"
#include "console_rig.h"

void setUp(void)
{
    begin_console();
    robot.health_pauses = true;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_steps_in_place_of_degrees_name_raw(void)
{
    static const char *const lines[][2] = {
        {"move 1 512", "error 33: servo 1: ANGLE 512: beyond 300deg; steps: 'move 1 512raw'\r\n"},
        {"move 1,2 512", "error 33: ANGLE 512: beyond 300deg; steps: 512raw\r\n"},
        {"set 1 GOAL_POSITION 512",
         "error 33: servo 1: VALUE 512: beyond 300deg; steps: 512raw\r\n"},
        {"pose 512 90", "error 33: ANGLE... '512': beyond 300deg; steps: 512raw\r\n"},
        {"limits 1 0 301", "error 33: servo 1: HIGH 301: beyond 300deg; steps: 301raw\r\n"},
        {"move 1 1024", "error 33: servo 1: ANGLE 1024 is out of range: 0 to 300deg\r\n"},
        {"move 1 90 512", "error 33: servo 1: SPEED 512 is out of range: 0 to 62rpm\r\n"},
    };

    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_move_of_two_servos_names_one_word(void)
{
    static const char two[] = "error 33: servo 1: SPEED 90: a speed is 0 to 62rpm; two servos: "
                              "'move 1,2 90'\r\n";

    assert_reply("error 33: servo 1: SPEED 90 is out of range: 0 to 62rpm\r\n", "move 1 2 90");
    robot_add(&robot, 2);
    assert_reply(two, "move 1 2 90");
    robot_add(&robot, 1);
    assert_reply("error 33: servo 1: SPEED 90 is out of range: 0 to 62rpm\r\n", "move 1 1 90");
}

/* True if the slip has a text when the move of this line is too fast. */
static bool fast_has_text(const char *line)
{
    struct token word = {0};

    parse_begin(&console.line);
    for (; *line; line++) {
        if (*line != ' ')
            token_add(&word, *line);
        if (*line == ' ' || (line[1] != ' ' && line[1] != '\0'))
            continue;
        parse_word(&console.line, &word, ' ');
        word.length = 0;
    }
    console.error = ERROR_TOO_FAST;
    return slip_text(&console) != NULL;
}

void test_fast_move_names_seconds_only_for_a_small_number(void)
{
    TEST_ASSERT_TRUE(fast_has_text("pose near in 20"));
    TEST_ASSERT_EQUAL_UINT16(20, console.printer.values[2].number);
    TEST_ASSERT_FALSE(fast_has_text("pose near in 21"));
    TEST_ASSERT_FALSE(fast_has_text("pose near in 2ms"));
}

void test_set_of_a_read_only_register_names_a_line(void)
{
    static const char *const lines[][2] = {
        {"set 1 PRESENT_POSITION 5",
         "error 42: servo 1: read-only, measured; 'move 1 5' moves there\r\n"},
        {"set 1 PRESENT_POSITION 512", "error 42: servo 1: read-only; 'get 1 36' prints it\r\n"},
        {"set 1 PRESENT_VOLTAGE 5", "error 42: servo 1: read-only; 'get 1 42' prints it\r\n"},
        {"set 1 ID 5", "error 42: servo 1: 'id 1 5' changes it\r\n"},
        {"set 1 ID 254", "error 42: servo 1: register cannot be set; "},
        {"set 1 BAUD_RATE 500000", "error 42: servo 1: 'baud 1 500000' changes it\r\n"},
        {"set 1 BAUD_RATE 500kbps", "error 42: servo 1: 'baud 1 500kbps' changes it\r\n"},
    };

    ASSERT_REPLIES(lines);
}
