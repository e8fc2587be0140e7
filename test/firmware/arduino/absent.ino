/* SPDX-License-Identifier: MIT */
// What each read says of a servo that is not there, and of one that loses its power.
// test/build/test_arduino.py
#include <CDS55xx.h>

CDS55XX_ROBOT(dxl);

using namespace ControlTableItem;

template <typename T> void say(const char *name, T value)
{
    Serial.print(name);
    Serial.print(' ');
    Serial.println(value);
    Serial.flush();
}

void setup()
{
    uint8_t data = 9;
    int32_t value = 7;

    Serial.begin(115200);
    dxl.begin();
    delay(1500);
    say("ping", dxl.ping(9));
    say("error", dxl.getLastLibErrCode() == DXL_LIB_ERROR_TIMEOUT);
    say("position", dxl.getPresentPosition(9));
    say("degrees", dxl.getPresentPosition(9, UNIT_DEGREE));
    say("velocity", dxl.getPresentVelocity(9, UNIT_RPM));
    say("item", dxl.readControlTableItem(MOVING, 9));
    say("model", dxl.getModelNumber(9));
    say("checked", dxl.getPresentPosition(9, &value, UNIT_DEGREE));
    say("value", value);
    say("read", dxl.read(9, ID, 1, &data, 1));
    say("data", data);
    say("mode", dxl.setOperatingMode(9, OP_POSITION));
    say("torqueOn", dxl.torqueOn(9));
    say("setID", dxl.setID(9, 10));
    say("setBaudrate", dxl.setBaudrate(9, 500000));

    // servo 1 is without power from 2.5 s to 3.5 s
    say("ping", dxl.ping(1));
    say("torqueOn", dxl.torqueOn(1));
    say("goal", dxl.setGoalPosition(1, 600));
    while (millis() < 3000) {
    }
    for (int i = 0; i < 4; i++)
        say("without power", dxl.getPresentPosition(1));
    while (millis() < 5500) {
    }
    say("ping", dxl.ping(1));
    say("goal", dxl.setGoalPosition(1, 400));
    dxl.printLastError(Serial);
    Serial.println();
    say("torqueOn", dxl.torqueOn(1));
    say("goal", dxl.setGoalPosition(1, 400));

    // from 6 s to 6.3 s it does not answer, and keeps its torque
    while (millis() < 6100) {
    }
    say("silent", dxl.setGoalPosition(1, 500));
    say("error", dxl.getLastLibErrCode() == DXL_LIB_ERROR_TIMEOUT);
    say("silent", dxl.setGoalPosition(1, 500));
    say("error", dxl.getLastLibErrCode() == DXL_LIB_ERROR_TIMEOUT);
    while (millis() < 6400) {
    }
    say("goal", dxl.setGoalPosition(1, 500));
}

void loop()
{
}
