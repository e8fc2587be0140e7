/* The host link of the firmware against noise and damage, on this machine under the sanitizers: the
 * demultiplexer, bridge, device and console as main.c joins them, over servos that answer anything.
 *
 * usage: fuzz BYTES DAMAGED [SEED]
 *
 * First so many random bytes. Then so many lines and packets with a byte changed, lost, added or
 * cut off; behind each a good packet and a good line, which must be answered as if nothing had
 * been. Exit status 1, with what happened, when one is not. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bridge.h"
#include "console.h"
#include "port_fake.h"
#include "values.h"

#define ROOM 2048

static struct cds_bus bus;
static struct cds_ring input, text, output;
static struct host host;
static struct bridge bridge;
static struct device device;
static struct values values;
static struct robot robot;
static struct settings settings;
static struct settings_store store;
static struct keeper keeper;
static struct console console;
static uint8_t packets[2][ANSWER_BEFORE + HOST_PACKET_MAX];
static uint16_t lost;

static uint32_t seed = 1;
static uint8_t said[ROOM]; // to the host, the latest
static size_t said_size;
static size_t most_said;

static uint32_t any(uint32_t count)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)(seed >> 8) * count >> 24);
}

static void open_all(void)
{
    port_fake_reset();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    host_open(&host, &input, &text, packets[0] + ANSWER_BEFORE);
    memset(&robot, 0, sizeof robot);
    robot_begin(&robot, &bus);
    settings_default(&settings);
    keeper = (struct keeper){.settings = &settings, .store = &store, .robot = &robot};
    values_open(&values, &keeper, &host, &bridge, &lost);
    device.world = &values_world;
    device.owner = &values;
    bridge_open(&bridge, &bus, &host, &device, &output, packets[1] + ANSWER_BEFORE);
    console_open(&console, &keeper, &text, &output);
}

/* Whoever is asked answers what was asked for; a third of them do not. A damaged READ that is whole
 * after all has not the reply of a good one. */
static void answer(void)
{
    static const uint8_t data[CDS_REPLY_MAX];
    const uint8_t *sent = port_fake.sent;
    bool reads = sent[3] == CDS_LENGTH_MIN + 2 && sent[4] == CDS_READ;
    uint8_t count = reads && sent[6] <= CDS_REPLY_MAX ? sent[6] : 0;

    if (sent[2] < CDS_BROADCAST_ID && sent[2] % 3)
        port_fake_answer(&bus.link, sent[2], 0, data, count);
}

static void turn(void)
{
    port_fake.now_us += 20;
    if (bus.link.state == CDS_LINK_TALKING && port_fake_transmit(&bus.link, 0))
        answer();
    cds_bus_poll(&bus);
    host_poll(&host);
    if (host.stop)
        console_stop(&console);
    host.stop = false;
    robot_poll(&robot);
    if (!robot_is_exclusive(&robot))
        bridge_poll(&bridge);
    else if (host.whole)
        robot_abort(&robot);
    if (!bridge_talks(&bridge))
        console_poll(&console);
    for (; cds_ring_count(&output); cds_ring_drop(&output, 1)) {
        if (said_size == ROOM) {
            memmove(said, said + ROOM / 2, ROOM / 2);
            said_size = ROOM / 2;
        }
        said[said_size++] = cds_ring_peek(&output, 0);
    }
    most_said = said_size > most_said ? said_size : most_said;
}

/* As the receive handler and main.c do it. */
static void hear(uint8_t byte)
{
    static bool broken;

    if (broken && cds_ring_count(&input) == 0) {
        broken = false;
        host_gap(&host);
    }
    if (broken || !cds_ring_put(&input, byte)) {
        broken = true;
        lost++;
    }
}

static void say(const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        while (cds_ring_count(&input) > 40)
            turn();
        hear(bytes[i]);
    }
}

static void wait_us(uint32_t us)
{
    uint32_t start = port_fake.now_us;

    while (port_fake.now_us - start < us)
        turn();
}

static bool has_said(const void *what, size_t size)
{
    return said_size >= size && memmem(said, said_size, what, size);
}

/* Until it is said, a second at most. */
static bool wait_for(const void *what, size_t size)
{
    for (uint32_t i = 0; i < 50000 && !has_said(what, size); i++)
        turn();
    return has_said(what, size);
}

static int fail(const char *what, const uint8_t *bytes, size_t size)
{
    printf("not answered: %s; seed %u, behind", what, seed);
    for (size_t i = 0; i < size; i++)
        printf(" %02X", bytes[i]);
    printf("\nsaid:");
    for (size_t i = 0; i < said_size; i++)
        printf(" %02X", said[i]);
    printf("\n");
    return 1;
}

/* --- noise ---------------------------------------------------------------------------------------
 */

static uint8_t any_byte(void)
{
    static const uint8_t likely[] = {0xFF, 0xFF, 1, 2, 253, 254, 0x84, 0x92, '\r', ' ', 'p', 4};

    return any(3) ? (uint8_t)any(256) : likely[any(sizeof likely)];
}

