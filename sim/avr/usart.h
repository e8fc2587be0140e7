/* SPDX-License-Identifier: MIT */
/* A USART of the AVR, between its registers and the nets TXD and RXD.
 *
 * There are two versions. The exact one (usart.c) replaces simavr's registers and follows the data
 * sheet. The stock one (usart_stock.c) keeps simavr's USART and passes bytes, for comparison. Both
 * use wire/uart.h, so both look the same on the wire.
 *
 * While an instruction writes a register, simavr's clock stands at the start of the instruction:
 * the write takes effect one cycle later (USART_WRITE_CYCLES). A frame starts with the write that
 * caused it. In silicon the transmitter's clock runs freely, and the start bit may come up to one
 * bit time later. */
#ifndef SIM_USART_H
#define SIM_USART_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>
#include <simavr/avr_uart.h>

#include "wire/net.h"
#include "wire/uart.h"

#define USART_WRITE_CYCLES 1
#define USART_QUEUE        64 // bytes that simavr's USART may accept before they are sent

enum usart_event {
    USART_ENABLED,      // TXEN or RXEN has changed, or the last frame after TXEN=0 has ended
    USART_FRAME,        // a frame begins on TXD
    USART_BAD_FORMAT,   // a frame begins and UCSRC does not select 8N1
    USART_WRITE_LOST,   // UDR was written while UDRE was 0: the byte is lost
    USART_WRITE_OFF,    // UDR was written while TXEN was 0: the byte is lost
    USART_OVERRUN,      // a received byte was overwritten (DOR)
    USART_BYTE_IGNORED, // stock only: a byte arrived while RXEN was 0
};

struct usart_byte {
    uint8_t byte;
    bool framing_error;
    bool overrun; // bytes were lost before this byte
};

struct usart {
    avr_t *avr;
    avr_uart_t
        *registers; // addresses and vectors; the exact version does not use simavr's state in it
    struct schedule *schedule;
    struct uart_tx tx;
    struct driver txd;
    struct uart_rx rx;
    bool exact;
    void *context;
    void (*on_event)(void *context, enum usart_event event, uint64_t now); // may be 0

    bool udr_full; // exact: UDR has a byte that waits for the shift register
    uint8_t udr_byte;
    struct usart_byte fifo[2];
    uint8_t fifo_size;
    bool shift_full; // a third byte waits in the receive shift register
    struct usart_byte shift;
    bool lost; // bytes were lost since the latest byte that was kept
    uint8_t read;

    uint8_t queue[USART_QUEUE]; // stock: bytes to send
    uint8_t queued;
    avr_io_write_t stock_write_udr; // stock: simavr's callbacks, called first
    void *stock_udr;
    avr_io_write_t stock_write_ucsrb;
    void *stock_ucsrb;
};

/* Replaces USART `number`. Returns false if the chip has no such USART. */
bool usart_init(struct usart *usart, avr_t *avr, unsigned number, bool exact,
                struct schedule *schedule, struct net *txd, struct net *rxd);
void usart_init_stock(struct usart *usart);

/* Resets registers and state with the chip. */
void usart_reset(struct usart *usart, uint64_t now);

/* Returns true if the USART drives TXD: TXEN is 1, or frames were pending when TXEN became 0. */
bool usart_is_transmitting(const struct usart *usart);

/* Returns true if a start bit now is received. The stock version checks only whole bytes, when they
 * arrive, and returns true always. */
bool usart_is_listening(const struct usart *usart);

bool usart_rxen(const struct usart *usart);

/* Returns the bit time in 1/256 cycle, from the present UBRR and U2X. */
uint32_t usart_bit_time_256(const struct usart *usart);

/* For both versions: enables the driver of TXD by TXEN. */
void usart_update_txd(struct usart *usart, uint64_t now);
void usart_notify(struct usart *usart, enum usart_event event, uint64_t now);
uint32_t usart_get_bit_time(void *context);

#endif
