/* SPDX-License-Identifier: MIT */
/* Completion and hints; see typing.h. */
#include "console/typing.h"

#include <string.h>

#include "console/commands/stored.h" // stored_unknown_name()
#include "console/console.h"
#include "console/errors.h"
#include "console/line_editor.h" // line_editor_insert()
#include "console/names.h"

#define BELL 0x07

/* Columns of a list of names. */
#define LIST_WIDTH 72

static const CDS_FLASH char typed_new_line[] = "\r\n";
const CDS_FLASH char typing_did_you_mean[] = "; did you mean ";

/* ---- completion ---- */

enum phase { READING, COLLECTING, LISTING };

struct completion {
    struct names names;
    struct token common; // what all names that fit share
    uint8_t phase;       // enum phase
    uint8_t begin;       // index of the word in the text of the editor
    uint8_t column;      // of the list
    bool is_unique;      // one name fits
    bool is_found;       // one or more fit
};

_Static_assert(sizeof(struct completion) <= CONSOLE_JOB_SIZE, "the job must fit");

static struct completion *completion(struct console *console)
{
    return console_job(console);
}

void typing_begin(struct console *console)
{
    memset(console_job(console), 0, CONSOLE_JOB_SIZE);
}

static bool end(struct console *console)
{
    parse_begin(&console->line);
    return false;
}

static bool ring_bell(struct console *console)
{
    printer_char(&console->printer, BELL);
    return end(console);
}

/* Reads the next word of the line, up to the word before the cursor. */
static bool read_word(struct console *console)
{
    struct completion *job = completion(console);
    const struct editor *editor = &console->editor;
    struct token token = {0};
    uint8_t at = job->begin;

    while (at < editor->cursor && editor->text[at] != ' ')
        token_add(&token, editor->text[at++]);
    if (at == editor->cursor) {
        parse_end_list(&console->line);
        job->phase = COLLECTING;
        return true;
    }
    job->begin = (uint8_t)(at + 1);
    if (token.length)
        parse_word(&console->line, &token, ' ');
    return console->line.error == 0 || ring_bell(console);
}

static uint8_t length_of_word(struct console *console)
{
    return (uint8_t)(console->editor.cursor - completion(console)->begin);
}

/* The name fits: keeps what it shares with the others. */
static void collect(struct completion *job)
{
    const struct token *name = &job->names.name;
    uint8_t same = 0;

    if (!job->is_found) {
        job->is_found = true;
        job->common = *name;
        job->is_unique = true;
        return;
    }
    while (same < job->common.length && same < name->length &&
           job->common.text[same] == name->text[same])
        same++;
    job->common.length = same;
    job->is_unique = false;
}

/* All names are known: completes the word, or begins the list. */
static bool decide(struct console *console)
{
    struct completion *job = completion(console);
    uint8_t length = length_of_word(console);

    if (!job->is_found || (command_set.has_room && length == 0 && names_id_is_due(&console->line)))
        return ring_bell(console); // a Tab alone types no `all`
    if (job->common.length > length || job->is_unique) {
        uint8_t added = (uint8_t)(job->common.length - length + job->is_unique);

        if (console->editor.length + added >= EDITOR_SIZE)
            return ring_bell(console);
        /* `pre` becomes `PRESENT_`: the typed part takes the case of the name. */
        for (uint8_t i = 0; command_set.advise && i < length; i++)
            line_editor_replace(&console->editor, (uint8_t)(job->begin + i), job->common.text[i]);
        for (uint8_t i = length; i < job->common.length; i++)
            line_editor_insert(&console->editor, job->common.text[i]);
        if (job->is_unique)
            line_editor_insert(&console->editor, ' ');
        return end(console);
    }
    memset(&job->names, 0, sizeof job->names);
    job->phase = LISTING;
    printer_flash(&console->printer, typed_new_line);
    return true;
}

static void list(struct console *console)
{
    struct completion *job = completion(console);
    const struct token *name = &job->names.name;

    if (job->column + name->length > LIST_WIDTH) {
        printer_flash(&console->printer, typed_new_line);
        job->column = 0;
    }
    for (uint8_t i = 0; i < name->length; i++)
        printer_char(&console->printer, name->text[i]);
    printer_char(&console->printer, ' ');
    printer_char(&console->printer, ' ');
    job->column = (uint8_t)(job->column + name->length + 2);
}

static bool end_list(struct console *console)
{
    printer_flash(&console->printer, typed_new_line);
    line_editor_redraw(&console->editor);
    console_prompt(console);
    return end(console);
}

