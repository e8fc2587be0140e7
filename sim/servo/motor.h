/* Motor, gear, angle sensor and temperature of a simulated servo, stepped at 250 Hz (R29).
 *
 * Integers only: the same steps give the same values on every host. A position unit is 300/1023
 * degrees (R9), positive is CCW (R35). What the slopes are and why: docs/internals/servo-model.md.
 */
#ifndef SIM_MOTOR_H
#define SIM_MOTOR_H

#include <stdbool.h>
#include <stdint.h>

#define MOTOR_UNIT       1000000    // microunits in a unit of goal and present position
#define MOTOR_SPEED_UNIT 4960       // microunits per step for 1 in a speed register: 62/1023 RPM
#define MOTOR_FULL_TURN  1227600000 // microunits in 360 degrees
#define MOTOR_STALL      1023       // torque of the stalled motor at 12.0 V
#define MOTOR_FRICTION   40         // of the gear, 1/1023 of stall

/* What the world does to a servo. */
struct servo_environment {
    uint8_t supply_dV; // 0.1 V
    uint8_t ambient_C; // temperature the case settles at, without its own losses
    int16_t load;      // external torque on the output, 1/1023 of stall at 12 V; > 0 pushes CW
    bool blocked;      // the output cannot turn
};

/* What the control table asks for; values as the registers hold them. */
struct motor_command {
    bool torque;           // power, torque enable
    bool endless;          // endless turn: goal and margins do not count
    bool clockwise;        // endless turn only
    uint16_t speed;        // 0: not limited; in endless turn: stop
    uint16_t goal;         // 0..1023
    uint16_t torque_limit; // 0..1023; 0: free run
    uint16_t punch;        // least torque while driving
    uint8_t acc, dcc;      // 0: no ramp
    uint8_t cw_margin, ccw_margin;
    uint8_t cw_proportion, ccw_proportion;
};

struct motor {
    int32_t position;    // microunits, -30 to 330 degrees: what is measured is 0 to 300 and 15 more
    int32_t speed;       // microunits per step
    int32_t torque;      // that the motor exerts, 1/1023 of stall
    int32_t temperature; // 1e-6 degrees C
    uint8_t stalled;     // steps for which the load was too much
    bool overload; // the torque limit cannot control the load: torque is lowered to 20 % (R36)
    bool moving;   // driven towards a goal (R32) or turning endlessly (R40)
};

/* At rest at `position` units, at the temperature of its surroundings. */
void motor_init(struct motor *motor, uint16_t position,
                const struct servo_environment *environment);

/* The drive is cut: power or torque is gone, the output coasts. */
void motor_release(struct motor *motor);

/* 4 ms later. */
void motor_step(struct motor *motor, const struct motor_command *command,
                const struct servo_environment *environment);

/* As the registers have them: 0..1023, and magnitude in bits 0-9 with bit 10 for CW (R35). The load
 * is that on the output: it points against the torque of the motor. */
uint16_t motor_present_position(const struct motor *motor);
uint16_t motor_present_speed(const struct motor *motor);
uint16_t motor_present_load(const struct motor *motor);
uint8_t motor_present_temperature(const struct motor *motor);

#endif
