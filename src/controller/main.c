/* The firmware: a text console and a bridge for protocol packets share one host link and one bus of
 * servos; the failsafe watches both.
 *
 * The poll order of turn() follows from four deadlines:
 *
 *   bus reply  The wire is idle from a reply until its next packet. So the bus comes first in a
 *              turn, and a bulk read polls it alone while a servo is asked.
 *   goal       The goals of a cycle leave within 350 us of their time, also under a flood. So while
 *              a cycle runs, bus and robot come before each part of a turn that may take long.
 *   host byte  The ring takes 64 bytes, 640 us at 1 Mbps. So a packet that comes in is taken until
 *              nothing more has come, or PART_US are over.
 *   Ctrl-X     Torque off begins within 20 ms. The host comes in each turn, and host_demux.h finds
 *              Ctrl-X wherever it stands. */
#include <stddef.h>

#include "host/bridge.h"
#include "cds55xx_avr.h"
#include "compiler.h" // NOINLINE
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

/* The host's ring is empty, but the transmitter still has two bytes: 20 bits at the lowest rate,
 * 2 000 000 / 256 bit/s, take 2560 us. */
#define HOST_DRAIN_US 4000

/* No loop holds up the goals of a cycle for longer. */
#define PART_US 100

/* How long a bulk read may keep the CPU while neither robot nor host need it. */
#define ALONE_US 5000

/* While there is other work, alarms, settings and memory are looked after so often. */
#define KEEP_US 1000

static const CDS_FLASH char host_rescued[] = "host link at own rate of the board: save keeps it";

#define HOST_BAUD_OWN 255 // in the settings: the board's own rate

/* Start-up does not clear it: the drive inhibit survives a reset. */
static struct inhibit_copy kept __attribute__((section(".noinit")));

static struct {
    struct cds_bus bus;
    struct serial serial;
    struct cds_ring text; // from the host, for the console
    struct host_demux host;
    struct host_rescue rescue;
    struct bridge bridge;
    struct device device;
    struct device_registers registers;
    struct settings settings;
    struct settings_store store;
    struct failsafe failsafe;
    struct memory memory;
    struct robot robot;
    struct console console;
    uint8_t packets[2][STATUS_PACKET_HEAD + HOST_PACKET_MAX]; // from the host, on the bridge
    uint32_t drained_us; // when the ring to the host was found empty before a change of rate; or 0
    uint16_t kept_ticks; // when keep() was called last
    uint8_t host_baud;   // rate of the host link in force, as in the settings
    uint8_t heard;       // serial.rx.head when keep() was called last
} controller;

CDS_AVR_BUS(controller.bus, 0)
CDS_AVR_CLOCK()
AVR_SERIAL(controller.serial)

/* True once `us` microseconds, at most 16000, have passed since `from_ticks`. */
static bool is_over(uint16_t from_ticks, uint16_t us)
{
    return (uint16_t)(cds_port_ticks() - from_ticks) >= us * CDS_PORT_TICKS_PER_US;
}

/* ---- sleep ---- */

static bool busy(void)
{
    return !console_idle(&controller.console) || !host_demux_idle(&controller.host) ||
           !bridge_idle(&controller.bridge) || controller.bus.request || controller.serial.broken ||
           controller.host_baud != controller.settings.host_baud ||
           !robot_idle(&controller.robot) || controller.failsafe.unsettled ||
           controller.store.result == SETTINGS_SAVING;
}

/* Bytes that an interrupt handler changes when it makes work. The clock overflows every 33 ms: work
 * that is due at a time is looked at then. */
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

/* Sleeps unless there is work. busy() takes longer than a handler may wait, so interrupts are on
 * meanwhile. An interrupt that comes after busy() changes a mark, and only the marks are compared
 * with interrupts off. The state of the bus link is no mark: while the bus has a request, busy() is
 * true. */
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

/* ---- rate of the host link ---- */

static uint16_t divisor_of(uint8_t baud)
{
    return baud == HOST_BAUD_OWN ? SERIAL_DIVISOR(BOARD_HOST_BAUD)
                                 : baud; // register value and UBRR are equal at 16 MHz with U2X
}

/* Opens the port anew, and drops what came, only if the rate really changes: 255 and another value
 * may mean the same rate. */
static void change_host_baud(uint8_t baud)
{
    if (divisor_of(baud) != divisor_of(controller.host_baud))
        serial_open(&controller.serial, divisor_of(baud));
    controller.host_baud = baud;
    controller.rescue.state = HOST_RESCUE_SHUT;
}

/* Changes the rate of the host link after the reply to the command or packet that set it has left.
 */
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

/* ---- set-up ---- */

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
        controller.host_baud = HOST_BAUD_OWN; // until follow_host_baud() ends the rescue
    serial_open(&controller.serial, divisor_of(controller.host_baud));
    sei();
    cds_bus_open(&controller.bus, 0, controller.settings.bus_baud);
    robot_begin(&controller.robot, &controller.bus, AVR_SHORTEST_DELAY(0));
    robot_resume(&controller.robot, &kept, avr_reset_cause & FAILSAFE_RESET_POWER);
    begin_failsafe();
    host_demux_open(&controller.host, &controller.serial.rx, &controller.text,
                    controller.packets[0] + STATUS_PACKET_HEAD);
    device_registers_open(&controller.registers, &controller.failsafe, &controller.host,
                          &controller.bridge, &controller.serial.gaps);
    controller.device.ops = &device_registers_ops;
    controller.device.context = &controller.registers;
    bridge_open(&controller.bridge, &controller.bus, &controller.host, &controller.device,
                &controller.serial.tx, controller.packets[1] + STATUS_PACKET_HEAD);
    console_open(&controller.console, &controller.failsafe, &controller.text,
                 &controller.serial.tx);
}

