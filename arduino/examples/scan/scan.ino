/* Finds all servos, at each rate that a servo keeps without power. */
#include <CDS55xx.h>

#ifdef ARDUINO_AVR_MEGA2560
#define DEBUG_SERIAL Serial
#else // on an Uno the servos have the only USART: connect a USB-serial adapter to pin 8
#include <SoftwareSerial.h>
SoftwareSerial DEBUG_SERIAL(7, 8);
#endif

const unsigned long BAUD[] = {1000000, 500000, 250000, 115200, 57600, 19200};

CDS55XX_ROBOT(dxl);

void setup()
{
    int found = 0;

    DEBUG_SERIAL.begin(115200);
    delay(1500); // the servos start up
    for (unsigned long baud : BAUD) {
        dxl.begin(baud);
        DEBUG_SERIAL.print(dxl.getPortBaud());
        DEBUG_SERIAL.println(" bit/s");
        for (int id = 0; id < DXL_BROADCAST_ID; id++) {
            if (dxl.ping(id)) {
                DEBUG_SERIAL.print("ID ");
                DEBUG_SERIAL.print(id);
                DEBUG_SERIAL.print(", model ");
                DEBUG_SERIAL.println(dxl.getModelNumber(id));
                found++;
            }
        }
    }
    DEBUG_SERIAL.print(found);
    DEBUG_SERIAL.println(" found");
}

void loop()
{
}
