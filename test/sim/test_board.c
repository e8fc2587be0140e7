/* SPDX-License-Identifier: MIT */
#include "board.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];
static struct board board;

static void put(const char *name, const char *text)
{
    char path[128];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(file);
    fputs(text, file);
    fclose(file);
}

static const char chip[] =
    "# a comment\nMCU        := atmega128\nF_CPU := 16000000\nLFUSE := 0x1f\n";
static const char wiring[] = "/* wiring */\n"
                             "#ifndef BOARD_H\n"
                             "#define BOARD_H\n"
                             "#define BOARD_BUS_COUNT           1\n"
                             "#define BOARD_BUS0_USART          1\n"
                             "#define BOARD_BUS0_RXD_PORT       D\n"
                             "#define BOARD_BUS0_RXD_BIT        2\n"
                             "#define BOARD_BUS0_TXD_PORT       D\n"
                             "#define BOARD_BUS0_TXD_BIT        3\n"
                             "#define BOARD_BUS0_TX_ENABLE_PORT A\n"
                             "#define BOARD_BUS0_TX_ENABLE_BIT  6\n"
                             "#define BOARD_BUS0_RX_ENABLE_PORT D\n"
                             "#define BOARD_BUS0_RX_ENABLE_BIT  7 // behind it a comment\n"
                             "#define BOARD_HOST_USART          0\n"
                             "#define BOARD_HOST_BAUD           115200\n"
                             "#endif\n";

void setUp(void)
{
    char path[128];
    snprintf(folder, sizeof(folder), "/tmp/test_board.XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/one", folder);
    mkdir(path, 0700);
    put("one/board.mk", chip);
    put("one/board.h", wiring);
    TEST_ASSERT_NOT_NULL(freopen("/dev/null", "w", stderr)); // messages are not checked here
}

void tearDown(void)
{
    char command[128];
    snprintf(command, sizeof(command), "rm -r %s", folder);
    TEST_ASSERT_EQUAL_INT(0, system(command));
}

void test_a_board_is_read_from_its_two_files(void)
{
    TEST_ASSERT_TRUE(board_read(&board, folder, "one"));
    TEST_ASSERT_EQUAL_STRING("atmega128", board.mcu);
    TEST_ASSERT_EQUAL_UINT32(16000000, board.clock_Hz);
    TEST_ASSERT_EQUAL_UINT(1, board.bus_count);
    TEST_ASSERT_EQUAL_INT(BOARD_TWO_ENABLES, board.bus[0].wiring);
    TEST_ASSERT_EQUAL_UINT(1, board.bus[0].usart);
    TEST_ASSERT_EQUAL_CHAR('A', board.bus[0].tx_enable.port);
    TEST_ASSERT_EQUAL_UINT(6, board.bus[0].tx_enable.bit);
    TEST_ASSERT_EQUAL_UINT(7, board.bus[0].rx_enable.bit);
    TEST_ASSERT_EQUAL_UINT(3, board.bus[0].txd.bit);
    TEST_ASSERT_EQUAL_UINT(2, board.bus[0].rxd.bit);
    TEST_ASSERT_EQUAL_UINT(0, board.host_usart);
    TEST_ASSERT_EQUAL_UINT32(115200, board.host_baud);
}

void test_an_unknown_board_is_refused(void)
{
    TEST_ASSERT_FALSE(board_read(&board, folder, "two"));
    TEST_ASSERT_FALSE(board_read(&board, folder, ""));
    TEST_ASSERT_FALSE(board_read(&board, folder, "../one")); // a path that does not exist
    TEST_ASSERT_FALSE(board_read(&board, "/no/such/folder", "one"));
}

static void assert_refused_without(const char *line)
{
    char text[sizeof(wiring)];
    snprintf(text, sizeof(text), "%s", wiring);
    char *found = strstr(text, line);
    TEST_ASSERT_NOT_NULL(found);
    found[0] = '_';
    put("one/board.h", text);
    TEST_ASSERT_FALSE_MESSAGE(board_read(&board, folder, "one"), line);
}

