/* SPDX-License-Identifier: MIT */
/* The virtual device: the controller answers for itself under an ID of its own, 253 by default. It
 * answers PING, READ, WRITE and RESET from a register table, as a servo does (manual 2.4; rulings
 * R4, R5, R33, R34): it refuses a whole packet if any byte is out of range or read-only. It ignores
 * broadcasts: they are meant for servos, and a broadcast WRITE of ID would change its own ID, too.
 *
 * The table below is also the source of docs/device.md. Main context.
 */
#ifndef CONTROLLER_DEVICE_H
#define CONTROLLER_DEVICE_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h" // CDS_FLASH

#define DEVICE_MODEL_NUMBER 0xCD55
#define DEVICE_OFF          254 // in the register ID: there is no device

/* X(name, address, bytes, access, lowest, highest, unit, text). The first
 * DEVICE_SETTING_COUNT registers are the settings, in the order of their table (settings.h).
 * Counters of the bus have the order of struct cds_stats, those of host and bridge the order of
 * their structs. */
#define DEVICE_REGISTERS(X)                                                                        \
    X(ID, 0x03, 1, RW, 0, 254, "-", "ID of the device; 254: there is no device")                   \
    X(HOST_BAUD, 0x04, 1, RW, 1, 255, "-",                                                         \
      "host link: 2 000 000 / (n + 1) bit/s after the reply; 255: the board's own rate")           \
    X(BUS_BAUD, 0x05, 1, RW, 0, 254, "-",                                                          \
      "bus: 2 000 000 / (n + 1) bit/s after the reply, as register 0x04 of a servo")               \
    X(RETURN_DELAY, 0x06, 1, RW, 0, 254, "2 us", "the longest of any servo on the bus")            \
    X(REPEATS, 0x07, 1, RW, 0, 2, "-",                                                             \
      "retries of the controller's own PING, READ and WRITE; packets of the host have none")       \
    X(ECHO, 0x08, 1, RW, 0, 2, "-",                                                                \
      "of the console: 0 bare replies, 1 it echoes each key, 2 for people: a prompt, too")         \
    X(LINK_LOSS_MS, 0x0A, 2, RW, 0, 65535, "ms",                                                   \
      "silence of the host that counts as loss of the link; 0: not watched")                       \
    X(LINK_LOSS_ACTION, 0x09, 1, RW, 0, 2, "-",                                                    \
      "after a loss of the link: 0 show it, 1 inhibit driving, 2 torque off")                      \
    X(ALARM_REPORT, 0x0E, 1, RW, 0, 1, "-",                                                        \
      "1: the console reports an alarm at once, whatever its mode")                                \
    X(CYCLE_US, 0x0C, 2, RW, 2000, 65535, "us", "period of the cycle")                             \
    X(MODEL, 0x00, 2, RD, 0, 65535, "-", "model number: 0xCD55")                                   \
    X(VERSION, 0x02, 1, RD, 0, 255, "-", "firmware version: 16 x major + minor")                   \
    X(SAVE, 0x10, 1, RW, 0, 1, "-",                                                                \
      "1: saves 0x03 to 0x0F; reads 0 when that has ended, 2 if the EEPROM has failed")            \
    X(BUS_STATE, 0x11, 1, RD, 0, 2, "-",                                                           \
      "0 quiet, 1 suspect: bytes came that no request asked for, 2 fault: held low")               \
    X(RESET_CAUSE, 0x12, 1, RD, 0, 255, "-",                                                       \
      "bits: 1 power, 2 reset pin, 4 brown-out, 8 watchdog, 16 JTAG")                              \
    X(LINK_LOST, 0x13, 1, RW, 0, 0, "-",                                                           \
      "1: the host was silent for LINK_LOSS_MS; 0 clears it, as the command clear does; range "    \
      "error while torque off is under way")                                                       \
    X(ALARMS, 0x14, 1, RW, 0, 0, "-",                                                              \
      "error bits of all known servos since the last clear; 0 clears them")                        \
    X(ALARM_ID, 0x15, 1, RD, 0, 255, "-", "ID of the first known servo with an alarm; 255: none")  \
    X(FAILED, 0x16, 1, RD, 0, 255, "servos", "that failed in the last SYNC READ or BULK READ")     \
    X(INHIBIT, 0x17, 1, RW, 0, 0, "-",                                                             \
      "1: driving is inhibited, after a stop, a lost host link or a reset during either; 0 "       \
      "releases it, as the command release does; range error while LINK_LOST is 1 or torque off "  \
      "is under way")                                                                              \
    X(MOTION_PLAY, 0x70, 1, RW, 0, 255, "-",                                                       \
      "N: plays the stored sequence in line N of 'sequence list', as the command play; 0 ends "    \
      "the "                                                                                       \
      "motion, as motion off; reads the sequence that plays; 0: none; see below")                  \
    X(MOTION_OVERRIDE, 0x71, 1, RW, 10, 200, "%",                                                  \
      "share of the speed, of the motion under way and of MOTION_PLAY; 'play' and 'pose ... in' "  \
      "set it, too")                                                                               \
    X(MOTION_PAUSE, 0x72, 1, RW, 0, 1, "-",                                                        \
      "1: the motion pauses, as by the command pause; 0: it goes on; range error while none is "   \
      "under way")                                                                                 \
    X(MOTION_STATE, 0x73, 1, RD, 0, 2, "-",                                                        \
      "0 no motion, 1 a motion starts: steps and servos are checked, 2 it is under way or paused") \
    X(MOTION_STEP, 0x74, 1, RD, 0, 16, "-", "step of the sequence under way, from 1 on; 0: none")  \
    X(MOTION_ERROR, 0x75, 1, RD, 0, 255, "-",                                                      \
      "why the last motion was refused or has ended, as in errors.md; 0: it has ended well, or "   \
      "one is under way; 79: it was ended by motion off or MOTION_PLAY")                           \
    X(DELAYS_REFUSED, 0x4A, 2, RD, 0, 65535, "packets",                                            \
      "not sent because they set a RETURN_DELAY that this board cannot receive")                   \
    X(BUS_SENT, 0x18, 2, RD, 0, 65535, "packets", "sent on the bus, retries included")             \
    X(BUS_RETRIED, 0x1A, 2, RD, 0, 65535, "packets", "sent again because no good reply had come")  \
    X(BUS_OK, 0x1C, 2, RD, 0, 65535, "transactions", "that ended well")                            \
    X(BUS_TIMEOUTS, 0x1E, 2, RD, 0, 65535, "transactions",                                         \
      "without a good reply by the deadline, and without damage")                                  \
    X(BUS_CORRUPT, 0x20, 2, RD, 0, 65535, "transactions",                                          \
      "without a good reply by the deadline, but with damage")                                     \
    X(BUS_LINE_BUSY, 0x22, 2, RD, 0, 65535, "requests",                                            \
      "not sent because the line did not become quiet")                                            \
    X(BUS_MALFORMED, 0x24, 2, RD, 0, 65535, "packets", "with a wrong LENGTH or checksum")          \
    X(BUS_NOISE_BYTES, 0x46, 2, RD, 0, 65535, "bytes", "that begin no packet")                     \
    X(BUS_STALE_REPLIES, 0x26, 2, RD, 0, 65535, "packets",                                         \
      "of the servo whose transaction had just failed")                                            \
    X(BUS_DUPLICATE_REPLIES, 0x28, 2, RD, 0, 65535, "packets",                                     \
      "of the servo that had just answered: two servos have its ID")                               \
    X(BUS_UNEXPECTED_PACKETS, 0x2A, 2, RD, 0, 65535, "packets",                                    \
      "of another servo, or of another length than the reply")                                     \
    X(BUS_FRAMING_ERRORS, 0x2C, 2, RD, 0, 65535, "bytes",                                          \
      "damaged: noise, collision or another baud rate")                                            \
    X(BUS_OVERRUNS, 0x2E, 2, RD, 0, 65535, "bytes", "lost in the USART: other handlers ran")       \
    X(BUS_RING_OVERFLOWS, 0x30, 2, RD, 0, 65535, "bytes", "lost because the ring was full")        \
    X(BUS_ECHO_ERRORS, 0x32, 2, RD, 0, 65535, "bytes", "sent that came back changed")              \
    X(HOST_PACKETS, 0x34, 2, RD, 0, 65535, "packets", "good ones from the host")                   \
    X(HOST_MALFORMED, 0x36, 2, RD, 0, 65535, "packets", "dropped: wrong LENGTH or checksum")       \
    X(HOST_SILENT, 0x38, 2, RD, 0, 65535, "packets",                                               \
      "dropped: the host was silent for 15 ms before their end")                                   \
    X(HOST_GAPS, 0x3A, 2, RD, 0, 65535, "-", "times that bytes of the host were lost")             \
    X(HOST_LATE, 0x4C, 2, RD, 0, 65535, "packets", "good, dropped: they had waited for 15 ms")     \
    X(HOST_STOPS, 0x48, 2, RD, 0, 65535, "-", "Ctrl-X found in damaged packets")                   \
    X(HOST_OVERFLOWS, 0x3C, 2, RD, 0, 65535, "-",                                                  \
      "HOST_GAPS in the receiver or its ring, damaged bytes included")                             \
    X(BRIDGE_PASSED, 0x3E, 2, RD, 0, 65535, "packets", "of the host given to the bus")             \
    X(BRIDGE_ANSWERED, 0x40, 2, RD, 0, 65535, "packets", "passed, and answered by the servo")      \
    X(BRIDGE_UNANSWERED, 0x42, 2, RD, 0, 65535, "packets",                                         \
      "passed, and not answered though a reply was due")                                           \
    X(BRIDGE_REFUSED, 0x44, 2, RD, 0, 65535, "packets",                                            \
      "not sent: driving is inhibited; a limit; a RETURN_DELAY that this board cannot receive; a " \
      "goal, ID or rate of a servo that a motion moves; READ at status return level 0; an "        \
      "operation has the bus; a malformed BULK READ")                                              \
    X(FAILED_IDS, 0x50, 32, RD, 0, 255, "-",                                                       \
      "a bit for each ID that failed in the last SYNC READ or BULK READ: bit ID % 8 of byte "      \
      "ID / 8")