static void noise(uint32_t count)
{
    while (count) {
        for (uint32_t burst = any(any(50) ? 4 : 64) + 1; burst && count; burst--, count--)
            hear(any_byte());
        turn();
        if (any(1000) == 0)
            wait_us(any(100000));
    }
    wait_us(200000);
}

/* --- damage --------------------------------------------------------------------------------------
 */

static size_t packet(uint8_t *to, uint8_t id, uint8_t instruction, size_t parameters)
{
    uint8_t sum = (uint8_t)(id + instruction + parameters + 2);

    to[0] = to[1] = 0xFF;
    to[2] = id;
    to[3] = (uint8_t)(parameters + 2);
    to[4] = instruction;
    for (size_t i = 0; i < parameters; i++) {
        to[5 + i] = any_byte();
        sum = (uint8_t)(sum + to[5 + i]);
    }
    to[5 + parameters] = (uint8_t)~sum;
    return parameters + 6;
}

static size_t any_packet(uint8_t *to)
{
    static const uint8_t instructions[] = {1, 2, 3, 4, 5, 6, 0x83, 0x84, 0x92};
    size_t parameters = any(4) ? any(12) : any(252);

    return packet(to, any_byte(), instructions[any(sizeof instructions)], parameters);
}

static size_t any_line(uint8_t *to)
{
    static const char *const lines[] = {"ping 1",
                                        "read 1 PRESENT_POSITION",
                                        "write 1 GOAL_POSITION 512 300",
                                        "sync GOAL_POSITION 4 1:0,2,44,1 2:0,1,44,1",
                                        "help",
                                        "version",
                                        "action"};

    return (size_t)sprintf((char *)to, "%s\r", lines[any(sizeof lines / sizeof *lines)]);
}

static size_t damage(uint8_t *bytes, size_t size)
{
    size_t at = any((uint32_t)size);

    switch (any(4)) {
    case 0: bytes[at] ^= (uint8_t)(1 + any(255)); return size;
    case 1: memmove(bytes + at, bytes + at + 1, size - at - 1); return size - 1;
    case 2:
        memmove(bytes + at + 1, bytes + at, size - at);
        bytes[at] = any_byte();
        return size + 1;
    default: return at;
    }
}

/* A packet or line that was cut and then is whole with the first byte of the next one after all
 * costs that one, too: for packets that is so 1 time in 256. So the next one counts then. */
static uint32_t seconds;

/* The ID of the device may have been changed, or the rate of the bus, by what was whole after all:
 * so a servo is asked. */
static int good_ones(const uint8_t *damaged, size_t size)
{
    static const uint8_t question[] = {0xFF, 0xFF, 4, 4, 2, 0x24, 2, 0xCF};
    static const uint8_t reply[] = {0xFF, 0xFF, 4, 4, 0, 0, 0, 0xF7};

    said_size = 0;
    say(question, sizeof question);
    if (!wait_for(reply, sizeof reply)) {
        seconds++;
        say(question, sizeof question);
        if (!wait_for(reply, sizeof reply))
            return fail("the packet", damaged, size);
    }
    for (uint32_t i = 0; i < 50000 && !console_idle(&console); i++)
        turn(); // it still answers what it took for lines
    said_size = 0;
    say((const uint8_t *)"ping 4\r", 7);
    if (!wait_for("ok\r\n", 4))
        return fail("the line", damaged, size);
    return 0;
}

static int damaged_ones(uint32_t count)
{
    uint8_t bytes[HOST_PACKET_MAX + 1];

    for (uint32_t i = 0; i < count; i++) {
        size_t size = damage(bytes, any(2) ? any_packet(bytes) : any_line(bytes));

        say(bytes, size);
        settings.device_id = 253;
        if (good_ones(bytes, size))
            return 1;
    }
    return 0;
}

int main(int argc, char **argv)
{
    uint32_t damaged;
    int failed;

    if (argc < 3) {
        fprintf(stderr, "usage: fuzz BYTES DAMAGED [SEED]\n");
        return 2;
    }
    seed = argc > 3 ? (uint32_t)strtoul(argv[3], NULL, 0) : 1;
    open_all();
    noise((uint32_t)strtoul(argv[1], NULL, 0));
    printf("noise: %s bytes; of 65536 each: %u packets, %u broken, %u silent, %u gaps, %u bytes "
           "lost\n",
           argv[1], host.counters.packets, host.counters.broken, host.counters.silent,
           host.counters.gaps, lost);
    damaged = (uint32_t)strtoul(argv[2], NULL, 0);
    failed = good_ones(NULL, 0) || damaged_ones(damaged) || seconds > damaged / 100;
    printf("damage: %s lines and packets; a good one behind them was not answered %u times\n",
           argv[2], seconds);
    if (port_fake.breaches)
        printf("%u rules of the port broken\n", port_fake.breaches);
    puts(failed || port_fake.breaches ? "FAILED" : "ok");
    return failed || port_fake.breaches;
}
