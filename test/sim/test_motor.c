/* SPDX-License-Identifier: MIT */
/* The motor model: speeds, ramps, position loop, loads and temperature. */
#include "unity.h"

#include "servo/motor.h"

static struct motor motor;
static struct motor_command command;
static struct servo_environment environment;

void setUp(void)
{
    environment = (struct servo_environment){.supply_dV = 120, .ambient_C = 32};
    command = (struct motor_command){
        .torque = true,
        .goal = 512,
        .torque_limit = 1023,
        .punch = 0x5A,
        .acc = 32,
        .dcc = 32,
        .cw_margin = 2,
        .ccw_margin = 2,
        .cw_proportion = 32,
        .ccw_proportion = 32,
    };
    motor_init(&motor, 512, &environment);
}

void tearDown(void)
{
}

static void steps(int count)
{
    while (count-- > 0) {
        motor_step(&motor, &command, &environment);
    }
}

static int steps_until_rest(void)
{
    int count = 0;
    do {
        steps(1);
        count++;
    } while ((motor.moving || motor.speed != 0) && count < 5000);
    return count;
}

static int position(void)
{
    return motor_present_position(&motor);
}

void test_at_rest_at_the_goal_nothing_happens(void)
{
    steps(1000);
    TEST_ASSERT_EQUAL(512 * MOTOR_UNIT, motor.position);
    TEST_ASSERT_EQUAL(0, motor_present_speed(&motor));
    TEST_ASSERT_EQUAL(0, motor_present_load(&motor));
    TEST_ASSERT_FALSE(motor.moving);
}

void test_the_output_arrives_within_the_margin_from_both_sides(void)
{
    static const uint16_t goals[] = {0, 1023, 512, 515, 509, 0, 1, 1022};
    for (unsigned i = 0; i < sizeof goals / sizeof goals[0]; i++) {
        command.goal = goals[i];
        TEST_ASSERT_LESS_THAN(400, steps_until_rest());
        TEST_ASSERT_INT_WITHIN(2, goals[i], position());
    }
}

void test_with_margin_0_the_output_arrives_exactly(void)
{
    command.cw_margin = command.ccw_margin = 0;
    for (unsigned dcc = 0; dcc <= 255; dcc += 15) {
        for (int goal = 100; goal <= 900; goal += 400) {
            command.goal = (uint16_t)goal;
            command.acc = command.dcc = (uint8_t)dcc;
            steps_until_rest();
            TEST_ASSERT_EQUAL(goal, position());
        }
    }
}

void test_output_does_not_run_past_the_goal(void)
{
    command.cw_margin = command.ccw_margin = 0;
    command.goal = 900;
    for (unsigned dcc = 1; dcc <= 255; dcc++) {
        motor_init(&motor, 200, &environment);
        command.dcc = (uint8_t)dcc;
        for (int i = 0; i < 2500; i++) {
            steps(1);
            TEST_ASSERT_LESS_OR_EQUAL(900 * MOTOR_UNIT + MOTOR_UNIT / 2, motor.position);
        }
    }
}

void test_R10_speed_0x3FF_is_62_rpm(void)
{
    command.endless = true;
    command.speed = 0x3FF;
    steps(100);
    int32_t start = motor.position;
    steps(25); // 0.1 s: 37.2 degrees are 126.852 units
    TEST_ASSERT_EQUAL(126852000, motor.position - start);
    TEST_ASSERT_EQUAL(0x3FF, motor_present_speed(&motor));
}

void test_R10_every_speed_is_kept(void)
{
    command.endless = true;
    for (int speed = 1; speed <= 1023; speed++) {
        command.speed = (uint16_t)speed;
        steps(40);
        TEST_ASSERT_EQUAL(speed, motor_present_speed(&motor));
        TEST_ASSERT_EQUAL(speed * MOTOR_SPEED_UNIT, motor.speed);
    }
}

void test_R10_speed_limits_the_way_to_the_goal(void)
{
    command.goal = 1000;
    command.speed = 100;
    steps(200);
    TEST_ASSERT_EQUAL(100, motor_present_speed(&motor));
}

