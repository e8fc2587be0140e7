#include "avr/bus_circuit.h"

#include <inttypes.h>
#include <stdio.h>

/* --- rules ---------------------------------------------------------------------------------------
 */

static bool has_adapter(const struct wire *wire)
{
    return wire->wiring == BOARD_ADAPTER || wire->wiring == BOARD_ADAPTER_ECHO;
}

static unsigned sent_byte(const struct wire *wire)
{
    return wire->usart.talker.frame >> 1 & 0xFF;
}

static void check_release(struct wire *wire, uint64_t now)
{
    const struct talker *talker = &wire->usart.talker;
    if (talker->busy && talker->bit > 0 && now < talker_end(talker)) {
        rules_break(wire->rules, RULE_EARLY_RELEASE, now,
                    "byte %02X was cut %" PRIu64 " cycles before the end of its stop bit",
                    sent_byte(wire), talker_end(talker) - now);
    }
}

/* The way to the receiver opens and shuts while a servo talks. */
static void check_listening(struct wire *wire, uint64_t now)
{
    bool listening = wire->rx_enable && usart_listens(&wire->usart);
    if (wire->listening && !listening && now < wire->servo_until) {
        rules_break(wire->rules, RULE_REPLY_LOST, now,
                    "the receiver was shut %" PRIu64 " cycles before a servo's byte had ended",
                    wire->servo_until - now);
    }
    wire->listening = listening;
}

/* An adapter's RXD never floats, and its TXD counts at any time: but a chip that comes out of reset
 * has not yet had the time to drive it. */
static void check_floating(struct wire *wire, uint64_t now)
{
    bool adapter = has_adapter(wire);
    wire->txd_driven = wire->txd_driven || wire->txd.enabled;
    bool rxd = !adapter && !wire->rx_enable && pin_state(&wire->pin_rxd) == PIN_FLOATS;
    if (rxd && !wire->rxd_floats) {
        rules_break(wire->rules, RULE_FLOATING_RXD, now, "RX enable off, no pull-up on RXD");
    }
    wire->rxd_floats = rxd;
    bool heard = adapter ? wire->txd_driven : wire->wiring != BOARD_TIED && wire->tx_enable;
    bool txd = heard && wire->txd.enabled == 0 && pin_state(&wire->pin_txd) == PIN_FLOATS;
    if (txd && !wire->txd_floats) {
        rules_break(wire->rules, RULE_FLOATING_TXD, now, "%sTXEN off, TXD an open input",
                    adapter ? "" : "TX enable on, ");
    }
    wire->txd_floats = txd;
}

/* A pin of the port that is tied to the wire must be an input: at any level it is not the servos'.
 */
static void check_output(struct wire *wire, uint64_t now, bool port_drives)
{
    bool output = wire->wiring == BOARD_TIED && port_drives;
    if (output && !wire->txd_output) {
        rules_break(wire->rules, RULE_TXD_OUTPUT, now, "TXEN off, TXD an output");
    }
    wire->txd_output = output;
}

/* What keeps the controller on the wire. */
static const char *driving(const struct wire *wire)
{
    if (has_adapter(wire)) {
        return "the adapter held the wire";
    }
    return wire->wiring == BOARD_TIED ? "TXD drove the wire" : "the TX enable was on";
}

static void sig_driver(void *owner, uint64_t now, struct driver *driver)
{
    struct wire *wire = owner;
    (void)driver;
    unsigned servos = wire->sig.enabled - wire->sig.excused - wire->to_sig.enabled;
    bool two = wire->to_sig.enabled && servos > 0;
    bool collision = servos > 1;
    if (two && !wire->two_drivers) {
        bool late = driver == &wire->to_sig;
        rules_break(wire->rules, RULE_TWO_DRIVERS, now, "%s began while %s",
                    late ? "the controller" : "a servo", late ? "a servo talked" : driving(wire));
    }
    if (collision && !wire->collision) {
        rules_break(wire->rules, RULE_COLLISION, now, "a servo began while another one talked");
    }
    wire->two_drivers = two;
    wire->collision = collision;
}

void wire_servo_byte(struct wire *wire, uint64_t now, uint64_t end)
{
    wire->servo_until = end;
    if (!wire->listening) {
        rules_break(wire->rules, RULE_REPLY_LOST, now, "a servo's byte began while %s",
                    wire->rx_enable     ? "RXEN was off"
                    : has_adapter(wire) ? driving(wire)
                                        : "the RX enable was off");
    }
}

