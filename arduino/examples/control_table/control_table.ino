/* SPDX-License-Identifier: MIT */
/* Reads and writes registers by name. A read that fails is never taken for a value. */
#include <CDS55xx.h>

#if defined(ARDUINO_AVR_MEGA2560) || defined(ARDUINO_AVR_MEGA)
#define DEBUG_SERIAL Serial
#else // on an Uno the servos have the only USART: connect a USB-serial adapter to pin 8
#include <SoftwareSerial.h>
SoftwareSerial DEBUG_SERIAL(7, 8);
#endif

const uint8_t DXL_ID = 1;

CDS55XX_ROBOT(dxl);

using namespace ControlTableItem; // the names of the registers

void setup()
{
    DEBUG_SERIAL.begin(115200);
    dxl.begin(1000000);
    while (!dxl.ping(DXL_ID)) { // a servo starts up in about a second
    }
    dxl.writeControlTableItem(LED, DXL_ID, 1);
}

void loop()
{
    int32_t millidegrees;
    int32_t tenths = dxl.readControlTableItem(PRESENT_VOLTAGE, DXL_ID);

    if (tenths < 0) { // no register holds a negative value
        dxl.printLastError(DEBUG_SERIAL);
        DEBUG_SERIAL.println();
    } else {
        DEBUG_SERIAL.print(tenths / 10.0);
        DEBUG_SERIAL.println(" V");
    }

    // without floating point
    if (dxl.getPresentPosition(DXL_ID, &millidegrees, UNIT_DEGREE)) {
        DEBUG_SERIAL.print(millidegrees);
        DEBUG_SERIAL.println(" millidegrees");
    }
    delay(500);
}
