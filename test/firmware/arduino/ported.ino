/* SPDX-License-Identifier: MIT */
// A sketch as one writes it for Dynamixel2Arduino: only include and constructor differ.
// test/build/test_arduino.py
#include <CDS55xx.h>

#define DXL_SERIAL   Serial1
#define DEBUG_SERIAL Serial

const uint8_t DXL_DIR_PIN = 2;
const uint8_t DXL_ID = 1;
const float DXL_PROTOCOL_VERSION = 1.0;

CDS55XX_ROBOT(dxl); // was: Dynamixel2Arduino dxl(DXL_SERIAL, DXL_DIR_PIN);

using namespace ControlTableItem;

void setup()
{
    DEBUG_SERIAL.begin(115200);
    while (!DEBUG_SERIAL) {
    }
    dxl.begin(1000000);
    dxl.setPortProtocolVersion(DXL_PROTOCOL_VERSION);
    delay(1500);
    dxl.scan();
    if (dxl.ping(DXL_ID) == true)
        DEBUG_SERIAL.println(dxl.getModelNumber(DXL_ID));
    else
        DEBUG_SERIAL.println(dxl.getLastLibErrCode());
    dxl.torqueOff(DXL_ID);
    dxl.setOperatingMode(DXL_ID, OP_POSITION);
    dxl.torqueOn(DXL_ID);
    dxl.writeControlTableItem(MOVING_SPEED, DXL_ID, 600);
    DEBUG_SERIAL.println(dxl.readControlTableItem(PRESENT_TEMPERATURE, DXL_ID));
    dxl.setGoalPosition(DXL_ID, 600);
    delay(500);
    while (dxl.readControlTableItem(MOVING, DXL_ID)) {
    }
    DEBUG_SERIAL.println(abs(dxl.getPresentPosition(DXL_ID) - 600) <= 2);
    dxl.setGoalPosition(DXL_ID, 120.7, UNIT_DEGREE);
    delay(500);
    while (dxl.readControlTableItem(MOVING, DXL_ID)) {
    }
    DEBUG_SERIAL.println(abs(dxl.getPresentPosition(DXL_ID, UNIT_DEGREE) - 120.7) < 0.6);
}

void loop()
{
}
