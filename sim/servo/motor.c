/* SPDX-License-Identifier: MIT */
#include "servo/motor.h"

#include <stdlib.h>

#define SUPPLY_NOMINAL_DV 120
#define FREE_SPEED        (1100 * MOTOR_SPEED_UNIT) // at 12 V without load and friction
#define SENSED_LOWEST     (-51150000)               // -15 degrees; the sensor covers 330 degrees
#define SENSED_HIGHEST    1074150000                // 315 degrees
#define POSITION_LOWEST   (-102300000)              // -30 degrees, the middle of the sensor's gap
#define STALLED_STEPS     25                        // 100 ms of stall are an overload
#define OVERLOAD_PERCENT  20                        // R36
#define THERMAL_STEPS     4096                      // time constant: 16.4 s
#define STALL_HEAT        100000000                 // 1e-6 degrees above ambient at stall torque

static int32_t clamp(int64_t value, int64_t lowest, int64_t highest)
{
    return (int32_t)(value < lowest ? lowest : value > highest ? highest : value);
}

static int64_t square_root(int64_t value)
{
    int64_t root = 0;
    for (int64_t bit = INT64_C(1) << 26; bit > 0; bit >>= 1) {
        if ((root | bit) * (root | bit) <= value) {
            root |= bit;
        }
    }
    return root;
}

/* Returns the distance to the goal in microunits, CCW positive. 0: the servo does not drive. */
static int32_t distance_to_go(const struct motor *motor, const struct motor_command *command)
{
    if (!command->torque || command->torque_limit == 0) {
        return 0;
    }
    if (command->endless) {
        int32_t distance = command->clockwise ? -MOTOR_FULL_TURN : MOTOR_FULL_TURN;
        return command->speed == 0 ? 0 : distance;
    }
    int32_t sensed = clamp(motor->position, SENSED_LOWEST, SENSED_HIGHEST);
    int32_t distance = command->goal * MOTOR_UNIT - sensed;
    int32_t margin = distance > 0 ? command->ccw_margin : command->cw_margin;
    return abs(distance) <= margin * MOTOR_UNIT ? 0 : distance;
}

/* Returns the torque of the position loop towards the goal, up to the torque limit. */
static int32_t position_loop_torque(const struct motor_command *command, int32_t distance)
{
    if (distance == 0) {
        return 0;
    }
    if (command->endless) {
        return command->torque_limit;
    }
    int64_t proportion = distance > 0 ? command->ccw_proportion : command->cw_proportion;
    return clamp(command->punch + proportion * abs(distance) / MOTOR_UNIT, 0,
                 command->torque_limit);
}

/* Returns the change of speed in each step. */
static int32_t slope(uint8_t ramp)
{
    return ramp == 0 ? INT32_MAX : ramp * MOTOR_SPEED_UNIT;
}

/* Returns the highest speed from which the output stops within `distance`, if it loses slope(dcc)
 * in each step: v + (v - d) + (v - 2d) + ... = distance. */
static int32_t braking_speed(uint8_t dcc, int32_t distance)
{
    if (dcc == 0) {
        return distance;
    }
    int64_t d = slope(dcc);
    return clamp(square_root(d * d / 4 + 2 * d * distance) - d / 2, 0, distance);
}

/* Returns the speed of the next step towards the goal, within the ramps. */
static int32_t ramped_speed(const struct motor_command *command, int32_t speed, int32_t distance)
{
    int64_t highest = command->speed == 0 ? INT32_MAX : command->speed * MOTOR_SPEED_UNIT;
    if (!command->endless) {
        highest = clamp(highest, 0, braking_speed(command->dcc, distance));
    }
    int64_t braked = (int64_t)speed - slope(command->dcc);
    int64_t faster = (int64_t)speed + slope(speed < 0 ? command->dcc : command->acc);
    return clamp(faster, INT32_MIN, braked > highest ? braked : highest);
}

/* Returns the motor's torque at this supply if its driver is asked for `drive`. */
static int32_t at_supply(int32_t drive, const struct servo_environment *environment)
{
    return drive * environment->supply_dV / SUPPLY_NOMINAL_DV;
}

/* Returns the speed of the next step at that torque: the speed moves half way to the balance of
 * torque, load and friction. */
static int32_t reachable_speed(int32_t speed, int32_t torque,
                               const struct servo_environment *environment)
{
    int64_t net = torque - environment->load;
    net = abs((int32_t)net) <= MOTOR_FRICTION ? 0
          : net > 0                           ? net - MOTOR_FRICTION
                                              : net + MOTOR_FRICTION;
    int64_t settled = net * FREE_SPEED / MOTOR_STALL;
    return (int32_t)(settled + (speed - settled) / 2);
}