void test_every_key_is_needed(void)
{
    assert_refused_without("BOARD_BUS_COUNT");
    assert_refused_without("BOARD_BUS0_USART");
    assert_refused_without("BOARD_BUS0_RXD_PORT");
    assert_refused_without("BOARD_BUS0_TX_ENABLE_BIT");
    assert_refused_without("BOARD_HOST_BAUD");
}

void test_a_board_of_two_buses_needs_the_pins_of_both(void)
{
    char text[sizeof(wiring)];
    snprintf(text, sizeof(text), "%s", wiring);
    *strstr(text, "1\n") = '2';
    put("one/board.h", text);
    TEST_ASSERT_FALSE(board_read(&board, folder, "one"));
}

void test_a_board_may_lack_a_host_link(void)
{
    char text[sizeof(wiring)];
    snprintf(text, sizeof(text), "%s", wiring);
    memcpy(strstr(text, "BOARD_HOST_USART"), "_", 1);
    put("one/board.h", text);
    TEST_ASSERT_TRUE(board_read(&board, folder, "one"));
    TEST_ASSERT_FALSE(board.has_host);
}

void test_one_usart_cannot_serve_bus_and_host(void)
{
    char text[sizeof(wiring)];
    snprintf(text, sizeof(text), "%s", wiring);
    strstr(strstr(text, "BOARD_HOST_USART"), "0\n")[0] = '1';
    put("one/board.h", text);
    TEST_ASSERT_FALSE(board_read(&board, folder, "one"));
}

/* --- wirings --- */

static bool read_wiring(const char *word, const char *without, const char *more)
{
    char text[sizeof(wiring) + 256];
    snprintf(text, sizeof(text), "%s#define BOARD_BUS0_WIRING %s\n%s", wiring, word, more);
    for (char *found = strstr(text, without); found; found = strstr(text, without)) {
        found[0] = '_';
    }
    put("one/board.h", text);
    return board_read(&board, folder, "one");
}

void test_wiring_two_enables_may_be_named(void)
{
    TEST_ASSERT_TRUE(read_wiring("TWO_ENABLES", "nothing", ""));
    TEST_ASSERT_EQUAL_INT(BOARD_TWO_ENABLES, board.bus[0].wiring);
}

void test_one_enable_needs_that_pin_only(void)
{
    TEST_ASSERT_TRUE(read_wiring("ONE_ENABLE", "BOARD_BUS0_RX_E",
                                 "#define BOARD_BUS0_ENABLE_PORT B\n"
                                 "#define BOARD_BUS0_ENABLE_BIT 3\n"));
    TEST_ASSERT_EQUAL_INT(BOARD_ONE_ENABLE, board.bus[0].wiring);
    TEST_ASSERT_EQUAL_CHAR('B', board.bus[0].tx_enable.port);
    TEST_ASSERT_EQUAL_UINT(3, board.bus[0].tx_enable.bit);
    TEST_ASSERT_FALSE(read_wiring("ONE_ENABLE", "nothing", ""));
}

void test_tied_pins_need_no_enable(void)
{
    TEST_ASSERT_TRUE(read_wiring("TIED", "BOARD_BUS0_TX_E", ""));
    TEST_ASSERT_EQUAL_INT(BOARD_TIED, board.bus[0].wiring);
    TEST_ASSERT_FALSE(read_wiring("TIED", "BOARD_BUS0_TXD", ""));
}

void test_an_unknown_wiring_is_refused(void)
{
    TEST_ASSERT_FALSE(read_wiring("THREE_ENABLES", "nothing", ""));
}

void test_sim_mcu_names_the_simulated_chip(void)
{
    TEST_ASSERT_TRUE(board_read(&board, folder, "one"));
    TEST_ASSERT_EQUAL_STRING("atmega128", board.core);
    put("one/board.mk", "MCU := atmega2561\nSIM_MCU := atmega2560\nF_CPU := 16000000\n");
    TEST_ASSERT_TRUE(board_read(&board, folder, "one"));
    TEST_ASSERT_EQUAL_STRING("atmega2561", board.mcu);
    TEST_ASSERT_EQUAL_STRING("atmega2560", board.core);
}

