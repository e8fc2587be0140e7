/* SPDX-License-Identifier: MIT */
/* Packets that are refused for another servo than that of the line. */
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

void test_packet_to_all_beyond_limits_names_the_servo(void)
{
    static const char *const lines[][2] = {
        {"move 254 10", "error 11: servo 2: the angle is not within its limits, 60.117deg to "
                        "239.883deg; nothing was sent; 'limits 2 LOW HIGH' changes them\r\n"},
        {"move 254 100", "error 11: servo 2: 'move' needs a SPEED above 0, up to 30rpm; nothing "
                         "was sent; 'limits 2 LOW HIGH' changes them\r\n"},
        {"write 254 GOAL_POSITION 34",
         "error 11: servo 2: 34 is 9.971deg, its limits are 60.117deg to 239.883deg\r\n"},
        {"torque 254 on", "error 11: servo 2: its goal is not known to be within its limits, "},
        {"sync GOAL_POSITION 2 1:0,0 2:0,0",
         "error 11: servo 2: its limits are 60.117deg to 239.883deg and 30rpm; nothing was sent; "
         "'limits 2 LOW HIGH' changes them\r\n"},
        {"sync TORQUE_ENABLE 1 2:1",
         "error 11: servo 2: its limits are 60.117deg to 239.883deg and 30rpm; nothing was sent; "
         "'limits 2 LOW HIGH' changes them\r\n"},
        {"write 254 ID 5", "error 11: not within the servo's limits; "},
    };

    robot_add(&robot, 1);
    robot_add(&robot, 2);
    reply_to("limits 2 60 240 30rpm");
    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_reset_to_the_id_of_a_listed_servo_names_it(void)
{
    static const char *const lines[][2] = {
        {"reset 2", "error 50: servo 2: ID 1 is in the robot's list, nothing was written; 'id 1 "
                    "NEW' first, or unplug servo 1, then 'servos forget 1'\r\n"},
    };

    robot_add(&robot, 1);
    robot_add(&robot, 2);
    ASSERT_REPLIES(lines);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}
