/* SPDX-License-Identifier: MIT */
/* The latest lines typed; see history.h. */
#include "console/history.h"

#include <stdbool.h>
#include <string.h>

/* Where the line begins whose NUL stands before index `end`, 1 to used. */
static uint8_t begin_of(const struct history *history, uint8_t end)
{
    uint8_t begin = (uint8_t)(end - 1);

    while (begin && history->text[begin - 1])
        begin--;
    return begin;
}

static bool is_newest(const struct history *history, const char *line, uint8_t length)
{
    uint8_t begin;

    if (history->used == 0)
        return false;
    begin = begin_of(history, history->used);
    return history->used - begin - 1 == length && memcmp(history->text + begin, line, length) == 0;
}

/* Drops the oldest lines until there is room for `size` bytes. */
static void make_room(struct history *history, uint8_t size)
{
    uint8_t drop = 0;

    while (history->used - drop + size > HISTORY_SIZE)
        drop = (uint8_t)(drop + strlen(history->text + drop) + 1);
    history->used = (uint8_t)(history->used - drop);
    memmove(history->text, history->text + drop, history->used);
}

void history_add(struct history *history, const char *line, uint8_t length)
{
    if (length && !memchr(line, '\0', length) && !is_newest(history, line, length)) {
        make_room(history, (uint8_t)(length + 1));
        memcpy(history->text + history->used, line, length);
        history->text[history->used + length] = '\0';
        history->used = (uint8_t)(history->used + length + 1);
    }
    history->at = history->used;
}

static uint8_t copy(const struct history *history, char *line)
{
    uint8_t length = (uint8_t)strlen(history->text + history->at);

    memcpy(line, history->text + history->at, length);
    return length;
}

uint8_t history_older(struct history *history, char *line)
{
    if (history->at == 0)
        return 0;
    history->at = begin_of(history, history->at);
    return copy(history, line);
}

uint8_t history_newer(struct history *history, char *line)
{
    if (history->at < history->used)
        history->at = (uint8_t)(history->at + strlen(history->text + history->at) + 1);
    return history->at < history->used ? copy(history, line) : 0;
}