/* --- people's own boards --- */

static bool read_own(const char *name)
{
    char path[128];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return board_read(&board, "/no/such/folder", path);
}

static void put_with_chip(const char *lines)
{
    char text[sizeof(wiring) + 128];
    snprintf(text, sizeof(text), "%s%s", wiring, lines);
    put("mine.h", text);
}

void test_path_to_board_h_reads_board_mk_beside_it(void)
{
    TEST_ASSERT_TRUE(read_own("one/board.h"));
    TEST_ASSERT_EQUAL_STRING("atmega128", board.mcu);
    TEST_ASSERT_TRUE(read_own("one"));
    TEST_ASSERT_EQUAL_UINT32(16000000, board.clock_Hz);
}

void test_chip_and_clock_may_stand_in_the_file(void)
{
    put_with_chip("#define BOARD_MCU atmega1284p\n#define BOARD_F_CPU 8000000\n");
    TEST_ASSERT_TRUE(read_own("mine.h"));
    TEST_ASSERT_EQUAL_STRING("atmega1284p", board.mcu);
    TEST_ASSERT_EQUAL_UINT32(8000000, board.clock_Hz);
    TEST_ASSERT_EQUAL_CHAR('A', board.bus[0].tx_enable.port);
}

void test_board_lines_in_all_forms_of_cpp_and_make_are_read(void)
{
    put_with_chip("# define BOARD_MCU atmega1284p\n #define\tBOARD_F_CPU  8000000\n");
    TEST_ASSERT_TRUE(read_own("mine.h"));
    TEST_ASSERT_EQUAL_STRING("atmega1284p", board.mcu);
    TEST_ASSERT_EQUAL_UINT32(8000000, board.clock_Hz);
    put("one/board.mk", "  MCU ?= atmega1284p # the chip\nF_CPU = 8000000  \n");
    TEST_ASSERT_TRUE(read_own("one"));
    TEST_ASSERT_EQUAL_STRING("atmega1284p", board.mcu);
    TEST_ASSERT_EQUAL_UINT32(8000000, board.clock_Hz);
}

void test_board_path_without_chip_is_refused(void)
{
    put("mine.h", wiring);
    TEST_ASSERT_FALSE(read_own("mine.h"));
    TEST_ASSERT_FALSE(read_own("none.h"));
}

void test_clock_that_is_not_given_is_16_MHz(void)
{
    put_with_chip("#define BOARD_MCU atmega1284p\n");
    TEST_ASSERT_TRUE(read_own("mine.h"));
    TEST_ASSERT_EQUAL_UINT32(16000000, board.clock_Hz);
    put("one/board.mk", "MCU := atmega644p\n");
    TEST_ASSERT_TRUE(read_own("one"));
    TEST_ASSERT_EQUAL_UINT32(16000000, board.clock_Hz);
}

/* Returns what board_read() prints on stderr. */
static const char *complaint(const char *name)
{
    static char text[512];
    char path[128];
    snprintf(path, sizeof(path), "%s/complaint", folder);
    TEST_ASSERT_NOT_NULL(freopen(path, "w", stderr));
    TEST_ASSERT_FALSE(read_own(name));
    fflush(stderr);
    FILE *file = fopen(path, "r");
    text[fread(text, 1, sizeof(text) - 1, file)] = 0;
    fclose(file);
    return text;
}

static void assert_complaint(const char *where, const char *what)
{
    char wanted[256];
    snprintf(wanted, sizeof(wanted), "%s/mine.h:%s: %s\n", folder, where, what);
    TEST_ASSERT_EQUAL_STRING(wanted, complaint("mine.h"));
}

void test_wrong_value_prints_file_and_line(void)
{
    put_with_chip("#define BOARD_MCU atmega1284p\n#define BOARD_F_CPU fast\n");
    assert_complaint("18", "BOARD_F_CPU: \"fast\" is not valid: use a whole number from 1000000 "
                           "to 32000000");
    char text[sizeof(wiring)];
    snprintf(text, sizeof(text), "%s", wiring);
    strstr(strstr(text, "BOARD_HOST_USART"), "0\n")[0] = '1';
    put("mine.h", text);
    assert_complaint("14", "BOARD_HOST_USART: USART1 has another job already");
}

