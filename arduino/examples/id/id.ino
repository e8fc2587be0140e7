/* SPDX-License-Identifier: MIT */
/* Changes the ID of servo 1 to 100, and back. */
#include <CDS55xx.h>

#if defined(ARDUINO_AVR_MEGA2560) || defined(ARDUINO_AVR_MEGA)
#define DEBUG_SERIAL Serial
#else // on an Uno the servos have the only USART: connect a USB-serial adapter to pin 8
#include <SoftwareSerial.h>
SoftwareSerial DEBUG_SERIAL(7, 8);
#endif

CDS55XX_ROBOT(dxl);

void change(uint8_t id, uint8_t new_id)
{
    DEBUG_SERIAL.print(id);
    DEBUG_SERIAL.print(" to ");
    DEBUG_SERIAL.print(new_id);
    DEBUG_SERIAL.print(": ");
    dxl.setID(id, new_id);
    dxl.printLastError(DEBUG_SERIAL); // "ok", or why not
    DEBUG_SERIAL.println();
}

void setup()
{
    DEBUG_SERIAL.begin(115200);
    dxl.begin(1000000);
    while (!dxl.ping(1)) { // a servo starts up in about a second
    }
    dxl.torqueOff(1);
    change(1, 100);
    change(100, 1);
}

void loop()
{
}
