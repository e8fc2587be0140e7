/* SPDX-License-Identifier: MIT */
// Calls each method of CDS55xx, and prints what it returns. test/build/test_arduino.py
#include <CDS55xx.h>

CDS55XX_ROBOT(dxl);

using namespace ControlTableItem;

const float DXL_PROTOCOL_VERSION = 1.0;

template <typename T> void say(const char *name, T value)
{
    Serial.print(name);
    Serial.print(' ');
    Serial.println(value);
    Serial.flush();
}

void goals()
{
    const int8_t narrow = 100;
    const uint16_t word_value = 1023;

    say("goal int", dxl.setGoalPosition(1, 90, UNIT_DEGREE));
    say("goal double", dxl.setGoalPosition(1, 90.5, UNIT_DEGREE));
    say("goal float", dxl.setGoalPosition(1, 45.25f, UNIT_DEGREE));
    say("goal long", dxl.setGoalPosition(1, 300L, UNIT_DEGREE));
    say("goal int8_t", dxl.setGoalPosition(1, narrow));
    say("goal uint16_t", dxl.setGoalPosition(1, word_value));
    say("goal uint32_t", dxl.setGoalPosition(1, (uint32_t)512));
    say("goal above", dxl.setGoalPosition(1, 300.1, UNIT_DEGREE));
    say("goal far above", dxl.setGoalPosition(1, 5000000000.0, UNIT_DEGREE));
    say("goal above raw", dxl.setGoalPosition(1, 4000000000ul));
    say("goal below", dxl.setGoalPosition(1, -1));
    say("goal far below", dxl.setGoalPosition(1, -2000000000L));
    say("goal nan", dxl.setGoalPosition(1, NAN, UNIT_DEGREE));
    say("goal unit", dxl.setGoalPosition(1, 10, UNIT_RPM));
    say("error", dxl.getLastLibErrCode());
}

void speeds()
{
    say("speed raw", dxl.setGoalVelocity(1, 200));
    say("speed rpm", dxl.setGoalVelocity(1, 31, UNIT_RPM));
    say("speed least", dxl.setGoalVelocity(1, 0.001, UNIT_RPM));
    say("speed 0", dxl.setGoalVelocity(1, 0, UNIT_RPM));
    say("speed percent", dxl.setGoalVelocity(1, 50, UNIT_PERCENT));
    say("speed above", dxl.setGoalVelocity(1, 63, UNIT_RPM));
    say("speed unit", dxl.setGoalVelocity(1, 1, UNIT_DEGREE));
}

void setup()
{
    const uint8_t led[] = {1};
    const uint8_t goal[] = {0, 2};
    uint8_t data[4] = {9, 9, 9, 9};
    uint8_t ids[4];
    int32_t value = 7;

    Serial.begin(115200);
    say("before begin", dxl.ping(1));
    say("begin", dxl.begin(3000000));
    say("after failed begin", dxl.ping(1));
    say("baud", dxl.getPortBaud());
    dxl.begin();
    say("baud", dxl.getPortBaud());
    say("version", dxl.setPortProtocolVersion(DXL_PROTOCOL_VERSION));
    say("version 2", dxl.setPortProtocolVersion(2.0));
    say("version is", dxl.getPortProtocolVersion());
    say("bus pins", DDRA); // pins 22 and 23; the others of a Mega stay free
    delay(1500);
    say("ping", dxl.ping(1));
    say("return delay", dxl.readControlTableItem(RETURN_DELAY_TIME, 1));
    say("ping all", dxl.ping());
    say("scan", dxl.scan());
    say("scan ids", dxl.scan(ids, 2));
    say("ids", ids[0] * 100 + ids[1]);
    say("model", dxl.getModelNumber(1));
    say("torqueOff", dxl.torqueOff(1));
    say("mode", dxl.setOperatingMode(1, OP_POSITION));
    say("torqueOn", dxl.torqueOn(1));
    say("torque", dxl.readControlTableItem(TORQUE_ENABLE, 1));
    say("ledOn", dxl.ledOn(1));
    say("led", dxl.readControlTableItem(LED, 1));
    say("ledOff", dxl.ledOff(1));
    goals();
    speeds();
    delay(2000);
    say("position raw", fabs(dxl.getPresentPosition(1) - 512) <= 2); // compliance margin
    say("degrees", fabs(dxl.getPresentPosition(1, UNIT_DEGREE) - 150.15) < 0.6);
    say("position", dxl.getPresentPosition(1, &value, UNIT_DEGREE));
    say("millidegrees", labs(value - 150147) < 600);
    say("position unit", dxl.getPresentPosition(1, UNIT_RPM));
    say("velocity", dxl.getPresentVelocity(1, UNIT_RPM));
    say("write above", dxl.writeControlTableItem(GOAL_POSITION, 1, 1024));
    say("write below", dxl.writeControlTableItem(LED, 1, -1));
    say("write read-only", dxl.writeControlTableItem(PRESENT_POSITION, 1, 1));
    say("write delay 0", dxl.writeControlTableItem(RETURN_DELAY_TIME, 1, 0));
    dxl.printLastError(Serial);
    Serial.println();
    say("refused", dxl.write(1, GOAL_POSITION, data, 2));
    say("packet error", dxl.getLastStatusPacketError());
    say("read", dxl.read(1, ID, 1, data, sizeof data));
    say("data", data[0]);
    say("read too long", dxl.read(1, ID, 5, data, sizeof data));
    say("read beyond", dxl.read(1, 300, 1, data, sizeof data));
    say("write", dxl.write(1, LED, led, 1));
    say("led", dxl.readControlTableItem(LED, 1));
    say("regWrite", dxl.regWrite(1, GOAL_POSITION, goal, 2));
    say("action", dxl.action(1));
    say("goal", dxl.readControlTableItem(GOAL_POSITION, 1));
    say("velocity mode", dxl.setOperatingMode(1, OP_VELOCITY));
    say("limit", dxl.readControlTableItem(CCW_ANGLE_LIMIT, 1));
    say("speed", dxl.readControlTableItem(MOVING_SPEED, 1));
    say("turn", dxl.setGoalVelocity(1, -31, UNIT_RPM));
    delay(500);
    say("velocity", dxl.getPresentVelocity(1, UNIT_RPM));
    say("velocity", dxl.getPresentVelocity(1, UNIT_PERCENT));
    say("velocity raw", dxl.getPresentVelocity(1));
    say("turn raw", dxl.setGoalVelocity(1, -100));
    say("speed", dxl.readControlTableItem(MOVING_SPEED, 1));
    say("mode", dxl.setOperatingMode(1, OP_POSITION));
    say("limit", dxl.readControlTableItem(CCW_ANGLE_LIMIT, 1));
    say("other mode", dxl.setOperatingMode(1, 16));
    say("setID taken", dxl.setID(1, 2));
    say("setID", dxl.setID(1, 7));
    say("ping 7", dxl.ping(7));
    say("ping 1", dxl.ping(1));
    say("setBaudrate 9600", dxl.setBaudrate(7, 9600));
    say("setBaudrate", dxl.setBaudrate(7, 500000));
    say("ping 2", dxl.ping(2));
    dxl.begin(500000);
    say("ping 7", dxl.ping(7));
    say("factoryReset", dxl.factoryReset(7));
    dxl.begin(1000000);
    delay(1500);
    say("ping 1", dxl.ping(1));
    say("broadcast", dxl.torqueOff(DXL_BROADCAST_ID));
    say("end", millis() > 5000);
}

void loop()
{
}
