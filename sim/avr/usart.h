/* A USART of the AVR between its registers and two nets, TXD and RXD.
 *
 * Two makes: the exact one (usart.c) takes the registers over from simavr and does what the data
 * sheet says; the stock one (usart_stock.c) leaves simavr's own in place and hands bytes over, to
 * show what the exact one is for. Both use the same talker and ear, so the wire looks alike to the
 * rest.
 *
 * simavr's clock stands at the start of an instruction while that instruction writes a register:
 * the write takes effect one cycle later (USART_WRITE_CYCLES). A frame starts with the write that
 * caused it. In silicon the transmitter's clock runs freely, and the start bit may come up to one
 * bit time later.
 */
#ifndef SIM_USART_H
#define SIM_USART_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>
#include <simavr/avr_uart.h>

#include "wire/net.h"
#include "wire/uart.h"

#define USART_WRITE_CYCLES 1
#define USART_QUEUE        64 // bytes that simavr's own USART may have accepted and not yet sent

enum usart_event {
    USART_ENABLED,      // TXEN or RXEN has changed, or the last frame after TXEN=0 is out
    USART_FRAME,        // a frame begins on TXD
    USART_BAD_FORMAT,   // a frame begins, and UCSRC does not say 8N1
    USART_WRITE_LOST,   // UDR was written while UDRE was 0: the byte is gone
    USART_WRITE_OFF,    // UDR was written while TXEN was 0: the byte is gone
    USART_OVERRUN,      // a received byte was overwritten (DOR)
    USART_BYTE_IGNORED, // stock only: a byte was handed over while RXEN was 0
};

struct usart_byte {
    uint8_t byte;
    bool framing_error;
    bool overrun; // bytes were lost before this one
};

struct usart {
    avr_t *avr;
    avr_uart_t *registers; // addresses, vectors; in exact mode simavr's own state in it is idle
    struct schedule *schedule;
    struct uart_tx tx;
    struct driver txd;
    struct uart_rx rx;
    bool exact;
    void *context;
    void (*on_event)(void *context, enum usart_event event, uint64_t now); // may be 0

    bool udr_full; // exact: a byte is in UDR, behind the one in the shift register
    uint8_t udr_byte;
    struct usart_byte fifo[2];
    uint8_t fifo_size;
    bool shift_full; // a third byte waits in the receive shift register
    struct usart_byte shift;
    bool lost; // since the latest byte that was kept
    uint8_t read;

    uint8_t queue[USART_QUEUE]; // stock: bytes to come
    uint8_t queued;
    avr_io_write_t stock_write_udr; // stock: simavr's own callbacks, called first
    void *stock_udr;
    avr_io_write_t stock_write_ucsrb;
    void *stock_ucsrb;
};

/* Finds USART `number` and takes it over. False when the chip has no such USART. */
bool usart_init(struct usart *usart, avr_t *avr, unsigned number, bool exact,
                struct schedule *schedule, struct net *txd, struct net *rxd);
void usart_init_stock(struct usart *usart);

/* Registers and state as after a reset of the chip. */
void usart_reset(struct usart *usart, uint64_t now);

/* It drives TXD: TXEN, or frames that were pending when TXEN went to 0. */
bool usart_is_transmitting(const struct usart *usart);

/* A start bit at this moment would be received. Stock judges only whole bytes, when they are handed
 * over: it always says yes. */
bool usart_is_listening(const struct usart *usart);

bool usart_rxen(const struct usart *usart);

/* Bit time in 1/256 cycle, from UBRR and U2X as they stand. */
uint32_t usart_bit_256(const struct usart *usart);

/* Shared by the two makes: TXD follows TXEN. */
void usart_update_txd(struct usart *usart, uint64_t now);
void usart_notify(struct usart *usart, enum usart_event event, uint64_t now);
uint32_t usart_get_bit_time(void *context);

#endif