static int32_t top_speed(uint8_t supply_dV)
{
    environment.supply_dV = supply_dV;
    motor_init(&motor, 0, &environment);
    command.goal = 1023;
    int32_t top = 0;
    for (int i = 0; i < 250; i++) {
        steps(1);
        top = motor.speed > top ? motor.speed : top;
    }
    return top;
}

void test_R10_speed_0_is_as_fast_as_the_supply_allows(void)
{
    TEST_ASSERT_INT32_WITHIN(25 * MOTOR_SPEED_UNIT, 1057 * MOTOR_SPEED_UNIT, top_speed(120));
    TEST_ASSERT_LESS_THAN(610 * MOTOR_SPEED_UNIT, top_speed(70));
    TEST_ASSERT_GREATER_THAN(1200 * MOTOR_SPEED_UNIT, top_speed(160));
}

void test_R10_a_low_supply_does_not_reach_0x3FF(void)
{
    command.speed = 0x3FF;
    TEST_ASSERT_LESS_THAN(800 * MOTOR_SPEED_UNIT, top_speed(90));
}

void test_a_load_slows_the_output_down(void)
{
    command.endless = true;
    command.speed = 0x3FF;
    environment.load = 500; // against CCW
    steps(100);
    TEST_ASSERT_INT_WITHIN(5, (1023 - 500 - MOTOR_FRICTION) * 1100 / 1023,
                           motor_present_speed(&motor));
}

void test_R40_acc_is_the_speed_gained_in_each_step(void)
{
    command.endless = true;
    command.speed = 0x3FF;
    command.acc = 10;
    for (int i = 1; i <= 100; i++) {
        steps(1);
        TEST_ASSERT_EQUAL(10 * i, motor_present_speed(&motor));
    }
}

void test_R40_dcc_is_the_speed_lost_in_each_step(void)
{
    command.goal = 1000;
    command.dcc = 5;
    int32_t before = 0;
    for (int i = 0; i < 1000; i++) {
        steps(1);
        if (motor.moving && position() < 960) { // further on the position loop is weaker
            TEST_ASSERT_LESS_OR_EQUAL(5 * MOTOR_SPEED_UNIT + 1, before - motor.speed);
        }
        before = motor.speed;
    }
    TEST_ASSERT_INT_WITHIN(2, 1000, position());
}

void test_R40_a_slower_dcc_takes_longer(void)
{
    command.goal = 1000;
    int fast = steps_until_rest();
    motor_init(&motor, 512, &environment);
    command.dcc = 4;
    TEST_ASSERT_GREATER_THAN(fast + 20, steps_until_rest());
}

void test_R40_acc_and_dcc_0_mean_no_ramp(void)
{
    command.endless = true;
    command.speed = 300;
    command.acc = command.dcc = 0;
    steps(1);
    TEST_ASSERT_EQUAL(300, motor_present_speed(&motor));
    command.clockwise = true;
    steps(1);
    TEST_ASSERT_EQUAL(0x400 | 300, motor_present_speed(&motor));
}

void test_goal_behind_the_output_makes_it_brake_and_turn(void)
{
    command.goal = 1000;
    steps(30);
    TEST_ASSERT_GREATER_THAN(0, motor.speed);
    int32_t speed = motor.speed;
    command.goal = 300;
    steps(1);
    TEST_ASSERT_EQUAL(speed - 32 * MOTOR_SPEED_UNIT, motor.speed);
    steps_until_rest();
    TEST_ASSERT_INT_WITHIN(2, 300, position());
}

void test_R32_within_the_margin_the_motor_does_not_drive(void)
{
    command.ccw_margin = 20;
    command.cw_margin = 5;
    command.goal = 532;
    steps(100);
    TEST_ASSERT_EQUAL(512 * MOTOR_UNIT, motor.position);
    TEST_ASSERT_FALSE(motor.moving);
    command.goal = 533;
    steps(1);
    TEST_ASSERT_TRUE(motor.moving);

    motor_init(&motor, 512, &environment);
    command.goal = 507;
    steps(100);
    TEST_ASSERT_EQUAL(512 * MOTOR_UNIT, motor.position);
    command.goal = 506;
    steps(1);
    TEST_ASSERT_TRUE(motor.moving);
}

