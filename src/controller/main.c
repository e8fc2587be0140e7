/* SPDX-License-Identifier: MIT */
/* The firmware. A text console and a bridge for protocol packets share one host link and one bus of
 * servos. The failsafe watches host link and servos.
 *
 * Four deadlines decide the poll order of turn():
 *
 *   bus reply  After a reply the bus is idle until the controller sends the next packet. So each
 *              turn polls the bus first, and only the bus is polled while a bulk read waits for a
 *              servo or the permit checks a packet.
 *   goal       The goals of a cycle leave within 350 us of their time (450 us beside a flood of the
 *              host), or of the end of a transaction that is on the bus then; within 800 us if its
 *              reply changed what the permit knows, within 2 ms after a broadcast, from which 18
 *              servos learn. So while an operation or a stop runs, bus and robot are also polled
 *              before each part of a turn that may take long.
 *   host byte  The ring holds 64 bytes, which take 640 us at 1 Mbps. So the demux takes bytes of a
 *              packet until the ring is empty or PART_US are over.
 *   Ctrl-X     Torque off begins within 20 ms. So each turn polls the host link, and host_demux.h
 *              finds Ctrl-X everywhere but inside a good packet. */
#include <stddef.h>

#include "host/bridge.h"
#include "cds55xx/avr.h"
#include "compiler.h" // NOINLINE
#include "console/console.h"
#include "host/device.h"
#include "host/host_demux.h"
#include "host/host_rescue.h"
#include "avr/idle.h"
#include "robot/failsafe.h"
#include "avr/memory.h"
#include "robot/robot.h"
#include "robot/reset_copy.h"
#include "avr/serial.h"
#include "host/device_registers.h"
#include "avr/watchdog.h"

/* After the ring to the host is empty, the transmitter still sends two bytes: 20 bits, 2560 us at
 * the lowest rate of 2 000 000 / 256 bit/s. */
#define HOST_DRAIN_US 4000

/* The longest time that one loop keeps the CPU from the goals of a cycle. */
#define PART_US 100

/* The longest time that a bulk read keeps the CPU while neither robot nor host need it. */
#define ALONE_US 5000

/* Period of poll_services() while there is other work. */
#define SERVICES_US 1000

static const CDS_FLASH char host_rescued[] = "host link at the board's rate: save keeps it";

#define HOST_BAUD_OWN 255 // in the settings: the board's own rate

#define TEXT_OF_(number) #number
#define TEXT_OF(number)  TEXT_OF_(number)

const CDS_FLASH char message_own_rate[] = ", " TEXT_OF(BOARD_HOST_BAUD) "bps, the board's own";

/* Start-up does not clear this copy: drive inhibit and rate of the bus survive a reset. */
static struct reset_copy reset_copy __attribute__((section(".noinit")));

static struct {
    struct cds_bus bus;
    struct serial serial;
    struct cds_ring text; // text of the host, for the console
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
    uint8_t packets[2][STATUS_PACKET_HEAD + HOST_PACKET_MAX]; // demux and bridge swap these two
    uint16_t services_ticks;                                  // time of the last poll_services()
    uint16_t host_ticks;   // the last time at which the rate of the host link could not change
    uint8_t host_baud;     // present rate of the host link, as in the settings
    uint8_t services_head; // serial.rx.head at the last poll_services()
} controller;

CDS_AVR_BUS(controller.bus, 0)
CDS_AVR_CLOCK()
AVR_SERIAL(controller.serial)

/* True if `us` microseconds, 0 to 16000, have passed since `from_ticks`. */
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

/* Bytes that an interrupt handler changes when there is new work. The clock overflows every 33 ms:
 * then the main loop checks work that is due at a certain time. */
struct event_marks {
    uint8_t host_head, host_tail, host_broken, bus_head, bus_broken, overflows;
};

static inline struct event_marks event_marks_now(void)
{
    return (struct event_marks){
        .host_head = controller.serial.rx.head,
        .host_tail = controller.serial.tx.tail,
        .host_broken = controller.serial.broken,
        .bus_head = controller.bus.link.rx.head,
        .bus_broken = controller.bus.link.broken,
        .overflows = cds_avr_clock.overflows[0],
    };
}

static inline bool are_same(struct event_marks a, struct event_marks b)
{
    return !((a.host_head ^ b.host_head) | (a.host_tail ^ b.host_tail) |
             (a.host_broken ^ b.host_broken) | (a.bus_head ^ b.bus_head) |
             (a.bus_broken ^ b.bus_broken) | (a.overflows ^ b.overflows));
}

/* Sleeps unless there is work. busy() takes longer than a handler may wait, so it runs with
 * interrupts on. An interrupt during or after busy() changes a mark; only the comparison of the
 * marks runs with interrupts off. The state of the bus link needs no mark: while the bus has a
 * request, busy() is true. */
