/* SPDX-License-Identifier: MIT */
#include "output/vcd.h"
#include "unity.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static struct vcd vcd;
static char path[64];
static char text[4096];

void setUp(void)
{
    snprintf(path, sizeof(path), "/tmp/test_vcd.XXXXXX");
    close(mkstemp(path));
    TEST_ASSERT_TRUE(vcd_open(&vcd, path, 16000000));
}

void tearDown(void)
{
    vcd_close(&vcd);
    unlink(path);
}

static const char *written(void)
{
    TEST_ASSERT_TRUE(vcd_close(&vcd));
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL(file);
    text[fread(text, 1, sizeof(text) - 1, file)] = 0;
    fclose(file);
    return text;
}

void test_a_dump_of_two_signals(void)
{
    unsigned wire = vcd_signal(&vcd, "wire", 1);
    unsigned vector = vcd_signal(&vcd, "vector", 8);
    vcd_change(&vcd, wire, 16, 1);
    vcd_change(&vcd, vector, 16, 32);
    vcd_change(&vcd, wire, 17, 0);
    TEST_ASSERT_EQUAL_STRING("$timescale 100 ps $end\n"
                             "$scope module cds55xx $end\n"
                             "$var wire 1 !! wire $end\n"
                             "$var wire 8 \"! vector $end\n"
                             "$upscope $end\n"
                             "$enddefinitions $end\n"
                             "#0\n0!!\nb00000000 \"!\n"
                             "#10000\n1!!\nb00100000 \"!\n"
                             "#10625\n0!!\n",
                             written());
}

/* The changes are in a temporary file until the dump is closed. */
void test_full_temporary_file_fails_the_close(void)
{
    struct rlimit limit;
    TEST_ASSERT_EQUAL_INT(0, getrlimit(RLIMIT_FSIZE, &limit));
    rlim_t before = limit.rlim_cur;
    unsigned vector = vcd_signal(&vcd, "vector", 8);
    signal(SIGXFSZ, SIG_IGN);
    limit.rlim_cur = 1000;
    setrlimit(RLIMIT_FSIZE, &limit);
    for (unsigned i = 1; i < 1000; i++) {
        vcd_change(&vcd, vector, i, i % 2);
    }
    limit.rlim_cur = before; // the disk has space again
    setrlimit(RLIMIT_FSIZE, &limit);
    FILE *kept = stderr;
    stderr = fopen("/dev/null", "w");
    bool good = vcd_close(&vcd);
    fclose(stderr);
    stderr = kept;
    TEST_ASSERT_FALSE(good);
}

void test_unchanged_value_is_not_written(void)
{
    unsigned wire = vcd_signal(&vcd, "wire", 1);
    vcd_change(&vcd, wire, 5, 0);
    TEST_ASSERT_NULL(strstr(written(), "#3125"));
}

void test_same_name_is_the_same_signal(void)
{
    TEST_ASSERT_EQUAL_UINT(vcd_signal(&vcd, "servo1", 1), vcd_signal(&vcd, "servo1", 1));
    TEST_ASSERT_NOT_EQUAL(vcd_signal(&vcd, "servo1", 1), vcd_signal(&vcd, "servo2", 1));
}

void test_time_stamps_never_decrease(void)
{
    unsigned wire = vcd_signal(&vcd, "wire", 1);
    vcd_change(&vcd, wire, 100, 1);
    vcd_change(&vcd, wire, 99, 0);
    TEST_ASSERT_NOT_NULL(strstr(written(), "#62500\n1!!\n0!!\n"));
}

void test_without_a_file_nothing_happens(void)
{
    struct vcd none = {0};
    vcd_change(&none, vcd_signal(&none, "wire", 1), 5, 1);
    TEST_ASSERT_TRUE(vcd_close(&none));
}

void test_a_file_that_cannot_be_written_is_refused(void)
{
    struct vcd none;
    TEST_ASSERT_NOT_NULL(freopen("/dev/null", "w", stderr));
    TEST_ASSERT_FALSE(vcd_open(&none, "/no/such/folder/x.vcd", 16000000));
}
