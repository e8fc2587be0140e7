/* SPDX-License-Identifier: MIT */
/* Files of the user: read as a whole, written as a whole, or one line on stderr. */
#include "output/files.h"
#include "unity.h"

#include <dirent.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];
static char path[128];
static FILE *kept_stderr;

void setUp(void)
{
    strcpy(folder, "/tmp/test_files.XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/file", folder);
    signal(SIGXFSZ, SIG_IGN);
    kept_stderr = stderr;
    stderr = fopen("/dev/null", "w");
}

void tearDown(void)
{
    char command[128];
    fclose(stderr);
    stderr = kept_stderr;
    snprintf(command, sizeof(command), "rm -r %s", folder);
    TEST_ASSERT_EQUAL_INT(0, system(command));
}

/* From now on files can grow to `bytes`: simulates a full disk. */
static void limit_files(rlim_t bytes)
{
    struct rlimit limit;
    TEST_ASSERT_EQUAL_INT(0, getrlimit(RLIMIT_FSIZE, &limit));
    limit.rlim_cur = bytes < limit.rlim_max ? bytes : limit.rlim_max;
    TEST_ASSERT_EQUAL_INT(0, setrlimit(RLIMIT_FSIZE, &limit));
}

static void put(const char *text, size_t size)
{
    FILE *file = fopen(path, "w");
    TEST_ASSERT_EQUAL_UINT(size, fwrite(text, 1, size, file));
    fclose(file);
}

static unsigned count_files(void)
{
    unsigned count = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *entry; (entry = readdir(dir)) != 0;) {
        count += entry->d_name[0] != '.';
    }
    closedir(dir);
    return count;
}

static void assert_content(const char *wanted)
{
    char *text = files_read_text(path);
    TEST_ASSERT_EQUAL_STRING(wanted, text);
    free(text);
}

void test_text_is_read_whole(void)
{
    put("", 0);
    assert_content("");
    put("two\nlines", 9);
    assert_content("two\nlines");
}

void test_long_text_is_read_up_to_the_limit(void)
{
    size_t size = FILES_TEXT_MIB * 1024u * 1024u;
    char *much = malloc(size + 1);
    memset(much, 'x', size + 1);
    put(much, size);
    char *text = files_read_text(path);
    TEST_ASSERT_EQUAL_UINT(size, strlen(text));
    free(text);
    put(much, size + 1);
    TEST_ASSERT_NULL(files_read_text(path));
    free(much);
}

void test_file_that_is_no_text_is_refused(void)
{
    TEST_ASSERT_NULL(files_read_text(path)); // missing
    TEST_ASSERT_NULL(files_read_text(folder));
    put("a\0b", 3);
    TEST_ASSERT_NULL(files_read_text(path));
}

void test_close_of_good_stream_is_true(void)
{
    FILE *file = fopen(path, "w");
    fputs("text", file);
    TEST_ASSERT_TRUE(files_close(file, path));
    assert_content("text");
    TEST_ASSERT_TRUE(files_close(0, path));
}

void test_close_after_an_earlier_error_is_false(void)
{
    FILE *file = fopen(path, "w");
    setvbuf(file, 0, _IONBF, 0);
    limit_files(10);
    fputs("more than ten bytes", file);
    limit_files(RLIM_INFINITY);
    fputs("room again", file);
    TEST_ASSERT_FALSE(files_close(file, path));
}

void test_close_that_cannot_write_the_rest_is_false(void)
{
    FILE *file = fopen("/dev/full", "w");
    fputs("text", file);
    TEST_ASSERT_FALSE(files_close(file, "/dev/full"));
}

void test_replace_puts_new_and_changed_content(void)
{
    TEST_ASSERT_TRUE(files_replace(path, "old", 3, false));
    assert_content("old");
    TEST_ASSERT_TRUE(files_replace(path, "newer", 5, true));
    assert_content("newer");
    TEST_ASSERT_EQUAL_UINT(1, count_files());
}

void test_replace_that_fails_leaves_the_old_content(void)
{
    TEST_ASSERT_TRUE(files_replace(path, "old", 3, true));
    limit_files(4);
    TEST_ASSERT_FALSE(files_replace(path, "newer", 5, true));
    limit_files(RLIM_INFINITY);
    assert_content("old");
    TEST_ASSERT_EQUAL_UINT(1, count_files());
}

void test_replace_in_the_working_folder_needs_no_slash(void)
{
    char before[256];
    TEST_ASSERT_NOT_NULL(getcwd(before, sizeof(before)));
    TEST_ASSERT_EQUAL_INT(0, chdir(folder));
    TEST_ASSERT_TRUE(files_check_replaceable("file"));
    bool good = files_replace("file", "text", 4, true);
    TEST_ASSERT_EQUAL_INT(0, chdir(before));
    TEST_ASSERT_TRUE(good);
    assert_content("text");
}

void test_replace_replaces_a_link_and_not_its_target(void)
{
    char target[128];
    struct stat found;
    snprintf(target, sizeof(target), "%s/target", folder);
    TEST_ASSERT_EQUAL_INT(0, symlink(target, path));
    TEST_ASSERT_FALSE(files_check_replaceable(path));
    TEST_ASSERT_TRUE(files_replace(path, "text", 4, true));
    TEST_ASSERT_EQUAL_INT(-1, access(target, F_OK));
    TEST_ASSERT_EQUAL_INT(0, lstat(path, &found));
    TEST_ASSERT_TRUE(S_ISREG(found.st_mode));
}
