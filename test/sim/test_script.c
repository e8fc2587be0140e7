/* The script runner against a firmware that is four lines of C, and lists of IDs. */
#include "script.h"
#include "unity.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CLOCK 16000000u
#define MS    (CLOCK / 1000)

static struct schedule schedule;
static struct script script;
static struct script_world world;
static char path[64];
static char log_text[1024]; // what happened, one word or line after the other
static char said[256];
static const char *answer; // to every command; 0: none
static bool ready;
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

static bool is_ready(void *owner)
{
    (void)owner;
    return ready;
}

static void say(void *owner, uint64_t now, const char *bytes, size_t size)
{
    (void)owner;
    strncat(said, bytes, size);
    if (strchr(said, '\n')) {
        note("%s", said);
        said[0] = 0;
        for (const char *c = answer; c && *c; c++) {
            script_hear(&script, now, (uint8_t)*c);
        }
    }
}

static void servos(void *owner, uint64_t now, const uint8_t *ids, unsigned count)
{
    (void)owner;
    (void)now;
    note("servos %u:", count);
    for (unsigned i = 0; i < count; i++) {
        note(" %u", ids[i]);
    }
    note("\n");
}

static void power(void *owner, uint64_t now, bool on)
{
    (void)owner;
    (void)now;
    note("power %d\n", on);
}

static void echo(void *owner, bool on)
{
    (void)owner;
    note("echo %d\n", on);
}

static void outcome(void *owner, uint64_t now, enum script_outcome what, const char *text)
{
    (void)owner;
    (void)now;
    note("outcome %d %s\n", what, text);
}

static void finished(void *owner, uint64_t now)
{
    (void)owner;
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
    script_start(&script, &schedule, CLOCK, &world, out);
    schedule_run_until(&schedule, (uint64_t)CLOCK * 60);
}

void setUp(void)
{
    snprintf(path, sizeof(path), "/tmp/test_script.XXXXXX");
    close(mkstemp(path));
    out = tmpfile();
    schedule_init(&schedule);
    world = (struct script_world){&schedule, is_ready, say, servos, power, echo, outcome, finished};
    log_text[0] = said[0] = 0;
    answer = "ok\n";
    ready = true;
    TEST_ASSERT_NOT_NULL(freopen("/dev/null", "w", stderr));
}

void tearDown(void)
{
    script_free(&script);
    schedule_free(&schedule);
    fclose(out);
    unlink(path);
}

void test_lines_are_said_one_after_the_other(void)
{
    run("# comment\n\nping 1\n  ping 2  \n");
    TEST_ASSERT_EQUAL_STRING("ping 1\noutcome 0 ping 1: ok\nping 2\noutcome 0 ping 2: ok\n"
                             "finished 1 ms\n",
                             log_text);
}

void test_only_ok_and_error_end_a_reply(void)
{
    answer = "id 1\r\nokay\r\nok\r\n";
    run("scan\n");
    TEST_ASSERT_EQUAL_STRING("scan\noutcome 0 scan: ok\nfinished 1 ms\n", log_text);
}

void test_an_error_is_told_and_the_script_goes_on(void)
{
    answer = "error 7: servo absent\n";
    run("ping 1\n@power off\n");
    TEST_ASSERT_EQUAL_STRING("ping 1\noutcome 1 ping 1: error 7: servo absent\npower 0\n"
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

void test_an_ok_that_should_be_an_error_is_told(void)
{
    run("!ping 77\n");
    TEST_ASSERT_EQUAL_STRING("ping 77\noutcome 2 ping 77: ok\nfinished 1 ms\n", log_text);
}

void test_a_reply_that_never_comes_ends_the_script(void)
{
    answer = "thinking\n";
    run("ping 1\nping 2\n");
    TEST_ASSERT_EQUAL_STRING("ping 1\noutcome 3 ping 1\nfinished 10001 ms\n", log_text);
}

void test_a_firmware_that_never_listens_ends_the_script(void)
{
    ready = false;
    run("ping 1\n");
    TEST_ASSERT_EQUAL_STRING("outcome 3 the firmware never listened\nfinished 10000 ms\n",
                             log_text);
}

void test_actions_act_on_the_simulation(void)
{
    run("@servos 0,1,5-7\n@servos 1,1,1\n@power off\n@wait 250\n@power on\n@echo on\n");
    TEST_ASSERT_EQUAL_STRING("servos 5: 0 1 5 6 7\nservos 3: 1 1 1\npower 0\npower 1\necho 1\n"
                             "finished 251 ms\n",
                             log_text);
}

void test_a_wait_may_be_longer_than_the_patience(void)
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

void test_bad_lines_are_refused_before_anything_runs(void)
{
    static const char *const bad[] = {
        "@fly 1\n", "@servos\n",   "@servos 1-\n",   "@servos 254\n", "@servos 5-3\n",
        "@power\n", "@power up\n", "@wait\n",        "@wait -5\n",    "@wait 5s\n",
        "!\n",      "@\n",         "@servosx 1-3\n", "@echo 1\n",     "@servos 1,,2"};
    for (unsigned i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(read_script(bad[i]), bad[i]);
        script_free(&script);
    }
    TEST_ASSERT_FALSE(script_read(&script, "/no/such/script"));
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
