/* SPDX-License-Identifier: MIT */
/* Blinks with the LED of servo 1. */
#include <CDS55xx.h>

const uint8_t DXL_ID = 1;

CDS55XX_ROBOT(dxl);

void setup()
{
    dxl.begin(1000000);
    while (!dxl.ping(DXL_ID)) { // a servo starts up in about a second
    }
}

void loop()
{
    dxl.ledOn(DXL_ID);
    delay(500);
    dxl.ledOff(DXL_ID);
    delay(500);
}