static void idle(void)
{
    struct event_marks before = event_marks_now();

    if (busy())
        return;
    cli();
    if (are_same(before, event_marks_now()))
        avr_sleep();
    sei();
}

/* ---- rate of the host link ---- */

static uint16_t divisor_of(uint8_t baud)
{
    return baud == HOST_BAUD_OWN ? SERIAL_DIVISOR(BOARD_HOST_BAUD)
                                 : baud; // register value and UBRR are equal at 16 MHz with U2X
}

/* Changes the rate of the port, which drops the bytes in its rings. Does not touch the port if the
 * rate stays the same: 255 and another value may mean the same rate. */
static void change_host_baud(uint8_t baud)
{
    if (divisor_of(baud) != divisor_of(controller.host_baud))
        serial_open(&controller.serial, divisor_of(baud));
    controller.host_baud = baud;
    controller.rescue.state = HOST_RESCUE_SHUT;
}

/* Applies the setting of the host rate, once the reply to the command or packet that changed it has
 * left. */
static void apply_host_baud(void)
{
    bool is_quiet = !bridge_talks(&controller.bridge) && console_idle(&controller.console) &&
                    !cds_ring_count(&controller.serial.tx);

    if (controller.host_baud == controller.settings.host_baud || !is_quiet ||
        controller.rescue.state == HOST_RESCUE_OPEN)
        controller.host_ticks = cds_port_ticks();
    else if (is_over(controller.host_ticks, HOST_DRAIN_US))
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
    failsafe_apply_settings(failsafe);
}

/* After a reset other than power-on the bus keeps its rate: servos that move have it. */
static void restore_rate(void)
{
    if (!(avr_reset_cause & FAILSAFE_RESET_POWER) && reset_copy_has_rate(&reset_copy))
        controller.settings.bus_baud = reset_copy.baud_reg.value;
}

/* Finds what the EEPROM stores. */
static void load(void)
{
    settings_load(&controller.store, &controller.settings);
    restore_rate();
    if (command_set.store)
        command_set.store->load(command_set.store->motions, &controller.store);
}

static void open(void)
{
    load();
    cds_avr_clock_open();
    controller.host_baud = controller.settings.host_baud;
    if (divisor_of(controller.host_baud) != divisor_of(HOST_BAUD_OWN) &&
        host_rescue_begin(&controller.rescue, avr_reset_cause))
        controller.host_baud = HOST_BAUD_OWN; // until apply_host_baud() ends the rescue
    serial_open(&controller.serial, divisor_of(controller.host_baud));
    sei();
    cds_bus_open(&controller.bus, 0, controller.settings.bus_baud);
    controller.robot.moves = command_set.moves;
    robot_begin(&controller.robot, &controller.bus, CDS_AVR_SHORTEST_DELAY(0));
    robot_resume(&controller.robot, &reset_copy, avr_reset_cause & FAILSAFE_RESET_POWER);
    begin_failsafe();
    host_demux_open(&controller.host, &controller.serial.rx, &controller.text,
                    controller.packets[0] + STATUS_PACKET_HEAD);
    device_registers_open(&controller.registers, &controller.failsafe, &controller.host,
                          &controller.bridge, &controller.serial.gaps);
    controller.device.ops = command_set.device;
    controller.device.context = &controller.registers;
    bridge_open(&controller.bridge, &controller.bus, &controller.host, &controller.device,
                &controller.serial.tx, controller.packets[1] + STATUS_PACKET_HEAD);
    console_open(&controller.console, &controller.failsafe, &controller.text,
                 &controller.serial.tx);
    if (command_set.store && command_set.store->begin)
        command_set.store->begin(&controller.failsafe, command_set.store->motions);
}

/* ---- bus and robot ---- */

/* Starts to send the bytes in the ring to the host, unless the last byte of a packet is leaving on
 * the bus. A servo may answer 2 us after the end of that packet, and on an idle host link the first
 * two bytes take two handlers in a row, 140 cycles. Before the last byte there is time: the end of
 * the packet is then at least two byte times away, 320 cycles at 1 Mbps.
 *
 * Returns serial.tx.head if all bytes in the ring are being sent, else another value. */
static uint8_t send_to_host(void)
{
    uint8_t head = controller.serial.tx.head;

    if (controller.bus.link.state == CDS_LINK_DRAINING)
        return (uint8_t)(head - 1u);
    serial_send(&controller.serial);
    return head;
}

/* While an operation has the bus to itself, perhaps at another rate, a packet of the host waits. It
 * ends the operation as soon as possible (robot_abort()). */
static void poll_bridge(void)
{
    bool is_exclusive = robot_is_exclusive(&controller.robot);

    if (!is_exclusive || bridge_goes_on(&controller.bridge))
        bridge_poll(&controller.bridge);
    if (is_exclusive && controller.host.has_packet)
        robot_abort(&controller.robot);
}

