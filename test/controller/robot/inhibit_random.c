/* SPDX-License-Identifier: MIT */
/* Random input to the controller while driving is inhibited, on this machine under the sanitizers.
 * A decoder of the packets on the wire decides, not what the firmware reports.
 *
 * usage: inhibit_random INPUTS [SEED]
 *
 * Rounds: lines, packets and damaged ones while driving is allowed; then a stop (typed, Ctrl-X, or
 * Ctrl-X in a damaged packet) or a lost host link amid them; then the same kinds of input while
 * driving is inhibited; then a release, after which a goal must reach the wire. The list of servos
 * is empty, partly filled, full, or a scan has found more servos than it holds. If a packet that
 * can drive a servo is sent while driving is inhibited, the program prints it; exit status 1. */
#include <stdio.h>
#include <stdlib.h>

#include "controller_rig.h"

#define PACKET_MAX 64

static bool inhibited; // by the sequence of inputs, not by what the firmware says
static uint32_t judged, driving, drove, kind, rounds, first_seed;

/* ---- decoder ---- */

static bool register_drives(unsigned reg, uint8_t value)
{
    return (reg >= 0x06 && reg <= 0x09) || (reg >= 0x1A && reg <= 0x21) || reg == 0x30 ||
           reg == 0x31 || (reg == 0x18 && value != 0);
}

static bool data_drives(unsigned reg, const uint8_t *data, size_t size)
{
    for (size_t i = 0; i < size; i++)
        if (register_drives(reg + (unsigned)i, data[i]))
            return true;
    return false;
}

static bool packet_drives(const uint8_t *bytes, size_t size)
{
    const uint8_t *parameters = bytes + 5, *end = bytes + size - 1;

    switch (bytes[4]) {
    case 1: return size != 6;
    case 2: return size > 8;
    case 3:
    case 4: return size > 7 && data_drives(parameters[0], parameters + 1, size - 7);
    case 0x83:
        if (size <= 8)
            return false;
        for (const uint8_t *block = parameters + 2; block < end; block += 1 + parameters[1]) {
            size_t left = (size_t)(end - block - 1); // the last block may be incomplete

            if (data_drives(parameters[0], block + 1, left < parameters[1] ? left : parameters[1]))
                return true;
        }
        return false;
    default: return true;
    }
}

static void judge(const uint8_t *bytes, size_t size)
{
    bool drives = packet_drives(bytes, size);

    judged++;
    driving += drives;
    if (!drives || !inhibited)
        return;
    drove++;
    printf("seed %u, round %u, kind %u: drives while inhibited:", first_seed, rounds, kind);
    for (size_t i = 0; i < size; i++)
        printf(" %02X", bytes[i]);
    printf("\n");
}

/* ---- input ---- */

static uint8_t any_id(void)
{
    static const uint8_t likely[] = {1, 2, 3, 4, 5, 19, 77, 99, 252, 254, 254, 254};

    return any(3) ? likely[any(sizeof likely)] : (uint8_t)any(253);
}

static uint8_t any_register(void)
{
    static const uint8_t likely[] = {0x05, 0x06, 0x08, 0x17, 0x18, 0x18, 0x19, 0x1A,
                                     0x1D, 0x1E, 0x1E, 0x20, 0x21, 0x2C, 0x30};

    return any(4) ? likely[any(sizeof likely)] : (uint8_t)any(256);
}

/* Returns any ID except that of the device, whose registers LINK_LOST and INHIBIT can release. */
static size_t any_packet(uint8_t *to)
{
    static const uint8_t instructions[] = {1, 2, 3, 3, 3, 4, 4, 5, 5, 6, 0x83, 0x83, 0x84, 0x92};
    uint8_t parameters[40], id = any_id();
    uint8_t instruction = instructions[any(sizeof instructions)];
    size_t count = any(14), each = 1 + any(5);

    for (size_t i = 0; i < sizeof parameters; i++)
        parameters[i] = (uint8_t)any(any(2) ? 3 : 256);
    parameters[0] = any_register();
    if (any(20) == 0)
        instruction = (uint8_t)any(256);
    if (instruction == 0x83) {
        id = any(10) ? 254 : id;
        parameters[1] = (uint8_t)each;
        count = 2 + (1 + each) * any(6) + (any(4) ? 0 : any(5));
        for (size_t i = 0; i < 6; i++)
            parameters[2 + i * (1 + each)] = any_id();
    }
    return build(to, id, instruction, parameters, count);
}

