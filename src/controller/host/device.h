/* The virtual device: the controller as one more ID on the bus, 253 unless it is set otherwise. It
 * answers PING, READ, WRITE and RESET out of a register table, in the manner of a servo
 * (manual 2.4, rulings R4, R5, R33, R34): what is out of range or read-only is refused as a whole.
 * It does not listen to broadcasts, which are meant for servos: a broadcast WRITE of ID would be
 * its own, too.
 *
 * One table: the firmware's registers and docs/device.md come from it. Main context.
 */
#ifndef CONTROLLER_DEVICE_H
#define CONTROLLER_DEVICE_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h" // CDS_FLASH

#define DEVICE_MODEL_NUMBER 0xCD55
#define DEVICE_OFF          254 // in the register ID: there is no device

/* X(name, address, bytes, access, lowest, highest, unit, what). The first DEVICE_KEPT of them are
 * the settings that are kept, in the order of their table (settings.h). */
#define DEVICE_REGISTERS(X)                                                                        \
    X(ID, 0x03, 1, RW, 0, 254, "-", "the device's own; 254: there is none")                        \
    X(HOST_BAUD, 0x04, 1, RW, 1, 255, "-",                                                         \
      "host link: 2 000 000 / (n + 1) bit/s from the answer on; 255: the board's own rate")        \
    X(BUS_BAUD, 0x05, 1, RW, 0, 254, "-",                                                          \
      "bus: 2 000 000 / (n + 1) bit/s from the answer on, as register 0x04 of a servo")            \
    X(RETURN_DELAY, 0x06, 1, RW, 0, 254, "2 us", "the longest of any servo on the bus")            \
    X(REPEATS, 0x07, 1, RW, 0, 2, "-",                                                             \
      "how often the controller's own PING, READ and WRITE are sent again; never the host's")      \
    X(ECHO, 0x08, 1, RW, 0, 1, "-", "1: the console echoes what is typed")                         \
    X(LINK_LOSS_MS, 0x0A, 2, RW, 0, 65535, "ms",                                                   \
      "silence of the host that counts as loss of the link; 0: not watched")                       \
    X(LINK_LOSS_ACTION, 0x09, 1, RW, 0, 2, "-", "then: 0 show it, 1 hold, 2 torque off")           \
    X(ALARM_REPORT, 0x0E, 1, RW, 0, 1, "-", "1: the console tells an alarm at once")               \
    X(CYCLE_US, 0x0C, 2, RW, 2000, 65535, "us", "period of the cycle")                             \
    X(MODEL, 0x00, 2, RD, 0, 65535, "-", "model number: 0xCD55")                                   \
    X(VERSION, 0x02, 1, RD, 0, 255, "-", "firmware version: 16 x major + minor")                   \
    X(SAVE, 0x10, 1, RW, 0, 1, "-",                                                                \
      "1: keep 0x03 to 0x0F; 0 again when that is done, 2: the EEPROM does not keep it")           \
    X(BUS_STATE, 0x11, 1, RD, 0, 2, "-", "0 ok, 1 busy: heard from unasked, 2 fault: held low")    \
    X(RESET_CAUSE, 0x12, 1, RD, 0, 255, "-",                                                       \
      "bits: 1 power, 2 reset pin, 4 brown-out, 8 watchdog, 16 JTAG")                              \
    X(LINK_LOST, 0x13, 1, RW, 0, 0, "-",                                                           \
      "1: the host was silent for LINK_LOSS_MS; 0 clears, as the console's clear does; a range "   \
      "error while torque off is under way")                                                       \
    X(ALARMS, 0x14, 1, RW, 0, 0, "-", "error bits of any servo since; 0 clears")                   \
    X(ALARM_ID, 0x15, 1, RD, 0, 255, "-", "the first known servo with one; 255: none")             \
    X(FAILED, 0x16, 1, RD, 0, 255, "servos", "failed in the last SYNC READ or BULK READ")          \
    X(INHIBIT, 0x17, 1, RW, 0, 0, "-",                                                             \
      "1: driving is inhibited, by a stop, a lost host link or from before a reset; 0 releases "   \
      "it, as the console's release does; a range error while LINK_LOST is 1 or torque off is "    \
      "under way")                                                                                 \
    X(DELAYS_REFUSED, 0x4A, 2, RD, 0, 65535, "packets",                                            \
      "not sent: they set a RETURN_DELAY that this board cannot bear")                             \
    X(BUS_SENT, 0x18, 2, RD, 0, 65535, "packets", "sent on the bus, repeated ones too")            \
    X(BUS_RETRIED, 0x1A, 2, RD, 0, 65535, "packets", "... of them, sent again")                    \
    X(BUS_OK, 0x1C, 2, RD, 0, 65535, "exchanges", "ended well")                                    \
    X(BUS_TIMEOUTS, 0x1E, 2, RD, 0, 65535, "exchanges", "without a reply by the deadline")         \
    X(BUS_CORRUPT, 0x20, 2, RD, 0, 65535, "exchanges", "with nothing but damage by the deadline")  \
    X(BUS_LINE_BUSY, 0x22, 2, RD, 0, 65535, "requests", "not sent: the line was not quiet")        \
    X(BUS_MALFORMED, 0x24, 2, RD, 0, 65535, "packets", "heard with a bad LENGTH or checksum")      \
    X(BUS_NOISE_BYTES, 0x46, 2, RD, 0, 65535, "bytes", "heard that began no packet")               \
    X(BUS_STALE_REPLIES, 0x26, 2, RD, 0, 65535, "packets", "replies too late")                     \
    X(BUS_DUPLICATE_REPLIES, 0x28, 2, RD, 0, 65535, "packets",                                     \
      "second replies: two servos have that ID")                                                   \
    X(BUS_UNEXPECTED_PACKETS, 0x2A, 2, RD, 0, 65535, "packets", "of a servo that was not asked")   \
    X(BUS_FRAMING_ERRORS, 0x2C, 2, RD, 0, 65535, "bytes", "damaged")                               \
    X(BUS_OVERRUNS, 0x2E, 2, RD, 0, 65535, "bytes", "lost in the receiver")                        \
    X(BUS_RING_OVERFLOWS, 0x30, 2, RD, 0, 65535, "bytes", "lost because nobody took them")         \
    X(BUS_ECHO_ERRORS, 0x32, 2, RD, 0, 65535, "bytes", "own ones that came back changed")          \
    X(HOST_PACKETS, 0x34, 2, RD, 0, 65535, "packets", "whole ones of the host")                    \
    X(HOST_MALFORMED, 0x36, 2, RD, 0, 65535, "packets", "dropped: LENGTH or checksum")             \
    X(HOST_SILENT, 0x38, 2, RD, 0, 65535, "packets", "dropped: the host fell silent for 15 ms")    \
    X(HOST_GAPS, 0x3A, 2, RD, 0, 65535, "-", "times that something of the host's was lost")        \
    X(HOST_LATE, 0x4C, 2, RD, 0, 65535, "packets", "dropped: 15 ms old when their turn came")      \
    X(HOST_STOPS, 0x48, 2, RD, 0, 65535, "-", "Ctrl-X found in damaged packets")                   \
    X(HOST_OVERFLOWS, 0x3C, 2, RD, 0, 65535, "-",                                                  \
      "of HOST_GAPS, those in the receiver or its buffer")                                         \
    X(BRIDGE_PASSED, 0x3E, 2, RD, 0, 65535, "packets", "of the host given to the bus")             \
    X(BRIDGE_ANSWERED, 0x40, 2, RD, 0, 65535, "packets", "... of them answered")                   \
    X(BRIDGE_UNANSWERED, 0x42, 2, RD, 0, 65535, "packets", "... not answered though one was due")  \
    X(BRIDGE_REFUSED, 0x44, 2, RD, 0, 65535, "packets", "not given to the bus: held, limited")     \
    X(FAILED_IDS, 0x50, 32, RD, 0, 255, "-",                                                       \
      "a bit for each ID that failed in the last SYNC READ or BULK READ: bit ID % 8 of byte "      \
      "ID / 8")

