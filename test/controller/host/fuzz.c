/* SPDX-License-Identifier: MIT */
/* Noise and damage on the host link: demux, bridge, device and console, joined as in main.c, under
 * the sanitizers of this machine.
 *
 * usage: fuzz BYTES DAMAGED [SEED]
 *
 * The host sends BYTES random bytes. Then it sends DAMAGED lines and packets with a byte changed,
 * lost or added, or with the end cut off. After each of them a good packet and a good line must be
 * answered. If one is not, the program prints what happened; exit status 1. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "controller_rig.h"

static bool has_said(const void *what, size_t size)
{
    return said_size >= size && memmem(said, said_size, what, size);
}

/* Turns until the controller has sent these bytes, for one second at most. */
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

/* ---- noise ---- */

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

/* ---- damage ---- */

static size_t packet(uint8_t *to, uint8_t id, uint8_t instruction, size_t count)
{
    uint8_t parameters[CDS_LENGTH_MAX];

    for (size_t i = 0; i < count; i++)
        parameters[i] = any_byte();
    return build(to, id, instruction, parameters, count);
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

/* Good packets that were not answered. */
static uint32_t unanswered;

/* Sends a good packet, often after the pause of a client that waits for a reply: it must be
 * answered then. Without the pause a cut packet may swallow it, and the packet after it must be
 * answered. It is a READ of a servo, since a damaged packet may be a good one that changes the
 * device's ID. */
static int good_ones(const uint8_t *damaged, size_t size)
{
    bool paused = any(2);

    static const uint8_t question[] = {0xFF, 0xFF, 4, 4, 2, 0x24, 2, 0xCF};
    static const uint8_t reply[] = {0xFF, 0xFF, 4, 4, 0, 0, 0, 0xF7};

    if (paused)
        wait_us(HOST_SILENCE_US + 1000);
    for (uint32_t i = 0; paused && i < 50000 && robot_is_stopping(&robot); i++)
        turn(); // damage with Ctrl-X stops the robot; torque off goes before packets of the host
    said_size = 0;
    say(question, sizeof question);
    if (!wait_for(reply, sizeof reply)) {
        unanswered++;
        if (paused)
            return fail("the packet after a pause", damaged, size);
        say(question, sizeof question);
        if (!wait_for(reply, sizeof reply))
            return fail("the packet", damaged, size);
    }
    for (uint32_t i = 0; i < 50000 && !console_idle(&console); i++)
        turn(); // the console answers damage that it takes for lines
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
           argv[1], host.counters.packets, host.counters.malformed, host.counters.silent,
           host.counters.gaps, lost);
    damaged = (uint32_t)strtoul(argv[2], NULL, 0);
    failed = good_ones(NULL, 0) || damaged_ones(damaged) || unanswered > damaged / 10;
    printf("damage: %s lines and packets; a good one behind them was not answered %u times\n",
           argv[2], unanswered);
    if (port_fake.breaches)
        printf("%u rules of the port broken\n", port_fake.breaches);
    puts(failed || port_fake.breaches ? "FAILED" : "ok");
    return failed || port_fake.breaches;
}
