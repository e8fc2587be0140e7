/* SPDX-License-Identifier: MIT */
/* The two halves of each simulated UART (AVR, servo, PC): transmitter and receiver. 8N1 only.
 *
 * Bit times are in 1/256 cycle, so 115200 bit/s is exact at 16 MHz. An edge falls on the nearest
 * whole cycle. The rounding error does not add up within a frame.
 *
 * A receiver does not store the past of the net. It takes its due samples whenever the net is about
 * to change. It needs one event for each frame, however many edges the frame has. */
#ifndef SIM_UART_H
#define SIM_UART_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/net.h"
#include "wire/schedule.h"

#define UART_FRAME_BITS 10 // start bit, 8 data bits, stop bit

/* Returns the bit time in 1/256 cycle. */
uint32_t uart_bit_time_256(uint32_t clock_Hz, uint32_t baud);

/* Returns the cycles in `half_bits` half bits, rounded. */
uint64_t uart_cycles_of_half_bits(uint32_t bit_time_256, unsigned half_bits);

struct uart_tx {
    struct schedule *schedule;
    struct driver *driver; // the transmitter sets its level; the caller enables it
    void *context;
    void (*on_start)(void *context, uint64_t now); // the start bit begins; may be 0
    void (*on_end)(void *context,
                   uint64_t now); // the stop bit has ended; the next frame may begin at once
    struct event event;
    bool busy;
    uint32_t bit_time_256;
    uint64_t start;
    uint16_t frame; // bit 0 is the start bit, bit 9 the stop bit
    uint8_t bit;    // index of the next bit
};

void uart_tx_init(struct uart_tx *tx, struct schedule *schedule, struct driver *driver,
                  void *context);
/* Sends one frame from `start` on. The transmitter must not be busy. */
void uart_tx_send(struct uart_tx *tx, uint64_t start, uint32_t bit_time_256, uint8_t byte);
/* Returns the time at which a bit of the present frame begins: 0 (start bit) to 9 (stop bit). */
uint64_t uart_tx_bit_time(const struct uart_tx *tx, unsigned bit);
/* Returns the time at which the stop bit of the present frame ends. */
uint64_t uart_tx_end(const struct uart_tx *tx);
/* Ends the frame at once, without on_end: power was lost. */
void uart_tx_stop(struct uart_tx *tx, uint64_t now);

struct uart_frame {
    uint8_t byte;
    bool framing_error; // the stop bit was low
    uint64_t start;     // start of the start bit
    uint64_t end;       // end of the stop bit, half a bit after the frame is delivered
};

struct uart_rx {
    struct schedule *schedule;
    struct net *net;
    void *context;
    uint32_t (*get_bit_time_256)(
        void *context); // called at each start bit; 0: bit_time_256 applies
    void (*on_start)(void *context, uint64_t now); // in the middle of a valid start bit; may be 0
    void (*on_byte)(void *context, uint64_t now,
                    const struct uart_frame *frame); // in the middle of the stop bit
    struct listener listener;
    struct event event;
    bool enabled;
    bool in_frame; // a frame has begun
    bool level;    // of the net since its latest change
    uint64_t level_time;
    uint8_t samples; // number of samples taken
    uint16_t bits;
    uint32_t bit_time_256;
    uint64_t start;
};

/* A new receiver is disabled. */
void uart_rx_init(struct uart_rx *rx, struct schedule *schedule, struct net *net, void *context);
/* A frame begins with a falling edge after the receiver was enabled. A frame that has begun earlier
 * gives no byte or a wrong byte, as in a real receiver. Disabling drops the present frame. */
void uart_rx_enable(struct uart_rx *rx, bool enabled);

#endif
