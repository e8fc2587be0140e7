/* The console: lines in, packets and replies out. */
#include <stdio.h>
#include <string.h>

#include "console/console.h"
#include "console/errors.h"
#include "host/host_demux.h"
#include "ring_input.h"
#include "port_fake.h"
#include "unity.h"

static struct cds_bus bus;
static struct cds_ring input, output;
static struct robot robot;
static struct settings settings;
static struct settings_store store;
static struct failsafe failsafe;
static struct console console;

/* What the console has said; only the end of it is kept. */
static char said[640];
static uint16_t said_length;

void setUp(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    memset(&console, 0, sizeof console);
    memset(&input, 0, sizeof input);
    memset(&output, 0, sizeof output);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    memset(&robot, 0, sizeof robot);
    robot_begin(&robot, &bus, 0);
    settings_default(&settings);
    failsafe = (struct failsafe){.settings = &settings, .store = &store, .robot = &robot};
    console_open(&console, &failsafe, &input, &output);
    said_length = 0;
    said[0] = '\0';
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void hear_console(void)
{
    while (cds_ring_count(&output)) {
        if (said_length == sizeof said - 1) { // keep the later half
            memmove(said, said + sizeof said / 2, sizeof said / 2);
            said_length = (uint16_t)(sizeof said / 2 - 1);
        }
        said[said_length++] = (char)ring_peek(&output, 0);
        said[said_length] = '\0';
        ring_drop(&output, 1);
    }
}

static void turn(void)
{
    cds_bus_poll(&bus);
    robot_poll(&robot);
    console_poll(&console);
    hear_console();
}

/* It goes on without an answer of the bus, and without more input. */
static bool moves(void)
{
    return console.state == CONSOLE_ENDING ||
           (console.state == CONSOLE_RUNNING && console.request.result != CDS_PENDING) ||
           (console.state == CONSOLE_READING && !console_idle(&console));
}

static void type(const char *text)
{
    while (*text) {
        while (!cds_ring_put(&input, (uint8_t)*text))
            turn();
        text++;
    }
    for (uint16_t i = 0; i < 100 || (i < 5000 && moves()); i++) // 50 goals are checked in parts
        turn();
}

/* Types a line that is answered without a transaction, or sends no reply-worthy packet. */
static const char *reply_to(const char *line)
{
    said_length = 0;
    said[0] = '\0';
    type(line);
    type("\r");
    if (bus.link.state == CDS_LINK_TALKING) {
        port_fake_transmit(&bus.link, 0);
        type("");
    }
    return said;
}

static void answer(uint8_t id, uint8_t error, const uint8_t *parameters, uint8_t count)
{
    port_fake_answer(&bus.link, id, error, parameters, count);
    type("");
}

static void assert_error(uint8_t number, const char *line)
{
    char start[12];

    sprintf(start, "error %u: ", number);
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(start, said, strlen(start), line);
    TEST_ASSERT_EQUAL_STRING("\r\n", said + strlen(said) - 2);
}

static void assert_sent(const char *hex)
{
    char text[3 * 40 + 1] = "";

    for (uint8_t i = 0; i < port_fake.sent_size && i < 40; i++)
        sprintf(text + strlen(text), i ? " %02X" : "%02X", port_fake.sent[i]);
    TEST_ASSERT_EQUAL_STRING(hex, text);
}

void test_ping_sends_the_packet_of_example_3(void)
{
    reply_to("ping 1");
    assert_sent("FF FF 01 02 01 FB");
    TEST_ASSERT_EQUAL_STRING("", said);
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_broadcast_ping_prints_id_of_reply(void)
{
    reply_to("ping 254");
    answer(42, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("id 42\r\nok\r\n", said);
}

void test_read_by_name_gives_bytes_and_value(void)
{
    static const uint8_t bytes[] = {0x34, 0x02};

    reply_to("read 7 present_position");
    assert_sent("FF FF 07 04 02 24 02 CC");
    answer(7, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x24: 34 02\r\nPRESENT_POSITION = 564\r\nok\r\n", said);
}

void test_read_by_address_gives_bytes_only(void)
{
    static const uint8_t bytes[] = {32};

    reply_to("read 1 0x2B");
    assert_sent("FF FF 01 04 02 2B 01 CC");
    answer(1, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x2B: 20\r\nok\r\n", said);
}

void test_read_of_ten_bytes_takes_two_lines(void)
{
    static const uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};

    reply_to("read 1 0x1E 10");
    answer(1, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x1E: 01 02 03 04 05 06 07 08\r\n0x26: 09 0A\r\nok\r\n", said);
}

void test_read_of_a_named_register_in_part_gives_no_value(void)
{
    static const uint8_t bytes[] = {0x34};

    reply_to("read 1 PRESENT_POSITION 1");
    answer(1, 0, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_STRING("0x24: 34\r\nok\r\n", said);
}

void test_write_by_name_fills_following_registers(void)
{
    reply_to("write 0 GOAL_POSITION 0x200 512");
    assert_sent("FF FF 00 07 03 1E 00 02 00 02 D3");
}

void test_write_by_address_takes_bytes(void)
{
    reply_to("write 0 0x08 0xFF 1");
    assert_sent("FF FF 00 05 03 08 FF 01 EF");
}

void test_broadcast_write_is_ok_when_sent(void)
{
    reply_to("write 254 ID 1");
    assert_sent("FF FF FE 04 03 03 01 F6");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_regwrite_and_action(void)
{
    reply_to("regwrite 1 goal-position 0x3FF");
    assert_sent("FF FF 01 05 04 1E FF 03 D5");
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    reply_to("action");
    assert_sent("FF FF FE 02 05 FA");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    reply_to("action 3");
    assert_sent("FF FF 03 02 05 F5");
}

void test_reset(void)
{
    reply_to("reset 0");
    assert_sent("FF FF 00 02 06 F7");
}

void test_sync_of_example_5(void)
{
    reply_to("sync GOAL_POSITION 4 0:0x10,0,0x50,1 1:0x20,2,0x60,3 2:0x30,0,0x70,1 "
             "3:0x20,2,0x80,3");
    assert_sent("FF FF FE 18 83 1E 04 00 10 00 50 01 01 20 02 60 03 02 30 00 70 01 03 20 02 80 "
                "03 12");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_sync_longer_than_any_buffer_of_text(void)
{
    char block[32];

    type("sync 0x1E 4");
    for (uint8_t id = 0; id < 50; id++) {
        sprintf(block, " %u:0x%02X,1,255,3", id, id);
        type(block);
    }
    reply_to("");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
    TEST_ASSERT_EQUAL_UINT16(258, port_fake.sent_size);
    TEST_ASSERT_EQUAL_HEX8(254, port_fake.sent[3]);
    for (uint8_t id = 0; id < 50; id++) {
        const uint8_t expected[] = {id, id, 1, 255, 3};

        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, port_fake.sent + 7 + 5 * id, sizeof expected);
    }
}

void test_sync_with_one_servo_too_many_is_refused(void)
{
    char block[24];

    type("sync 0x1E 4");
    for (uint8_t id = 0; id < 51; id++) {
        sprintf(block, " %u:1,2,3,4", id);
        type(block);
    }
    assert_error(CDS_NO_ROOM, "");
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_malformed_blocks(void)
{
    static const char *const lines[] = {
        "sync 0x1E 2 1:1",       "sync 0x1E 2 1:1,2,3", "sync 0x1E 2 1,1,2", "sync 0x1E 2 1:1:2",
        "sync 0x1E 2 1:1,2 2:1", "sync 0x1E 2 1:1,2 2", "sync 0x1E 2 1:1,",  "sync 0x1E 2 1:"};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_error(ERROR_BLOCK, lines[i]);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_unknown_commands(void)
{
    assert_error(ERROR_UNKNOWN_COMMAND, "pong 1");
    assert_error(ERROR_UNKNOWN_COMMAND, "pin 1");
    assert_error(ERROR_UNKNOWN_COMMAND, "pings 1");
    assert_error(ERROR_UNKNOWN_COMMAND, "averyveryveryverylongwordindeed");
    assert_error(ERROR_UNKNOWN_COMMAND, "\x01\x80");
}

void test_wrong_counts(void)
{
    static const char *const lines[] = {"ping",      "ping 1 2",    "read 1",       "read 1 2 3 4",
                                        "write 1",   "write 1 ID",  "regwrite 1 3", "reset",
                                        "reset 1 2", "help help 1", "version 1",    "action 1 2",
                                        "sync",      "sync 3",      "sync 3 1"};

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_error(ERROR_COUNT, lines[i]);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_numbers_out_of_range(void)
{
    static const char *const lines[] = {
        "ping 255",          "ping 65536",       "read 254 3",      "reset 254",
        "read 1 0x32",       "read 1 3 0",       "read 1 0x31 2",   "read 1 0 51",
        "write 1 3 256",     "write 1 ID 254",   "write 1 LED 2",   "write 1 GOAL_POSITION 1024",
        "write 1 PUNCH 1 2", "write 1 0x31 1 2", "sync 0x1E 0 1:1", "sync 0x30 3 1:1,2,3",
        "sync 3 1 254:1",    "sync 3 1 1:256",   "write 1 256 1",   "write 1 0x10000 1",
    };

    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_error(ERROR_OUT_OF_RANGE, lines[i]);
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.packets);
}

void test_not_a_number(void)
{
    assert_error(ERROR_NOT_A_NUMBER, "ping one");
    assert_error(ERROR_NOT_A_NUMBER, "write 1 ID 0x");
    assert_error(ERROR_NOT_A_NUMBER, "read 1 ID 1,2");
    assert_error(ERROR_NOT_A_NUMBER, "sync 3 1 1:a");
    assert_error(ERROR_OUT_OF_RANGE, "ping -1");
    assert_error(ERROR_NOT_A_NUMBER, "ping 1.5");
    assert_error(ERROR_NOT_A_NUMBER, "ping 1raw");
}

void test_unknown_register(void)
{
    assert_error(ERROR_UNKNOWN_REGISTER, "read 1 GOAL");
    assert_error(ERROR_UNKNOWN_REGISTER, "read 1 GOAL_POSITIONS");
    assert_error(ERROR_UNKNOWN_REGISTER, "write 1 averyveryveryverylongwordindeed 1");
}

void test_the_first_error_of_a_line_counts(void)
{
    assert_error(ERROR_NOT_A_NUMBER, "write x GOAL 99999");
}

void test_line_too_long_is_one_error_and_the_next_line_works(void)
{
    for (uint16_t i = 0; i < 7000; i++)
        type("abcdefghij ");
    assert_error(ERROR_LINE_TOO_LONG, "");
    for (uint16_t i = 0; i < CONSOLE_LINE_MAX; i++)
        type(" ");
    assert_error(ERROR_LINE_TOO_LONG, "version");
    TEST_ASSERT_EQUAL_STRING("cds55xx 0.1.0 host\r\nok\r\n", reply_to("version"));
}

void test_a_line_of_just_the_longest_length_is_carried_out(void)
{
    for (uint16_t i = 0; i < CONSOLE_LINE_MAX - 7; i++)
        type(" ");
    reply_to("version");
    TEST_ASSERT_EQUAL_STRING("cds55xx 0.1.0 host\r\nok\r\n", said);
}

void test_line_ends_of_every_kind_and_empty_lines(void)
{
    type("\r\n\r\n   \n\t\r");
    TEST_ASSERT_EQUAL_STRING("", said);
    type("version\r\nversion\n");
    TEST_ASSERT_EQUAL_STRING("cds55xx 0.1.0 host\r\nok\r\ncds55xx 0.1.0 host\r\nok\r\n", said);
}

void test_spaces_and_tabs_between_words(void)
{
    reply_to("  ping \t  1  ");
    assert_sent("FF FF 01 02 01 FB");
}

void test_absent_servo(void)
{
    reply_to("ping 9");
    port_fake.now_us += 1000000;
    type("");
    TEST_ASSERT_EQUAL_STRING_LEN("error 2: no reply by the deadline; check power", said, 46);
    port_fake.now_us += CDS_STALE_REPLY_US; // the bus rests
    reply_to("ping 1");
    answer(1, 0, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
}

void test_damaged_reply(void)
{
    static const uint8_t damaged[] = {0xFF, 0xFF, 1, 2, 0, 0xFD};

    reply_to("ping 1");
    port_fake_hear(&bus.link, damaged, sizeof damaged);
    port_fake.now_us += 1000000;
    type("");
    TEST_ASSERT_EQUAL_STRING_LEN("error 3: ", said, 9);
}

void test_packet_errors_of_servo_have_numbers(void)
{
    static const uint8_t errors[][2] = {{CDS_ERROR_INSTRUCTION, ERROR_SERVO_INSTRUCTION},
                                        {CDS_ERROR_RANGE, ERROR_SERVO_RANGE},
                                        {CDS_ERROR_CHECKSUM, ERROR_SERVO_CHECKSUM},
                                        {CDS_ERROR_ANGLE, ERROR_SERVO_ANGLE}};
    char start[24];

    for (uint8_t i = 0; i < 4; i++) {
        reply_to("write 1 LED 1");
        answer(1, errors[i][0], NULL, 0);
        sprintf(start, "error %u: servo: ", errors[i][1]);
        TEST_ASSERT_EQUAL_STRING_LEN(start, said, strlen(start));
    }
}

void test_conditions_are_warnings_and_ok(void)
{
    reply_to("ping 1");
    answer(1, CDS_ERROR_VOLTAGE | CDS_ERROR_OVERHEATING | CDS_ERROR_OVERLOAD, NULL, 0);
    TEST_ASSERT_EQUAL_STRING("warning: input voltage\r\nwarning: overheating\r\n"
                             "warning: overload\r\nok\r\n",
                             said);
}

void test_all_error_bits_are_named(void)
{
    static const char *const lines[] = {
        "warning: input voltage\r\n",
        "\r\nwarning: overheating\r\n",
        "\r\nwarning: overload\r\n",
        "\r\nalso 20: servo: instruction error; ",
        "\r\nalso 21: servo: range error; ",
        "\r\nalso 22: servo: checksum error; ",
        "\r\nerror 23: servo: angle limit error; ",
    };
    const char *from = said;

    reply_to("ping 1");
    answer(1, 0x7F, NULL, 0);
    for (uint8_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        from = strstr(from, lines[i]);
        TEST_ASSERT_NOT_NULL_MESSAGE(from, lines[i]);
    }
}

void test_several_packet_errors_end_in_one_error_line(void)
{
    reply_to("write 1 LED 1");
    answer(1, CDS_ERROR_RANGE | CDS_ERROR_ANGLE, NULL, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("also 21: ", said, 9);
    TEST_ASSERT_NOT_NULL(strstr(said, "\r\nerror 23: "));
    TEST_ASSERT_NULL(strstr(said, "ok\r\n"));
}

void test_read_refused_by_the_servo_gives_no_bytes(void)
{
    reply_to("read 1 ID");
    answer(1, CDS_ERROR_RANGE, NULL, 0);
    TEST_ASSERT_EQUAL_STRING_LEN("error 21: ", said, 10);
}

static void mark(uint8_t byte)
{
    char text[2] = {(char)byte, '\0'};

    type(text);
}

void test_lost_input_drops_line_and_prints_error_at_once(void)
{
    type("write 1 GOAL_POSITION 5");
    mark(HOST_MARK_LOST);
    TEST_ASSERT_EQUAL_STRING_LEN("error 36: ", said, 10);
    reply_to("ping 1");
    assert_sent("FF FF 01 02 01 FB");
}

void test_packet_drops_begun_line_without_reply(void)
{
    type("write 1 GOAL_POSITION 5");
    mark(HOST_MARK_DROPPED);
    TEST_ASSERT_EQUAL_STRING("", said);
    reply_to("ping 1");
    assert_sent("FF FF 01 02 01 FB");
}

void test_the_next_line_waits_for_the_reply_to_this_one(void)
{
    reply_to("ping 1\rping 2");
    assert_sent("FF FF 01 02 01 FB");
    TEST_ASSERT_EQUAL_UINT16(1, port_fake.packets);
    answer(1, 0, NULL, 0);
    port_fake_transmit(&bus.link, 0);
    assert_sent("FF FF 02 02 01 FA");
}

void test_stopped_reader_delays_reply_without_loss(void)
{
    type("");
    for (const char *c = "help\r"; *c; c++)
        cds_ring_put(&input, (uint8_t)*c);
    for (uint16_t i = 0; i < 2000; i++) {
        cds_bus_poll(&bus);
        console_poll(&console); // nobody reads
    }
    TEST_ASSERT_GREATER_THAN_UINT8(CDS_RING_SIZE - PRINTER_PIECE, cds_ring_count(&output));
    TEST_ASSERT_FALSE(console_idle(&console));
    for (uint16_t i = 0; i < 1000; i++)
        turn();
    TEST_ASSERT_NOT_NULL(strstr(said, "sync REG LENGTH ID:BYTE,... ...: write many"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said + strlen(said) - 4);
}

void test_idle_only_when_there_is_nothing_to_do(void)
{
    TEST_ASSERT_TRUE(console_idle(&console));
    cds_ring_put(&input, 'p');
    TEST_ASSERT_FALSE(console_idle(&console));
    type("ing 1\r");
    TEST_ASSERT_FALSE(console_idle(&console));
    port_fake_transmit(&bus.link, 0);
    answer(1, 0, NULL, 0);
    TEST_ASSERT_TRUE(console_idle(&console));
}
