/* SPDX-License-Identifier: MIT */
#include "avr/bus_circuit.h"

#include <inttypes.h>
#include <stdio.h>

/* --- rules --- */

static bool has_adapter(const struct bus_circuit *circuit)
{
    return circuit->wiring == BOARD_ADAPTER || circuit->wiring == BOARD_ADAPTER_ECHO;
}

static unsigned sent_byte(const struct bus_circuit *circuit)
{
    return circuit->usart.tx.frame >> 1 & 0xFF;
}

static void check_release(struct bus_circuit *circuit, uint64_t now)
{
    const struct uart_tx *tx = &circuit->usart.tx;
    if (tx->busy && tx->bit > 0 && now < uart_tx_end(tx)) {
        rules_record_breach(circuit->rules, RULE_EARLY_RELEASE, now,
                            "byte %02X was cut %" PRIu64 " cycles before the end of its stop bit",
                            sent_byte(circuit), uart_tx_end(tx) - now);
    }
}

/* The path to the receiver must be open while a servo sends. */
static void check_listening(struct bus_circuit *circuit, uint64_t now)
{
    bool listening = circuit->rx_enable && usart_is_listening(&circuit->usart);
    if (circuit->listening && !listening && now < circuit->servo_until) {
        rules_record_breach(circuit->rules, RULE_REPLY_LOST, now,
                            "the receiver was shut %" PRIu64
                            " cycles before a servo's byte had ended",
                            circuit->servo_until - now);
    }
    circuit->listening = listening;
}

/* The RXD pin of an adapter never floats. Its TXD pin must be driven at all times, except between a
 * reset and the first time that the firmware drives it. */
static void check_floating(struct bus_circuit *circuit, uint64_t now)
{
    bool adapter = has_adapter(circuit);
    circuit->txd_driven = circuit->txd_driven || circuit->txd.enabled;
    bool rxd = !adapter && !circuit->rx_enable && pin_state(&circuit->pin_rxd) == PIN_FLOATS;
    if (rxd && !circuit->rxd_floats) {
        rules_record_breach(circuit->rules, RULE_FLOATING_RXD, now,
                            "RX enable off, no pull-up on RXD");
    }
    circuit->rxd_floats = rxd;
    bool txd_matters =
        adapter ? circuit->txd_driven : circuit->wiring != BOARD_TIED && circuit->tx_enable;
    bool txd =
        txd_matters && circuit->txd.enabled == 0 && pin_state(&circuit->pin_txd) == PIN_FLOATS;
    if (txd && !circuit->txd_floats) {
        rules_record_breach(circuit->rules, RULE_FLOATING_TXD, now, "%sTXEN off, TXD an open input",
                            adapter ? "" : "TX enable on, ");
    }
    circuit->txd_floats = txd;
}

/* A port pin that is tied to the wire must be an input: as an output it drives the wire at any
 * level. */
static void check_output(struct bus_circuit *circuit, uint64_t now, bool port_drives)
{
    bool output = circuit->wiring == BOARD_TIED && port_drives;
    if (output && !circuit->txd_output) {
        rules_record_breach(circuit->rules, RULE_TXD_OUTPUT, now, "TXEN off, TXD an output");
    }
    circuit->txd_output = output;
}

/* Says in words what connects the controller to the wire. */
static const char *driving(const struct bus_circuit *circuit)
{
    if (has_adapter(circuit)) {
        return "the adapter held the wire";
    }
    return circuit->wiring == BOARD_TIED ? "TXD drove the wire" : "the TX enable was on";
}

static void sig_driver(void *context, uint64_t now, struct driver *driver)
{
    struct bus_circuit *circuit = context;
    (void)driver;
    unsigned servos = circuit->sig.enabled - circuit->sig.exempt - circuit->to_sig.enabled;
    bool two = circuit->to_sig.enabled && servos > 0;
    bool collision = servos > 1;
    if (two && !circuit->two_drivers) {
        bool late = driver == &circuit->to_sig;
        rules_record_breach(circuit->rules, RULE_TWO_DRIVERS, now, "%s began while %s",
                            late ? "the controller" : "a servo",
                            late ? "a servo talked" : driving(circuit));
    }
    if (collision && !circuit->collision) {
        rules_record_breach(circuit->rules, RULE_COLLISION, now,
                            "a servo began while another one talked");
    }
    circuit->two_drivers = two;
    circuit->collision = collision;
}

void bus_circuit_servo_byte(struct bus_circuit *circuit, uint64_t now, uint64_t end)
{
    circuit->servo_until = end;
    if (!circuit->listening) {
        rules_record_breach(circuit->rules, RULE_REPLY_LOST, now, "a servo's byte began while %s",
                            circuit->rx_enable     ? "RXEN was off"
                            : has_adapter(circuit) ? driving(circuit)
                                                   : "the RX enable was off");
    }
}