static int32_t sag_under(int16_t load)
{
    motor_init(&motor, 512, &environment);
    environment.load = load;
    steps(1000);
    TEST_ASSERT_FALSE(motor.overload);
    return motor.position - 512 * MOTOR_UNIT;
}

void test_proportion_is_stiffness(void)
{
    int32_t soft = sag_under(400); // pushes CW, the loop pulls CCW
    command.cw_proportion = 200;
    TEST_ASSERT_EQUAL(soft, sag_under(400));
    command.ccw_proportion = 100;
    int32_t stiff = sag_under(400);
    TEST_ASSERT_LESS_THAN(0, soft);
    TEST_ASSERT_LESS_THAN(0, stiff);
    TEST_ASSERT_GREATER_THAN(2 * soft / 3, stiff);
    command.cw_proportion = 32;
    TEST_ASSERT_GREATER_THAN(3 * MOTOR_UNIT, sag_under(-400));
}

void test_without_punch_friction_stops_the_output_early(void)
{
    command.punch = 0;
    command.ccw_proportion = 4;
    command.ccw_margin = 0;
    command.goal = 600;
    steps(2000);
    TEST_ASSERT_LESS_THAN(595, position());
    TEST_ASSERT_TRUE(motor.moving);
    command.punch = 90;
    steps(500);
    TEST_ASSERT_EQUAL(600, position());
}

void test_R35_present_load_has_the_direction_of_the_load(void)
{
    sag_under(300);
    TEST_ASSERT_BITS(0x400, 0x400, motor_present_load(&motor));
    TEST_ASSERT_INT_WITHIN(MOTOR_FRICTION, 300, motor_present_load(&motor) & 0x3FF);
    sag_under(-300);
    TEST_ASSERT_BITS(0x400, 0, motor_present_load(&motor));
    TEST_ASSERT_INT_WITHIN(MOTOR_FRICTION, 300, motor_present_load(&motor) & 0x3FF);
}

void test_R35_speed_has_bit_10_for_CW(void)
{
    command.endless = true;
    command.speed = 200;
    steps(50);
    TEST_ASSERT_EQUAL(200, motor_present_speed(&motor));
    command.clockwise = true;
    steps(50);
    TEST_ASSERT_EQUAL(0x400 | 200, motor_present_speed(&motor));
}

void test_R35_values_in_registers_are_rounded_and_end_at_1023(void)
{
    static const int32_t rows[][3] = {
        // per million, magnitude of speed, magnitude of load
        {0, 0, 0},       {499999, 0, 0},           {500000, 1, 1},
        {1, 0, 0},       {1000000, 1, 1},          {1499999, 1, 1},
        {1500000, 2, 2}, {1023499999, 1023, 1023}, {1100000000, 1023, 1023},
    };
    for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int32_t speed = (int32_t)((int64_t)rows[i][0] * MOTOR_SPEED_UNIT / 1000000);
        motor.position = rows[i][0];
        motor.speed = speed;
        motor.torque = -rows[i][2];
        TEST_ASSERT_EQUAL(rows[i][1], position());
        TEST_ASSERT_EQUAL(rows[i][1], motor_present_speed(&motor));
        TEST_ASSERT_EQUAL(rows[i][2], motor_present_load(&motor));
        motor.speed = -speed;
        motor.torque = rows[i][2];
        int bit_10 = rows[i][1] ? 0x400 : 0; // 0 for magnitude 0
        TEST_ASSERT_EQUAL(rows[i][1] | bit_10, motor_present_speed(&motor));
        TEST_ASSERT_EQUAL(rows[i][2] | bit_10, motor_present_load(&motor));
    }
    motor.torque = 1024;
    TEST_ASSERT_EQUAL(0x7FF, motor_present_load(&motor));
}

void test_load_while_turning_is_load_and_friction(void)
{
    command.endless = true;
    command.speed = 200;
    steps(50);
    TEST_ASSERT_EQUAL(0x400 | MOTOR_FRICTION, motor_present_load(&motor));
    environment.load = 100;
    steps(50);
    TEST_ASSERT_EQUAL(0x400 | (100 + MOTOR_FRICTION), motor_present_load(&motor));
}

