/* SPDX-License-Identifier: MIT */
/* The bus of one USART: the wire SIG, the buffers that connect it to TXD and RXD, and their rules.
 *
 * Two enables (the manual's circuit): TXD - buffer (TX enable) - SIG - buffer (RX enable) - RXD. 10
 * kOhm hold TX enable low and RX enable high while the AVR's pins float. One enable: it is the TX
 * enable, and the RX buffer is on while it is low. Tied: TXD and RXD are the wire; tx_enable is
 * true while the TXD pin drives, rx_enable is always true. Adapter: it drives from the first edge
 * of a frame on TXD to the end of the stop bit and BUS_CIRCUIT_HOLD_us longer. Meanwhile RXD is
 * high, or follows the wire (echo). */
#ifndef SIM_BUS_CIRCUIT_H
#define SIM_BUS_CIRCUIT_H

#include <stdbool.h>
#include <stdint.h>

#include "avr/machine.h"
#include "avr/pins.h"
#include "avr/usart.h"
#include "board.h"
#include "wire/net.h"
#include "wire/rules.h"

/* An adapter cannot know at the end of a stop bit that no further byte follows. */
#define BUS_CIRCUIT_HOLD_us 1

struct bus_circuit {
    const struct machine *machine;
    struct rules *rules;
    enum board_wiring wiring;
    struct usart usart;
    struct net sig;
    struct net txd;
    struct net rxd;
    struct driver to_sig;  // TX buffer
    struct driver to_rxd;  // RX buffer
    struct driver txd_pin; // PORT and DDR of TXD while the USART does not use the pin
    struct listener on_sig, on_txd;
    struct pin pin_tx_enable, pin_rx_enable, pin_txd, pin_rxd;
    struct pin_input rxd_input;
    bool tx_enable, rx_enable; // at the buffers
    bool listening;            // RX enable and RXEN are on: a start bit now is received
    bool rxd_floats, txd_floats;
    bool txd_output;             // tied: the port drives TXD
    bool two_drivers, collision; // two drivers now: controller and servo; two servos
    bool txd_driven;             // TXD was driven since the latest reset
    uint64_t frame_end;          // adapter: end of the latest frame that it passed on
    struct event release;        // adapter: it stops driving
    uint64_t servo_until;        // end of the latest byte of a servo
    void *context;
    /* An enable has changed, or the controller's transmitter has become busy or idle. May be 0. */
    void (*on_change)(void *context, uint64_t now);
    /* A byte of the controller begins on the wire. May be 0. */
    void (*on_byte)(void *context, uint64_t now);
};

/* Returns false, with one line on stderr, if the chip lacks the USART or a pin. */
bool bus_circuit_init(struct bus_circuit *circuit, struct machine *machine,
                      const struct board_bus *bus, bool exact, struct rules *rules);
void bus_circuit_reset(struct bus_circuit *circuit, uint64_t now);

/* A byte of a servo begins and ends at `end`. Do not call it for a driver that is exempt from the
 * rules. */
void bus_circuit_servo_byte(struct bus_circuit *circuit, uint64_t now, uint64_t end);

#endif
