/* SPDX-License-Identifier: MIT */
/* Moves servo 1 to and fro, and prints where it is. */
#include <CDS55xx.h>

#if defined(ARDUINO_AVR_MEGA2560) || defined(ARDUINO_AVR_MEGA)
#define DEBUG_SERIAL Serial
#else // on an Uno the servos have the only USART: connect a USB-serial adapter to pin 8
#include <SoftwareSerial.h>
SoftwareSerial DEBUG_SERIAL(7, 8);
#endif

const uint8_t DXL_ID = 1;

CDS55XX_ROBOT(dxl);

void show(unsigned long ms, float degrees)
{
    DEBUG_SERIAL.print(ms);
    DEBUG_SERIAL.print(" ms: ");
    DEBUG_SERIAL.print(degrees); // nan: the position was not read
    DEBUG_SERIAL.println(" degrees");
}

void setup()
{
    DEBUG_SERIAL.begin(115200);
    dxl.begin(1000000);
    while (!dxl.ping(DXL_ID)) { // a servo starts up in about a second
    }
    dxl.torqueOff(DXL_ID);
    dxl.setOperatingMode(DXL_ID, OP_POSITION);
    dxl.torqueOn(DXL_ID);
    dxl.setGoalVelocity(DXL_ID, 30, UNIT_RPM);
}

void loop()
{
    dxl.setGoalPosition(DXL_ID, 512); // the value of the register: 0 to 1023
    delay(1000);
    show(millis(), dxl.getPresentPosition(DXL_ID, UNIT_DEGREE));

    dxl.setGoalPosition(DXL_ID, 90.5, UNIT_DEGREE);
    delay(1000);
    show(millis(), dxl.getPresentPosition(DXL_ID, UNIT_DEGREE));
}
