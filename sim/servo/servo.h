/* SPDX-License-Identifier: MIT */
/* One simulated CDS55xx servo: bytes in, status packets out.
 *
 * The model includes nothing of the AVR, of the wire and of the controller's library. Its codec,
 * control table and motor are its own, so the same mistake cannot be on both sides. The caller
 * passes each received byte to servo_receive(), calls servo_tick() every 4 ms (R29) and sends
 * servo->reply. "Rn" is a ruling on a contradiction in the manual: docs/internals/rulings.md. */
#ifndef SIM_SERVO_H
#define SIM_SERVO_H

#include <stdbool.h>
#include <stdint.h>

#include "servo/control_table.h" // addresses of the registers
#include "servo/motor.h"         // struct motor, struct servo_environment
#include "wire/codec.h"          // struct codec

#define SERVO_REGISTERS         TABLE_REGISTERS
#define SERVO_EEPROM_SIZE       TABLE_EEPROM_SIZE
#define SERVO_PACKET_MAX        CODEC_PACKET_MAX // 258
#define SERVO_TICK_US           4000
#define SERVO_RESET_BAUD        1 // register 0x04: 2 000 000 / (1 + 1) = 1 Mbit/s
#define SERVO_BROADCAST_ID      0xFE
#define SERVO_PAUSE_US          2000   // a packet from before this pause is not executed
#define SERVO_PACKET_TIMEOUT_US 100000 // the servo drops an unfinished packet
#define SERVO_SYNC_WRITE_LIMIT  143    // bytes, with quirks.sync_write_limit

/* Bits of the ERROR byte (manual 2.3). */
enum servo_error {
    SERVO_ERROR_VOLTAGE = 0x01,
    SERVO_ERROR_ANGLE = 0x02,
    SERVO_ERROR_OVERHEATING = 0x04,
    SERVO_ERROR_RANGE = 0x08,
    SERVO_ERROR_CHECKSUM = 0x10,
    SERVO_ERROR_OVERLOAD = 0x20,
    SERVO_ERROR_INSTRUCTION = 0x40,
};

enum servo_lamp { SERVO_LAMP_OFF, SERVO_LAMP_ON, SERVO_LAMP_BLINKING };

/* A status packet to send. It starts `delay_us` after the end of the last received byte, at the bit
 * rate of the baud register `baud`. Both are as on arrival of the instruction packet (R2). */
struct servo_reply {
    uint16_t size; // bytes
    uint8_t baud;
    uint32_t delay_us;
    uint8_t bytes[SERVO_PACKET_MAX];
};

/* Differences between real servos and the manual. servo_init() turns all off. */
struct servo_quirks {
    bool silent_after_power_up;   // ignores all bytes for 1 s
    bool sync_write_limit;        // ignores a longer SYNC WRITE
    uint16_t extra_turnaround_us; // added to the return delay
    uint16_t jitter_us;           // a random time from 0 to this, added as well
    uint32_t seed;                // of the jitter, never 0; servo_init() derives it from the ID
};

struct servo {
    uint8_t registers[SERVO_REGISTERS];   // the values that READ returns
    struct servo_environment environment; // the caller may change it at any time
    struct servo_quirks quirks;           // the caller may change them at any time
    struct servo_reply reply;
    struct motor motor;
    /* the servo's own */
    bool powered;
    uint8_t saved_baud;    // value of 0x04 after the next power-up (R24)
    uint8_t packet_error;  // of the latest packet, good or damaged (R36)
    uint16_t torque_limit; // MAX_TORQUE at power-up (R7)
    uint32_t ticks;        // since power-up
    struct {
        uint8_t address;
        uint8_t count;
        uint8_t data[SERVO_REGISTERS];
    } registered; // the kept REG WRITE, while 0x2C is 1
    struct codec codec;
};

/* Sets factory values and the ID, and powers up at 12.0 V and 32 degrees Celsius, without load,
 * with the output in the middle. */
void servo_init(struct servo *servo, uint8_t id);

/* Powers up or off. Power-up, also of a powered servo, clears the RAM area, the lock, torque, the
 * registered write and an unlisted baud rate. A servo without power ignores bytes. Keep ticking it:
 * its output coasts. */
void servo_power(struct servo *servo, bool on);

/* The line was silent for `us` before the next byte. After SERVO_PAUSE_US the servo does not
 * execute a packet that stands inside a damaged one and ended before the silence. After
 * SERVO_PACKET_TIMEOUT_US it drops an unfinished packet, as Dynamixels do. */
void servo_silence(struct servo *servo, uint64_t us);

/* Processes one received byte. Returns true if servo->reply is to be sent; it replaces an earlier
 * reply. Do not pass bytes to a servo that sends or is about to send. */
bool servo_receive(struct servo *servo, uint8_t byte, bool framing_error);

/* Advances the servo by 4 ms: takes goals, updates present values and alarms. */
void servo_tick(struct servo *servo);

/* Returns the baud register that the receiver uses after the reply. */
uint8_t servo_baud(const struct servo *servo);

/* The EEPROM area after the next power-up. Setting it powers up a powered servo again. Setting
 * returns false and does nothing if no servo can hold the bytes. Read-only registers keep their
 * values. */
void servo_get_eeprom(const struct servo *servo, uint8_t bytes[SERVO_EEPROM_SIZE]);
bool servo_set_eeprom(struct servo *servo, const uint8_t bytes[SERVO_EEPROM_SIZE]);

/* For plots and tables. */
uint16_t servo_goal_position(const struct servo *servo);
uint16_t servo_present_position(const struct servo *servo);
int16_t servo_present_speed(const struct servo *servo);       // -1023..1023, positive is CCW
int16_t servo_present_load(const struct servo *servo);        // the same
int32_t servo_position_milliunits(const struct servo *servo); // not limited to 0..1023
bool servo_torque(const struct servo *servo); // torque is enabled and MAX_TORQUE is not 0
enum servo_lamp servo_lamp(const struct servo *servo);
bool servo_led(const struct servo *servo);       // lit now; an alarm blinks at 2 Hz
uint8_t servo_errors(const struct servo *servo); // of conditions and of the latest packet

#endif
