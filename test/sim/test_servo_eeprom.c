/* SPDX-License-Identifier: MIT */
/* EEPROM areas in files. */
#include "servo/servo_eeprom.h"
#include "unity.h"

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#define CLOCK 16000000u

static struct schedule schedule;
static struct net net;
static struct servos servos;
static struct servo_eeprom state;
static char folder[] = "/tmp/test_state_XXXXXX";

static void start(const uint8_t *ids, unsigned count)
{
    schedule_init(&schedule);
    net_init(&net);
    servos_init(&servos, &schedule, &net, CLOCK);
    TEST_ASSERT_TRUE(servo_eeprom_init(&state, folder, 0, &servos));
    servos_replace(&servos, 0, ids, count);
}

static void stop(void)
{
    servos_free(&servos);
    schedule_free(&schedule);
}

static const uint8_t ids[] = {1, 2, 2};

void setUp(void)
{
    memcpy(folder + sizeof(folder) - 7, "XXXXXX", 6);
    TEST_ASSERT_NOT_NULL(mkdtemp(folder));
    start(ids, 3);
    TEST_ASSERT_TRUE(servo_eeprom_load(&state));
}

static unsigned files(bool remove_them)
{
    unsigned count = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *entry; (entry = readdir(dir)) != 0;) {
        char path[600];
        snprintf(path, sizeof(path), "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] != '.') {
            count++;
            if (remove_them) {
                unlink(path);
            }
        }
    }
    closedir(dir);
    return count;
}

void tearDown(void)
{
    stop();
    files(true);
    rmdir(folder);
}

static uint8_t *registers(unsigned index)
{
    return servos.node[index].servo.registers;
}

static void restart(void)
{
    stop();
    start(ids, 3);
}

static void write_file(const char *name, const char *text)
{
    char path[600];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    fputs(text, file);
    fclose(file);
}

static void read_file(const char *name, char text[200])
{
    char path[600];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL(file);
    text[fread(text, 1, 199, file)] = 0;
    fclose(file);
}

void test_unchanged_servo_has_no_file(void)
{
    servo_eeprom_save(&state);
    TEST_ASSERT_EQUAL_UINT(0, files(false));
}

void test_the_eeprom_area_comes_back_and_the_ram_area_does_not(void)
{
    registers(0)[TABLE_ID] = 9;
    registers(0)[TABLE_CCW_LIMIT] = 0x12;
    registers(0)[TABLE_LED] = 1;
    servo_eeprom_save(&state);
    restart();
    TEST_ASSERT_TRUE(servo_eeprom_load(&state));
    TEST_ASSERT_EQUAL_UINT8(9, registers(0)[TABLE_ID]);
    TEST_ASSERT_EQUAL_HEX8(0x12, registers(0)[TABLE_CCW_LIMIT]);
    TEST_ASSERT_EQUAL_UINT8(0, registers(0)[TABLE_LED]);
    TEST_ASSERT_EQUAL_UINT8(2, registers(1)[TABLE_ID]);
}

void test_receiver_has_the_kept_rate(void)
{
    registers(0)[TABLE_BAUD] = 34;
    servos.node[0].servo.saved_baud = 34;
    servo_eeprom_save(&state);
    restart();
    TEST_ASSERT_TRUE(servo_eeprom_load(&state));
    TEST_ASSERT_EQUAL_UINT8(34, servos.node[0].baud);
    TEST_ASSERT_EQUAL_UINT(1, servos.receivers[34]->users);
}

void test_servos_of_same_id_have_a_file_each(void)
{
    registers(1)[TABLE_ALARM_LED] = 1;
    registers(2)[TABLE_ALARM_LED] = 2;
    servo_eeprom_save(&state);
    TEST_ASSERT_EQUAL_UINT(2, files(false));
    restart();
    TEST_ASSERT_TRUE(servo_eeprom_load(&state));
    TEST_ASSERT_EQUAL_UINT8(1, registers(1)[TABLE_ALARM_LED]);
    TEST_ASSERT_EQUAL_UINT8(2, registers(2)[TABLE_ALARM_LED]);
}

void test_changes_are_saved_four_times_a_second(void)
{
    registers(0)[TABLE_ID] = 9;
    schedule_run_until(&schedule, CLOCK / 4 - 1);
    TEST_ASSERT_EQUAL_UINT(0, files(false));
    schedule_run_until(&schedule, CLOCK / 4);
    TEST_ASSERT_EQUAL_UINT(1, files(false));
    registers(1)[TABLE_ID] = 8;
    schedule_run_until(&schedule, CLOCK / 2);
    TEST_ASSERT_EQUAL_UINT(2, files(false));
}

