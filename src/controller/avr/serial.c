/* SPDX-License-Identifier: MIT */
/* The controller's serial port to the PC; see serial.h. */
#include "avr/serial.h"

void serial_open(struct serial *serial, uint16_t divisor)
{
    SERIAL_CONTROL = 0; // first, so that no handler of the port runs while the struct changes
    serial->rx.tail = serial->rx.head;
    serial->tx.tail = serial->tx.head;
    serial->broken = 0;
    SERIAL_STATUS = CDS_AVR_U2X;
    SERIAL_REGISTER_(UCSR, C) = CDS_AVR_EIGHT_BITS;
    SERIAL_REGISTER_(UBRR, H) = (uint8_t)(divisor >> 8);
    SERIAL_REGISTER_(UBRR, L) = (uint8_t)divisor;
    SERIAL_CONTROL = SERIAL_IDLE;
}

void serial_send(struct serial *serial)
{
    if (cds_ring_count(&serial->tx))
        SERIAL_CONTROL = serial->broken ? SERIAL_SENDING & SERIAL_DEAF : SERIAL_SENDING;
}

bool serial_resume_after_gap(struct serial *serial)
{
    if (!serial->broken || cds_ring_count(&serial->rx))
        return false;
    while (SERIAL_STATUS & 1 << 7) // RXC: bytes that came right after the gap, at most three
        (void)SERIAL_DATA;
    serial->broken = 0;
    SERIAL_CONTROL = SERIAL_SENDING; // the handler turns sending off if the ring is empty
    return true;
}
