/* The two halves of every UART in the simulation (AVR, servo, PC): talker and ear. 8N1 only.
 *
 * Bit times are in 1/256 cycle, so that 115200 baud is right at 16 MHz; an edge falls on the
 * nearest whole cycle, and the rounding does not add up within a frame.
 *
 * An ear keeps no past: it fills in its samples whenever the net is about to change, so it needs
 * one event a frame, and a frame of ten slow bits may see any number of fast edges.
 */
#ifndef SIM_UART_H
#define SIM_UART_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/net.h"
#include "wire/schedule.h"

#define UART_FRAME_BITS 10 // start, 8 data, stop

/* Bit time in 1/256 cycle. */
uint32_t uart_bit_256(uint32_t clock_Hz, uint32_t baud);

/* Cycles in `half_bits` half bits, rounded. */
uint64_t uart_half_bits(uint32_t bit_256, unsigned half_bits);

struct uart_tx {
    struct schedule *schedule;
    struct driver *driver; // whose level it sets; who enables it is the owner's business
    void *context;
    void (*on_start)(void *context, uint64_t now); // the start bit begins; may be 0
    void (*on_end)(void *context, uint64_t now);   // the stop bit has ended; may talk again at once
    struct event event;
    bool busy;
    uint32_t bit_256;
    uint64_t start;
    uint16_t frame; // bit 0: start bit; bit 9: stop bit
    uint8_t bit;    // the one that comes next
};

void uart_tx_init(struct uart_tx *tx, struct schedule *schedule, struct driver *driver,
                  void *context);
/* Puts one frame on the driver, from `start` on. The talker must not be busy. */
void uart_tx_send(struct uart_tx *tx, uint64_t start, uint32_t bit_256, uint8_t byte);
/* Time at which a bit of the present frame begins: 0 (start) to 9 (stop). */
uint64_t uart_tx_bit_time(const struct uart_tx *tx, unsigned bit);
/* Time at which the stop bit of the present frame ends. */
uint64_t uart_tx_end(const struct uart_tx *tx);
/* Power was lost: the frame ends here, unfinished and without on_end. */
void uart_tx_stop(struct uart_tx *tx, uint64_t now);

struct uart_frame {
    uint8_t byte;
    bool framing_error; // the stop bit was low
    uint64_t start;     // of its start bit
    uint64_t end;       // of its stop bit: half a bit after it is delivered
};

struct uart_rx {
    struct schedule *schedule;
    struct net *net;
    void *context;
    uint32_t (*get_bit_256)(void *context);        // asked at each start bit; 0: bit_256 holds
    void (*on_start)(void *context, uint64_t now); // start bit verified, in its middle; may be 0
    void (*on_byte)(void *context, uint64_t now, const struct uart_frame *frame); // mid stop bit
    struct listener listener;
    struct event event;
    bool enabled;
    bool hearing; // within a frame
    bool level;   // of the net since the latest change
    uint64_t level_time;
    uint8_t samples; // taken so far
    uint16_t bits;
    uint32_t bit_256;
    uint64_t start;
};

/* The ear begins disabled. */
void uart_rx_init(struct uart_rx *rx, struct schedule *schedule, struct net *net, void *context);
/* A frame begins with a falling edge after the ear was enabled. What comes of a frame that had
 * begun before is what a real receiver makes of it: nothing, or garbage. Disabling drops the frame.
 */
void uart_rx_enable(struct uart_rx *rx, bool enabled);

#endif