void test_the_file_is_one_line_of_text(void)
{
    char text[200];
    registers(0)[TABLE_ID] = 9;
    servo_eeprom_save(&state);
    read_file("bus0-servo001.eeprom", text);
    TEST_ASSERT_EQUAL_STRING("CDS55xx EEPROM 00 01 01 09 01 01 00 00 FF 03 00 50 3C A0 FF 03 02 25 "
                             "04 00 00 00 00 00 CRC 9323\n",
                             text);
}

void test_damage_to_any_character_is_detected(void)
{
    char good[200];
    registers(0)[TABLE_ID] = 9;
    servo_eeprom_save(&state);
    read_file("bus0-servo001.eeprom", good);
    FILE *kept = stderr;
    stderr = fopen("/dev/null", "w");
    unsigned unnoticed = 0;
    for (unsigned i = 0; i < strlen(good); i++) {
        char bad[200];
        strcpy(bad, good);
        bad[i] = bad[i] == '5' ? '6' : '5';
        write_file("bus0-servo001.eeprom", bad);
        restart();
        unnoticed += servo_eeprom_load(&state);
        bad[i] = 0; // cut
        write_file("bus0-servo001.eeprom", bad);
        restart();
        unnoticed += servo_eeprom_load(&state);
    }
    fclose(stderr);
    stderr = kept;
    TEST_ASSERT_EQUAL_UINT(0, unnoticed);
}

void test_impossible_values_with_a_right_checksum_are_refused(void)
{
    char text[200];
    registers(0)[TABLE_ID] = 254;
    servo_eeprom_save(&state);
    read_file("bus0-servo001.eeprom", text);
    TEST_ASSERT_NOT_NULL(strstr(text, "FE"));
    restart();
    FILE *kept = stderr;
    stderr = fopen("/dev/null", "w");
    bool loaded = servo_eeprom_load(&state);
    fclose(stderr);
    stderr = kept;
    TEST_ASSERT_FALSE(loaded);
}

void test_impossible_folder_is_reported(void)
{
    struct servo_eeprom other;
    char path[600];
    write_file("file", "");
    snprintf(path, sizeof(path), "%s/file", folder);
    FILE *kept = stderr;
    stderr = fopen("/dev/null", "w");
    bool good = servo_eeprom_init(&other, path, 0, &servos);
    fclose(stderr);
    stderr = kept;
    TEST_ASSERT_FALSE(good);
}

void test_failed_write_is_reported_and_keeps_the_old_file(void)
{
    char text[200];
    struct rlimit limit;
    registers(0)[TABLE_ID] = 9;
    servo_eeprom_save(&state);
    TEST_ASSERT_EQUAL_INT(0, getrlimit(RLIMIT_FSIZE, &limit));
    rlim_t size = limit.rlim_cur;
    signal(SIGXFSZ, SIG_IGN);
    limit.rlim_cur = 10; // bytes of a file: less than the text needs
    TEST_ASSERT_EQUAL_INT(0, setrlimit(RLIMIT_FSIZE, &limit));
    registers(0)[TABLE_ID] = 10;
    FILE *kept = stderr;
    stderr = fopen("/dev/null", "w");
    servo_eeprom_save(&state);
    fclose(stderr);
    stderr = kept;
    limit.rlim_cur = size;
    TEST_ASSERT_EQUAL_INT(0, setrlimit(RLIMIT_FSIZE, &limit));
    TEST_ASSERT_TRUE(state.failed);
    TEST_ASSERT_EQUAL_UINT(1, files(false)); // the new file was removed
    read_file("bus0-servo001.eeprom", text);
    TEST_ASSERT_NOT_NULL(strstr(text, "00 01 01 09"));
}

void test_without_a_folder_no_file_is_written(void)
{
    struct servo_eeprom none;
    TEST_ASSERT_TRUE(servo_eeprom_init(&none, 0, 0, &servos));
    registers(0)[TABLE_ID] = 9;
    TEST_ASSERT_TRUE(servo_eeprom_load(&none));
    servo_eeprom_save(&none);
    TEST_ASSERT_EQUAL_UINT8(9, registers(0)[TABLE_ID]);
}

void test_unchanged_servo_is_not_written_again(void)
{
    registers(0)[TABLE_ID] = 9;
    servo_eeprom_save(&state);
    TEST_ASSERT_EQUAL_UINT(1, files(true));
    servo_eeprom_save(&state);
    TEST_ASSERT_EQUAL_UINT(0, files(false));
}
