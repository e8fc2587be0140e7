/* The controller's serial port to the PC; see serial.h. */
#include "serial.h"

/* The nearest rate there is with U2X. 115200 is 2.1 % off at 16 MHz, as on every Arduino. */
#define DIVISOR ((F_CPU + 4UL * BOARD_HOST_BAUD) / (8UL * BOARD_HOST_BAUD))
#if DIVISOR < 1 || DIVISOR > 4096 || F_CPU * 100 > 8UL * DIVISOR * BOARD_HOST_BAUD * 103 ||        \
    F_CPU * 100 < 8UL * DIVISOR * BOARD_HOST_BAUD * 97
#error "BOARD_HOST_BAUD cannot be made within 3 %"
#endif

void serial_open(struct serial *serial)
{
    *serial = (struct serial){.broken = 0};
    SERIAL_STATUS = AVR_U2X;
    SERIAL_REGISTER_(UCSR, C) = AVR_EIGHT_BITS;
    serial_set_baud(UINT8_MAX);
    SERIAL_CONTROL = SERIAL_IDLE;
}

void serial_set_baud(uint8_t baud)
{
    uint16_t divisor = baud == UINT8_MAX ? DIVISOR - 1 : baud;

    SERIAL_REGISTER_(UBRR, H) = (uint8_t)(divisor >> 8);
    SERIAL_REGISTER_(UBRR, L) = (uint8_t)divisor;
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
