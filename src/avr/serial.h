/* The controller's serial port to the PC: full duplex, 8N1, a ring for each direction. It belongs
 * to the firmware, not to the library.
 *
 * When the PC sends more than the ring holds, all that follows is refused until the reader has
 * noticed (serial_broken()): so a gap is always at the end of what the ring holds, and the reader
 * knows what was cut.
 */
#ifndef AVR_SERIAL_H
#define AVR_SERIAL_H

#include <avr/interrupt.h>
#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "cds55xx/ring.h" // struct cds_ring
#include "usart.h"        // AVR_PASTE, AVR_U2X

#if !defined BOARD_HOST_USART || !defined BOARD_HOST_BAUD
#error "the console wants BOARD_HOST_USART and _BAUD in board.h; or name a FIRMWARE in board.mk"
#endif

struct serial {
    struct cds_ring rx;
    struct cds_ring tx;
    volatile uint8_t broken; // not 0: something was lost, and nothing is taken until it is cleared
    volatile uint16_t lost;  // bytes, modulo 65536
};

#define SERIAL_REGISTER_(a, b) AVR_PASTE3(a, BOARD_HOST_USART, b)
#define SERIAL_DATA            AVR_PASTE(UDR, BOARD_HOST_USART)
#define SERIAL_STATUS          SERIAL_REGISTER_(UCSR, A)
#define SERIAL_CONTROL         SERIAL_REGISTER_(UCSR, B)

enum {
    SERIAL_IDLE = 1 << 7 | 1 << 4 | 1 << 3, // RXCIE, RXEN, TXEN
    SERIAL_SENDING = SERIAL_IDLE | 1 << 5,  // and UDRIE
};

/* Opens the port at BOARD_HOST_BAUD. Main context, once. */
void serial_open(struct serial *serial);

/* Starts sending what stands in tx. Main context, after putting bytes there. */
void serial_send(struct serial *serial);

/* True once after bytes were lost and all those before the gap have been taken. Main context. */
bool serial_broken(struct serial *serial);

/* Event: a byte came, with its status register as read before it. */
static inline void serial_on_rx(struct serial *serial, uint8_t status, uint8_t byte)
{
    bool good = !(status & (AVR_FRAMING_ERROR | AVR_OVERRUN)) && !serial->broken;

    if (!good || !cds_ring_put(&serial->rx, byte)) {
        serial->broken = 1;
        serial->lost++;
    }
}

/* Event: the transmitter can take a byte. */
static inline void serial_on_tx_ready(struct serial *serial)
{
    if (cds_ring_count(&serial->tx) == 0) {
        SERIAL_CONTROL = SERIAL_IDLE;
        return;
    }
    SERIAL_DATA = cds_ring_peek(&serial->tx, 0);
    cds_ring_drop(&serial->tx, 1);
}

/* Binds the board's BOARD_HOST_USART to `serial`, a struct serial with static storage. */
#define AVR_SERIAL(serial)                                                                         \
    ISR(AVR_PASTE3(USART, BOARD_HOST_USART, _RX_vect))                                             \
    {                                                                                              \
        uint8_t status = SERIAL_STATUS; /* goes with the byte: read first */                       \
        serial_on_rx(&(serial), status, SERIAL_DATA);                                              \
    }                                                                                              \
    ISR(AVR_PASTE3(USART, BOARD_HOST_USART, _UDRE_vect))                                           \
    {                                                                                              \
        serial_on_tx_ready(&(serial));                                                             \
    }

#endif