void test_without_torque_friction_holds_a_small_load_only(void)
{
    command.torque = false;
    environment.load = MOTOR_FRICTION;
    steps(100);
    TEST_ASSERT_EQUAL(512 * MOTOR_UNIT, motor.position);
    environment.load = MOTOR_FRICTION + 10;
    steps(100);
    int32_t pushed = motor.position - 512 * MOTOR_UNIT;
    TEST_ASSERT_LESS_THAN(0, pushed);
    motor_init(&motor, 512, &environment);
    environment.load = -(MOTOR_FRICTION + 10);
    steps(100);
    TEST_ASSERT_EQUAL(-pushed, motor.position - 512 * MOTOR_UNIT);
    TEST_ASSERT_FALSE(motor.moving);
}

void test_without_torque_the_output_coasts_to_rest(void)
{
    command.goal = 1000;
    steps(40);
    int32_t start = motor.position, speed = motor.speed;
    command.torque = false;
    steps(1);
    TEST_ASSERT_EQUAL(start + speed / 2, motor.position);
    steps(1);
    TEST_ASSERT_EQUAL(start + speed / 2 + speed / 4, motor.position);
    steps(50);
    TEST_ASSERT_EQUAL(0, motor.speed);
}

void test_R36_max_torque_0_is_free_run(void)
{
    command.torque_limit = 0;
    command.goal = 900;
    steps(250);
    TEST_ASSERT_EQUAL(512 * MOTOR_UNIT, motor.position);
    TEST_ASSERT_FALSE(motor.moving);
    environment.load = -100;
    steps(250);
    TEST_ASSERT_GREATER_THAN(520, position());
    TEST_ASSERT_FALSE(motor.overload);
}

void test_R36_a_load_beyond_the_torque_limit_is_overload(void)
{
    command.torque_limit = 511;
    environment.load = 511;
    steps(500);
    TEST_ASSERT_FALSE(motor.overload);
    environment.load = 512;
    steps(500);
    TEST_ASSERT_TRUE(motor.overload);
}

void test_R36_overload_lowers_torque_to_20_percent(void)
{
    environment.load = 1100;
    steps(200);
    TEST_ASSERT_TRUE(motor.overload);
    TEST_ASSERT_EQUAL(0x400 | 204, motor_present_load(&motor));
}

void test_R36_torque_returns_when_the_load_falls(void)
{
    environment.load = 1100;
    steps(200);
    environment.load = 900; // more than the lowered torque, less than the limit
    steps(1);
    TEST_ASSERT_FALSE(motor.overload);
    steps(2000);
    TEST_ASSERT_FALSE(motor.overload);
    TEST_ASSERT_INT_WITHIN(30, 512, position());
}

void test_a_short_jerk_is_no_overload(void)
{
    environment.load = 1100;
    steps(20);
    environment.load = 0;
    steps(20);
    environment.load = 1100;
    steps(20);
    TEST_ASSERT_FALSE(motor.overload);
}

void test_a_blocked_output_is_overload_and_stands(void)
{
    steps(10);
    environment.blocked = true;
    command.goal = 900;
    steps(24);
    TEST_ASSERT_FALSE(motor.overload);
    TEST_ASSERT_EQUAL(0x400 | 1023, motor_present_load(&motor));
    steps(1); // 100 ms
    TEST_ASSERT_TRUE(motor.overload);
    TEST_ASSERT_EQUAL(512 * MOTOR_UNIT, motor.position);
    TEST_ASSERT_EQUAL(0, motor_present_speed(&motor));
    environment.blocked = false;
    steps_until_rest();
    TEST_ASSERT_FALSE(motor.overload);
    TEST_ASSERT_INT_WITHIN(2, 900, position());
}

void test_blocked_output_at_the_goal_is_no_overload(void)
{
    environment.blocked = true;
    steps(100);
    TEST_ASSERT_FALSE(motor.overload);
}

void test_a_low_supply_has_less_torque(void)
{
    environment.load = 600;
    steps(500);
    TEST_ASSERT_FALSE(motor.overload);
    environment.supply_dV = 60;
    steps(500);
    TEST_ASSERT_TRUE(motor.overload);
}