#define DEVICE_TABLE_SIZE 0x70
#define DEVICE_KEPT       10

enum device_register {
#define DEVICE_ENUM_(name, address, bytes, access, lowest, highest, unit, what) DEVICE_##name,
    DEVICE_REGISTERS(DEVICE_ENUM_)
#undef DEVICE_ENUM_
        DEVICE_REGISTER_COUNT,
} __attribute__((packed));

/* What stands behind the registers; `reg`: enum device_register. Not asked for MODEL, VERSION,
 * FAILED and FAILED_IDS. */
struct device_ops {
    uint16_t (*get)(void *context, uint8_t reg);
    void (*set)(void *context, uint8_t reg, uint16_t value); // within its range
    bool (*allows)(void *context, uint8_t reg);              // may `reg` be written now?
    void (*reset)(void *context);                            // factory values
    bool (*settled)(void *context); // after set and reset: has it all come into force?
};

struct device {
    const CDS_FLASH struct device_ops *ops;
    void *context;         // of its values
    uint8_t error, length; // of the answer: CDS_ERROR_* bits, parameters
    bool unsettled;        // what was asked is done but for ops->settled()
    uint8_t left, from;    // of a READ: registers to be looked at, its first address
    uint8_t failed;        // servos, of
    uint8_t failed_ids[32];
};

/* The ID it has now; DEVICE_OFF: none. */
uint8_t device_id(const struct device *device);

/* Does what the whole packet at `packet` asks. True: device->error and `length` are those of the
 * answer, whose parameters are at `packet` now. False: it cannot be answered yet, call again. */
bool device_obey(struct device *device, uint8_t *packet);

/* True while device_obey() has to be called again for the same packet. */
static inline bool device_is_busy(const struct device *device)
{
    return device->unsettled || device->left;
}

/* For FAILED and FAILED_IDS. */
void device_forget_failures(struct device *device);
void device_note_failure(struct device *device, uint8_t id);

#endif