static void byte_begins(struct wire *wire, uint64_t now)
{
    if (!wire->tx_enable && !has_adapter(wire)) {
        rules_break(wire->rules, RULE_DRIVER_OFF, now, "byte %02X never reached the wire",
                    sent_byte(wire));
    } else if (wire->on_byte) {
        wire->on_byte(wire->owner, now);
    }
}

static void usart_notice(void *owner, enum usart_notice notice, uint64_t now)
{
    struct wire *wire = owner;
    switch (notice) {
    case USART_ENABLED:
        check_listening(wire, now);
        check_floating(wire, now);
        break;
    case USART_BAD_FORMAT:
        rules_break(wire->rules, RULE_FRAME_FORMAT, now, "UCSRC does not say 8N1");
        byte_begins(wire, now);
        break;
    case USART_FRAME: byte_begins(wire, now); break;
    case USART_WRITE_LOST:
        rules_break(wire->rules, RULE_LOST_WRITE, now, "the byte was ignored");
        break;
    case USART_WRITE_OFF:
        rules_break(wire->rules, RULE_TRANSMITTER_OFF, now, "the byte was ignored");
        break;
    case USART_OVERRUN:
        rules_break(wire->rules, RULE_OVERRUN, now, "DOR: two bytes unread, a third overwritten");
        break;
    case USART_BYTE_UNHEARD:
        rules_break(wire->rules, RULE_REPLY_LOST, now, "a byte came while RXEN was off");
        break;
    }
}

/* --- the circuit ---------------------------------------------------------------------------------
 */

static void tell(struct wire *wire, uint64_t now)
{
    if (wire->on_change) {
        wire->on_change(wire->owner, now);
    }
}

/* The receiver is shut before the driver is on, and opened after it is off. */
static void adapter_turn(struct wire *wire, uint64_t now, bool drives)
{
    bool hears = !drives || wire->wiring == BOARD_ADAPTER_ECHO;
    wire->tx_enable = drives;
    wire->rx_enable = hears;
    driver_enable(&wire->to_rxd, now, wire->to_rxd.enabled && hears);
    driver_set(&wire->to_sig, now, drives, wire->txd.level);
    driver_set(&wire->to_rxd, now, hears, wire->sig.level);
    check_listening(wire, now);
    tell(wire, now);
}

/* It knows a frame by the falling edge and the bit rate, and counts from there. */
static void adapter_frame(struct wire *wire, uint64_t now)
{
    uint64_t hold = (uint64_t)wire->machine->avr->frequency * WIRE_HOLD_us / 1000000;
    uint32_t bit_256 = usart_bit_256(&wire->usart);
    wire->frame_end = now + uart_half_bits(bit_256, 2 * UART_FRAME_BITS);
    schedule_at(wire->machine->schedule, &wire->release, wire->frame_end + hold);
    if (!wire->tx_enable) {
        adapter_turn(wire, now, true);
    }
}

static void adapter_releases(void *owner, uint64_t now)
{
    adapter_turn(owner, now, false);
}

static void sig_level(void *owner, uint64_t now, bool level)
{
    struct wire *wire = owner;
    driver_level(&wire->to_rxd, now, level);
}

static void txd_level(void *owner, uint64_t now, bool level)
{
    struct wire *wire = owner;
    if (has_adapter(wire) && !level && now >= wire->frame_end) {
        adapter_frame(wire, now);
    }
    driver_level(&wire->to_sig, now, level);
}

static bool enable_level(const struct pin *pin, bool resistor)
{
    switch (pin_state(pin)) {
    case PIN_LOW: return false;
    case PIN_HIGH: return true;
    case PIN_PULLED_UP: // 20 to 50 kOhm inside against 10 kOhm outside: the resistor wins
    case PIN_FLOATS: break;
    }
    return resistor;
}

/* What joins TXD and RXD to the wire. */
static void read_enables(const struct wire *wire, bool port_drives, bool *tx, bool *rx)
{
    switch (wire->wiring) {
    case BOARD_TWO_ENABLES:
        *tx = enable_level(&wire->pin_tx_enable, false);
        *rx = enable_level(&wire->pin_rx_enable, true);
        break;
    case BOARD_ONE_ENABLE:
        *tx = enable_level(&wire->pin_tx_enable, false);
        *rx = !*tx;
        break;
    case BOARD_TIED:
        *tx = port_drives || usart_transmits(&wire->usart);
        *rx = true;
        break;
    default: // an adapter: no pin has a say
        *tx = wire->tx_enable;
        *rx = wire->rx_enable;
        break;
    }
}

