/* SPDX-License-Identifier: MIT */
#include "board.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define VALUE_SIZE            64
#define LINE_SIZE             256
#define BOARDS_SIZE           512
#define CLOCK_IF_NOT_GIVEN_HZ 16000000

/* The text of one data file and its path, for messages. */
struct source {
    char path[BOARD_PATH_SIZE];
    FILE *file;
    unsigned line; // line of the latest word that was found
    bool good;     // nothing has been missing so far
};

static bool is_path(const char *name)
{
    return strpbrk(name, "./") != 0;
}

static bool is_folder(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

void board_paths(const char *folder, const char *name, char wiring[BOARD_PATH_SIZE],
                 char chip[BOARD_PATH_SIZE])
{
    if (!is_path(name)) {
        snprintf(wiring, BOARD_PATH_SIZE, "%s/%s/board.h", folder, name);
    } else {
        snprintf(wiring, BOARD_PATH_SIZE, "%s%s", name, is_folder(name) ? "/board.h" : "");
    }
    const char *slash = strrchr(wiring, '/');
    snprintf(chip, BOARD_PATH_SIZE, "%.*sboard.mk", (int)(slash ? slash - wiring + 1 : 0), wiring);
}

/* Returns 0, or what is wrong. Checks the type before fopen(), which would wait at a pipe. */
static const char *open_path(struct source *source)
{
    struct stat what;
    if (stat(source->path, &what) != 0) {
        return strerror(errno);
    }
    if (!S_ISREG(what.st_mode)) {
        return "is no regular file";
    }
    if (what.st_size > BOARD_FILE_KIB * 1024) {
        return "longer than 256 KiB";
    }
    source->file = fopen(source->path, "r");
    source->good = source->file != 0;
    return source->good ? 0 : strerror(errno);
}

/* Finds the word after `key`, in lines `#define KEY WORD`, `KEY := WORD`, `KEY = WORD` or `KEY ?=
 * WORD`. A blank of the formats stands for any number of blanks, or none. */
static bool has_word(struct source *source, const char *key, char *word)
{
    char line[LINE_SIZE];
    char name[LINE_SIZE];
    rewind(source->file);
    for (source->line = 1; fgets(line, sizeof(line), source->file); source->line++) {
        bool found = sscanf(line, " # define %255s %63s", name, word) == 2 ||
                     sscanf(line, " %255[A-Za-z0-9_] :=%63s", name, word) == 2 ||
                     sscanf(line, " %255[A-Za-z0-9_] =%63s", name, word) == 2 ||
                     sscanf(line, " %255[A-Za-z0-9_] ?=%63s", name, word) == 2;
        if (found && strcmp(name, key) == 0) {
            return true;
        }
    }
    word[0] = 0;
    return false;
}

static bool find_word(struct source *source, const char *key, char *word)
{
    bool found = has_word(source, key, word);
    if (!found && source->good) {
        fprintf(stderr, "%s: %s is missing\n", source->path, key);
    }
    source->good = source->good && found;
    return found;
}

/* Reports only the first error of a file. `wanted` continues "use ". */
static void complain(struct source *source, const char *key, const char *word, const char *wanted)
{
    if (source->good) {
        fprintf(stderr, "%s:%u: %s: \"%s\" is not valid: use %s\n", source->path, source->line, key,
                word, wanted);
    }
    source->good = false;
}

/* Parses an integer constant of C: decimal, octal or hexadecimal, with U or L after it
 * (16000000UL). strtoul() alone would accept -18446744073709551615 as 1. */
static bool parse_number(const char *word, uint32_t min, uint32_t max, uint32_t *value)
{
    char *end = 0;
    errno = 0;
    unsigned long number = isdigit((unsigned char)word[0]) ? strtoul(word, &end, 0) : 0;
    if (!end || end[strspn(end, "UL")] != 0 || errno || number < min || number > max) {
        return false;
    }
    *value = (uint32_t)number;
    return true;
}

/* Returns `min` if the value is missing or out of range, so the caller stays within its arrays.
 * source->good is false then. */
static uint32_t number(struct source *source, const char *key, uint32_t min, uint32_t max)
{
    char word[VALUE_SIZE];
    char wanted[VALUE_SIZE];
    uint32_t value = min;
    if (find_word(source, key, word) && !parse_number(word, min, max, &value)) {
        snprintf(wanted, sizeof(wanted), "a whole number from %" PRIu32 " to %" PRIu32, min, max);
        complain(source, key, word, wanted);
    }
    return value;
}

static struct board_pin pin(struct source *source, unsigned bus, const char *name)
{
    char key[VALUE_SIZE];
    char word[VALUE_SIZE];
    struct board_pin pin = {0};
    snprintf(key, sizeof(key), "BOARD_BUS%u_%s_PORT", bus, name);
    if (find_word(source, key, word)) {
        pin.port = word[0];
        if (word[0] < 'A' || word[0] > 'L' || word[1] != 0) {
            complain(source, key, word, "one letter from A to L");
        }
    }
    snprintf(key, sizeof(key), "BOARD_BUS%u_%s_BIT", bus, name);
    pin.bit = (uint8_t)number(source, key, 0, 7);
    return pin;
}

static enum board_wiring read_circuit(struct source *source, unsigned index)
{
    static const char *const names[BOARD_WIRINGS] = {"TWO_ENABLES", "ONE_ENABLE", "TIED", "ADAPTER",
                                                     "ADAPTER_ECHO"};
    char key[VALUE_SIZE];
    char word[VALUE_SIZE];
    snprintf(key, sizeof(key), "BOARD_BUS%u_WIRING", index);
    if (!has_word(source, key, word)) {
        return BOARD_TWO_ENABLES;
    }
    for (int i = 0; i < BOARD_WIRINGS; i++) {
        if (strcmp(word, names[i]) == 0) {
            return (enum board_wiring)i;
        }
    }
    complain(source, key, word, "TWO_ENABLES, ONE_ENABLE, TIED, ADAPTER or ADAPTER_ECHO");
    return BOARD_TWO_ENABLES;
}

static void read_bus(struct board_bus *bus, struct source *source, unsigned index)
{
    char key[VALUE_SIZE];
    snprintf(key, sizeof(key), "BOARD_BUS%u_USART", index);
    bus->usart = number(source, key, 0, 3);
    bus->wiring = read_circuit(source, index);
    if (bus->wiring == BOARD_TWO_ENABLES) {
        bus->tx_enable = pin(source, index, "TX_ENABLE");
        bus->rx_enable = pin(source, index, "RX_ENABLE");
    } else if (bus->wiring == BOARD_ONE_ENABLE) {
        bus->tx_enable = pin(source, index, "ENABLE");
    }
    bus->txd = pin(source, index, "TXD");
    bus->rxd = pin(source, index, "RXD");
}

/* A USART can have one use only. */
static void take_usart(struct source *source, const char *key, unsigned usart, unsigned *used)
{
    char word[VALUE_SIZE];
    if (source->good && (*used & 1u << usart)) {
        has_word(source, key, word); // finds the line of the message
        fprintf(stderr, "%s:%u: %s: USART%u has another job already\n", source->path, source->line,
                key, usart);
        source->good = false;
    }
    *used |= 1u << usart;
}

static void check_usarts(const struct board *board, struct source *source)
{
    char key[VALUE_SIZE];
    unsigned used = 0;
    for (unsigned i = 0; i < board->bus_count; i++) {
        snprintf(key, sizeof(key), "BOARD_BUS%u_USART", i);
        take_usart(source, key, board->bus[i].usart, &used);
    }
    if (board->has_host) {
        take_usart(source, "BOARD_HOST_USART", board->host_usart, &used);
    }
}

static bool read_wiring(struct board *board, struct source *source)
{
    board->bus_count = number(source, "BOARD_BUS_COUNT", 1, BOARD_BUSES_MAX);
    for (unsigned i = 0; i < board->bus_count && source->good; i++) {
        read_bus(&board->bus[i], source, i);
    }
    char word[VALUE_SIZE];
    board->has_host = has_word(source, "BOARD_HOST_USART", word);
    if (board->has_host) {
        board->host_usart = number(source, "BOARD_HOST_USART", 0, 3);
        board->host_baud = number(source, "BOARD_HOST_BAUD", 1, 2000000);
    }
    check_usarts(board, source);
    return source->good;
}

static bool read_chip(struct board *board, struct source *source, const char *mcu,
                      const char *clock)
{
    find_word(source, mcu, board->mcu);
    if (!has_word(source, "SIM_MCU", board->core)) {
        memcpy(board->core, board->mcu, sizeof(board->core));
    }
    char word[VALUE_SIZE];
    board->clock_Hz = has_word(source, clock, word) ? number(source, clock, 1000000, 32000000)
                                                    : CLOCK_IF_NOT_GIVEN_HZ;
    return source->good;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static int is_board(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && !strchr(entry->d_name, '~');
}

static void list_boards(const char *folder, const char *name)
{
    struct dirent **entries = 0;
    int count = scandir(folder, &entries, is_board, 0);
    fprintf(stderr, "there is no board \"%s\" in %s; there are:", name, folder);
    char *names[BOARDS_SIZE];
    unsigned known = 0;
    for (int i = 0; i < count; i++) {
        struct source source;
        snprintf(source.path, sizeof(source.path), "%s/%s/board.h", folder, entries[i]->d_name);
        if (known < BOARDS_SIZE && !open_path(&source)) {
            fclose(source.file);
            names[known++] = entries[i]->d_name;
        }
    }
    qsort(names, known, sizeof(names[0]), by_name);
    for (unsigned i = 0; i < known; i++) {
        fprintf(stderr, " %s", names[i]);
    }
    fputs(known ? "" : " none", stderr);
    if (is_folder(name)) {
        fprintf(stderr, "; the folder %s of yours is --board ./%s", name, name);
    }
    fputs("\n", stderr);
    for (int i = 0; i < count; i++) {
        free(entries[i]);
    }
    free(entries);
}

/* `wiring` is open. */
static bool read_files(struct board *board, struct source *wiring, struct source *chip)
{
    char word[VALUE_SIZE];
    if (!read_wiring(board, wiring)) {
        return false;
    }
    if (has_word(wiring, "BOARD_MCU", word)) {
        return read_chip(board, wiring, "BOARD_MCU", "BOARD_F_CPU");
    }
    const char *wrong = open_path(chip);
    if (wrong) {
        fprintf(stderr, "%s: %s; it or BOARD_MCU in board.h names the chip\n", chip->path, wrong);
        return false;
    }
    bool good = read_chip(board, chip, "MCU", "F_CPU");
    fclose(chip->file);
    return good;
}

static bool open_path_of_user(struct source *wiring)
{
    const char *wrong = open_path(wiring);
    if (wrong) {
        fprintf(stderr, "%s: %s\n", wiring->path, wrong);
    }
    return !wrong;
}

static bool open_known(struct source *wiring, const char *folder, const char *name)
{
    if (!name[0] || open_path(wiring)) {
        list_boards(folder, name);
        return false;
    }
    return true;
}

bool board_read(struct board *board, const char *folder, const char *name)
{
    struct source wiring = {.good = false};
    struct source chip = {.good = false};
    *board = (struct board){0};
    board_paths(folder, name, wiring.path, chip.path);
    if (!(is_path(name) ? open_path_of_user(&wiring) : open_known(&wiring, folder, name))) {
        return false;
    }
    bool good = read_files(board, &wiring, &chip);
    fclose(wiring.file);
    return good;
}
