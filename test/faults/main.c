/* SPDX-License-Identifier: MIT */
/* Runs one row of `make faults` on one board; scripts/faults.py runs all rows.
 *
 *     faults --list              rows: name, boards, what
 *     faults ROW BOARD ELF [PART PARTS SEED]
 *
 * Prints lines `progress DONE TOTAL` and `failure TEXT`, then `done` and the results of the row,
 * with tabs between the words. Exit status 0: no failure; 1: failures; 2: bad input. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "data_path.h"
#include "rows.h"

static const struct row *const tables[] = {rows_wire, rows_servo, rows_line, rows_handler,
                                           rows_host};
#define TABLES (sizeof(tables) / sizeof(tables[0]))

static void list(void)
{
    for (unsigned i = 0; i < TABLES; i++) {
        for (const struct row *row = tables[i]; row->name; row++) {
            printf("%s\t%s\t%s\n", row->name, row->boards ? row->boards : "", row->what);
        }
    }
}

static bool is_in(const struct row *table, const struct row *wanted)
{
    while (table->name && table != wanted) {
        table++;
    }
    return table->name;
}

static const struct row *find(const char *name)
{
    for (unsigned i = 0; i < TABLES; i++) {
        for (const struct row *row = tables[i]; row->name; row++) {
            if (strcmp(row->name, name) == 0) {
                return row;
            }
        }
    }
    return 0;
}

static void progress(const struct check *check)
{
    static time_t printed;
    if (printed != time(0)) {
        printed = time(0);
        printf("progress\t%u\t%u\n", check->injections - 1, check->total);
        fflush(stdout);
    }
}

struct part {
    uint32_t part, parts, seed;
};

static int run(const struct row *row, const char *board, const char *elf, struct part part)
{
    static struct rig rig;
    static struct check check;
    char boards[DATA_PATH_SIZE];
    data_path(boards, "boards");
    if (!rig_open(&rig, elf, boards, board, row->servos, is_in(rows_host, row))) {
        return 2;
    }
    check = (struct check){.rig = &rig,
                           .row = row,
                           .part = part.part,
                           .parts = part.parts,
                           .seed = part.seed,
                           .on_progress = progress};
    check_open(&check);
    check.counting = true;
    row->run(&check);
    check.counting = false;
    check.index = 0;
    row->run(&check);
    printf("done\t%u\t%u\t%u\t%u\t%u\t%.1f\n", check.injections, check.failures, check.undetected,
           check.misunderstood, check.lost, (double)check.longest / RIG_US);
    check_close(&check);
    rig_close(&rig);
    return check.failures > 0;
}

static uint32_t number(const char *word)
{
    return (uint32_t)strtoul(word, 0, 10);
}

int main(int count, char **words)
{
    struct part part = {1, 1, 0};
    if (count == 2 && strcmp(words[1], "--list") == 0) {
        list();
        return 0;
    }
    if (count == 7) {
        part = (struct part){number(words[4]), number(words[5]), number(words[6])};
    }
    const struct row *row = count == 4 || count == 7 ? find(words[1]) : 0;
    if (!row || part.part < 1 || part.part > part.parts) {
        fputs("faults: --list, or ROW BOARD ELF [PART PARTS SEED]\n", stderr);
        return 2;
    }
    return run(row, words[2], words[3], part);
}
