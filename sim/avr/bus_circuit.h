/* The bus of one USART: the signal wire, the buffers that join it to TXD and RXD, and its rules.
 *
 * The manual's circuit: TXD - buffer (TX enable) - SIG - buffer (RX enable) - RXD. 10 kOhm hold the
 * TX enable low and the RX enable high while the AVR's pins float. With one enable it is the TX
 * enable, and the RX buffer is on when it is low. Tied: TXD and RXD are the wire; then the "TX
 * enable" is whether the pin drives, the "RX enable" is always on. An adapter works both by itself:
 * it drives from the edge that begins a frame on TXD to the end of the stop bit, and holds the wire
 * WIRE_HOLD_us longer. Meanwhile RXD is high, or it hears the wire nevertheless (echo).
 */
#ifndef SIM_BUS_CIRCUIT_H
#define SIM_BUS_CIRCUIT_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "avr/machine.h"
#include "wire/net.h"
#include "avr/pins.h"
#include "wire/rules.h"
#include "avr/usart.h"

/* Adapter: behind the end of a stop bit it cannot know at once that no other byte follows. */
#define BUS_CIRCUIT_HOLD_us 1

struct bus_circuit {
    const struct machine *machine;
    struct rules *rules;
    enum board_wiring wiring;
    struct usart usart;
    struct net sig;
    struct net txd;
    struct net rxd;
    struct driver to_sig;  // the TX buffer
    struct driver to_rxd;  // the RX buffer
    struct driver txd_pin; // PORT and DDR on TXD while the USART leaves it alone
    struct listener on_sig, on_txd;
    struct pin pin_tx_enable, pin_rx_enable, pin_txd, pin_rxd;
    struct pin_input rxd_input;
    bool tx_enable, rx_enable; // as the buffers see them
    bool listening;            // RX enable and RXEN: a start bit now would be received
    bool rxd_floats, txd_floats;
    bool txd_output;             // tied: the port drives TXD
    bool two_drivers, collision; // now
    bool txd_driven;             // since the latest reset
    uint64_t frame_end;          // adapter: of the latest frame that it passed on
    struct event release;        // adapter: it lets go of the wire
    uint64_t servo_until;        // end of the latest byte of a servo
    void *context;
    /* An enable has changed, or the controller's transmitter begins or falls idle; may be 0. */
    void (*on_change)(void *context, uint64_t now);
    /* A byte of the controller begins on the wire; may be 0. */
    void (*on_byte)(void *context, uint64_t now);
};

/* False, with one line on stderr, when the chip lacks the USART or a pin. */
bool bus_circuit_init(struct bus_circuit *circuit, struct machine *machine,
                      const struct board_bus *bus, bool exact, struct rules *rules);
void bus_circuit_reset(struct bus_circuit *circuit, uint64_t now);

/* A servo's byte begins and will end at `end`; not for one that is excused. */
void bus_circuit_servo_byte(struct bus_circuit *circuit, uint64_t now, uint64_t end);

#endif
