/* The firmware: on one host link a text console, and a bridge for protocol packets, over one bus of
 * servos; and a failsafe for when nobody looks. */
#include <stddef.h>

#include "host/bridge.h"
#include "cds55xx_avr.h"
#include "console/console.h"
#include "host/device.h"
#include "host/host_demux.h"
#include "host/host_rescue.h"
#include "robot/inhibit.h"
#include "avr/idle.h"
#include "robot/failsafe.h"
#include "avr/memory.h"
#include "robot/robot.h"
#include "avr/serial.h"
#include "host/device_registers.h"
#include "avr/watchdog.h"

/* Until the last byte has left at the lowest rate, 2 000 000 / 256 bit/s, once the ring is empty:
 * two are with the transmitter. */
#define HOST_DRAIN_US 4000

/* While servo after servo is read, the bus is polled so often before the rest of a turn is due, if
 * the host says nothing: at 1 Mbps 18 servos of 8 bytes take fewer, and 5 ms. Less if the robot has
 * something to do, too, or something of the host's is still to be looked at, which may be Ctrl-X.
 */
#define POLLS        1500
#define POLLS_OTHERS 150

/* So many polls in a row take a reply of up to 50 bytes. */
#define REPLY_POLLS 8

/* So often is the host listened to in a turn while a packet comes in. */
#define HOST_POLLS 8

/* Of so many turns one looks after host link, alarms and memory, while there is other work; and two
 * after the console, while a packet comes in. */
#define KEPT_TURNS 8

static const CDS_FLASH char host_rescued[] =
    "host link at own rate of the board: save keeps it";

#define HOST_BAUD_OWN 255 // in the settings: the board's

/* Not cleared by start-up: a reset does not forget that driving is inhibited. */
static struct inhibit_copy kept __attribute__((section(".noinit")));

static struct {
    struct cds_bus bus;
    struct serial serial;
    struct cds_ring text; // for the console
    struct host host;
    struct host_rescue rescue;
    struct bridge bridge;
    struct device device;
    struct values values;
    struct settings settings;
    struct settings_store store;
    struct failsafe failsafe;
    struct memory memory;
    struct robot robot;
    struct console console;
    uint8_t packets[2][ANSWER_BEFORE + HOST_PACKET_MAX]; // from the host, on the bridge
    uint32_t drained_us; // when the ring to the host was found empty, before a change of its rate
    uint8_t host_baud;   // as in the settings, in force
    uint8_t heard;       // of the host: as serial.rx.head was
    uint8_t turns;
} controller;

CDS_AVR_BUS(controller.bus, 0)
CDS_AVR_CLOCK()
AVR_SERIAL(controller.serial)

static bool busy(void)
{
    return !console_idle(&controller.console) || !host_idle(&controller.host) ||
           !bridge_idle(&controller.bridge) || controller.bus.request || controller.serial.broken ||
           controller.host_baud != controller.settings.host_baud ||
           !robot_idle(&controller.robot) || controller.failsafe.unsettled ||
           controller.store.result == SETTINGS_SAVING;
}

/* The bytes that interrupt handlers change and that mean work, and the clock's overflows: what is
 * due at a time is looked at with each of them. */
struct marks {
    uint8_t host_head, host_tail, host_broken, bus_head, bus_broken, overflows;
};

static inline struct marks marks_now(void)
{
    return (struct marks){
        .host_head = controller.serial.rx.head,
        .host_tail = controller.serial.tx.tail,
        .host_broken = controller.serial.broken,
        .bus_head = controller.bus.link.rx.head,
        .bus_broken = controller.bus.link.broken,
        .overflows = cds_avr_clock.overflows[0],
    };
}

static inline bool are_same(struct marks a, struct marks b)
{
    return !((a.host_head ^ b.host_head) | (a.host_tail ^ b.host_tail) |
             (a.host_broken ^ b.host_broken) | (a.bus_head ^ b.bus_head) |
             (a.bus_broken ^ b.bus_broken) | (a.overflows ^ b.overflows));
}

/* Sleeps unless there is work. busy() takes longer than a handler may wait, so it is asked with
 * interrupts on. An interrupt behind the question has changed a mark: only these are compared with
 * interrupts off. While the bus has a request, busy() is true: the state of its link is no mark. */