void test_a_joint_has_stops_15_degrees_beyond_the_range(void)
{
    command.torque = false;
    environment.load = 900;
    steps(1000);
    TEST_ASSERT_EQUAL(-51150000, motor.position);
    TEST_ASSERT_EQUAL(0, motor_present_speed(&motor));
    TEST_ASSERT_EQUAL(0, position());
    environment.load = -900;
    steps(1000);
    TEST_ASSERT_EQUAL(1074150000, motor.position);
    TEST_ASSERT_EQUAL(1023, position());
}

void test_R16_endless_turn_goes_round(void)
{
    command.endless = true;
    command.speed = 1000;
    int highest = 0, wraps = 0, last = 512;
    for (int i = 0; i < 1000; i++) {
        steps(1);
        highest = position() > highest ? position() : highest;
        wraps += position() < last;
        last = position();
    }
    TEST_ASSERT_EQUAL(1023, highest);
    TEST_ASSERT_EQUAL(4, wraps); // 4 s at 60.6 RPM from the middle
    command.clockwise = true;
    wraps = 0;
    for (int i = 0; i < 1000; i++) {
        steps(1);
        wraps += position() > last + 500; // it turns CCW a little while it brakes
        last = position();
        TEST_ASSERT_INT32_WITHIN(MOTOR_FULL_TURN / 2, 512 * MOTOR_UNIT, motor.position);
    }
    TEST_ASSERT_EQUAL(4, wraps);
}

void test_R40_moving_in_endless_turn_while_the_speed_is_not_0(void)
{
    command.endless = true;
    steps(1);
    TEST_ASSERT_FALSE(motor.moving);
    command.speed = 1;
    steps(1);
    TEST_ASSERT_TRUE(motor.moving);
    command.speed = 0;
    steps(50);
    TEST_ASSERT_FALSE(motor.moving);
    TEST_ASSERT_EQUAL(0, motor.speed);
}

void test_output_returns_from_the_gap_of_the_sensor(void)
{
    for (int32_t start = -100; start <= 1120; start += 20) {
        motor_init(&motor, 0, &environment);
        motor.position = start * MOTOR_UNIT;
        command.goal = 300;
        steps(1);
        TEST_ASSERT_INT32_WITHIN(MOTOR_UNIT, start * MOTOR_UNIT, motor.position); // no jump
        steps_until_rest();
        TEST_ASSERT_INT_WITHIN(2, 300, position());
    }
}

void test_temperature_starts_at_the_ambient(void)
{
    steps(10000);
    TEST_ASSERT_EQUAL(32, motor_present_temperature(&motor));
}

void test_temperature_follows_the_ambient_first_order(void)
{
    environment.ambient_C = 132;
    steps(4096); // one time constant: 63 %
    TEST_ASSERT_EQUAL(32 + 63, motor_present_temperature(&motor));
    steps(60000);
    TEST_ASSERT_INT_WITHIN(1, 132, motor_present_temperature(&motor));
}

void test_temperature_rises_with_torque(void)
{
    sag_under(400);
    steps(60000);
    int moderate = motor_present_temperature(&motor);
    sag_under(900);
    steps(60000);
    int high = motor_present_temperature(&motor);
    TEST_ASSERT_INT_WITHIN(4, 32 + 15, moderate); // (400 / 1023)^2 of 100 degrees
    TEST_ASSERT_INT_WITHIN(8, 32 + 77, high);
}

void test_temperature_register_ends_at_255(void)
{
    environment.ambient_C = 255;
    command.goal = 1023;
    environment.supply_dV = 255;
    environment.load = 2000;
    steps(60000);
    TEST_ASSERT_EQUAL(255, motor_present_temperature(&motor));
}

void test_the_same_steps_give_the_same_values(void)
{
    struct motor first = {0};
    for (int run = 0; run < 2; run++) {
        setUp();
        for (int i = 0; i < 1000; i++) {
            command.goal = (uint16_t)(i * 37 % 1024);
            environment.load = (int16_t)(i * 71 % 800 - 400);
            steps(3);
        }
        if (run == 0) {
            first = motor;
        }
    }
    TEST_ASSERT_EQUAL(first.position, motor.position);
    TEST_ASSERT_EQUAL(first.speed, motor.speed);
    TEST_ASSERT_EQUAL(first.temperature, motor.temperature);
}