/* Polls the bus until all received bytes of a reply are taken: one poll takes a part of them. */
static bool take_reply(void)
{
    struct cds_bus *bus = &controller.bus;
    bool is_in_use;

    do {
        is_in_use = cds_bus_poll(bus);
    } while (bus->state == CDS_BUS_RECEIVING && cds_parser_has_unread(&bus->parser, &bus->link.rx));
    return is_in_use;
}

/* Polls bus and bridge. During a bulk read it goes on from servo to servo, and while the permit
 * checks a packet from goal to goal, until that ends, the host sends a byte, or the time is over.
 */
static void poll_bus(void)
{
    const struct bridge *bridge = &controller.bridge;
    const struct cds_bus *bus = &controller.bus;
    bool is_alone = robot_idle(&controller.robot) && !cds_ring_count(&controller.serial.rx);
    uint16_t from_ticks = cds_port_ticks(), us = is_alone ? ALONE_US : PART_US;
    uint8_t sent = send_to_host(), heard = controller.serial.rx.head;

    do {
        while (take_reply() &&
               (bridge_awaits_servo(bridge) || bus->state == CDS_BUS_WAITING_FOR_LINE) &&
               sent == controller.serial.tx.head && heard == controller.serial.rx.head &&
               !is_over(from_ticks, us)) {
        }
        sent = send_to_host();
        poll_bridge();
        if (sent != controller.serial.tx.head)
            sent = send_to_host();
    } while (bridge_is_reading(bridge) && heard == controller.serial.rx.head &&
             !is_over(from_ticks, us));
}

/* Packets of the host on the bridge delay the state check. */
static void poll_bus_and_robot(void)
{
    poll_bus();
    if (!bridge_idle(&controller.bridge)) {
        controller.failsafe.host_types = false;
        robot_delay_health(&controller.robot);
    }
    robot_poll(&controller.robot);
}

/* ---- host and console ---- */

/* Takes bytes of the host until no packet is coming in, or PART_US are over. */
static void poll_demux(void)
{
    uint16_t from_ticks = cds_port_ticks();

    while (host_demux_poll(&controller.host) && !is_over(from_ticks, PART_US)) {
    }
}

static void note_lost_bytes(void)
{
    if (!serial_resume_after_gap(&controller.serial))
        return;
    if (controller.rescue.state)
        host_rescue_damage(&controller.rescue);
    else
        host_demux_gap(&controller.host);
}

/* Polls the host link. Ctrl-X stops the robot before the console is polled, and a whole packet goes
 * to the bridge at once. */
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
    if (controller.host.has_packet)
        poll_bridge();
}

/* After HOST_RESCUE_ENTERS Enters the board's own rate becomes the setting, and the console prints
 * it. */
static void set_own_baud(void)
{
    if (controller.rescue.enters != HOST_RESCUE_ENTERS ||
        !console_say(&controller.console, host_rescued))
        return;
    controller.rescue.enters = 0;
    controller.settings.host_baud = HOST_BAUD_OWN;
}

static void poll_console(void)
{
    if (!bridge_talks(&controller.bridge)) { // no text within a status packet
        set_own_baud();
        console_poll(&controller.console);
    }
    apply_host_baud();
    send_to_host();
}

/* Polls failsafe, settings and memory. Any byte of the host shows that the host is alive. */
static void poll_services(void)
{
    struct failsafe *failsafe = &controller.failsafe;

    controller.services_ticks = cds_port_ticks();
    if (controller.services_head != controller.serial.rx.head) {
        controller.services_head = controller.serial.rx.head;
        failsafe_heard(failsafe);
    }
    failsafe_poll(failsafe);
    kept_store(&reset_copy.baud_reg, controller.settings.bus_baud);
    if (command_set.has_room && robot_idle(&controller.robot) && console_idle(&controller.console))
        failsafe_confirm_stop(failsafe);
    settings_save_poll(&controller.store);
    if (failsafe->counts_stack && memory_poll(&controller.memory)) {
        failsafe->spare_bytes = controller.memory.spare_bytes;
        failsafe->counts_stack = false;
    }
}

/* ---- main loop ---- */

/* While an operation or a stop runs, polls bus and robot before a part of the turn that may take
 * long. */
static void robot_first(void)
{
    if (!robot_idle(&controller.robot))
        poll_bus_and_robot();
}

/* One turn of the main loop; the top of this file explains its order. NOINLINE: a debugger finds it
 * by its name. */
NOINLINE static void turn(void)
{
    watchdog_pet();
    poll_bus_and_robot();
    poll_host();
    robot_first();
    poll_console();
    if (is_over(controller.services_ticks, SERVICES_US) || !busy()) {
        robot_first();
        poll_services();
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
