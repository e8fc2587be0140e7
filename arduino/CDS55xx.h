/* SPDX-License-Identifier: MIT */
/* CDS55xx servos from an Arduino sketch. Methods have the names of Dynamixel2Arduino where both
 * libraries can do a thing; docs/arduino.md has the table of differences. Every call waits for its
 * reply. Pins, wiring and timer: docs/arduino.md.
 *
 *     #include <CDS55xx.h>
 *     CDS55XX_ROBOT(robot);
 *
 *     void setup() { robot.begin(1000000); robot.torqueOn(1); }
 *     void loop() { robot.setGoalPosition(1, 90, UNIT_DEGREE); delay(1000); }
 */
#ifndef CDS55XX_ARDUINO_H
#define CDS55XX_ARDUINO_H

#include <Arduino.h>

#include "cds55xx/bus.h"           // struct cds_bus
#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/queue.h"         // struct cds_queue
#include "cds55xx/servos.h"        // struct cds_servos
#include "cds55xx/avr.h"           // CDS_AVR_BUS(), CDS_AVR_CLOCK()
#include "serial_notice.h"         // CDS55XX_SERIAL_NOTICE

/* Defines the object `name`, and binds it to the bus of the board. At file scope, once. */
#define CDS55XX_ROBOT(name)                                                                        \
    static struct cds_bus name##_bus;                                                              \
    CDS_AVR_BUS(name##_bus, 0)                                                                     \
    CDS_AVR_CLOCK()                                                                                \
    CDS55xx name(name##_bus)

/* Servos of which the library knows limits, presence and return delay. More servos work, too. */
#if RAMEND >= 0x1000
#define CDS55XX_SERVOS 32
#else
#define CDS55XX_SERVOS 8
#endif

/* The shortest return delay, register 0x05, whose replies arrive in time beside the interrupt
 * handlers of the Arduino core. ping() and scan() raise a shorter one: once, it is EEPROM. */
#define CDS55XX_RETURN_DELAY_US 24

#define DXL_BROADCAST_ID CDS_BROADCAST_ID // all servos, in torqueOff() and other writes

/* `mode` of setOperatingMode(). */
enum OperatingMode { OP_VELOCITY = 1, OP_POSITION = 3 };

/* `unit` of values. */
enum ParamUnit { UNIT_RAW, UNIT_PERCENT, UNIT_RPM, UNIT_DEGREE };

/* getLastLibErrCode() returns an enum cds_result. These names are of Dynamixel2Arduino; their
 * numbers are not. */
enum DXLLibErrorCode {
    DXL_LIB_OK = CDS_OK,
    DXL_LIB_ERROR_TIMEOUT = CDS_TIMEOUT,
    DXL_LIB_ERROR_CHECK_SUM = CDS_CORRUPT,
};

/* Registers by the names that Dynamixel2Arduino uses, then those of the CDS55xx alone. */
namespace ControlTableItem
{
enum ControlTableItemIndex {
    MODEL_NUMBER = CDS_REG_MODEL_NUMBER,
    FIRMWARE_VERSION = CDS_REG_FIRMWARE_VERSION,
    ID = CDS_REG_ID,
    BAUD_RATE = CDS_REG_BAUD_RATE,
    RETURN_DELAY_TIME = CDS_REG_RETURN_DELAY,
    CW_ANGLE_LIMIT = CDS_REG_CW_ANGLE_LIMIT,
    CCW_ANGLE_LIMIT = CDS_REG_CCW_ANGLE_LIMIT,
    TEMPERATURE_LIMIT = CDS_REG_MAX_TEMPERATURE,
    MIN_VOLTAGE_LIMIT = CDS_REG_MIN_VOLTAGE,
    MAX_VOLTAGE_LIMIT = CDS_REG_MAX_VOLTAGE,
    MAX_TORQUE = CDS_REG_MAX_TORQUE,
    STATUS_RETURN_LEVEL = CDS_REG_STATUS_RETURN_LEVEL,
    ALARM_LED = CDS_REG_ALARM_LED,
    SHUTDOWN = CDS_REG_ALARM_SHUTDOWN,
    TORQUE_ENABLE = CDS_REG_TORQUE_ENABLE,
    LED = CDS_REG_LED,
    CW_COMPLIANCE_MARGIN = CDS_REG_CW_COMPLIANCE_MARGIN,
    CCW_COMPLIANCE_MARGIN = CDS_REG_CCW_COMPLIANCE_MARGIN,
    GOAL_POSITION = CDS_REG_GOAL_POSITION,
    MOVING_SPEED = CDS_REG_MOVING_SPEED,
    PRESENT_POSITION = CDS_REG_PRESENT_POSITION,
    PRESENT_SPEED = CDS_REG_PRESENT_SPEED,
    PRESENT_LOAD = CDS_REG_PRESENT_LOAD,
    PRESENT_VOLTAGE = CDS_REG_PRESENT_VOLTAGE,
    PRESENT_TEMPERATURE = CDS_REG_PRESENT_TEMPERATURE,
    REGISTERED = CDS_REG_REGISTERED_INSTRUCTION,
    MOVING = CDS_REG_MOVING,
    LOCK = CDS_REG_LOCK,
    PUNCH = CDS_REG_PUNCH,
    CW_PROPORTION = CDS_REG_CW_PROPORTION,
    CCW_PROPORTION = CDS_REG_CCW_PROPORTION,
    ACC = CDS_REG_ACC,
    DCC = CDS_REG_DCC,
};
} // namespace ControlTableItem

/* A number of a sketch, in thousandths: 90, 90L and 90.0 are 90000. Integers need no floating
 * point. A number beyond what 32 bits hold, or NAN, becomes INT32_MAX, which every method
 * refuses. */
class CDS55xxNumber
{
  public:
    CDS55xxNumber(int value) : thousandths(1000L * value)
    {
    }
    CDS55xxNumber(unsigned value) : thousandths(1000L * (long)value)
    {
    }
    CDS55xxNumber(long value) : thousandths(isInRange(value) ? 1000 * value : INT32_MAX)
    {
    }
    CDS55xxNumber(unsigned long value)
        : thousandths(value <= (unsigned long)limit ? 1000 * (long)value : INT32_MAX)
    {
    }
    CDS55xxNumber(double value)
        : thousandths(fabs(value) < limit ? (int32_t)lround(value * 1000) : INT32_MAX)
    {
    }

    const int32_t thousandths;

  private:
    static bool isInRange(long value)
    {
        return -limit <= value && value <= limit;
    }
    static const long limit = INT32_MAX / 1000;
};

/* The servos of one bus. A method that returns bool returns true if the servo has answered and
 * accepted; getLastLibErrCode() says why not. */
class CDS55xx
{
  public:
    /* CDS55XX_ROBOT() calls it. */
    explicit CDS55xx(struct cds_bus &bus) : bus_(bus)
    {
    }

    /* Opens the bus at `baud` bit/s, 7843 to 2000000. Sends nothing. False: no register value comes
     * near enough to this rate (3 %); then every call fails until the next begin(). */
    bool begin(unsigned long baud = 1000000);

    /* Returns the rate that begin() got, in bit/s; 0 before it or after it failed. */
    unsigned long getPortBaud() const
    {
        return baud_;
    }

    /* True for 1.0, the only version. */
    bool setPortProtocolVersion(float version)
    {
        return note(version == 1.0f ? CDS_OK : CDS_BAD_ARGUMENT);
    }
    float getPortProtocolVersion() const
    {
        return 1.0f;
    }

    /* True if servo `id`, 0 to 253, answers. A return delay below CDS55XX_RETURN_DELAY_US is raised
     * to it. DXL_BROADCAST_ID: as scan(). */
    bool ping(uint8_t id = DXL_BROADCAST_ID);

    /* Pings all IDs at the rate of the bus: 0.2 s at 1 Mbps. True if a servo answers. */
    bool scan()
    {
        return scan(NULL, 0) != 0;
    }

    /* Writes the IDs that answer to `ids`, at most `capacity` of them. Returns how many answer. */
    uint8_t scan(uint8_t *ids, uint8_t capacity);

    /* Returns register 0x01, 1 for a CDS5516; 0xFFFF: it was not read. */
    uint16_t getModelNumber(uint8_t id);

    /* Changes the ID to `new_id`, 0 to 253, and checks that the servo answers there. False also if
     * a servo has the new ID already: then nothing is written. */
    bool setID(uint8_t id, uint8_t new_id);

    /* Changes the rate of the servo to 19200, 57600, 115200, 250000, 500000 or 1000000 bit/s, and
     * checks that it answers there. The bus keeps its rate until begin(). */
    bool setBaudrate(uint8_t id, uint32_t baudrate);

    /* Factory values: the servo is ID 1 at 1 Mbps afterwards. `option` is not used. */
    bool factoryReset(uint8_t id, uint8_t option = 0xFF, uint32_t timeout_ms = 10);

    /* Switches torque on. A servo that had lost its power may be driven again. */
    bool torqueOn(uint8_t id);

    /* Switches torque off: the output turns freely. */
    bool torqueOff(uint8_t id)
    {
        return writeControlTableItem(ControlTableItem::TORQUE_ENABLE, id, 0);
    }

    /* Switches the LED on. */
    bool ledOn(uint8_t id)
    {
        return writeControlTableItem(ControlTableItem::LED, id, 1);
    }

    /* Switches the LED off. */
    bool ledOff(uint8_t id)
    {
        return writeControlTableItem(ControlTableItem::LED, id, 0);
    }

    /* OP_POSITION or OP_VELOCITY (endless turn). Writes the angle limits, EEPROM, only if the mode
     * differs. A servo that comes from endless turn gets 0 to 300 degrees; one that enters it
     * stands still until setGoalVelocity(). Other modes: false, CDS_BAD_ARGUMENT. */
    bool setOperatingMode(uint8_t id, uint8_t mode);

    /* Moves to `value`: UNIT_RAW 0 to 1023, UNIT_DEGREE 0 to 300. */
    bool setGoalPosition(uint8_t id, CDS55xxNumber value, uint8_t unit = UNIT_RAW);

    /* Speed of moves, or of endless turn. UNIT_RAW 0 to 2047, or -1023 to -1 as 1025 to 2047;
     * UNIT_RPM -62 to 62; UNIT_PERCENT -100 to 100 of 62 RPM. Positive is CCW. In position mode not
     * negative, and 0 is as fast as the servo can. */
    bool setGoalVelocity(uint8_t id, CDS55xxNumber value, uint8_t unit = UNIT_RAW);

    /* Present position or speed. With `value` it is a whole number: of UNIT_RAW the register, of
     * other units thousandths (millidegrees, 1/1000 RPM). False: *value is as it was. */
    bool getPresentPosition(uint8_t id, int32_t *value, uint8_t unit);
    bool getPresentVelocity(uint8_t id, int32_t *value, uint8_t unit);

    /* The same in floating point. NAN: it was not read. */
    float getPresentPosition(uint8_t id, uint8_t unit = UNIT_RAW)
    {
        int32_t value;

        return getPresentPosition(id, &value, unit) ? toFloat(value, unit) : NAN;
    }
    float getPresentVelocity(uint8_t id, uint8_t unit = UNIT_RAW)
    {
        int32_t value;

        return getPresentVelocity(id, &value, unit) ? toFloat(value, unit) : NAN;
    }

    /* Reads a register, in its own unit: 0 to 65535; -1: it was not read. `timeout_ms` is not used:
     * the library knows when a reply is late. */
    int32_t readControlTableItem(uint8_t item, uint8_t id, uint32_t timeout_ms = 100);

    /* Writes a register, in its own unit. False without a packet if `data` is out of range. */
    bool writeControlTableItem(uint8_t item, uint8_t id, int32_t data, uint32_t timeout_ms = 100);

    /* Reads `length` registers, 1 to 50, from `address` on. Returns `length`, or 0: `data` is as it
     * was. */
    int32_t read(uint8_t id, uint16_t address, uint16_t length, uint8_t *data, uint16_t capacity,
                 uint32_t timeout_ms = 10);

    /* Writes `length` registers, 1 to 49, from `address` on. */
    bool write(uint8_t id, uint16_t address, const uint8_t *data, uint16_t length,
               uint32_t timeout_ms = 10);

    /* As write(), but the servo keeps the values until action(). */
    bool regWrite(uint8_t id, uint16_t address, const uint8_t *data, uint16_t length,
                  uint32_t timeout_ms = 10);

    /* The servo carries out what regWrite() has sent; DXL_BROADCAST_ID: all servos at once. */
    bool action(uint8_t id, uint32_t timeout_ms = 10);

    /* How the last call ended: 0 (DXL_LIB_OK), or another enum cds_result, docs/errors.md. */
    int32_t getLastLibErrCode() const
    {
        return result_;
    }

    /* CDS_ERROR_* bits of the last reply. */
    uint8_t getLastStatusPacketError() const
    {
        return request_.error;
    }

    /* Prints how the last call ended: "no reply by the deadline". Returns the number of bytes. */
    size_t printLastError(Print &out) const;

    /* For calls of the C library: what is known of each servo; servos().bus is the bus. */
    struct cds_servos &servos()
    {
        return servos_;
    }

  private:
    static float toFloat(int32_t value, uint8_t unit)
    {
        return unit == UNIT_RAW ? (float)value : (float)value / 1000.0f;
    }
    bool note(enum cds_result result)
    {
        result_ = result;
        return result == CDS_OK;
    }
    bool isReady();
    bool readRegisters(uint8_t id, uint8_t address, uint8_t length);
    bool readWord(uint8_t id, uint8_t address, uint16_t *value);
    bool writeWord(uint8_t id, uint8_t address, uint16_t value);
    bool drive(uint8_t id, uint8_t address, uint16_t value);
    bool isThere(uint8_t id);
    void raiseReturnDelay(uint8_t id);
    bool changeIdentity(uint8_t change, uint8_t id, uint8_t to);

    struct cds_bus &bus_;
    struct cds_servos servos_;
    struct cds_queue queue_;
    struct cds_request request_;
    struct cds_servo_state states_[CDS55XX_SERVOS];
    uint8_t packet_[CDS_PACKET_SIZE(CDS_REPLY_MAX)];
    uint8_t reply_[CDS_REPLY_MAX];
    unsigned long baud_;
    enum cds_result result_;
};

/* The bus has a USART of the board. The core's object of this USART cannot be used with it. */
template <int usart> inline HardwareSerial &cds55xxUsartOfTheBus()
{
    static_assert(usart != BOARD_BUS0_USART, CDS55XX_SERIAL_NOTICE);
    return *(HardwareSerial *)0; // never compiled
}
#if BOARD_BUS0_USART == 0
#define Serial cds55xxUsartOfTheBus<0>()
#else
#define Serial1 cds55xxUsartOfTheBus<1>()
#endif

#endif
