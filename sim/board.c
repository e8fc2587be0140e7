#include "board.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATH_ROOM   512
#define VALUE_ROOM  64
#define LINE_ROOM   256
#define BOARDS_ROOM 512

/* Text of one data file and where it came from, for messages. */
struct source {
    char path[PATH_ROOM];
    FILE *file;
    bool good; // nothing was missing so far
};

static bool open_source(struct source *source, const char *folder, const char *name,
                        const char *file)
{
    snprintf(source->path, sizeof(source->path), "%s/%s/%s", folder, name, file);
    source->file = fopen(source->path, "r");
    source->good = source->file != 0;
    return source->good;
}

/* The word behind `key`, in lines `#define KEY WORD` or `KEY := WORD`. */
static bool has_word(struct source *source, const char *key, char *word)
{
    char line[LINE_ROOM];
    char name[LINE_ROOM];
    rewind(source->file);
    while (fgets(line, sizeof(line), source->file)) {
        bool found = sscanf(line, " #define %255s %63s", name, word) == 2 ||
                     sscanf(line, " %255[A-Za-z0-9_] :=%63s", name, word) == 2 ||
                     sscanf(line, " %255[A-Za-z0-9_] =%63s", name, word) == 2;
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

static void complain(struct source *source, const char *key, const char *word)
{
    if (source->good) {
        fprintf(stderr, "%s: %s: \"%s\" will not do\n", source->path, key, word);
    }
    source->good = false;
}

static uint32_t number(struct source *source, const char *key, uint32_t max)
{
    char word[VALUE_ROOM];
    char *end = 0;
    if (!find_word(source, key, word)) {
        return 0;
    }
    unsigned long value = strtoul(word, &end, 0);
    size_t suffix = strspn(end, "UL"); // 16000000UL
    if (end == word || end[suffix] != 0 || value > max) {
        complain(source, key, word);
    }
    return (uint32_t)value;
}

static struct board_pin pin(struct source *source, unsigned bus, const char *name)
{
    char key[VALUE_ROOM];
    char word[VALUE_ROOM];
    struct board_pin pin = {0};
    snprintf(key, sizeof(key), "BOARD_BUS%u_%s_PORT", bus, name);
    if (find_word(source, key, word)) {
        pin.port = word[0];
        if (word[0] < 'A' || word[0] > 'L' || word[1] != 0) {
            complain(source, key, word);
        }
    }
    snprintf(key, sizeof(key), "BOARD_BUS%u_%s_BIT", bus, name);
    pin.bit = (uint8_t)number(source, key, 7);
    return pin;
}

static void read_bus(struct board_bus *bus, struct source *source, unsigned index)
{
    char key[VALUE_ROOM];
    snprintf(key, sizeof(key), "BOARD_BUS%u_USART", index);
    bus->wiring = BOARD_TWO_ENABLES;
    bus->usart = number(source, key, 3);
    bus->tx_enable = pin(source, index, "TX_ENABLE");
    bus->rx_enable = pin(source, index, "RX_ENABLE");
    bus->txd = pin(source, index, "TXD");
    bus->rxd = pin(source, index, "RXD");
}

/* Each USART has one job. */
static void check_usarts(const struct board *board, struct source *source)
{
    unsigned used = 0;
    bool twice = board->bus_count == 0 || (board->has_host && board->host_baud == 0);
    for (unsigned i = 0; i < board->bus_count; i++) {
        twice = twice || (used & 1u << board->bus[i].usart);
        used |= 1u << board->bus[i].usart;
    }
    twice = twice || (board->has_host && (used & 1u << board->host_usart));
    if (source->good && twice) {
        fprintf(stderr, "%s: no bus, no host baud rate, or one USART for two of them\n",
                source->path);
        source->good = false;
    }
}

static bool read_wiring(struct board *board, struct source *source)
{
    board->bus_count = number(source, "BOARD_BUS_COUNT", BOARD_BUSES_MAX);
    for (unsigned i = 0; i < board->bus_count && source->good; i++) {
        read_bus(&board->bus[i], source, i);
    }
    char word[VALUE_ROOM];
    board->has_host = has_word(source, "BOARD_HOST_USART", word);
    if (board->has_host) {
        board->host_usart = number(source, "BOARD_HOST_USART", 3);
        board->host_baud = number(source, "BOARD_HOST_BAUD", 2000000);
    }
    check_usarts(board, source);
    fclose(source->file);
    return source->good;
}

static bool read_chip(struct board *board, struct source *source)
{
    find_word(source, "MCU", board->mcu);
    board->clock_Hz = number(source, "F_CPU", 32000000);
    if (source->good && board->clock_Hz < 1000000) {
        complain(source, "F_CPU", "less than 1 MHz");
    }
    fclose(source->file);
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
    char *names[BOARDS_ROOM];
    unsigned known = 0;
    for (int i = 0; i < count; i++) {
        struct source source;
        if (known < BOARDS_ROOM && open_source(&source, folder, entries[i]->d_name, "board.h")) {
            fclose(source.file);
            names[known++] = entries[i]->d_name;
        }
    }
    qsort(names, known, sizeof(names[0]), by_name);
    for (unsigned i = 0; i < known; i++) {
        fprintf(stderr, " %s", names[i]);
    }
    fputs(known ? "\n" : " none\n", stderr);
    for (int i = 0; i < count; i++) {
        free(entries[i]);
    }
    free(entries);
}

bool board_read(struct board *board, const char *folder, const char *name)
{
    *board = (struct board){0};
    struct source wiring;
    struct source chip;
    bool a_name = name[0] && name[0] != '.' && !strchr(name, '/');
    if (!a_name || !open_source(&wiring, folder, name, "board.h")) {
        list_boards(folder, name);
        return false;
    }
    if (!open_source(&chip, folder, name, "board.mk")) {
        fclose(wiring.file);
        fprintf(stderr, "%s: cannot be read\n", chip.path);
        return false;
    }
    bool wired = read_wiring(board, &wiring);
    return read_chip(board, &chip) && wired;
}