#define DEVICE_TABLE_SIZE    0x76
#define DEVICE_SETTING_COUNT 10

enum device_register {
#define DEVICE_ENUM_(name, address, bytes, access, lowest, highest, unit, what) DEVICE_##name,
    DEVICE_REGISTERS(DEVICE_ENUM_)
#undef DEVICE_ENUM_
        DEVICE_REGISTER_COUNT,
} __attribute__((packed));

/* Gives the device access to what its registers stand for; `reg`: enum device_register. The device
 * itself answers MODEL, VERSION, FAILED and FAILED_IDS. */
struct device_ops {
    uint16_t (*get)(void *context, uint8_t reg);
    void (*set)(void *context, uint8_t reg, uint16_t value);    // a value within its range
    bool (*allows)(void *context, uint8_t reg, uint16_t value); // true if it may be written now
    bool (*reset)(void *context);   // sets factory values; false: refused, nothing was changed
    bool (*settled)(void *context); // true when all that was set or reset is in force
};

struct device {
    const CDS_FLASH struct device_ops *ops;
    void *context;          // for ops
    uint8_t error, length;  // of the reply: CDS_ERROR_* bits, number of parameters
    bool unsettled;         // a WRITE or RESET waits for ops->settled()
    uint8_t left, from;     // READ under way: registers left to look at, first address
    uint8_t failed;         // servos in failed_ids
    uint8_t failed_ids[32]; // a bit for each ID
};

/* Returns the ID of the device; DEVICE_OFF: there is no device. */
uint8_t device_id(const struct device *device);

/* Carries out the whole packet at `packet`. True: device->error and device->length tell the reply,
 * and its parameters stand at `packet`. False: not finished; call again. */
bool device_obey(struct device *device, uint8_t *packet);

/* The WRITE or RESET that waits for ops->settled() gets no answer. */
static inline void device_drop_answer(struct device *device)
{
    device->unsettled = false;
    device->left = 0;
}

/* True while device_obey() has to be called again for the same packet. */
static inline bool device_is_busy(const struct device *device)
{
    return device->unsettled || device->left;
}

/* Clear FAILED and FAILED_IDS; add a servo to them. */
void device_forget_failures(struct device *device);
void device_note_failure(struct device *device, uint8_t id);

#endif