/* The port pins may have changed. Releasing comes before driving, as both may come of one write. */
static void follow_pins(struct wire *wire, uint64_t now)
{
    enum pin_state txd = pin_state(&wire->pin_txd);
    bool port_drives = (txd == PIN_LOW || txd == PIN_HIGH) && !usart_transmits(&wire->usart);
    bool tx = false;
    bool rx = true;
    driver_set(&wire->txd_pin, now, port_drives, txd != PIN_LOW); // first: an adapter acts on it
    read_enables(wire, port_drives, &tx, &rx);
    bool changed = tx != wire->tx_enable || rx != wire->rx_enable;
    bool were_both = wire->tx_enable && wire->rx_enable;
    if (wire->tx_enable && !tx) {
        check_release(wire, now);
    }
    wire->tx_enable = tx;
    wire->rx_enable = rx;
    if (wire->wiring == BOARD_TWO_ENABLES && tx && rx && !were_both) {
        rules_break(wire->rules, RULE_BOTH_ENABLES, now, "the controller hears itself");
    }
    check_output(wire, now, port_drives);
    driver_set(&wire->to_sig, now, tx, wire->txd.level);
    driver_set(&wire->to_rxd, now, rx, wire->sig.level);
    check_listening(wire, now);
    check_floating(wire, now);
    if (changed) {
        tell(wire, now);
    }
}

/* simavr tells at the start of the instruction that writes. */
static void pins_changed(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    (void)value;
    struct wire *wire = param;
    follow_pins(wire, wire->machine->avr->cycle + USART_WRITE_CYCLES);
}

static void notice(void *owner, enum usart_notice what, uint64_t now)
{
    struct wire *wire = owner;
    if (what == USART_ENABLED) {
        follow_pins(wire, now); // TXEN takes the pin from the port, or gives it back
    }
    usart_notice(wire, what, now);
    tell(wire, now);
}

void wire_reset(struct wire *wire, uint64_t now)
{
    wire->txd_driven = false;
    wire->servo_until = 0; // it hears no more of that, and that is no breach
    usart_reset(&wire->usart, now);
    follow_pins(wire, now);
}

/* --- set-up --------------------------------------------------------------------------------------
 */

static bool find_pin(struct wire *wire, struct pin *pin, const struct board_pin *where)
{
    if (pin_find(pin, wire->machine->avr, where->port, where->bit)) {
        pin_watch(pin, pins_changed, wire);
        return true;
    }
    fprintf(stderr, "%s: no pin P%c%u: change the pin in board.h\n", wire->machine->avr->mmcu,
            where->port, where->bit);
    return false;
}

static void init_nets(struct wire *wire)
{
    net_init(&wire->sig);
    net_init(&wire->txd);
    net_init(&wire->rxd);
    driver_init(&wire->to_sig, &wire->sig);
    driver_init(&wire->to_rxd, &wire->rxd);
    driver_init(&wire->txd_pin, &wire->txd);
    wire->on_sig = (struct listener){wire, sig_level, sig_driver, 0};
    wire->on_txd = (struct listener){wire, txd_level, 0, 0};
    net_listen(&wire->sig, &wire->on_sig);
    net_listen(&wire->txd, &wire->on_txd);
}

bool wire_init(struct wire *wire, struct machine *machine, const struct board_bus *bus, bool exact,
               struct rules *rules)
{
    *wire = (struct wire){.machine = machine, .rules = rules, .wiring = bus->wiring};
    init_nets(wire);
    wire->rx_enable = has_adapter(wire);
    event_init(&wire->release, adapter_releases, wire);
    bool one = bus->wiring == BOARD_ONE_ENABLE;
    if (((one || bus->wiring == BOARD_TWO_ENABLES) &&
         !find_pin(wire, &wire->pin_tx_enable, &bus->tx_enable)) ||
        (bus->wiring == BOARD_TWO_ENABLES &&
         !find_pin(wire, &wire->pin_rx_enable, &bus->rx_enable)) ||
        !find_pin(wire, &wire->pin_txd, &bus->txd) || !find_pin(wire, &wire->pin_rxd, &bus->rxd)) {
        return false;
    }
    if (!usart_init(&wire->usart, machine->avr, bus->usart, exact, machine->schedule, &wire->txd,
                    &wire->rxd)) {
        fprintf(stderr, "%s: no USART%u: change BOARD_BUSn_USART in board.h\n", machine->avr->mmcu,
                bus->usart);
        return false;
    }
    pin_join(&wire->rxd_input, &wire->pin_rxd, &wire->rxd);
    wire->usart.owner = wire;
    wire->usart.notice = notice;
    wire_reset(wire, 0);
    return true;
}