/* ---- bus and robot ---- */

/* Starts to send what stands in the ring to the host, unless the last byte of a packet is leaving
 * on the bus. If the host link was idle, its first two bytes take two handlers in a row, 140
 * cycles, and a servo may answer 2 us after the end of the packet. With a byte still to be given to
 * the transmitter that end is two byte times away, 320 cycles at 1 Mbps. Returns serial.tx.head if
 * all before it is under way, else a value that it cannot take before all is. */
static uint8_t send_to_host(void)
{
    uint8_t head = controller.serial.tx.head;

    if (controller.bus.link.state == CDS_LINK_DRAINING)
        return (uint8_t)(head - 1u);
    serial_send(&controller.serial);
    return head;
}

/* While an operation has the bus to itself, perhaps at another rate, a packet of the host waits and
 * ends the operation if it is a scan or a diagnosis. */
static void poll_bridge(void)
{
    bool exclusive = robot_is_exclusive(&controller.robot);

    if (!exclusive || controller.bridge.state == BRIDGE_WAITING) // its packet is on the bus already
        bridge_poll(&controller.bridge);
    if (exclusive && controller.host.whole)
        robot_abort(&controller.robot);
}

/* Polls until all that has come of a reply is taken; one poll takes a part of it. */
static bool take_reply(void)
{
    struct cds_bus *bus = &controller.bus;
    bool is_in_use;

    do {
        is_in_use = cds_bus_poll(bus);
    } while (bus->state == CDS_BUS_RECEIVING && cds_parser_has_unread(&bus->parser, &bus->link.rx));
    return is_in_use;
}

/* Polls bus and bridge. A bulk read stays here from servo to servo, until it ends, the host says
 * something or the time is over. */
static void poll_bus(void)
{
    const struct bridge *bridge = &controller.bridge;
    bool is_alone = robot_idle(&controller.robot) && !cds_ring_count(&controller.serial.rx);
    uint16_t from_ticks = cds_port_ticks(), us = is_alone ? ALONE_US : PART_US;
    uint8_t sent = send_to_host(), heard = controller.serial.rx.head;

    do {
        while (take_reply() && bridge_awaits_servo(bridge) && sent == controller.serial.tx.head &&
               !is_over(from_ticks, us)) {
        }
        sent = send_to_host();
        poll_bridge();
        if (sent != controller.serial.tx.head)
            sent = send_to_host();
    } while (bridge_is_reading(bridge) && heard == controller.serial.rx.head &&
             !is_over(from_ticks, us));
}

/* The state check rests while the bridge has packets of the host. */
static void poll_bus_and_robot(void)
{
    poll_bus();
    if (!bridge_idle(&controller.bridge))
        robot_yield(&controller.robot);
    robot_poll(&controller.robot);
}

/* ---- host and console ---- */

/* Takes bytes of the host until no packet is coming in or PART_US are over. */
static void poll_demux(void)
{
    uint16_t from_ticks = cds_port_ticks();

    while (host_demux_poll(&controller.host) && !is_over(from_ticks, PART_US)) {
    }
}

static void note_lost_bytes(void)
{
    if (!serial_broken(&controller.serial))
        return;
    if (controller.rescue.state)
        host_rescue_damage(&controller.rescue);
    else
        host_demux_gap(&controller.host);
}

/* Ctrl-X acts before the console polls, and a whole packet goes to the bridge at once. */
static void poll_host(void)
{
    if (controller.rescue.state)
        controller.host.stop = host_rescue_poll(&controller.rescue, &controller.serial.rx);
    if (!controller.rescue.state)
        poll_demux();
    if (controller.host.stop) {
        controller.host.stop = false;
        console_stop(&controller.console);
    }
    note_lost_bytes();
    if (controller.host.whole)
        poll_bridge();
}

/* After three Enters the board's own rate becomes the setting, and the console says so. */
static void keep_own_baud(void)
{
    struct printer *printer = &controller.console.printer;

    if (controller.rescue.enters != HOST_RESCUE_ENTERS || !printer_ready(printer))
        return;
    controller.rescue.enters = 0;
    controller.settings.host_baud = HOST_BAUD_OWN;
    printer_line(printer, host_rescued);
}

static void poll_console(void)
{
    if (!bridge_talks(&controller.bridge)) { // text must not tear a status packet
        keep_own_baud();
        console_poll(&controller.console);
    }
    follow_host_baud();
    send_to_host();
}

/* Looks after failsafe, settings and memory. Any byte of the host shows that the host is alive. */
static void keep(void)
{
    struct failsafe *failsafe = &controller.failsafe;

    controller.kept_ticks = cds_port_ticks();
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

/* ---- main loop ---- */

/* While a cycle or an operation runs, its packets leave before a part of the turn that may take
 * long.
 */
static void robot_first(void)
{
    if (!robot_idle(&controller.robot))
        poll_bus_and_robot();
}

/* One turn of the main loop; the top of this file has the reasons for its order. NOINLINE: a
 * debugger finds it by its name. */
NOINLINE static void turn(void)
{
    watchdog_pet();
    poll_bus_and_robot();
    poll_host();
    robot_first();
    poll_console();
    if (is_over(controller.kept_ticks, KEEP_US) || !busy()) {
        robot_first();
        keep();
    }
    idle();
}

int main(void)
{
    watchdog_on();
    open();
    for (;;)
        turn();
}
