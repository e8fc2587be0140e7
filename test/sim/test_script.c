/* SPDX-License-Identifier: MIT */
/* Scenarios, run against a firmware of four lines of C and servos on a wire; and lists of IDs. */
#include "host/adapter.h"
#include "script/script.h"
#include "unity.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CLOCK 16000000u
#define MS    (CLOCK / 1000)

static struct schedule schedule;
static struct script script;
static struct net net;
static struct servos servos;
static struct transcript transcript;
static struct adapter adapter; // the controller
static struct rules rules;
static struct script_ops ops;
static char path[64];
static char log_text[1024]; // events of the run, one word or line each
static char said[256];
static const char *answer;      // the reply to every command; 0: none
static const char *mode_answer; // the reply to `mode program`
static unsigned modes;          // times that `mode program` was sent
static bool ready;
static bool dies; // the firmware crashes at the next command
static bool for_good;
static FILE *out;

static void note(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void note(const char *format, ...)
{
    size_t used = strlen(log_text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(log_text + used, sizeof(log_text) - used, format, arguments);
    va_end(arguments);
}

static bool reset_is_late; // an ordered reset does not happen by itself

static bool is_ready(void *context)
{
    (void)context;
    return ready;
}

static void say(void *context, uint64_t now, const char *bytes, size_t size)
{
    (void)context;
    strncat(said, bytes, size);
    if (strcmp(said, "mode program\n") == 0) { // not noted: each script begins with it
        said[0] = 0;
        modes++;
        for (const char *c = mode_answer; *c; c++) {
            script_receive(&script, now, (uint8_t)*c);
        }
        return;
    }
    if (strchr(said, '\n')) {
        note("%s", said);
        said[0] = 0;
        if (dies) {
            dies = false;
            ready = !for_good;
            script_receive(&script, now, '?'); // half a line
            script_was_reset(&script, now);
            return;
        }
        for (const char *c = answer; c && *c; c++) {
            script_receive(&script, now, (uint8_t)*c);
        }
    }
}

static void put_servos(void *context, uint64_t now, const uint8_t *ids, unsigned count)
{
    (void)context;
    servos_replace(&servos, now, ids, count);
    note("servos %u:", count);
    for (unsigned i = 0; i < count; i++) {
        note(" %u", ids[i]);
    }
    note("\n");
}

static struct servos *bus(void *context, unsigned index)
{
    (void)context;
    return index == 0 ? &servos : 0;
}

static uint64_t send(void *context, uint64_t now, const uint8_t *bytes, size_t size)
{
    (void)context;
    adapter_send(&adapter, now, bytes, size);
    return adapter_end(&adapter);
}

static void baud(void *context, uint32_t value)
{
    (void)context;
    adapter_baud(&adapter, value);
}

static const char *fault(void *context, uint64_t now, const char *text)
{
    (void)context;
    note("fault %s at %u ms\n", text, (unsigned)(now / MS));
    return strcmp(text, "baud 9 1") == 0 ? "no servo has that ID" : 0;
}

static void reset_controller(void *context, uint64_t now, const struct reset_order *order)
{
    (void)context;
    note("%s %d in %u us, write %u at %u %%, at %u ms\n", order->hang ? "hang" : "reset",
         (int)order->cause, order->us, order->writes, order->percent, (unsigned)(now / MS));
    if (!order->hang && !order->us && !order->writes && !reset_is_late) {
        script_was_reset(&script, now);
    }
}

static void echo(void *context, bool on)
{
    (void)context;
    note("echo %d\n", on);
}

static void outcome(void *context, uint64_t now, enum script_outcome what, const char *text)
{
    (void)context;
    (void)now;
    note("outcome %d %s\n", what, text);
}

static void finished(void *context, uint64_t now)
{
    (void)context;
    note("finished %u ms\n", (unsigned)(now / MS));
}

static bool read_script(const char *text)
{
    FILE *file = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(file);
    fputs(text, file);
    fclose(file);
    return script_read(&script, path);
}

static void run(const char *text)
{
    TEST_ASSERT_TRUE(read_script(text));
    TEST_ASSERT_TRUE(script_start(&script, &schedule, CLOCK, &ops, out));
    schedule_run_until(&schedule, (uint64_t)CLOCK * 60);
}

static void line_seen(void *context, const struct transcript *line)
{
    (void)context;
    script_record_packet(&script, line);
}

void setUp(void)
{
    static const uint8_t ids[] = {1, 2, 3};
    snprintf(path, sizeof(path), "/tmp/test_script.XXXXXX");
    close(mkstemp(path));
    out = tmpfile();
    schedule_init(&schedule);
    rules_init(&rules, CLOCK, 0);
    net_init(&net);
    adapter_init(&adapter, &schedule, &net, &net, CLOCK, 1000000);
    transcript_init(&transcript, &schedule, &net, &adapter.driver);
    transcript.on_line = line_seen;
    servos_init(&servos, &schedule, &net, CLOCK);
    servos_replace(&servos, 0, ids, sizeof(ids));
    ops = (struct script_ops){.console_ready = is_ready,
                              .console_send = say,
                              .has_text = true,
                              .bus_send = send,
                              .bus_baud = baud,
                              .bus = bus,
                              .servos = put_servos,
                              .fault = fault,
                              .reset = reset_controller,
                              .echo = echo,
                              .rules = &rules,
                              .outcome = outcome,
                              .finished = finished};
    log_text[0] = said[0] = 0;
    answer = "ok\n";
    mode_answer = "ok\n";
    modes = 0;
    ready = true;
    dies = for_good = reset_is_late = false;
    TEST_ASSERT_NOT_NULL(freopen("/dev/null", "w", stderr));
}

void tearDown(void)
{
    script_free(&script);
    servos_free(&servos);
    schedule_free(&schedule);
    fclose(out);
    unlink(path);
}

void test_commands_are_sent_one_after_the_other(void)
{
    run("# comment\n\nping 1\n  ping 2  \n");
    TEST_ASSERT_EQUAL_STRING("ping 1\noutcome 0 ping 1: ok\nping 2\noutcome 0 ping 2: ok\n"
                             "finished 1 ms\n",
                             log_text);
}

void test_mode_program_is_sent_once_before_the_commands(void)
{
    run("@echo on\n");
    TEST_ASSERT_EQUAL_UINT(0, modes);
    tearDown();
    setUp();
    run("ping 1\nping 2\n");
    TEST_ASSERT_EQUAL_UINT(1, modes);
}

void test_lines_before_ok_of_mode_program_are_dropped(void)
{
    char text[128] = "";

    mode_answer = "cds55xx 0.1.0\r\n\r> mode program\r\nok\r\n";
    answer = "32\nok\n";
    run("@echo on\nread 1 43\n@expect text cds55xx within 0\n");
    rewind(out);
    text[fread(text, 1, sizeof(text) - 1, out)] = 0;
    TEST_ASSERT_EQUAL_STRING("> read 1 43\n32\nok\n", text);
    TEST_ASSERT_NOT_NULL(strstr(log_text, "not met; seen: 32|ok\n"));
}

void test_firmware_without_modes_gets_the_commands(void)
{
    mode_answer = "error 30: unknown command\n";
    run("ping 1\n");
    TEST_ASSERT_EQUAL_STRING("ping 1\noutcome 0 ping 1: ok\nfinished 1 ms\n", log_text);
}

void test_no_reply_to_mode_program_ends_the_script(void)
{
    mode_answer = "\n";
    run("@echo off\nping 1\nping 2\n");
    TEST_ASSERT_EQUAL_STRING("echo 0\noutcome 3 ping 1: not sent; no reply to 'mode program' in "
                             "10000 ms, neither 'ok' nor 'error N: text'\nfinished 10001 ms\n",
                             log_text);
    TEST_ASSERT_EQUAL_UINT(2, script_line_number(&script));
}

void test_only_ok_and_error_end_a_reply(void)
{
    answer = "id 1\r\nokay\r\nok\r\n";
    run("scan\n");
    TEST_ASSERT_EQUAL_STRING("scan\noutcome 0 scan: ok\nfinished 1 ms\n", log_text);
}

void test_error_reply_is_reported_and_the_script_goes_on(void)
{
    answer = "error 7: servo absent\n";
    run("ping 1\n@echo off\n");
    TEST_ASSERT_EQUAL_STRING("ping 1\noutcome 1 ping 1: error 7: servo absent\necho 0\n"
                             "finished 1 ms\n",
                             log_text);
}

void test_an_exclamation_mark_expects_an_error(void)
{
    answer = "error 7: servo absent\n";
    run("! ping 77\n");
    TEST_ASSERT_EQUAL_STRING("ping 77\noutcome 0 ping 77: error 7: servo absent\nfinished 1 ms\n",
                             log_text);
}

void test_ok_in_place_of_an_expected_error_is_reported(void)
{
    run("!ping 77\n");
    TEST_ASSERT_EQUAL_STRING("ping 77\noutcome 2 ping 77: ok\nfinished 1 ms\n", log_text);
}

#define TOO_LONG                                                                                   \
    ", neither 'ok' nor 'error N: text'; if it takes longer, write 'within MS' at the end of the " \
    "line\n"

void test_missing_reply_ends_the_script(void)
{
    answer = "thinking\n";
    run("ping 1\nping 2\n");
    TEST_ASSERT_EQUAL_STRING(
        "ping 1\noutcome 3 ping 1: no reply in 10000 ms" TOO_LONG "finished 10001 ms\n", log_text);
}

void test_within_sets_the_time_for_a_reply(void)
{
    answer = "thinking\n";
    run("scan rescue  within 15000 \n");
    TEST_ASSERT_EQUAL_STRING("scan rescue\noutcome 3 scan rescue: no reply in 15000 ms" TOO_LONG
                             "finished 15001 ms\n",
                             log_text);
}

void test_within_sets_the_time_for_an_expected_error(void)
{
    answer = "thinking\n";
    run("! ping 1 within 20\n");
    TEST_ASSERT_EQUAL_STRING(
        "ping 1\noutcome 3 ping 1: no reply in 20 ms" TOO_LONG "finished 21 ms\n", log_text);
}

void test_within_without_milliseconds_is_part_of_a_command(void)
{
    run("ping within 1s\nping within\nwithin 5\n");
    TEST_ASSERT_EQUAL_STRING("ping within 1s\noutcome 0 ping within 1s: ok\n"
                             "ping within\noutcome 0 ping within: ok\n"
                             "within 5\noutcome 0 within 5: ok\nfinished 1 ms\n",
                             log_text);
}

void test_a_firmware_that_never_listens_ends_the_script(void)
{
    ready = false;
    run("ping 1\n");
    TEST_ASSERT_EQUAL_STRING("outcome 3 the firmware never listened\nfinished 10001 ms\n",
                             log_text);
}

void test_lines_with_at_need_no_console(void)
{
    ready = false;
    run("@wait 20\n@fault stuck low 5\n@expect servo 1 ID 1\n@at 12000\n");
    TEST_ASSERT_EQUAL_STRING("fault stuck low 5 at 21 ms\nfinished 12000 ms\n", log_text);
}

void test_console_timeout_begins_at_the_first_command(void)
{
    ready = false;
    run("@wait 12000\nping 1\n@echo on\n");
    TEST_ASSERT_EQUAL_STRING("outcome 3 the firmware never listened\nfinished 22001 ms\n",
                             log_text);
    TEST_ASSERT_EQUAL_UINT(2, script_line_number(&script));
}

void test_actions_act_on_the_simulation(void)
{
    servos.duplicates = true;
    run("@servos 0,1,5-7\n@servos 1,1,1\n@wait 250\n@echo on\n"
        "@fault stuck low 5\n@at 400\n@fault stuck off\n");
    TEST_ASSERT_EQUAL_STRING(
        "servos 5: 0 1 5 6 7\nservos 3: 1 1 1\necho 1\nfault stuck low 5 at 251 ms\n"
        "fault stuck off at 400 ms\nfinished 400 ms\n",
        log_text);
}

void test_wait_may_be_longer_than_the_reply_timeout(void)
{
    run("ping 1\n@wait 20000\nping 2\n");
    TEST_ASSERT_NOT_NULL(strstr(log_text, "finished 20001 ms\n"));
}

void test_print_and_echo_go_to_the_output(void)
{
    char text[128] = "";
    answer = "32\nok\n";
    run("@print Example 2: read\nread 1 43\n@echo on\nread 1 43\n");
    rewind(out);
    text[fread(text, 1, sizeof(text) - 1, out)] = 0;
    TEST_ASSERT_EQUAL_STRING("Example 2: read\n> read 1 43\n32\nok\n", text);
}

/* --- causes --- */

static const struct servo_environment *environment_of(unsigned servo)
{
    return &servos.node[servo - 1].servo.environment;
}

void test_environment_is_set_for_all_or_for_some_servos(void)
{
    run("@supply 9.5\n@supply 2-3 7.4\n@ambient 1,3 60\n@load -300\n@load 2 450\n@block 3 on\n"
        "@power 2 off\n");
    static const struct servo_environment expected[] = {
        {95, 60, -300, false}, {74, 32, 450, false}, {74, 60, -300, true}};
    for (unsigned i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL(expected[i].supply_dV, environment_of(i + 1)->supply_dV);
        TEST_ASSERT_EQUAL(expected[i].ambient_C, environment_of(i + 1)->ambient_C);
        TEST_ASSERT_EQUAL(expected[i].load, environment_of(i + 1)->load);
        TEST_ASSERT_EQUAL(expected[i].blocked, environment_of(i + 1)->blocked);
        TEST_ASSERT_EQUAL(i != 1, servos.node[i].servo.powered);
    }
}

void test_servo_is_named_by_its_place(void)
{
    run("@power 2nd off\n@supply 3rd 7.4\n@load 1st 300\n");
    for (unsigned i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL(i != 1, servos.node[i].servo.powered);
        TEST_ASSERT_EQUAL(i == 2 ? 74 : 120, environment_of(i + 1)->supply_dV);
        TEST_ASSERT_EQUAL(i == 0 ? 300 : 0, environment_of(i + 1)->load);
    }
}

void test_line_without_ids_that_names_an_id_warns(void)
{
    char text[400] = "";
    run("@load 1\n@ambient 3\n@supply 12\n@load 4\n@load 1 1\n");
    rewind(out);
    text[fread(text, 1, sizeof(text) - 1, out)] = 0;
    TEST_ASSERT_NOT_NULL(
        strstr(text, ":1: warning: '@load 1' is for all servos; for servo 1 a value is missing\n"));
    TEST_ASSERT_NOT_NULL(strstr(text, ":2: warning: '@ambient 3' is for all servos; for servo 3"));
    TEST_ASSERT_NULL(strstr(text, ":3: "));
    TEST_ASSERT_NULL(strstr(text, ":4: "));
    TEST_ASSERT_NULL(strstr(text, ":5: "));
}

void test_power_and_block_return(void)
{
    run("@power off\n@block on\n@wait 10\n@power 1 on\n@block 2-3 off\n");
    TEST_ASSERT_TRUE(servos.node[0].servo.powered);
    TEST_ASSERT_FALSE(servos.node[1].servo.powered);
    TEST_ASSERT_TRUE(environment_of(1)->blocked);
    TEST_ASSERT_FALSE(environment_of(3)->blocked);
}

void test_ramp_runs_while_the_scenario_goes_on(void)
{
    run("@supply 2 8.0 over 100\n@load 2 -1000 over 200\n@wait 50\n"
        "@expect servo 2 PRESENT_VOLTAGE 99..101 within 4\n"
        "@expect servo 1 PRESENT_VOLTAGE 120 within 0\n@load 2 77\n@wait 500\n");
    TEST_ASSERT_EQUAL(80, environment_of(2)->supply_dV);
    TEST_ASSERT_EQUAL(77, environment_of(2)->load); // the later line has ended the ramp
    TEST_ASSERT_EQUAL(120, environment_of(1)->supply_dV);
}

void test_a_ramp_is_even_and_ends_in_time(void)
{
    run("@at 10\n@load 1 100 over 100\n@at 60\n@expect servo 1 torque off\n");
    TEST_ASSERT_EQUAL(100, environment_of(1)->load);
    tearDown();
    setUp();
    TEST_ASSERT_TRUE(read_script("@at 10\n@load 1 100 over 100\n@at 200\n"));
    TEST_ASSERT_TRUE(script_start(&script, &schedule, CLOCK, &ops, out));
    for (unsigned ms = 10; ms <= 120; ms += 10) {
        schedule_run_until(&schedule, ms * MS);
        TEST_ASSERT_EQUAL(ms < 110 ? ms - 10 : 100, environment_of(1)->load);
    }
}

void test_new_servos_end_all_ramps(void)
{
    run("@supply 5 over 100\n@wait 10\n@servos 1-3\n@wait 200\n");
    TEST_ASSERT_EQUAL(120, environment_of(1)->supply_dV);
}

/* --- time --- */

void test_at_waits_until_that_time(void)
{
    run("@at 100\n@expect servo 1 torque off within 0\n@at 100\n@at 250\n");
    TEST_ASSERT_EQUAL_STRING("finished 250 ms\n", log_text);
}

void test_at_a_time_in_the_past_fails(void)
{
    run("@at 100\n@wait 50\n@at 120\n@echo on\n");
    TEST_ASSERT_EQUAL_STRING("outcome 4 @at 120: it is 150.000 ms already\nfinished 150 ms\n",
                             log_text);
}

/* --- expectations --- */

static void expect_met(const char *text, const char *end)
{
    char wanted[64];
    setUp();
    run(text);
    snprintf(wanted, sizeof(wanted), "finished %s ms\n", end);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(wanted, log_text, text);
    tearDown();
}

static void expect_unmet(const char *text, const char *seen)
{
    setUp();
    run(text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(log_text, "outcome 4 @expect"), text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(log_text, seen), log_text);
    TEST_ASSERT_NULL_MESSAGE(strstr(log_text, "echo"), "the scenario ends there");
    tearDown();
}

void test_expect_servo_reads_the_state_of_the_servo(void)
{
    tearDown();
    expect_met("@expect servo 1-3 GOAL_POSITION 512\n", "1");
    expect_met("@expect servo 2 0x1E 0\n@expect servo 2 31 2\n", "1"); // bytes by address
    expect_met("@expect servo 1 CCW_ANGLE_LIMIT 1000..0x3FF\n", "1");
    expect_met("@expect servo 3 torque off\n@expect servo 3 led off\n@expect servo 3 error 0\n",
               "1");
    expect_met("@supply 2 5\n@expect servo 2 led blinking\n@expect servo 2 error 0x01\n", "4");
    expect_met("@power 2 off\n@expect servo 2 led off\n", "1");
    expect_unmet("@expect servo 1-3 GOAL_POSITION 513 within 5\n@echo on\n",
                 "not met; seen: servo 1 has 512 (0x200)\nfinished 6 ms");
    expect_unmet("@supply 3 5\n@wait 9\n@expect servo 1-3 error 0 within 7\n@echo on\n",
                 "seen: servo 3 has 1 (0x01)\nfinished 17 ms");
    expect_unmet("@supply 3 5\n@wait 9\n@expect servo 3 led off\n@echo on\n", "finished 1010 ms");
    expect_unmet("@expect servo 1 torque on within 0\n",
                 "seen: servo 1 has torque off\nfinished 1 ms");
    expect_unmet("@expect servo 1 led blinking within 0\n",
                 "seen: servo 1 has led off\nfinished 1 ms");
    setUp();
}

void test_expectation_is_met_within_its_time(void)
{
    tearDown();
    expect_met("@supply 1 5 over 200\n@expect servo 1 PRESENT_VOLTAGE 0..60 within 300\n", "176");
    expect_unmet("@supply 1 5 over 200\n@expect servo 1 PRESENT_VOLTAGE 0..60 within 100\n",
                 "servo 1 has 86");
    setUp();
}

#define PING1 "@send FF FF 01 02 01 FB\n"

void test_packets_are_expected_in_their_order(void)
{
    tearDown();
    expect_met(PING1 "@expect packet in FFFF010201FB\n@expect packet out FF FF 01 02 00 FC\n", "1");
    expect_met(PING1 "@expect packet out FF FF 01 02 .. fc\n@expect packet in .. FF 01 02 01 FB\n",
               "1");
    expect_met(
        "@send FF FF FE 02 06 F9 00\n@wait 1\n@send FF FF FE 04 03 19 01 E0 FF FF 01 02 01 "
        "FB\n@expect packet in FF FF FE 04 03 19 01 E0\n@expect packet in FF FF 01 02 01 FB\n"
        "@expect packet out FF FF 01 02 00 FC\n",
        "2");
    static const char *const wrong[] = {
        "in FF FF 01 02 00 FC",     // from the servo
        "out FF FF 01 02 01 FB",    // from the controller
        "out FF FF 01 02 00",       // too short
        "out FF FF 01 02 00 FC ..", // too long
        "out FF FF 01 02 00 FC!",   // no framing error
    };
    for (unsigned i = 0; i < sizeof(wrong) / sizeof(wrong[0]); i++) {
        char text[120];
        snprintf(text, sizeof(text), PING1 "@expect packet %s\n", wrong[i]);
        expect_unmet(text, wrong[i][0] == 'i' ? "not met; seen: FF FF 01 02 01 FB\n"
                                              : "not met; seen: FF FF 01 02 00 FC\n");
    }
    expect_unmet(PING1 "@expect packet out .. .. .. .. .. ..\n@expect packet out .. within 10\n",
                 "not met; seen: no packet");
    expect_unmet(PING1 "@wait 1\n@expect packet out .. .. .. .. .. .. within 2\n", "no packet");
    setUp();
}

void test_bytes_are_sent_at_the_rate_that_was_set(void)
{
    tearDown();
    expect_met("@baud 57600\n" PING1 "@expect silence 20\n@baud 1000000\n" PING1
               "@expect packet out FF FF 01 02 00 FC\n",
               "22");
    setUp();
}

void test_expect_packet_matches_damaged_bytes(void)
{
    run("@send FF FF 01 02 01 00\n@expect packet in FF FF 01 02 01 00\n"
        "@expect packet out FF FF 01 02 10 EC\n@send 12\n@expect packet in 12\n");
    TEST_ASSERT_EQUAL_STRING("finished 1 ms\n", strstr(log_text, "finished"));
}

void test_silence_is_no_edge_and_a_high_wire(void)
{
    tearDown();
    expect_unmet(PING1 "@expect silence 1\n", "the wire is not silent\nfinished 1 ms");
    expect_met("@power off\n" PING1 "@expect silence 900\n", "901");
    expect_met(PING1 "@wait 1\n@expect silence 900\n", "902");
    setUp();
    driver_set(&adapter.driver, 0, true, false);
    run("@expect silence 10\n");
    TEST_ASSERT_NOT_NULL(strstr(log_text, "the wire is not silent\nfinished 1 ms"));
}

void test_expect_text_searches_the_whole_last_reply(void)
{
    answer = "id 7\nid 9\nok\n";
    run("scan\nscan\n@expect text id 7\n@expect text d 9\n@expect text ok within 0\n");
    TEST_ASSERT_EQUAL_STRING("scan\noutcome 0 scan: ok\nscan\noutcome 0 scan: ok\nfinished 1 ms\n",
                             log_text);
    tearDown();
    setUp();
    answer = "id 7\nok\n";
    run("scan\n@expect text id 8 within 30\n");
    TEST_ASSERT_NOT_NULL(strstr(log_text, "@expect text id 8 within 30: not met; seen: id 7|ok\n"
                                          "finished 31 ms"));
    tearDown();
    setUp();
    answer = "id 7\nok\n";
    run("scan\n@wait 1\n@expect text id 7 within 3\n"); // dropped
    TEST_ASSERT_NOT_NULL(strstr(log_text, "seen: no line of text\n"));
}

void test_expected_breach_is_not_counted(void)
{
    rules_record_breach(&rules, RULE_COLLISION, 0, "a test");
    run("@expect rule collision\n");
    TEST_ASSERT_EQUAL_STRING("finished 1 ms\n", log_text);
    TEST_ASSERT_EQUAL(0, rules_broken(&rules));
    tearDown();
    expect_unmet("@expect rule overrun within 10\n", "seen: it was not broken\nfinished 11 ms");
    setUp();
}

void test_refused_fault_ends_the_scenario(void)
{
    run("@fault baud 9 1\n@echo on\n");
    TEST_ASSERT_EQUAL_STRING("fault baud 9 1 at 1 ms\n"
                             "outcome 4 @fault baud 9 1: no servo has that ID\nfinished 1 ms\n",
                             log_text);
}

void test_show_prints_the_state_of_a_servo(void)
{
    char shown[200] = "";
    table_set(servos.node[1].servo.registers, TABLE_GOAL_POSITION, 2, 0x155);
    run("@show servo 2 GOAL_POSITION\n@show servo 1,3 0x03\n@show servo 1 torque\n");
    rewind(out);
    TEST_ASSERT_TRUE(fread(shown, 1, sizeof(shown) - 1, out) > 0);
    TEST_ASSERT_EQUAL_STRING("servo 2 GOAL_POSITION 341\nservo 1 0x03 1\nservo 3 0x03 3\n"
                             "servo 1 torque off\n",
                             shown);
}

/* --- bad input --- */

void test_bad_lines_are_refused_before_the_run(void)
{
    static const char *const bad[] = {
        "@fly 1\n",
        "@servos\n",
        "@servos 1-\n",
        "@servos 254\n",
        "@servos 5-3\n",
        "@power\n",
        "@power up\n",
        "@wait\n",
        "@wait -5\n",
        "@wait 5s\n",
        "!\n",
        "@\n",
        "@servosx 1-3\n",
        "@echo 1\n",
        "@servos 1,,2\n",
        "@wait 5 6\n",
        "@wait 3600001\n",
        "@at soon\n",
        "@at -1\n",
        "@power 1\n",
        "@power 0th on\n",
        "@power 2nds on\n",
        "@power nd on\n",
        "@power 1 on off\n",
        "@power 254 on\n",
        "@power on over 5\n",
        "@block 1 on over 5\n",
        "@supply\n",
        "@supply 25.6\n",
        "@supply -1\n",
        "@supply -0.5\n",
        "@supply 12.05\n",
        "@supply 12.\n",
        "@supply 1 2 3\n",
        "@supply 12 over\n",
        "@supply 12 over 5s\n",
        "@supply 1 12 over 5 6\n",
        "@supply 12V\n",
        "@supply 1\n",
        "@supply 2.9 over 10\n",
        "@ambient 256\n",
        "@ambient 20.5\n",
        "@load 2047\n",
        "@load 1-2\n",
        "@send\n",
        "@send FF F\n",
        "@send FF ..\n",
        "@send FF!\n",
        "@send xx\n",
        "@baud 0\n",
        "@fault\n",
        "@fault rain\n",
        "@fault stuck\n",
        "@fault flip in\n",
        "@expect\n",
        "@expect rain\n",
        "@expect packet\n",
        "@expect packet FF FF\n",
        "@expect packet in\n",
        "@expect packet in FG\n",
        "@expect packet in FF FF within\n",
        "@expect packet in FF FF within 1.5\n",
        "@expect silence\n",
        "@expect silence 0\n",
        "@expect silence 10 within 5\n",
        "@expect servo 1 LED\n",
        "@expect servo LED 1\n",
        "@expect servo 1 LED 1 2\n",
        "@expect servo 1 GLOW 1\n",
        "@expect servo 1 50 0\n",
        "@expect servo 1 LED -1\n",
        "@expect servo 1 LED 5..4\n",
        "@expect servo 1 LED 1.\n",
        "@expect servo 1 led bright\n",
        "@expect servo 1 led 3\n",
        "@expect servo 1 torque blinking\n",
        "@expect servo 1 error 256\n",
        "@expect servo 1 PRESENT_POSITION 1024\n",
        "@expect servo 1 PRESENT_VOLTAGE 256..300\n",
        "@expect servo 1 LED 1 within -1\n",
        "@expect servo 1 LED 1 within 3600001\n",
        "@expect text\n",
        "@show servo 1\n",
        "@show text LED 1\n",
        "@show servo 1 LED 1\n",
        "@show servo 1 GLOW\n",
        "@show servo 254 LED\n",
        "@expect rule politeness\n",
    };
    for (unsigned i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(read_script(bad[i]), bad[i]);
        script_free(&script);
    }
    TEST_ASSERT_FALSE(script_read(&script, "/no/such/script"));
}

static bool starts(const char *text)
{
    TEST_ASSERT_TRUE_MESSAGE(read_script(text), text);
    bool good = script_start(&script, &schedule, CLOCK, &ops, out);
    tearDown();
    setUp();
    return good;
}

static bool reads_a_send_of(int bytes)
{
    static char text[16 + 1025 * 3];
    size_t size = (size_t)sprintf(text, "@send");
    for (int i = 0; i < bytes; i++) {
        size += (size_t)sprintf(text + size, " FF");
    }
    bool good = read_script(text);
    tearDown();
    setUp();
    return good;
}

void test_no_more_than_1024_bytes_are_sent_by_one_line(void)
{
    TEST_ASSERT_TRUE(reads_a_send_of(1024));
    TEST_ASSERT_FALSE(reads_a_send_of(1025));
}

void test_missing_servos_are_reported_before_the_run(void)
{
    TEST_ASSERT_TRUE(starts("@power 1-3 off\n@servos 7\n@power 7 off\n@expect servo 7 ID 7\n"));
    TEST_ASSERT_FALSE(starts("@load 4 0\n"));
    TEST_ASSERT_TRUE(starts("@power 3rd off\n@servos 7-10\n@power 4th off\n"));
    TEST_ASSERT_FALSE(starts("@power 4th off\n"));
    TEST_ASSERT_FALSE(starts("@servos 7\n@power 2nd off\n"));
    TEST_ASSERT_FALSE(starts("@expect servo 0-1 LED 0\n"));
    TEST_ASSERT_FALSE(starts("@servos 7\n@power 1 off\n"));
}

void test_duplicate_id_needs_allow_duplicates(void)
{
    TEST_ASSERT_FALSE(starts("@servos 3,7,3\n"));
    servos.duplicates = true;
    TEST_ASSERT_TRUE(starts("@servos 3,7,3\n"));
}

void test_missing_functions_are_reported_before_the_run(void)
{
    ops.console_send = 0;
    ops.console_ready = 0;
    TEST_ASSERT_FALSE(starts("ping 1\n"));
    ops.has_text = false;
    TEST_ASSERT_FALSE(starts("@expect text ok\n"));
    ops.bus_send = 0;
    TEST_ASSERT_FALSE(starts("@send FF\n"));
    ops.bus_send = 0;
    TEST_ASSERT_FALSE(starts("@baud 9600\n"));
    ops.fault = 0;
    TEST_ASSERT_FALSE(starts("@fault noise 0\n"));
    ops.reset = 0;
    TEST_ASSERT_FALSE(starts("@reset power\n"));
    ops.reset = 0;
    TEST_ASSERT_FALSE(starts("@hang\n"));
}

void test_line_behind_a_reset_waits_until_it_has_happened(void)
{
    reset_is_late = true;
    run("ping 1\n@reset power\n@echo on\n");
    TEST_ASSERT_EQUAL_STRING(
        "ping 1\noutcome 0 ping 1: ok\nreset 0 in 0 us, write 0 at 0 %, at 1 ms\n", log_text);
    script_was_reset(&script, schedule.now);
    schedule_run_until(&schedule, schedule.now + CLOCK);
    TEST_ASSERT_NOT_NULL(strstr(log_text, "echo 1\n"));
}

void test_resets_and_hangs_are_ordered(void)
{
    run("@reset power\n@wait 5\n@reset external in 2.5\n@reset brown-out write 7 60\n"
        "@reset watchdog\n@hang\n@hang in 20\n");
    TEST_ASSERT_EQUAL_STRING("reset 0 in 0 us, write 0 at 0 %, at 1 ms\n"
                             "reset 1 in 2500 us, write 0 at 0 %, at 6 ms\n"
                             "reset 2 in 0 us, write 7 at 60 %, at 6 ms\n"
                             "reset 3 in 0 us, write 0 at 0 %, at 6 ms\n"
                             "hang 0 in 0 us, write 0 at 0 %, at 6 ms\n"
                             "hang 0 in 20000 us, write 0 at 0 %, at 6 ms\nfinished 6 ms\n",
                             log_text);
}

void test_bad_reset_orders_are_reported_before_the_run(void)
{
    static const char *const bad[] = {
        "@reset\n",
        "@reset noise\n",
        "@reset power on\n",
        "@reset power in\n",
        "@reset power in -1\n",
        "@reset power write 0 5\n",
        "@reset power write 1\n",
        "@reset power write 1 101\n",
        "@reset power at 5\n",
        "@hang 5\n",
        "@hang in\n",
        "@hang in 5 ms\n",
    };
    for (unsigned i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(read_script(bad[i]), bad[i]);
        script_free(&script);
    }
}

/* The reset may come in the middle of a byte of the reply. */
void test_reset_ends_the_wait_for_a_reply(void)
{
    dies = true;
    run("ping 1\nping 2\n");
    TEST_ASSERT_EQUAL_STRING("ping 1\nping 2\noutcome 0 ping 2: ok\nfinished 11 ms\n", log_text);
    TEST_ASSERT_EQUAL_UINT(2, modes);
}

void test_firmware_deaf_after_a_reset_ends_the_script(void)
{
    dies = for_good = true;
    run("ping 1\nping 2\n");
    TEST_ASSERT_EQUAL_STRING("ping 1\noutcome 3 the firmware never listened\nfinished 10001 ms\n",
                             log_text);
}

void test_without_a_console_the_scenario_begins_at_once(void)
{
    ops.console_send = 0;
    ops.console_ready = 0;
    run("@send FF\n@echo on\n");
    TEST_ASSERT_EQUAL_STRING("echo 1\nfinished 0 ms\n", log_text);
}

static void start_empty(void)
{
    memset(&script, 0, sizeof(script));
    script_start_empty(&script, &schedule, CLOCK, &ops, out);
}

/* Returns what is wrong with the order; "" if it runs. Then simulates 60 s. */
static const char *order(const char *text)
{
    static char what[SCRIPT_WHAT_SIZE];
    log_text[0] = 0;
    const char *wrong = script_order(&script, schedule.now, text, what);
    schedule_run_until(&schedule, schedule.now + (uint64_t)CLOCK * 60);
    return wrong ? wrong : "";
}

void test_orders_run_one_after_the_other(void)
{
    start_empty();
    TEST_ASSERT_EQUAL_STRING("", order("load 1 100"));
    TEST_ASSERT_EQUAL_STRING("finished 0 ms\n", log_text);
    TEST_ASSERT_EQUAL(100, environment_of(1)->load);
    TEST_ASSERT_EQUAL_STRING("", order(" \t@load 1 200 over 100 "));
    TEST_ASSERT_EQUAL_STRING("finished 60000 ms\n", log_text);
    TEST_ASSERT_EQUAL(200, environment_of(1)->load);
    TEST_ASSERT_EQUAL_STRING("", order("wait 1000"));
    TEST_ASSERT_EQUAL_STRING("finished 121000 ms\n", log_text);
    TEST_ASSERT_EQUAL_STRING("", order("servos 7"));
    TEST_ASSERT_EQUAL_STRING("", order("load 7 300"));
    TEST_ASSERT_EQUAL(300, environment_of(1)->load); // the first servo is servo 7 now
}

void test_wrong_orders_are_named_and_do_not_run(void)
{
    static const char *const orders[][2] = {
        {"load 4 100", "there is no servo 4; there: 1-3"},
        {"power 4th off", "@power 4th off: there are 3 servos"},
        {"load 1 many", "a load is wanted, -2046 to 2046 (1023: stall)"},
        {"servos 1,1", "an ID occurs twice, and there is no --allow-duplicates"},
        {"@@load 1 100",
         "unknown @ command; there are @servos @power @supply @ambient @load @block "
         "@fault @reset @hang @wait @at @send @baud @expect @show @print @echo"},
    };
    start_empty();
    for (unsigned i = 0; i < sizeof(orders) / sizeof(orders[0]); i++) {
        TEST_ASSERT_EQUAL_STRING(orders[i][1], order(orders[i][0]));
        TEST_ASSERT_EQUAL_STRING("", log_text);
    }
    TEST_ASSERT_EQUAL(0, environment_of(1)->load);
}

void test_order_that_fails_has_an_outcome_and_the_next_runs(void)
{
    start_empty();
    TEST_ASSERT_EQUAL_STRING("", order("expect servo 1 torque on within 10"));
    TEST_ASSERT_EQUAL_STRING("outcome 4 @expect servo 1 torque on within 10: not met; seen: "
                             "servo 1 has torque off\nfinished 10 ms\n",
                             log_text);
    TEST_ASSERT_EQUAL_STRING("", order("expect servo 1 torque off"));
    TEST_ASSERT_EQUAL_STRING("finished 60000 ms\n", log_text);
}

void test_cancelled_order_never_finishes(void)
{
    char what[SCRIPT_WHAT_SIZE];
    start_empty();
    TEST_ASSERT_NULL(script_order(&script, 0, "expect servo 1 torque on within 1000", what));
    schedule_run_until(&schedule, 10 * MS);
    script_cancel(&script);
    schedule_run_until(&schedule, 2000 * MS);
    TEST_ASSERT_EQUAL_STRING("", log_text);
    TEST_ASSERT_EQUAL_STRING("", order("print next"));
    TEST_ASSERT_EQUAL_STRING("finished 2000 ms\n", log_text);
}

void test_longest_send_fits_into_an_order(void)
{
    char text[8 + 3 * SCENARIO_SEND_MAX] = "send";
    for (unsigned i = 0; i < SCENARIO_SEND_MAX; i++) {
        strcpy(text + 4 + 3 * i, " 55");
    }
    start_empty();
    TEST_ASSERT_EQUAL_STRING("", order(text));
    TEST_ASSERT_EQUAL_STRING("finished 10 ms\n", log_text);
}

void test_lists_of_ids(void)
{
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    TEST_ASSERT_NULL(ids_parse("1-18", false, ids, &count));
    TEST_ASSERT_EQUAL_UINT(18, count);
    TEST_ASSERT_EQUAL_UINT8(18, ids[17]);
    TEST_ASSERT_NULL(ids_parse("0-253", false, ids, &count));
    TEST_ASSERT_EQUAL_UINT(254, count);
    TEST_ASSERT_NULL(ids_parse("7,3,7", true, ids, &count));
    TEST_ASSERT_NOT_NULL(ids_parse("7,3,7", false, ids, &count));
    TEST_ASSERT_NOT_NULL(ids_parse("0-253,1", true, ids, &count));
    TEST_ASSERT_NOT_NULL(ids_parse("99999999999999999999", true, ids, &count));
}
