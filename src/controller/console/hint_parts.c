/* SPDX-License-Identifier: MIT */
/* Hints for a part of a name; see hint_parts.h. */
#include "console/hint_parts.h"

#include <string.h> // memset()

#include "console/commands/stored.h" // stored_unknown_name()
#include "console/console.h"
#include "console/names.h"

static const CDS_FLASH char before_next[] = ", ";
static const CDS_FLASH char before_last[] = " or ";
static const CDS_FLASH char end_of_hint[] = "?";

#define BEGIN_MIN 2 // characters of the shortest word that hints by the begin of a name
#define PART_MIN  3 // characters of the shortest word that hints by any part of a name
#define TYPO_MIN  5 // characters of the shortest word that is searched with one error

/* In this order, until one finds names. */
enum search {
    SEARCH_WORD, // names that contain the word; of two characters: that begin with it; then
                 // typing.c searches a name near the word
    SEARCH_REST, // names that contain what stands behind a '_' of the word
    SEARCH_TYPO, // names with a part near the word
} __attribute__((packed));

/* console->phase; below COUNT_NAMES: enum typing_phase. */
enum { COUNT_NAMES = TYPING_ENDED + 1, LIST_NAMES, HINT_ENDS };

struct parts {
    struct names names;
    uint8_t from;   // index of the character of the word at which the part begins
    uint8_t count;  // names that have the part
    uint8_t left;   // of these, not yet printed
    uint8_t search; // enum search
};

_Static_assert(sizeof(struct parts) <= CONSOLE_JOB_SIZE, "the job must fit");

static struct parts *parts(struct console *console)
{
    return console_job(console);
}

/* True if the name contains the part, in any case. */
static bool contains(const struct token *name, const char *part, uint8_t length)
{
    uint8_t same = 0;

    for (uint8_t at = 0; same < length && at + length <= name->length; at++)
        for (same = 0; same < length && !((name->text[at + same] ^ part[same]) & ~0x20); same++)
            ;
    return same == length;
}

/* True if one of the parts of the name between '_' has one error of the word. */
static bool has_near_part(const struct token *name, const struct token *word)
{
    struct token part = {0};

    for (uint8_t at = 0; at < name->length; at++) {
        bool is_end = name->text[at] == '_';

        if (!is_end)
            token_add(&part, name->text[at]);
        if ((is_end || at + 1 == name->length) && typing_errors(word, &part) <= 1)
            return true;
        if (is_end)
            part.length = 0;
    }
    return false;
}

/* True if the present name has the part. */
static bool fits(struct console *console)
{
    const struct parts *job = parts(console);
    const struct token *word = &console->token;

    if (command_set.has_room && word->length < PART_MIN)
        return names_begin_alike(&job->names.name, word->text, word->length);
    return job->search == SEARCH_TYPO ? has_near_part(&job->names.name, word)
                                      : contains(&job->names.name, word->text + job->from,
                                                 (uint8_t)(word->length - job->from));
}

/* The part is what stands behind the next '_' of the word. False: there is no more, or too little.
 */
static bool shorten(struct console *console)
{
    struct parts *job = parts(console);
    const struct token *word = &console->token;

    while (job->from < word->length && word->text[job->from++] != '_') {
    }
    memset(&job->names, 0, sizeof job->names);
    return word->length >= job->from + PART_MIN;
}

static bool may_be_part(const struct console *console)
{
    return typing_has_unknown_name(console) &&
           console->token.length >= (command_set.has_room ? BEGIN_MIN : PART_MIN) &&
           console->token.length <= TOKEN_MAX;
}

static void begin_search(struct console *console, enum search search)
{
    typing_begin(console);
    parts(console)->search = search;
    console->phase = COUNT_NAMES;
}

/* Begins the next search, since this one has found nothing. Returns false if there is none. */
static bool begin_next(struct console *console)
{
    struct parts *job = parts(console);

    if (job->search == SEARCH_WORD) {
        console->phase = TYPING_BEGINS;
        return typing.search(console);
    }
    if (job->search == SEARCH_REST && shorten(console))
        return true;
    if (job->search == SEARCH_REST && console->token.length >= TYPO_MIN) {
        begin_search(console, SEARCH_TYPO);
        return true;
    }
    console->phase = HINT_ENDS;
    return false;
}

/* Looks at one name. Returns false at the end of all searches. */
static bool count_names(struct console *console)
{
    struct parts *job = parts(console);

    switch (names_next(&job->names, &console->line)) {
    case NAMES_FOUND: job->count = (uint8_t)(job->count + fits(console)); return true;
    case NAMES_NONE: return true;
    default: break;
    }
    if (job->count == 0)
        return begin_next(console);
    job->left = job->count;
    memset(&job->names, 0, sizeof job->names);
    console->phase = LIST_NAMES;
    return false;
}

/* `pose rihgt in 1s`: the unknown name is the word, and its place the one whose names are searched.
 */
static void take_unknown_name(struct console *console)
{
    struct command_line *line = &console->line;
    const char *name = stored_unknown_name(console);
    bool is_second = name && name != parse_name(line, 0);

    if (line->error || name == NULL)
        return;
    console->token.length = 0;
    for (uint8_t i = 0; i < PARSE_NAME_SIZE && name[i]; i++)
        token_add(&console->token, name[i]);
    line->usage = line->command->usage;
    while (parse_argument_at(line->usage) != ARGUMENT_NAME || (is_second && *line->usage != 'P'))
        line->usage++;
}

static bool search_parts(struct console *console)
{
    if (console->phase == TYPING_BEGINS)
        take_unknown_name(console);
    if (!may_be_part(console))
        return typing.search(console);
    if (console->phase == TYPING_BEGINS)
        begin_search(console, SEARCH_WORD);
    if (console->phase == COUNT_NAMES)
        return count_names(console);
    if (console->phase >= LIST_NAMES)
        return false;
    if (typing.search(console))
        return true;
    if (typing.has_hint(console))
        return false;
    begin_search(console, SEARCH_REST);
    return begin_next(console);
}

static bool has_parts(struct console *console)
{
    return console->phase == LIST_NAMES ? may_be_part(console) && parts(console)->left
                                        : typing.has_hint(console);
}

/* Looks at one name, and prints it if it has the part. */
static void print_part(struct console *console)
{
    struct parts *job = parts(console);
    struct printer *printer = &console->printer;

    if (console->phase != LIST_NAMES) {
        typing.print_hint(console);
        console->phase = HINT_ENDS;
        return;
    }
    if (names_next(&job->names, &console->line) != NAMES_FOUND || !fits(console))
        return;
    if (job->left == job->count)
        printer_flash(printer, typing_did_you_mean);
    else
        printer_flash(printer, job->left == 1 ? before_last : before_next);
    for (uint8_t i = 0; i < job->names.name.length; i++)
        printer_char(printer, job->names.name.text[i]);
    if (--job->left == 0)
        printer_line(printer, end_of_hint);
}

const CDS_FLASH struct command_typing typing_with_parts = {
    .begin = typing_begin,
    .complete = typing_complete,
    .search = search_parts,
    .has_hint = has_parts,
    .print_hint = print_part,
};
