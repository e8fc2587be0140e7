/* SPDX-License-Identifier: MIT */
// Prints on Serial without a pause while the bus is busy; says how many milliseconds went by
// between two writes to the LED, and how many requests got no good reply at once.
// test/build/test_arduino.py
#include <CDS55xx.h>

CDS55XX_ROBOT(dxl);

void setup()
{
    struct cds_stats stats;
    char digit = '0';

    Serial.begin(115200);
    dxl.begin();
    while (!dxl.ping(1)) {
    }
    dxl.ledOn(1);
    unsigned long from = millis();
    while (millis() - from < 1000) {
        int32_t position;
        while (Serial.availableForWrite() > 0) {
            Serial.write(digit);
            digit = digit == '9' ? '0' : digit + 1;
        }
        dxl.getPresentPosition(1, &position, UNIT_RAW);
    }
    unsigned long ms = millis() - from;
    dxl.ledOff(1);
    cds_bus_stats(dxl.servos().bus, &stats);
    while (digit != '0') {
        Serial.write(digit);
        digit = digit == '9' ? '0' : digit + 1;
    }
    Serial.print("ms ");
    Serial.print(ms);
    Serial.print(" lost ");
    Serial.println(stats.sent - stats.ok);
}

void loop()
{
}
