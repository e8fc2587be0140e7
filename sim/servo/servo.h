/* One simulated CDS55xx servo: a state machine of bytes in, status packets out.
 *
 * It knows nothing of AVRs, of wires and of the controller's library: its codec, its control table
 * and its motor are its own, so that one mistake cannot cancel itself out. Who owns it gives it
 * every byte its receiver hears and a tick every 4 ms (R29), and puts the reply on the wire. "Rn"
 * are the project's rulings on the manual's contradictions: docs/internals/rulings.md.
 */
#ifndef SIM_SERVO_H
#define SIM_SERVO_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/codec.h"          // struct codec
#include "servo/motor.h"         // struct motor, struct servo_world
#include "servo/control_table.h" // the addresses of the registers

#define SERVO_REGISTERS         TABLE_REGISTERS
#define SERVO_EEPROM_SIZE       TABLE_EEPROM_SIZE
#define SERVO_PACKET_MAX        CODEC_PACKET_MAX // 258
#define SERVO_TICK_US           4000
#define SERVO_RESET_BAUD        1 // register 0x04: 2 000 000 / (1 + 1) = 1 Mbps
#define SERVO_BROADCAST_ID      0xFE
#define SERVO_PAUSE_US          2000   // what ended before such a pause is not executed behind it
#define SERVO_PACKET_TIMEOUT_US 100000 // the rest of a packet does not come any more
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

/* What the LED does. */
enum servo_lamp { SERVO_LAMP_OFF, SERVO_LAMP_ON, SERVO_LAMP_BLINKING };

/* A status packet that is due. It leaves `delay_us` after the end of the last byte heard, in bits
 * of the baud register `baud`: both as they were when the instruction packet arrived (R2). */
struct servo_reply {
    uint16_t size; // bytes
    uint8_t baud;
    uint32_t delay_us;
    uint8_t bytes[SERVO_PACKET_MAX];
};

/* How real servos are known to differ from the manual; all off after servo_init(). */
struct servo_quirks {
    bool silent_after_power_up;   // deaf and mute for 1 s
    bool sync_write_limit;        // a longer SYNC WRITE is not noticed at all
    uint16_t extra_turnaround_us; // on top of the return delay
    uint16_t jitter_us;           // 0..this on top of that, at random
    uint32_t seed;                // of the jitter, never 0; servo_init() takes it from the ID
};

struct servo {
    uint8_t registers[SERVO_REGISTERS];   // what a READ returns
    struct servo_environment environment; // the owner's to change at any time
    struct servo_quirks quirks;           // likewise
    struct servo_reply reply;
    struct motor motor;
    /* the rest is the servo's own */
    bool powered;
    uint8_t saved_baud;    // what 0x04 is after the next power-up (R24)
    uint8_t packet_error;  // of its last packet, good or damaged (R36)
    uint16_t torque_limit; // max torque as copied at power-up (R7)
    uint32_t ticks;        // since power-up
    struct {
        uint8_t address;
        uint8_t count;
        uint8_t data[SERVO_REGISTERS];
    } registered; // the REG WRITE that waits, while 0x2C is 1
    struct codec codec;
};

/* Factory values and this ID, powered up at 12.0 V and 32 degrees, no load, output in the middle.
 */
void servo_init(struct servo *servo, uint8_t id);

/* true powers up anew, also after no power-off: RAM area, lock, torque, registered write and an
 * unlisted baud rate are lost. Without power it is deaf and mute; go on ticking: the output coasts.
 */
void servo_power(struct servo *servo, bool on);

/* The line was silent for so long before the next byte. After SERVO_PAUSE_US the servo does not
 * execute a packet any more that stands inside a damaged one and ended before the silence. After
 * SERVO_GIVES_UP_US it drops the packet that has begun, as Dynamixels do. */
void servo_silence(struct servo *servo, uint64_t us);

/* One byte its receiver heard. True: servo->reply is due. An earlier reply that still waits is the
 * owner's to keep. A servo that talks or waits to talk should not be given bytes. */
bool servo_receive(struct servo *servo, uint8_t byte, bool framing_error);

/* 4 ms have passed: goals are taken, present values and alarms renewed. */
void servo_tick(struct servo *servo);

/* The baud register its receiver uses once the reply has left. */
uint8_t servo_baud(const struct servo *servo);

/* What it finds at the next power-up. A set powers up anew if it has power; false, and nothing
 * happens, if no servo can hold those bytes. Read-only registers keep their values. */
void servo_get_eeprom(const struct servo *servo, uint8_t bytes[SERVO_EEPROM_SIZE]);
bool servo_set_eeprom(struct servo *servo, const uint8_t bytes[SERVO_EEPROM_SIZE]);

/* For plots and tables. */
uint16_t servo_goal_position(const struct servo *servo);
uint16_t servo_present_position(const struct servo *servo);
int32_t servo_position_milliunits(const struct servo *servo); // not cut off at 0 and 1023
bool servo_torque(const struct servo *servo);                 // neither shut down nor free
enum servo_lamp servo_lamp(const struct servo *servo);
bool servo_led(const struct servo *servo);       // lit now; an alarm blinks at 2 Hz
uint8_t servo_errors(const struct servo *servo); // conditions and the last packet's

#endif
