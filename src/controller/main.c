/* The firmware: on one host link a text console, and a bridge for protocol packets, over one bus of
 * servos; and a keeper for when nobody looks. */
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
#include "texts.h" // TEXT_HOST_RESCUED
#include "host/device_registers.h"
#include "avr/watchdog.h"

/* Until the last byte has left at the lowest rate, 2 000 000 / 256 bit/s, once the ring is empty:
 * two are with the transmitter. */
#define HOST_DRAIN_US 4000

/* No loop holds up the rest of a turn for longer. */
#define PART_US 100

/* A bulk read is alone on the bus, and nothing else is due. */
#define BULK_READ_US 5000

/* Alarms, settings and memory are looked at so often while there is other work. */
#define KEEP_US 1000

#define HOST_BAUD_OWN 255 // in the settings: the board's

/* Not cleared by start-up: a reset does not forget that driving is inhibited. */
static struct inhibit_copy kept __attribute__((section(".noinit")));

static struct {
    struct cds_bus bus;
    struct serial serial;
    struct cds_ring text; // for the console
    struct host_demux host;
    struct host_rescue rescue;
    struct bridge bridge;
    struct device device;
    struct device_registers registers;
    struct settings settings;
    struct settings_store store;
    struct keeper keeper;
    struct memory memory;
    struct robot robot;
    struct console console;
    uint8_t packets[2][STATUS_PACKET_HEAD + HOST_PACKET_MAX]; // from the host, on the bridge
    uint32_t drained_us; // when the ring to the host was found empty, before a change of its rate
    uint8_t host_baud;   // as in the settings, in force
    uint8_t heard;       // of the host: as serial.rx.head was
    uint16_t kept_ticks; // when keep() was called last
} controller;

CDS_AVR_BUS(controller.bus, 0)
CDS_AVR_CLOCK()
AVR_SERIAL(controller.serial)

/* True once `us` microseconds have passed since `from_ticks`; for up to 16 ms. */
static bool is_over(uint16_t from_ticks, uint16_t us)
{
    return (uint16_t)(cds_port_ticks() - from_ticks) >= us * CDS_PORT_TICKS_PER_US;
}

static bool busy(void)
{
    return !console_idle(&controller.console) || !host_demux_idle(&controller.host) ||
           !bridge_idle(&controller.bridge) || controller.bus.request || controller.serial.broken ||
           controller.host_baud != controller.settings.host_baud ||
           !robot_idle(&controller.robot) || controller.keeper.unsettled ||
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
    struct keeper *keeper = &controller.keeper;

    controller.kept_ticks = cds_port_ticks();
    if (controller.heard != controller.serial.rx.head) {
        controller.heard = controller.serial.rx.head;
        keeper_heard(keeper);
    }
    keeper_poll(keeper);
    settings_save_poll(&controller.store);
    if (keeper->counts_stack && memory_poll(&controller.memory)) {
        keeper->spare_bytes = controller.memory.spare_bytes;
        keeper->counts_stack = false;
    }
}

static void begin_keeper(void)
{
    struct keeper *keeper = &controller.keeper;

    keeper->settings = &controller.settings;
    keeper->store = &controller.store;
    keeper->robot = &controller.robot;
    keeper->damaged_stops = &controller.host.counters.stops;
    keeper->room_bytes = memory_room_bytes();
    keeper_begin(keeper, avr_reset_cause);
    keeper_follow(keeper);
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
    robot_resume(&controller.robot, &kept, avr_reset_cause & KEEPER_RESET_POWER);
    begin_keeper();
    host_demux_open(&controller.host, &controller.serial.rx, &controller.text,
                    controller.packets[0] + STATUS_PACKET_HEAD);
    device_registers_open(&controller.registers, &controller.keeper, &controller.host,
                          &controller.bridge, &controller.serial.gaps);
    controller.device.ops = &device_registers_ops;
    controller.device.context = &controller.registers;
    bridge_open(&controller.bridge, &controller.bus, &controller.host, &controller.device,
                &controller.serial.tx, controller.packets[1] + STATUS_PACKET_HEAD);
    console_open(&controller.console, &controller.keeper, &controller.text, &controller.serial.tx);
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
    struct writer *writer = &controller.console.writer;

    if (controller.rescue.enters != HOST_RESCUE_ENTERS || !writer_ready(writer))
        return;
    controller.rescue.enters = 0;
    controller.settings.host_baud = HOST_BAUD_OWN;
    writer_line(writer, TEXT_HOST_RESCUED);
}

/* What the host says. */
static void poll_host(void)
{
    uint16_t from_ticks = cds_port_ticks();
    bool comes;

    if (controller.rescue.state)
        controller.host.stop = host_rescue_poll(&controller.rescue, &controller.serial.rx);
    do {
        comes = !controller.rescue.state && host_demux_poll(&controller.host);
    } while (comes && !is_over(from_ticks, PART_US));
    if (controller.host.stop) {
        controller.host.stop = false;
        console_stop(&controller.console);
    }
    if (serial_broken(&controller.serial)) {
        if (controller.rescue.state)
            host_rescue_damage(&controller.rescue);
        else
            host_demux_gap(&controller.host);
    }
    if (controller.host.whole)
        poll_bridge();
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
    bool is_in_use;

    do {
        is_in_use = cds_bus_poll(bus);
    } while (bus->state == CDS_BUS_RECEIVING &&
             cds_parser_has_unread(&bus->parser, &bus->link.rx));
    return is_in_use;
}

/* What the bridge has to say leaves at once. While a servo is asked, nothing comes between two
 * polls. */
static void poll_bus(void)
{
    const struct bridge *bridge = &controller.bridge;
    bool is_alone = robot_idle(&controller.robot) && !cds_ring_count(&controller.serial.rx);
    uint16_t from_ticks = cds_port_ticks(), slice_us = is_alone ? BULK_READ_US : PART_US;
    uint8_t sent = send_to_host(), heard = controller.serial.rx.head;

    do {
        while (take_reply() && bridge_waits(bridge) && sent == controller.serial.tx.head &&
               !is_over(from_ticks, slice_us)) {
        }
        sent = send_to_host();
        poll_bridge();
        if (sent != controller.serial.tx.head)
            sent = send_to_host();
    } while (bridge_hurries(bridge) && heard == controller.serial.rx.head &&
             !is_over(from_ticks, slice_us));
}

static void serve_robot(void)
{
    poll_bus();
    if (!bridge_idle(&controller.bridge))
        robot_yield(&controller.robot);
    robot_poll(&controller.robot);
}

/* The main loop's body. */
__attribute__((noinline)) static void turn(void)
{
    watchdog_pet();
    serve_robot();
    poll_host();
    if (!robot_idle(&controller.robot))
        serve_robot();
    poll_console();
    if (is_over(controller.kept_ticks, KEEP_US) || !busy())
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