bool typing_complete(struct console *console)
{
    struct completion *job = completion(console);
    enum names_result result;

    if (!printer_ready(&console->printer))
        return true;
    if (job->phase == READING)
        return read_word(console);
    result = names_next(&job->names, &console->line);
    if (result == NAMES_END)
        return job->phase == COLLECTING ? decide(console) : end_list(console);
    if (result == NAMES_NONE ||
        !names_begin_alike(&job->names.name, console->editor.text + job->begin,
                           length_of_word(console)))
        return true;
    if (job->phase == COLLECTING)
        collect(job);
    else
        list(console);
    return true;
}

/* ---- hints ---- */

#define ERRORS_MAX 2 // in a word; 1 in a word of less than 5 characters

struct hint {
    struct names names;
    struct token nearest; // length 0: there is none
    uint8_t least;        // errors of this name, and 1
};

_Static_assert(sizeof(struct hint) <= CONSOLE_JOB_SIZE, "the job must fit");

static struct hint *hint(struct console *console)
{
    return console_job(console);
}

/* The character at `index` in small letters, or '\0' behind the end. */
static char small(const struct token *token, uint8_t index)
{
    return (char)(index < token->length ? token->text[index] | 0x20 : '\0');
}

/* At each difference it takes the first of these errors that the next characters agree with. */
uint8_t typing_errors(const struct token *word, const struct token *name)
{
    uint8_t errors = 0, at = 0, in_name = 0;

    while ((at < word->length || in_name < name->length) && errors <= ERRORS_MAX) {
        char c = small(word, at), next = small(word, (uint8_t)(at + 1));
        char due = small(name, in_name), later = small(name, (uint8_t)(in_name + 1));

        if (at >= 3 && at == word->length)
            return (uint8_t)(errors + 1);
        if (c != due) {
            errors++;
            if (c == later && next == due &&
                small(word, (uint8_t)(at + 2)) == small(name, (uint8_t)(in_name + 2))) { // swapped
                at++;
                in_name++;
            } else if (c == later && c) { // missing
                at--;
            } else if (next == due) { // too many
                in_name--;
            }
        }
        at++;
        in_name++;
    }
    return errors;
}

bool typing_has_unknown_name(const struct console *console)
{
    uint8_t error = console->line.error;

    if (command_set.advise && error == 0)
        return stored_unknown_name(console);
    return error == ERROR_UNKNOWN_COMMAND || error == ERROR_UNKNOWN_WORD ||
           error == ERROR_UNKNOWN_REGISTER || error == ERROR_UNKNOWN_SETTING;
}

/* True if only the present name begins with the word, not the nearest one: `of` is off, not on. */
static bool is_better(struct console *console)
{
    const struct hint *job = hint(console);
    const struct token *word = &console->token;

    return job->nearest.length && names_begin_alike(&job->names.name, word->text, word->length) &&
           !names_begin_alike(&job->nearest, word->text, word->length);
}

static bool search(struct console *console)
{
    struct hint *job = hint(console);
    enum names_result result;
    uint8_t errors;

    if (!typing_has_unknown_name(console) || console->token.length > TOKEN_MAX ||
        console->phase >= TYPING_ENDED)
        return false;
    if (console->phase == TYPING_BEGINS) {
        typing_begin(console);
        job->least = console->token.length < 5 ? 2 : ERRORS_MAX + 1;
        if (console->token.length == 1)
            job->least = 1; // no hint: any name of two letters has one error
        console->phase = TYPING_SEARCHES;
    }
    result = names_next(&job->names, &console->line);
    if (result == NAMES_FOUND) {
        errors = typing_errors(&console->token, &job->names.name);
        if (errors < job->least || (errors == job->least && is_better(console))) {
            job->least = errors;
            job->nearest = job->names.name;
        }
    }
    if (result == NAMES_END)
        console->phase = TYPING_ENDED;
    return result != NAMES_END;
}

static bool has_hint(struct console *console)
{
    return console->phase == TYPING_ENDED && typing_has_unknown_name(console) &&
           hint(console)->nearest.length;
}

static void print_hint(struct console *console)
{
    const struct token *nearest = &hint(console)->nearest;

    printer_flash(&console->printer, typing_did_you_mean);
    for (uint8_t i = 0; i < nearest->length; i++)
        printer_char(&console->printer, nearest->text[i]);
    printer_char(&console->printer, '?');
    printer_end_of_line(&console->printer);
    hint(console)->nearest.length = 0;
}

const CDS_FLASH struct command_typing typing = {
    .begin = typing_begin,
    .complete = typing_complete,
    .search = search,
    .has_hint = has_hint,
    .print_hint = print_hint,
};