static void byte_begins(struct bus_circuit *circuit, uint64_t now)
{
    if (!circuit->tx_enable && !has_adapter(circuit)) {
        rules_record_breach(circuit->rules, RULE_DRIVER_OFF, now,
                            "byte %02X never reached the wire", sent_byte(circuit));
    } else if (circuit->on_byte) {
        circuit->on_byte(circuit->context, now);
    }
}

static void check_usart_event(void *context, enum usart_event event, uint64_t now)
{
    struct bus_circuit *circuit = context;
    switch (event) {
    case USART_ENABLED:
        check_listening(circuit, now);
        check_floating(circuit, now);
        break;
    case USART_BAD_FORMAT:
        rules_record_breach(circuit->rules, RULE_FRAME_FORMAT, now, "UCSRC does not say 8N1");
        byte_begins(circuit, now);
        break;
    case USART_FRAME: byte_begins(circuit, now); break;
    case USART_WRITE_LOST:
        rules_record_breach(circuit->rules, RULE_LOST_WRITE, now, "the byte was ignored");
        break;
    case USART_WRITE_OFF:
        rules_record_breach(circuit->rules, RULE_TRANSMITTER_OFF, now, "the byte was ignored");
        break;
    case USART_OVERRUN:
        rules_record_breach(circuit->rules, RULE_OVERRUN, now,
                            "DOR: two bytes unread, a third overwritten");
        break;
    case USART_BYTE_IGNORED:
        rules_record_breach(circuit->rules, RULE_REPLY_LOST, now, "a byte came while RXEN was off");
        break;
    }
}

/* --- the circuit --- */

static void notify(struct bus_circuit *circuit, uint64_t now)
{
    if (circuit->on_change) {
        circuit->on_change(circuit->context, now);
    }
}

/* Closes the path to the receiver before the driver turns on, and opens it after the driver is off.
 */
static void adapter_turn(struct bus_circuit *circuit, uint64_t now, bool drives)
{
    bool receives = !drives || circuit->wiring == BOARD_ADAPTER_ECHO;
    circuit->tx_enable = drives;
    circuit->rx_enable = receives;
    driver_enable(&circuit->to_rxd, now, circuit->to_rxd.enabled && receives);
    driver_set(&circuit->to_sig, now, drives, circuit->txd.level);
    driver_set(&circuit->to_rxd, now, receives, circuit->sig.level);
    check_listening(circuit, now);
    notify(circuit, now);
}

/* The adapter recognises a frame by its falling edge and knows its length from the bit rate. */
static void adapter_frame(struct bus_circuit *circuit, uint64_t now)
{
    uint64_t hold = (uint64_t)circuit->machine->avr->frequency * BUS_CIRCUIT_HOLD_us / 1000000;
    uint32_t bit_time_256 = usart_bit_time_256(&circuit->usart);
    circuit->frame_end = now + uart_cycles_of_half_bits(bit_time_256, 2 * UART_FRAME_BITS);
    schedule_at(circuit->machine->schedule, &circuit->release, circuit->frame_end + hold);
    if (!circuit->tx_enable) {
        adapter_turn(circuit, now, true);
    }
}

static void adapter_releases(void *context, uint64_t now)
{
    adapter_turn(context, now, false);
}

static void sig_level(void *context, uint64_t now, bool level)
{
    struct bus_circuit *circuit = context;
    driver_level(&circuit->to_rxd, now, level);
}

static void txd_level(void *context, uint64_t now, bool level)
{
    struct bus_circuit *circuit = context;
    if (has_adapter(circuit) && !level && now >= circuit->frame_end) {
        adapter_frame(circuit, now);
    }
    driver_level(&circuit->to_sig, now, level);
}

static bool enable_level(const struct pin *pin, bool resistor)
{
    switch (pin_state(pin)) {
    case PIN_LOW: return false;
    case PIN_HIGH: return true;
    case PIN_PULLED_UP: // 20 to 50 kOhm inside the AVR against 10 kOhm outside: the resistor
                        // decides
    case PIN_FLOATS: break;
    }
    return resistor;
}

/* Returns what connects TXD and RXD to the wire. */
static void read_enables(const struct bus_circuit *circuit, bool port_drives, bool *tx, bool *rx)
{
    switch (circuit->wiring) {
    case BOARD_TWO_ENABLES:
        *tx = enable_level(&circuit->pin_tx_enable, false);
        *rx = enable_level(&circuit->pin_rx_enable, true);
        break;
    case BOARD_ONE_ENABLE:
        *tx = enable_level(&circuit->pin_tx_enable, false);
        *rx = !*tx;
        break;
    case BOARD_TIED:
        *tx = port_drives || usart_is_transmitting(&circuit->usart);
        *rx = true;
        break;
    default: // an adapter: no pin controls it
        *tx = circuit->tx_enable;
        *rx = circuit->rx_enable;
        break;
    }
}

/* Applies the port pins to the buffers. Releasing comes before driving, because one write can do
 * both. */
