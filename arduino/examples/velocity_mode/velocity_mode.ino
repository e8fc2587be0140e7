/* SPDX-License-Identifier: MIT */
/* Turns servo 1 as a wheel: forwards, backwards, stop. */
#include <CDS55xx.h>

#if defined(ARDUINO_AVR_MEGA2560) || defined(ARDUINO_AVR_MEGA)
#define DEBUG_SERIAL Serial
#else // on an Uno the servos have the only USART: connect a USB-serial adapter to pin 8
#include <SoftwareSerial.h>
SoftwareSerial DEBUG_SERIAL(7, 8);
#endif

const uint8_t DXL_ID = 1;

CDS55XX_ROBOT(dxl);

void show()
{
    DEBUG_SERIAL.print(dxl.getPresentVelocity(DXL_ID, UNIT_RPM)); // nan: the speed was not read
    DEBUG_SERIAL.println(" RPM");
}

void setup()
{
    DEBUG_SERIAL.begin(115200);
    dxl.begin(1000000);
    while (!dxl.ping(DXL_ID)) { // a servo starts up in about a second
    }
    dxl.torqueOff(DXL_ID);
    dxl.setOperatingMode(DXL_ID, OP_VELOCITY);
    dxl.torqueOn(DXL_ID);
}

void loop()
{
    dxl.setGoalVelocity(DXL_ID, 25.8, UNIT_RPM);
    delay(1000);
    show();

    dxl.setGoalVelocity(DXL_ID, -10, UNIT_PERCENT); // of 62 RPM
    delay(1000);
    show();

    dxl.setGoalVelocity(DXL_ID, 0);
    delay(1000);
    show();
}
