/* The controller's serial port to the PC; see serial.h. */
#include "serial.h"

#define BAUD     BOARD_HOST_BAUD
#define BAUD_TOL 3 // per cent: 115200 is 2.1 % off at 16 MHz, as on every Arduino
#define USE_2X   1
#include <util/setbaud.h> // a rate that cannot be made does not compile

#if !USE_2X
#error "the port sets U2X"
#endif

void serial_open(struct serial *serial)
{
    *serial = (struct serial){.broken = 0};
    SERIAL_STATUS = AVR_U2X;
    SERIAL_REGISTER_(UCSR, C) = AVR_EIGHT_BITS;
    SERIAL_REGISTER_(UBRR, H) = UBRRH_VALUE;
    SERIAL_REGISTER_(UBRR, L) = UBRRL_VALUE;
    SERIAL_CONTROL = SERIAL_IDLE;
}

void serial_send(struct serial *serial)
{
    if (cds_ring_count(&serial->tx))
        SERIAL_CONTROL = SERIAL_SENDING;
}

bool serial_broken(struct serial *serial)
{
    if (!serial->broken || cds_ring_count(&serial->rx))
        return false;
    serial->broken = 0;
    return true;
}