/* In position mode the joint has stops where the sensor ends. Without stops a high load would turn
 * the output round and round. */
static void move(struct motor *motor, bool endless)
{
    int32_t next = motor->position + motor->speed;
    int32_t stopped = clamp(next, SENSED_LOWEST, SENSED_HIGHEST);
    bool inside = motor->position >= SENSED_LOWEST && motor->position <= SENSED_HIGHEST;
    if (!endless && inside && next != stopped) {
        next = stopped;
        motor->speed = 0;
    }
    if (next < POSITION_LOWEST) {
        next += MOTOR_FULL_TURN;
    } else if (next >= POSITION_LOWEST + MOTOR_FULL_TURN) {
        next -= MOTOR_FULL_TURN;
    }
    motor->position = next;
}

static void warm(struct motor *motor, const struct servo_environment *environment)
{
    int64_t heat =
        (int64_t)motor->torque * motor->torque * STALL_HEAT / (MOTOR_STALL * MOTOR_STALL);
    int64_t settled = environment->ambient_C * INT64_C(1000000) + heat;
    motor->temperature += (int32_t)((settled - motor->temperature) / THERMAL_STEPS);
}

/* A turning motor carries load and friction. A motor at rest exerts the torque that it has. */
static int32_t exerted_torque(int32_t speed, int32_t available_torque, int32_t direction,
                              const struct servo_environment *environment)
{
    if (speed == 0) {
        return direction * available_torque;
    }
    return clamp(environment->load + (speed > 0 ? MOTOR_FRICTION : -MOTOR_FRICTION),
                 -available_torque, available_torque);
}

void motor_init(struct motor *motor, uint16_t position, const struct servo_environment *environment)
{
    *motor = (struct motor){.position = position * MOTOR_UNIT,
                            .temperature = environment->ambient_C * 1000000};
}

void motor_release(struct motor *motor)
{
    motor->torque = 0;
    motor->stalled = 0;
    motor->overload = false;
    motor->moving = false;
}

void motor_step(struct motor *motor, const struct motor_command *command,
                const struct servo_environment *environment)
{
    int32_t distance = distance_to_go(motor, command);
    int32_t direction = (distance > 0) - (distance < 0);
    int32_t drive = position_loop_torque(command, distance);
    int32_t limit = command->torque_limit;

    /* The full limit applies here. With the lowered limit an overload would never end. */
    bool too_much = environment->blocked
                        ? drive == limit
                        : direction * environment->load > at_supply(limit, environment);
    if (distance == 0 || !too_much) {
        motor->stalled = 0;
    } else if (motor->stalled < STALLED_STEPS) {
        motor->stalled++;
    }
    motor->overload = motor->stalled == STALLED_STEPS;
    if (motor->overload) {
        drive = clamp(drive, 0, limit * OVERLOAD_PERCENT / 100);
    }

    int32_t available_torque = at_supply(drive, environment);
    int64_t wanted = 0;
    if (distance != 0) {
        wanted =
            direction * (int64_t)ramped_speed(command, direction * motor->speed, abs(distance));
    }
    motor->speed =
        environment->blocked
            ? 0
            : clamp(wanted, reachable_speed(motor->speed, -available_torque, environment),
                    reachable_speed(motor->speed, available_torque, environment));
    motor->torque = exerted_torque(motor->speed, available_torque, direction, environment);
    motor->moving = distance != 0;
    move(motor, command->endless);
    warm(motor, environment);
}

static uint16_t magnitude_and_direction(int32_t magnitude, bool clockwise)
{
    magnitude = clamp(magnitude, 0, 0x3FF);
    return (uint16_t)(magnitude > 0 && clockwise ? magnitude | 0x400 : magnitude);
}

uint16_t motor_present_position(const struct motor *motor)
{
    return (uint16_t)(clamp(motor->position + MOTOR_UNIT / 2, 0, 1023 * MOTOR_UNIT) / MOTOR_UNIT);
}

uint16_t motor_present_speed(const struct motor *motor)
{
    int32_t rounded = (abs(motor->speed) + MOTOR_SPEED_UNIT / 2) / MOTOR_SPEED_UNIT;
    return magnitude_and_direction(rounded, motor->speed < 0);
}

uint16_t motor_present_load(const struct motor *motor)
{
    return magnitude_and_direction(abs(motor->torque), motor->torque > 0);
}

uint8_t motor_present_temperature(const struct motor *motor)
{
    return (uint8_t)clamp(motor->temperature / 1000000, 0, UINT8_MAX);
}