static size_t any_line(uint8_t *to)
{
    static const char *const lines[] = {
        "torque %u on",
        "torque %u off",
        "move %u 90deg",
        "move %u 10deg 30rpm",
        "turn %u 20rpm",
        "led %u on",
        "regwrite %u TORQUE_ENABLE 1 0 2 2 32 32 0 0",
        "regwrite %u GOAL_POSITION 512",
        "action %u",
        "action",
        "reset %u",
        "factory %u",
        "factory 254 force",
        "write %u GOAL_POSITION 512 300",
        "write %u 24 1",
        "write %u 44 0",
        "set %u CCW_ANGLE_LIMIT 0deg",
        "set %u GOAL_POSITION 90deg",
        "sync GOAL_POSITION 4 %u:0,2,44,1 2:0,1,44,1",
        "sync TORQUE_ENABLE 1 %u:1 9:1",
        "servos forget",
        "servos",
        "status",
        "group 1 2 4",
        "group 1 2 4 action",
        "pose 10 20 30",
        "pose 90 150 210 at 30rpm",
        "cycle every 4ms",
        "cycle off",
        "scan",
        "diagnose %u",
        "limits %u 10deg 200deg 30rpm",
        "id %u 7",
        "ping %u",
        "read %u PRESENT_POSITION",
        "stop",
        "alarms",
        "monitor 1 2 every 20ms",
        "baud %u 500000",
        "settings repeats 2",
        "release 1",
    };
    int length = sprintf((char *)to, lines[any(sizeof lines / sizeof *lines)], any_id());

    to[length] = '\r';
    return (size_t)length + 1;
}

/* Sends a line or a packet (one packet in eight is damaged, one input in 300 is a Ctrl-X), then
 * runs some turns of the main loop. */
static void any_input(void)
{
    uint8_t bytes[PACKET_MAX + 40];
    size_t size = any(2) ? any_packet(bytes) : any_line(bytes);

    if (any(8) == 0 && bytes[0] == 0xFF)
        bytes[2 + any((uint32_t)size - 2)] ^= (uint8_t)(1u << any(8));
    if (any(300) == 0)
        bytes[0] = 0x18;
    settings.device_id = 253;
    settings.bus_baud = CDS_BAUD_1M;
    if (size > 2 && bytes[0] == 0xFF && bytes[2] == 253)
        return; // the damage has made it a packet to the device
    say(bytes, size);
    wait_us(any(4) ? any(1500) : any(9000));
}

static void inputs(uint32_t count)
{
    while (count--)
        any_input();
}

static void type(const char *line)
{
    say((const uint8_t *)line, strlen(line));
}

/* Runs until the console is idle, 3 s at most. Enter ends an incomplete line; a key ends a command
 * that goes on. */
static void settle(void)
{
    for (uint32_t i = 0; i < 150; i++) {
        type("\r");
        wait_us(20000);
        if (console_idle(&console) && host_demux_idle(&host) && !robot_is_stopping(&robot))
            return;
    }
}

/* ---- rounds ---- */

/* Inhibits driving. A stop must act within 20 ms after its last byte, a lost link after the silence
 * of the setting. */
static void begin_inhibit(void)
{
    static const uint8_t cut[] = {0xFF, 0xFF, 1, 0xFE, 3, 0x18};

    if (kind == 0) {
        settle(); // a line typed during the reply to another line is lost
        type("stop\r");
    } else if (kind == 1) {
        type("\x18");
    } else if (kind == 2) {
        say(cut, sizeof cut);
    } else {
        settings.link_loss_action = kind == 3 ? FAILSAFE_INHIBIT : FAILSAFE_TORQUE_OFF;
        settings.link_loss_ms = 15;
    }
    wait_us(20000);
    inhibited = true;
}

/* Allows driving again. A goal must reach the wire: otherwise this test could not fail. */
static bool release(void)
{
    static const uint8_t goal[] = {0x1E, 0, 2};
    uint8_t bytes[PACKET_MAX];
    uint32_t before;

    settings.link_loss_ms = 0;
    settle();
    inhibited = false;
    type(kind >= 3 ? "clear\r" : "release\r");
    settle();
    type("cycle off\rservos forget\r"); // an OFFLINE servo would not be driven
    settle();
    before = driving;
    say(bytes, build(bytes, 99, 3, goal, sizeof goal));
    wait_us(5000);
    if (driving == before)
        printf("seed %u, round %u: no goal after a release of kind %u; said: %.*s\n", first_seed,
               rounds, kind, (int)said_size, (const char *)said);
    return driving != before;
}

/* Makes the list of servos empty, partly filled, full, or lets a scan find more than it holds. */
static void fill(uint32_t servos)
{
    type("cycle off\rservos forget\r");
    settle();
    for (uint8_t id = 1; servos && id <= (servos == 1 ? 5 : ROBOT_SERVOS); id++)
        robot_add(&robot, id);
    if (servos == 3)
        type("scan\r");
    settle();
}

int main(int argc, char **argv)
{
    uint32_t left;
    bool good = true;

    if (argc < 2) {
        fprintf(stderr, "usage: inhibit_random INPUTS [SEED]\n");
        return 2;
    }
    left = (uint32_t)strtoul(argv[1], NULL, 0);
    seed = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 0) : 1;
    first_seed = seed;
    open_all();
    on_packet = judge;
    for (; left && good; rounds++) {
        uint32_t count = 1 + any(400);

        kind = any(5);
        if (count > left)
            count = left;
        left -= count;
        fill(any(4));
        inputs(any(20));
        begin_inhibit();
        inputs(count);
        good = release();
    }
    printf("%s inputs in %u rounds: %u packets judged, %u of them drive; %u while inhibited\n",
           argv[1], rounds, judged, driving, drove);
    good = good && drove == 0 && driving > rounds && port_fake.breaches == 0;
    puts(good ? "ok" : "FAILED");
    return !good;
}
