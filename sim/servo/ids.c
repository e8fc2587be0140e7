/* SPDX-License-Identifier: MIT */
#include "servo/ids.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>

#define HIGHEST_ID 253

static bool parse_number(const char **text, unsigned *value)
{
    if (!isdigit((unsigned char)**text)) {
        return false;
    }
    char *end = 0;
    unsigned long number = strtoul(*text, &end, 10);
    *text = end;
    *value = number > HIGHEST_ID ? HIGHEST_ID + 1 : (unsigned)number;
    return true;
}

const char *ids_parse(const char *text, bool allow_duplicates, uint8_t ids[IDS_MAX],
                      unsigned *count)
{
    bool seen[IDS_MAX] = {false};
    *count = 0;
    do {
        unsigned first = 0;
        if (!parse_number(&text, &first)) {
            return "a list of IDs is wanted, as in 1-18 or 0,1,5-7";
        }
        unsigned last = first;
        if (*text == '-' && (text++, !parse_number(&text, &last))) {
            return "a list of IDs is wanted, as in 1-18 or 0,1,5-7";
        }
        if (first > HIGHEST_ID || last > HIGHEST_ID || first > last) {
            return "IDs are 0 to 253, the lower one first";
        }
        for (unsigned id = first; id <= last; id++) {
            if (seen[id] && !allow_duplicates) {
                return "an ID occurs twice";
            }
            if (*count == IDS_MAX) {
                return "more than 254 servos";
            }
            seen[id] = true;
            ids[(*count)++] = (uint8_t)id;
        }
    } while (*text == ',' && *text++);
    return *text == 0 ? 0 : "a list of IDs is wanted, as in 1-18 or 0,1,5-7";
}

const char *ids_parse_set(const char *text, bool set[IDS_MAX])
{
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    const char *wrong = ids_parse(text, true, ids, &count);
    for (unsigned i = 0; !wrong && i < count; i++) {
        set[ids[i]] = true;
    }
    return wrong;
}

const char *ids_print(const bool set[IDS_MAX], char *text, size_t capacity)
{
    size_t size = (size_t)snprintf(text, capacity, "none");
    const char *comma = "";
    for (unsigned id = 0; id < IDS_MAX; id++) {
        unsigned last = id;
        while (set[id] && last + 1 < IDS_MAX && set[last + 1]) {
            last++;
        }
        if (!set[id]) {
            continue;
        }
        size = *comma ? size : 0;
        if (size + sizeof(",253-253..") > capacity) {
            snprintf(text + size, capacity - size, "..");
            break;
        }
        size += (size_t)snprintf(text + size, capacity - size, last > id ? "%s%u-%u" : "%s%u",
                                 comma, id, last);
        comma = ",";
        id = last;
    }
    return text;
}