static void idle(void)
{
    struct marks before = marks_now();

    if (busy())
        return;
    cli();
    if (are_same(before, marks_now()))
        avr_sleep();
    sei();
}

static uint16_t divisor_of(uint8_t baud)
{
    return baud == HOST_BAUD_OWN ? SERIAL_DIVISOR(BOARD_HOST_BAUD)
                                 : baud; // with U2X at 16 MHz UBRR is n, as on the bus
}

/* What came at another rate is worth nothing; at the same one, by another name, it is. */
static void change_host_baud(uint8_t baud)
{
    if (divisor_of(baud) != divisor_of(controller.host_baud))
        serial_open(&controller.serial, divisor_of(baud));
    controller.host_baud = baud;
    controller.rescue.state = HOST_RESCUE_SHUT;
}

/* The rate of the host link changes behind the answer that said so. */
static void follow_host_baud(void)
{
    bool quiet = !bridge_talks(&controller.bridge) && console_idle(&controller.console) &&
                 !cds_ring_count(&controller.serial.tx);

    if (controller.host_baud == controller.settings.host_baud || !quiet ||
        controller.rescue.state == HOST_RESCUE_OPEN)
        controller.drained_us = 0;
    else if (controller.drained_us == 0)
        controller.drained_us = cds_port_now_us() | 1;
    else if (cds_port_now_us() - controller.drained_us > HOST_DRAIN_US)
        change_host_baud(controller.settings.host_baud);
}

/* Bytes that came, whatever they are, are a host that is alive. */
static void keep(void)
{
    struct failsafe *failsafe = &controller.failsafe;

    if (controller.heard != controller.serial.rx.head) {
        controller.heard = controller.serial.rx.head;
        failsafe_heard(failsafe);
    }
    failsafe_poll(failsafe);
    settings_save_poll(&controller.store);
    if (failsafe->counts_stack && memory_poll(&controller.memory)) {
        failsafe->spare_bytes = controller.memory.spare_bytes;
        failsafe->counts_stack = false;
    }
}

static void begin_failsafe(void)
{
    struct failsafe *failsafe = &controller.failsafe;

    failsafe->settings = &controller.settings;
    failsafe->store = &controller.store;
    failsafe->robot = &controller.robot;
    failsafe->damaged_stops = &controller.host.counters.stops;
    failsafe->room_bytes = memory_room_bytes();
    failsafe_begin(failsafe, avr_reset_cause);
    failsafe_follow(failsafe);
}

static void open(void)
{
    settings_load(&controller.store, &controller.settings);
    cds_avr_clock_open();
    controller.host_baud = controller.settings.host_baud;
    if (divisor_of(controller.host_baud) != divisor_of(HOST_BAUD_OWN) &&
        host_rescue_begin(&controller.rescue, avr_reset_cause))
        controller.host_baud = HOST_BAUD_OWN; // follow_host_baud() ends it
    serial_open(&controller.serial, divisor_of(controller.host_baud));
    sei();
    cds_bus_open(&controller.bus, 0, controller.settings.bus_baud);
    robot_begin(&controller.robot, &controller.bus, AVR_SHORTEST_DELAY(0));
    robot_resume(&controller.robot, &kept, avr_reset_cause & FAILSAFE_RESET_POWER);
    begin_failsafe();
    host_open(&controller.host, &controller.serial.rx, &controller.text,
              controller.packets[0] + ANSWER_BEFORE);
    values_open(&controller.values, &controller.failsafe, &controller.host, &controller.bridge,
                &controller.serial.gaps);
    controller.device.world = &values_world;
    controller.device.owner = &controller.values;
    bridge_open(&controller.bridge, &controller.bus, &controller.host, &controller.device,
                &controller.serial.tx, controller.packets[1] + ANSWER_BEFORE);
    console_open(&controller.console, &controller.failsafe, &controller.text,
                 &controller.serial.tx);
}

/* With nothing to send so far, the first two bytes cost two handlers, one right behind the other:
 * these must not come at the end of a packet of the bus, for the servo may answer 2 us later. They
 * take 140 cycles; while the last byte is still to be given, that end is two byte times away, 320
 * cycles at 1 Mbps. Returns serial.tx.head if all before it is under way, else one that it cannot
 * come to be before all is. */