/* Sets the value of `key` in mine.h. */
static void put_value(const char *key, const char *value)
{
    char text[sizeof(wiring) + 256];
    const char *old = strstr(wiring, key) + strlen(key);
    old += strspn(old, " ");
    snprintf(text, sizeof(text),
             "%.*s%s%s#define BOARD_MCU atmega128\n"
             "#define BOARD_F_CPU 16000000\n",
             (int)(old - wiring), wiring, value, old + strcspn(old, " \n"));
    put("mine.h", text);
}

void test_board_number_in_range_is_accepted(void)
{
    put_value("BOARD_BUS0_RXD_BIT", "0x7");
    TEST_ASSERT_TRUE(read_own("mine.h"));
    TEST_ASSERT_EQUAL_UINT(7, board.bus[0].rxd.bit);
    put_value("BOARD_HOST_BAUD", "2000000UL");
    TEST_ASSERT_TRUE(read_own("mine.h"));
    TEST_ASSERT_EQUAL_UINT32(2000000, board.host_baud);
}

/* Checks every number of a board.h with values that are no number or too large. */
void test_board_number_out_of_range_is_refused(void)
{
    static const struct {
        const char *key, *line, *range;
    } numbers[] = {
        {"BOARD_BUS_COUNT", "4", "1 to 3"},    {"BOARD_BUS0_USART", "5", "0 to 3"},
        {"BOARD_BUS0_RXD_BIT", "7", "0 to 7"}, {"BOARD_BUS0_TXD_BIT", "9", "0 to 7"},
        {"BOARD_HOST_USART", "14", "0 to 3"},  {"BOARD_HOST_BAUD", "15", "1 to 2000000"},
    };
    static const char *const values[] = {"-1",
                                         "2000001",
                                         "4294967296",
                                         "4294967297",
                                         "9223372036854775807",
                                         "18446744073709551617",
                                         "-18446744073709551615",
                                         "99999999999999999999999",
                                         "1.5",
                                         "1x",
                                         "0x",
                                         "one",
                                         "(1)"};
    for (unsigned i = 0; i < sizeof(numbers) / sizeof(numbers[0]); i++) {
        for (unsigned v = 0; v < sizeof(values) / sizeof(values[0]); v++) {
            char what[160];
            put_value(numbers[i].key, values[v]);
            snprintf(what, sizeof(what), "%s: \"%s\" is not valid: use a whole number from %s",
                     numbers[i].key, values[v], numbers[i].range);
            assert_complaint(numbers[i].line, what);
        }
    }
}

void test_board_with_four_buses_is_refused(void)
{
    put_value("BOARD_BUS_COUNT", "4");
    assert_complaint("4", "BOARD_BUS_COUNT: \"4\" is not valid: use a whole number from 1 to 3");
}

void test_board_with_port_beyond_l_is_refused(void)
{
    put_value("BOARD_BUS0_RXD_PORT", "M");
    assert_complaint("6", "BOARD_BUS0_RXD_PORT: \"M\" is not valid: use one letter from A to L");
    put_value("BOARD_BUS0_RXD_PORT", "DD");
    assert_complaint("6", "BOARD_BUS0_RXD_PORT: \"DD\" is not valid: use one letter from A to L");
}

void test_board_with_unknown_wiring_names_the_words(void)
{
    put_with_chip("#define BOARD_BUS0_WIRING THREE\n");
    assert_complaint("17", "BOARD_BUS0_WIRING: \"THREE\" is not valid: use TWO_ENABLES, "
                           "ONE_ENABLE, TIED, ADAPTER or ADAPTER_ECHO");
}

void test_chip_missing_or_clock_wrong_is_refused(void)
{
    put("one/board.mk", "F_CPU := 16000000\n");
    TEST_ASSERT_FALSE(board_read(&board, folder, "one"));
    put("one/board.mk", "MCU := atmega128\nF_CPU := fast\n");
    TEST_ASSERT_FALSE(board_read(&board, folder, "one"));
}
