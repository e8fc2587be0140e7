/* SPDX-License-Identifier: MIT */
/* Finds all servos, at each rate that a servo keeps without power. */
#include <CDS55xx.h>

#if defined(ARDUINO_AVR_MEGA2560) || defined(ARDUINO_AVR_MEGA)
#define DEBUG_SERIAL Serial
#else // on an Uno the servos have the only USART: connect a USB-serial adapter to pin 8
#include <SoftwareSerial.h>
SoftwareSerial DEBUG_SERIAL(7, 8);
#endif

const unsigned long BAUD[] = {1000000, 500000, 250000, 115200, 57600, 19200};

CDS55XX_ROBOT(dxl);

void setup()
{
    uint8_t ids[20];

    DEBUG_SERIAL.begin(115200);
    delay(1500); // the servos start up
    for (unsigned long baud : BAUD) {
        dxl.begin(baud);
        uint8_t found = dxl.scan(ids, sizeof ids);
        DEBUG_SERIAL.print(baud);
        DEBUG_SERIAL.print(" bit/s, found ");
        DEBUG_SERIAL.println(found);
        for (int i = 0; i < found && i < (int)sizeof ids; i++) {
            DEBUG_SERIAL.print("ID ");
            DEBUG_SERIAL.print(ids[i]);
            DEBUG_SERIAL.print(", model ");
            DEBUG_SERIAL.println(dxl.getModelNumber(ids[i]));
        }
    }
}

void loop()
{
}