static uint8_t send_to_host(void)
{
    uint8_t head = controller.serial.tx.head;

    if (controller.bus.link.state == CDS_LINK_DRAINING)
        return (uint8_t)(head - 1u);
    serial_send(&controller.serial);
    return head;
}

/* Packets wait while the bus may be at another rate. A scan or a diagnosis gives way to them. */
static void poll_bridge(void)
{
    bool exclusive = robot_is_exclusive(&controller.robot);

    if (!exclusive || controller.bridge.state == BRIDGE_WAITING) // its packet is on the bus already
        bridge_poll(&controller.bridge);
    if (exclusive && controller.host.whole)
        robot_abort(&controller.robot);
}

/* Behind three Enters the board's own rate is the setting, and the console says so. */
static void keep_own_baud(void)
{
    struct printer *printer = &controller.console.printer;

    if (controller.rescue.enters != HOST_RESCUE_ENTERS || !printer_ready(printer))
        return;
    controller.rescue.enters = 0;
    controller.settings.host_baud = HOST_BAUD_OWN;
    printer_line(printer, host_rescued);
}

/* What the host says. True: it is in the midst of a packet. */
static bool poll_host(void)
{
    uint8_t left = HOST_POLLS;
    bool comes;

    if (controller.rescue.state)
        controller.host.stop = host_rescue_poll(&controller.rescue, &controller.serial.rx);
    do {
        comes = !controller.rescue.state && host_poll(&controller.host);
    } while (comes && --left);
    if (controller.host.stop) {
        controller.host.stop = false;
        console_stop(&controller.console);
    }
    if (serial_broken(&controller.serial)) {
        if (controller.rescue.state)
            host_rescue_damage(&controller.rescue);
        else
            host_gap(&controller.host);
    }
    if (controller.host.whole)
        poll_bridge();
    return comes;
}

static void poll_console(void)
{
    if (!bridge_talks(&controller.bridge)) { // a status packet must not be torn by text
        keep_own_baud();
        console_poll(&controller.console);
    }
    follow_host_baud();
    send_to_host();
}

/* Polls until what has come of a reply is taken: a poll takes a part of it. */
static bool take_reply(void)
{
    struct cds_bus *bus = &controller.bus;
    uint8_t left = REPLY_POLLS;
    bool is_in_use;

    do {
        is_in_use = cds_bus_poll(bus);
    } while (bus->state == CDS_BUS_RECEIVING &&
             cds_parser_has_unread(&bus->parser, &bus->link.rx) && --left);
    return is_in_use;
}

/* What the bridge has to say leaves at once. While a servo is asked, nothing comes between two
 * polls. */
static void poll_bus(void)
{
    const struct bridge *bridge = &controller.bridge;
    uint16_t left = robot_idle(&controller.robot) && !cds_ring_count(&controller.serial.rx)
                        ? POLLS
                        : POLLS_OTHERS;
    uint8_t sent = send_to_host(), heard = controller.serial.rx.head;

    do {
        while (take_reply() && bridge_waits(bridge) && sent == controller.serial.tx.head &&
               --left) {
        }
        sent = send_to_host();
        poll_bridge();
        if (sent != controller.serial.tx.head)
            sent = send_to_host();
    } while (bridge_hurries(bridge) && heard == controller.serial.rx.head && left && --left);
}

/* The main loop's body: the bus and who uses it in each turn, for goals are due at their time. So a
 * host that says more than can be taken has every second turn, and the console the others; else the
 * console has each while it reads, which is at the host's pace. Not inlined: a debugger finds it.
 */
__attribute__((noinline)) static void turn(void)
{
    bool odd = controller.turns & 1, flooded = controller.host.skipping, comes = false;

    watchdog_pet();
    controller.turns++;
    poll_bus();
    if (!bridge_idle(&controller.bridge))
        robot_yield(&controller.robot);
    robot_poll(&controller.robot);
    if (odd || !flooded)
        comes = poll_host();
    if (flooded)
        robot_poll(&controller.robot); // again: goals are due, and a line may take long
    if (comes && controller.turns % KEPT_TURNS >= 2) // of these one is odd
        return;
    if (!odd || (!flooded && controller.console.state == CONSOLE_READING))
        poll_console();
    if (controller.turns % KEPT_TURNS == 0 || !busy()) // in none of the console's
        keep();
    idle();
}

int main(void)
{
    watchdog_on();
    open();
    for (;;)
        turn();
}