static void apply_pins(struct bus_circuit *circuit, uint64_t now)
{
    enum pin_state txd = pin_state(&circuit->pin_txd);
    bool port_drives =
        (txd == PIN_LOW || txd == PIN_HIGH) && !usart_is_transmitting(&circuit->usart);
    bool tx = false;
    bool rx = true;
    driver_set(&circuit->txd_pin, now, port_drives,
               txd != PIN_LOW); // first: an adapter reacts to it
    read_enables(circuit, port_drives, &tx, &rx);
    bool changed = tx != circuit->tx_enable || rx != circuit->rx_enable;
    bool were_both = circuit->tx_enable && circuit->rx_enable;
    if (circuit->tx_enable && !tx) {
        check_release(circuit, now);
    }
    circuit->tx_enable = tx;
    circuit->rx_enable = rx;
    if (circuit->wiring == BOARD_TWO_ENABLES && tx && rx && !were_both) {
        rules_record_breach(circuit->rules, RULE_BOTH_ENABLES, now, "the controller hears itself");
    }
    check_output(circuit, now, port_drives);
    driver_set(&circuit->to_sig, now, tx, circuit->txd.level);
    driver_set(&circuit->to_rxd, now, rx, circuit->sig.level);
    check_listening(circuit, now);
    check_floating(circuit, now);
    if (changed) {
        notify(circuit, now);
    }
}

/* simavr calls this at the start of the writing instruction. */
static void pins_changed(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    (void)value;
    struct bus_circuit *circuit = param;
    apply_pins(circuit, circuit->machine->avr->cycle + USART_WRITE_CYCLES);
}

static void usart_has_event(void *context, enum usart_event event, uint64_t now)
{
    struct bus_circuit *circuit = context;
    if (event == USART_ENABLED) {
        apply_pins(circuit, now); // TXEN takes the pin from the port or returns it
    }
    check_usart_event(circuit, event, now);
    notify(circuit, now);
}

void bus_circuit_reset(struct bus_circuit *circuit, uint64_t now)
{
    circuit->txd_driven = false;
    circuit->servo_until = 0; // the AVR no longer receives that byte; this breaks no rule
    usart_reset(&circuit->usart, now);
    apply_pins(circuit, now);
}

/* --- set-up --- */

static bool find_pin(struct bus_circuit *circuit, struct pin *pin, const struct board_pin *where)
{
    if (pin_find(pin, circuit->machine->avr, where->port, where->bit)) {
        pin_watch(pin, pins_changed, circuit);
        return true;
    }
    fprintf(stderr, "%s: no pin P%c%u: change the pin in board.h\n", circuit->machine->avr->mmcu,
            where->port, where->bit);
    return false;
}

static void init_nets(struct bus_circuit *circuit)
{
    net_init(&circuit->sig);
    net_init(&circuit->txd);
    net_init(&circuit->rxd);
    driver_init(&circuit->to_sig, &circuit->sig);
    driver_init(&circuit->to_rxd, &circuit->rxd);
    driver_init(&circuit->txd_pin, &circuit->txd);
    circuit->on_sig = (struct listener){circuit, sig_level, sig_driver, 0};
    circuit->on_txd = (struct listener){circuit, txd_level, 0, 0};
    net_listen(&circuit->sig, &circuit->on_sig);
    net_listen(&circuit->txd, &circuit->on_txd);
}

bool bus_circuit_init(struct bus_circuit *circuit, struct machine *machine,
                      const struct board_bus *bus, bool exact, struct rules *rules)
{
    *circuit = (struct bus_circuit){.machine = machine, .rules = rules, .wiring = bus->wiring};
    init_nets(circuit);
    circuit->rx_enable = has_adapter(circuit);
    event_init(&circuit->release, adapter_releases, circuit);
    bool one = bus->wiring == BOARD_ONE_ENABLE;
    if (((one || bus->wiring == BOARD_TWO_ENABLES) &&
         !find_pin(circuit, &circuit->pin_tx_enable, &bus->tx_enable)) ||
        (bus->wiring == BOARD_TWO_ENABLES &&
         !find_pin(circuit, &circuit->pin_rx_enable, &bus->rx_enable)) ||
        !find_pin(circuit, &circuit->pin_txd, &bus->txd) ||
        !find_pin(circuit, &circuit->pin_rxd, &bus->rxd)) {
        return false;
    }
    if (!usart_init(&circuit->usart, machine->avr, bus->usart, exact, machine->schedule,
                    &circuit->txd, &circuit->rxd)) {
        fprintf(stderr, "%s: no USART%u: change BOARD_BUSn_USART in board.h\n", machine->avr->mmcu,
                bus->usart);
        return false;
    }
    pin_connect_input(&circuit->rxd_input, &circuit->pin_rxd, &circuit->rxd);
    circuit->usart.context = circuit;
    circuit->usart.on_event = usart_has_event;
    bus_circuit_reset(circuit, 0);
    return true;
}
