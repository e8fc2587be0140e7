/* SPDX-License-Identifier: MIT */
/* Motor, gear, angle sensor and temperature of a simulated servo, stepped at 250 Hz (R29).
 *
 * The model uses integers only: the same steps give the same values on every host. A position unit
 * is 300/1023 degrees (R9). Positive is CCW (R35). docs/internals/servo-model.md explains the
 * model. */
#ifndef SIM_MOTOR_H
#define SIM_MOTOR_H

#include <stdbool.h>
#include <stdint.h>

#define MOTOR_UNIT       1000000    // microunits in a unit of goal and present position
#define MOTOR_SPEED_UNIT 4960       // microunits per step for 1 in a speed register: 62/1023 RPM
#define MOTOR_FULL_TURN  1227600000 // microunits in 360 degrees
#define MOTOR_STALL      1023       // torque of the stalled motor at 12.0 V
#define MOTOR_FRICTION   40         // of the gear, in 1/1023 of stall torque

/* What acts on a servo from outside. */
struct servo_environment {
    uint8_t supply_dV; // 0.1 V
    uint8_t ambient_C; // temperature of the case without the motor's own heat, degrees Celsius
    int16_t load;      // external torque on the output, in 1/1023 of stall torque at 12 V; positive
                       // pushes CW
    bool blocked;      // the output cannot turn
};

/* What the control table demands. Values are in the units of the registers. */
struct motor_command {
    bool torque;           // power is on and torque is enabled
    bool endless;          // endless turn: goal and margins have no effect
    bool clockwise;        // endless turn only
    uint16_t speed;        // 0: not limited; in endless turn: stop
    uint16_t goal;         // 0..1023
    uint16_t torque_limit; // 0..1023; 0: free run
    uint16_t punch;        // lowest torque while driving
    uint8_t acc, dcc;      // 0: no ramp
    uint8_t cw_margin, ccw_margin;
    uint8_t cw_proportion, ccw_proportion;
};

struct motor {
    int32_t position;    // microunits, -30 to 330 degrees; the sensor measures -15 to 315
    int32_t speed;       // microunits per step
    int32_t torque;      // torque that the motor exerts, in 1/1023 of stall torque
    int32_t temperature; // 1e-6 degrees Celsius
    uint8_t stalled;     // number of steps for which the load was too high
    bool overload;       // the load exceeds the torque limit: torque is lowered to 20 % (R36)
    bool moving;         // drives towards a goal (R32) or turns endlessly (R40)
};

/* The motor is at rest at `position` units and has the ambient temperature. */
void motor_init(struct motor *motor, uint16_t position,
                const struct servo_environment *environment);

/* Cuts the drive: power or torque is off and the output coasts. */
void motor_release(struct motor *motor);

/* Advances the model by 4 ms. */
void motor_step(struct motor *motor, const struct motor_command *command,
                const struct servo_environment *environment);

/* Return the values of the registers: 0..1023, or a magnitude in bits 0-9 with bit 10 for CW (R35).
 * The load is that on the output: its direction is against the motor's torque. */
uint16_t motor_present_position(const struct motor *motor);
uint16_t motor_present_speed(const struct motor *motor);
uint16_t motor_present_load(const struct motor *motor);
uint8_t motor_present_temperature(const struct motor *motor);

#endif
